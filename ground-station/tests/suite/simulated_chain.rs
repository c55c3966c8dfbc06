//! Serves a simulated chain to the station, as `uchain serve` does.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use sim_harness::measure::metrics::Reference;
use sim_harness::mission::World;
use sim_harness::scenario::Scenario;
use sim_harness::serve::{self, Event, Live, Ports};

/// A served chain; it ends when it is dropped.
pub(crate) struct SimulatedChain {
    base: SocketAddr,
    ending: Arc<AtomicBool>,
    events: Arc<Mutex<Vec<Event>>>,
    thread: Option<JoinHandle<()>>,
}

impl SimulatedChain {
    /// Serves the scenario `demo`, a head and three relays, on free ports and in real time.
    pub(crate) fn demo() -> Self {
        let ending = Arc::new(AtomicBool::new(false));
        let events = Arc::new(Mutex::new(Vec::new()));
        let scenario = Scenario::open("demo").unwrap();
        let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, scenario.drones.members()).unwrap();
        let base = *ports.addresses().last().unwrap();
        let (stop, journal) = (Arc::clone(&ending), Arc::clone(&events));
        let thread = thread::spawn(move || {
            let world = World::of(&scenario);
            let reference = Reference::of(&scenario, &world);
            let live = Live::new(&scenario, &world, &reference, 1, false);
            serve::serve(live, ports, 1.0, None, &stop, |_, event| {
                journal.lock().unwrap().push(event);
            });
        });
        Self { base, ending, events, thread: Some(thread) }
    }

    /// The base's address, as the station takes it.
    pub(crate) fn address(&self) -> String {
        format!("udp://{}", self.base)
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
