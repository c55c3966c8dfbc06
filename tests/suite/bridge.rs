//! `uchain bridge` to an unmodified cflib: its scan finds the bridge, and it connects to the drone
//! behind it.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use bridge::{self, FIRST_PORT, Ports, Radio, RadioLost, Rate};
use sim_harness::measure::metrics::Reference;
use sim_harness::scenario::Scenario;
use sim_harness::serve::{self, Live};

/// A radio without losses, behind which a served drone is: it acknowledges each packet at once, with
/// the next of the drone's packets that has come.
struct Near(UdpSocket);

/// The empty packet of an acknowledgement.
const EMPTY: [u8; 1] = [0xF3];

impl Near {
    fn of(drone: SocketAddr) -> std::io::Result<Self> {
        let socket = UdpSocket::bind((drone.ip(), 0))?;
        socket.connect(drone)?;
        socket.set_nonblocking(true)?;
        Ok(Self(socket))
    }
}

impl Radio for Near {
    fn exchange(&mut self, packet: &[u8]) -> Result<Option<Vec<u8>>, RadioLost> {
        let lost = |error: std::io::Error| RadioLost(error.to_string());
        if packet[0] & 0xF3 != 0xF3 {
            self.0.send(packet).map_err(lost)?;
        }
        let mut answer = [0; 32];
        let length = self.0.recv(&mut answer).ok();
        Ok(Some(length.map_or_else(|| EMPTY.to_vec(), |length| answer[..length].to_vec())))
    }
}

#[test]
#[ignore = "needs python3 and the Python package index"]
fn cflib_finds_the_bridge_and_reads_and_sets_the_drone_behind_it() {
    let scenario = Scenario::open("demo").unwrap_or_else(|error| panic!("{error}"));
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let drones = Ports::open(crate::serve::host(4), FIRST_PORT, scenario.drones.members()).unwrap();
    let mut radio = Near::of(*drones.addresses().last().unwrap()).unwrap();
    let host = crate::serve::host(5);
    let port = Ports::open(host, FIRST_PORT, 1).unwrap();
    let (python, done) = (crate::serve::python(), AtomicBool::new(false));
    thread::scope(|scope| {
        let (scenario, world, reference, stop) = (&scenario, &world, &reference, &done);
        scope.spawn(move || {
            let live = Live::new(scenario, world, reference, 1, false);
            serve::serve(live, drones, 1.0, None, stop, |_, _| {});
        });
        let rate = Rate::per_second(500).unwrap();
        let bridge = scope.spawn(move || {
            bridge::run(&mut radio, port, rate, stop, |_, event| {
                eprintln!("{event}");
            })
        });
        let output = crate::serve::script(python, "bridged", host, 1, &[]);
        done.store(true, Ordering::Relaxed);
        let (tally, output) = (bridge.join().unwrap().unwrap(), output.unwrap());
        println!("{tally:?}\n{}", crate::serve::said(&output));
        assert!(output.status.success());
        // cflib asks for each row and each value.
        assert!(tally.received > 200 && tally.sent > 200, "{tally:?}");
        assert!(tally.polls >= tally.received, "{tally:?}");
    });
}
