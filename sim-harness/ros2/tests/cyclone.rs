//! A served mission and a peer with another maker's DDS, Eclipse Cyclone DDS.

use std::ffi::OsString;
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use bridge::Ports;
use measure::metrics::Reference;
use ros2::Companion;
use ros2_topics::{Domain, Node};
use scenario::Scenario;
use serve::{Live, World};
use units::{Duration, Metres, Order};

/// A domain that no other program of this machine is likely to be in.
const DOMAIN: &str = "213";
/// The mission ends also where the peer cannot be started: four times the minute that the peer tries, since the
/// mission is flown four times as fast, and as much again.
const LONGEST: Duration = Duration::from_secs(480);

fn python() -> OsString {
    std::env::var_os("UCHAIN_CYCLONEDDS_PYTHON")
        .expect("UCHAIN_CYCLONEDDS_PYTHON does not name a Python that has the package cyclonedds")
}

#[test]
#[ignore = "needs the Python package cyclonedds; UCHAIN_CYCLONEDDS_PYTHON names the Python"]
fn cyclone_dds_hears_the_topics_and_steers_the_head() {
    let scenario = Scenario::open("straight").unwrap_or_else(|error| panic!("{error}"));
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, scenario.drones.members()).unwrap();
    let domain = Domain::of_option(Some(DOMAIN)).unwrap_or_else(|error| panic!("{error}"));
    let mut node = Node::open(domain, "uchain").unwrap_or_else(|error| panic!("{error}"));
    let commands = node.follow().unwrap_or_else(|error| panic!("{error}"));
    let live = Live::new(&scenario, &world, &reference, 1, false);
    let companion = Companion::new(node, commands, &scenario, live.trace()).unwrap();
    let live = live.with_companion(Box::new(companion));
    let python = python();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cyclone.py");
    let stop = AtomicBool::new(false);
    let (live, peer) = thread::scope(|scope| {
        let peer = scope.spawn(|| {
            let peer = Command::new(python).arg(script).arg(DOMAIN).output().unwrap();
            stop.store(true, Ordering::Relaxed);
            peer
        });
        let (live, _) = serve::serve(live, ports, 4.0, Some(LONGEST), &stop, |_, _| {});
        (live, peer.join().unwrap())
    });
    assert!(peer.status.success(), "{}", String::from_utf8_lossy(&peer.stderr));
    assert_eq!(live.ordered(), Some(Order::Return));
    assert!(Metres(live.metrics().farthest_m) > Metres(1.5));
}
