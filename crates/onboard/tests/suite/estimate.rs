//! What `reset_estimator` of cflib asks of a drone: to forget its position, and how well the drone
//! knows it (`kalman.resetEstimation`, `kalman.varPX`).

use onboard::{Config, Drone, Keys, Sensed, Setup, Snapshot};
use units::{Duration, Instant, MissionKind, NodeId, Role};
use wire::p2p::Epoch;
use wire::radio::Datarate;

use crate::common::packets::{hover, task};
use crate::common::{Clear, Net};

/// The longest that a flight to its place takes here.
const MINUTE: Duration = Duration::from_secs(60);

fn drone(role: Role, mission: MissionKind) -> Drone<Clear> {
    let node = NodeId(if role == Role::Base { 1 } else { 0 });
    let setup = Setup { mission, ..Setup::new(node, role) };
    let mut drone = Drone::new(Config::DEFAULT, &setup);
    let schedule = airlink::Schedule::new(Datarate::Mbit2, node).unwrap();
    let keys = Keys::Held { seal: Clear, epoch: Epoch::FIRST, schedule, may_fly: true };
    drone.open_link(Instant::ZERO, keys);
    drone
}

/// Gives a drone a position, as `send_extpos` does, and a round to take it in.
fn told(drone: &mut Drone<Clear>, now: Instant, x: f32) {
    let packet = [&[0x6C][..], &x.to_le_bytes(), &[0; 8]].concat();
    drone.client(now, &packet);
    drone.step(now, &Sensed::NONE);
}

fn seen(drone: &Drone<Clear>, now: Instant) -> (f32, f32) {
    let snapshot = drone.snapshot(now, &Snapshot::DEFAULT);
    (snapshot.position.x, snapshot.variance.place)
}

/// The console of a node after `packet` comes to it five times a second for so long.
fn console(net: &mut Net, node: usize, packet: &[u8], span: Duration) -> String {
    let mut said = String::new();
    for _ in 0..span.as_micros() / 200_000 {
        let answers = net.client(node, packet);
        for answer in answers.iter().filter(|answer| answer[0] >> 4 == 0) {
            said += &String::from_utf8_lossy(&answer[1..]);
        }
        net.run(Duration::from_millis(200));
    }
    said
}

#[test]
fn a_drone_on_the_ground_forgets_its_position_when_it_is_asked_to() {
    let mut drone = drone(Role::Head, MissionKind::Swarm);
    let at = |ms| Instant::from_millis(ms);
    assert_eq!(seen(&drone, at(0)).1, f32::INFINITY, "no position was told yet");
    told(&mut drone, at(200), 3.0);
    let (x, variance) = seen(&drone, at(200));
    assert!(x == 3.0 && variance < 1e-3, "{x} {variance}");
    // The next fix is the first again, so one far off is believed at once.
    drone.client(at(300), &reset());
    assert_eq!(seen(&drone, at(300)).1, f32::INFINITY);
    told(&mut drone, at(400), -7.0);
    let (x, variance) = seen(&drone, at(400));
    assert!(x == -7.0 && variance < 1e-3, "{x} {variance}");
}

/// The packet that sets `kalman.resetEstimation` to 1 by its name.
fn reset() -> Vec<u8> {
    b"\x2F\0kalman\0resetEstimation\0\x08\x01".to_vec()
}

/// Scripts reset before they fly, also one that is started while the chain is out.
#[test]
fn a_reset_changes_nothing_in_the_air() {
    let mut net = Net::new(2, 0, 1);
    let (head, base) = (0, net.base());
    let fly = |net: &mut Net, span| console(net, base, &hover(0.2), span);
    fly(&mut net, MINUTE);
    assert!(net.nodes[head].flew.is_some());
    let state = net.nodes[head].drone.state();
    assert_eq!(net.client(head, &reset())[0].last(), Some(&13), "EACCES");
    assert_eq!(net.client(base, &reset())[0].last(), Some(&0), "the base does not move");
    fly(&mut net, Duration::from_secs(1));
    assert_eq!(net.nodes[head].drone.state(), state);
}

/// `reset_estimator` waits until the variances stand still to a thousandth.
#[test]
fn the_variances_of_a_chain_stand_still_on_the_ground() {
    for role in [Role::Head, Role::Relay, Role::Base] {
        let drone = drone(role, MissionKind::Chain);
        let of = |ms| drone.snapshot(Instant::from_millis(ms), &Snapshot::DEFAULT).variance;
        assert_eq!(of(0), of(5_000));
        assert!(of(0).place < 0.02 && of(0).height < 0.02, "{role:?}: {:?}", of(0));
    }
}

/// A script that flies twice lands after the first flight; nothing flies before a wait.
#[test]
fn the_base_says_why_a_head_stays_down_that_was_told_to_fly() {
    let mut net = Net::new(2, 0, 1);
    let base = net.base();
    let flies = |net: &mut Net| console(net, base, &hover(0.0), Duration::from_secs(9));
    assert!(!flies(&mut net).contains("stays down"));
    net.client(base, &task(3));
    net.run(Duration::from_secs(10));
    let said = flies(&mut net);
    assert_eq!(said.matches("The head stays down").count(), 1, "{said}");
    net.client(base, &task(0));
    net.run(Duration::from_secs(5));
    assert!(!flies(&mut net).contains("stays down"));
}

/// The head flies on as little as the operator sees why.
#[test]
fn the_base_says_that_links_are_reckoned_while_packets_are_held_back() {
    let mut net = Net::new(2, 10, 1);
    let base = net.base();
    let flies = |net: &mut Net| console(net, base, &hover(0.2), Duration::from_secs(25));
    let said = flies(&mut net);
    assert!(!said.contains("reckoned"), "{said}");
    net.held = 1_000_000;
    let said = flies(&mut net);
    assert_eq!(said.matches("links are reckoned, and the head stands").count(), 3, "{said}");
    net.held = 0;
    net.run(Duration::from_secs(2));
    let said = flies(&mut net);
    assert!(!said.contains("reckoned"), "{said}");
}
