//! Serves the drone with Bitcraze's firmware to clients over UDP: cflib and cfclient connect to it.

use bridge::Polled;
use onboard::State;
use units::{Instant, MissionKind, NodeId, Order, Role};

use super::StockDrone;
use mission::trace::Node;
use serve::{STEP, World};

/// Milliseconds between two packets of the client's Crazyradio: half of its rate.
const POLL_MS: u64 = 2;

/// A drone, and the Crazyradio of its client.
pub struct Served {
    drone: StockDrone,
    packets: Polled,
    halted: Option<String>,
}

impl Served {
    /// A drone that has just been switched on.
    #[must_use]
    pub fn new(drone: StockDrone) -> Self {
        Self { drone, packets: Polled::default(), halted: None }
    }

    /// The drone.
    #[must_use]
    pub const fn drone(&self) -> &StockDrone {
        &self.drone
    }

    /// The access that the emulator refused, if it refused one.
    #[must_use]
    pub fn halted(&self) -> Option<&str> {
        self.halted.as_deref()
    }

    fn millisecond(&mut self) {
        if let Err(halt) = self.drone.advance() {
            self.halted = Some(halt.to_string());
            return;
        }
        for answer in self.drone.take_answers() {
            self.packets.acknowledged(&answer);
        }
        if self.drone.now_ms().is_multiple_of(POLL_MS) {
            self.drone.hear(self.packets.next_packet());
        }
    }
}

impl World for Served {
    fn now(&self) -> Instant {
        Instant::from_millis(self.drone.now_ms())
    }

    fn advance(&mut self) {
        for _ in 0..STEP.as_micros() / 1_000 {
            if self.halted.is_none() {
                self.millisecond();
            }
        }
    }

    fn nodes(&self) -> Vec<Node> {
        vec![Node { id: NodeId::HEAD, role: Role::Head, mission: MissionKind::Chain }]
    }

    /// The vendor's firmware has no agent.
    fn state(&self, _: usize) -> Option<State> {
        None
    }

    fn client(&mut self, _: usize, packet: &[u8]) {
        self.packets.give(packet);
    }

    fn poll_client(&mut self, _: usize, take: &mut dyn FnMut(&[u8])) {
        self.packets.take_received().iter().for_each(|packet| take(packet));
    }

    fn ordered(&self) -> Option<Order> {
        None
    }

    fn is_halted(&self) -> bool {
        self.halted.is_some()
    }
}
