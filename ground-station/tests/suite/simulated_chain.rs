//! Serves a simulated chain to the station, as `uchain serve` does.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use bridge::Ports;
use sim_harness::bodies::emulated::{Emulated, Firmware};
use sim_harness::measure::metrics::Reference;
use sim_harness::mission::trace::Trace;
use sim_harness::scenario::Scenario;
use sim_harness::serve::{self, Event, Live};
use storage::keys;
use units::{Dbm, NodeId};

/// The limits on the pages of virtual drones.
pub(crate) const LAUNCH: Dbm = Dbm(-67.5);
pub(crate) const RETREAT: Dbm = Dbm(-72.5);

/// A served chain; it ends when it is dropped.
pub(crate) struct SimulatedChain {
    /// The ports, the head's first, the base's last.
    ports: Vec<SocketAddr>,
    ending: Arc<AtomicBool>,
    events: Arc<Mutex<Vec<Event>>>,
    thread: Option<JoinHandle<Trace>>,
}

impl SimulatedChain {
    /// Serves the scenario `demo`, a head and three relays, on free ports and in real time.
    pub(crate) fn demo() -> Self {
        Self::of(Scenario::open("demo").unwrap())
    }

    /// Serves this scenario on free ports and in real time.
    pub(crate) fn of(scenario: Scenario) -> Self {
        Self::at_speed(scenario, 1.0)
    }

    /// Serves this scenario on free ports, with so many simulated seconds per second.
    pub(crate) fn at_speed(scenario: Scenario, speed: f64) -> Self {
        let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, scenario.drones.members()).unwrap();
        Self::serve(scenario, ports, speed, None)
    }

    /// Serves it on the first free ports in a row from 24,000 on, as `uchain serve` does from
    /// 19,850 on.
    pub(crate) fn demo_in_a_row() -> Self {
        let scenario = Scenario::open("demo").unwrap();
        let members = scenario.drones.members();
        let row = |first| Ports::open(Ipv4Addr::LOCALHOST, first, members).ok();
        let ports = (24_000..30_000).step_by(members).find_map(row).unwrap();
        Self::serve(scenario, ports, 1.0, None)
    }

    /// Serves a head, a relay and a base that run the firmware's ELF on emulated Crazyflies, as fast
    /// as the emulator is, and no faster than real time. Their limits were given to them with their
    /// keys: [`LAUNCH`] and [`RETREAT`].
    pub(crate) fn of_virtual_drones(firmware: Firmware) -> Self {
        let scenario = Scenario::open("short-hop").unwrap();
        let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, scenario.drones.members()).unwrap();
        Self::serve(scenario, ports, 1.0, Some(firmware))
    }

    fn serve(scenario: Scenario, ports: Ports, speed: f64, firmware: Option<Firmware>) -> Self {
        let ending = Arc::new(AtomicBool::new(false));
        let events = Arc::new(Mutex::new(Vec::new()));
        let addresses = ports.addresses().to_vec();
        let (stop, journal) = (Arc::clone(&ending), Arc::clone(&events));
        let thread = thread::spawn(move || {
            let world = scenario.world();
            let reference = Reference::of(&scenario, &world);
            let live = match firmware {
                None => Live::new(&scenario, &world, &reference, 1, true),
                Some(firmware) => {
                    let node = |n: usize| NodeId(n as u8);
                    let drone = |n| {
                        let mut drone = Emulated::new(&scenario, &firmware, node(n), 1);
                        let after = keys::PAGE_ADDRESS + keys::LENGTH as u32;
                        let limits = keys::encode_limits(LAUNCH, RETREAT);
                        drone.machine_mut().memory_mut().program(after, &limits);
                        drone
                    };
                    let drones = (0..scenario.drones.members()).map(drone).collect();
                    Live::emulated(&scenario, &world, &reference, 1, true, drones)
                }
            };
            let (live, _) = serve::serve(live, ports, speed, None, &stop, |_, event| {
                journal.lock().unwrap().push(event);
            });
            assert_eq!(live.mission().halted(), None);
            live.trace().clone()
        });
        Self { ports: addresses, ending, events, thread: Some(thread) }
    }

    /// The addresses of all drones, the head's first, the base's last.
    pub(crate) fn addresses(&self) -> Vec<String> {
        self.ports.iter().map(|port| format!("udp://{port}")).collect()
    }

    /// The base's address, as the station takes it.
    pub(crate) fn address(&self) -> String {
        format!("udp://{}", self.ports.last().unwrap())
    }

    /// The head's address.
    pub(crate) fn head_address(&self) -> String {
        format!("udp://{}", self.ports[0])
    }

    /// Ends the chain, and returns the record of where its drones truly were.
    pub(crate) fn end(mut self) -> Trace {
        self.ending.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap()
    }

    /// All events so far.
    pub(crate) fn events(&self) -> Vec<Event> {
        self.events.lock().unwrap().clone()
    }

    /// Waits for an event.
    pub(crate) async fn wait_for(&self, what: &str, is_it: impl Fn(&Event) -> bool) {
        for _ in 0..1_200 {
            if self.events().iter().any(&is_it) {
                return;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("within a minute there was no {what}: {:?}", self.events());
    }
}

impl Drop for SimulatedChain {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
