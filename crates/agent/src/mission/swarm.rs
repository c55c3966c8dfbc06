//! The swarm mission: drones that survey an area, gather, and cross a passage.

mod duty;

pub use duty::SwarmDuty;

use units::{MetresPerSecond, Payload, Radians, RadiansPerSecond};

use super::{Next, Outbox, Round, Wish};
use crate::{AgentConfig, Told};

/// What a drone of a swarm knows of the others.
#[derive(Clone, Debug)]
pub(crate) struct Swarm {
    /// The drones that were heard, one bit each.
    heard: u16,
}

impl Swarm {
    /// A drone that has not heard any other.
    pub(crate) const fn new() -> Self {
        Self { heard: 0 }
    }

    /// Takes in what the others told since the last round.
    pub(crate) fn listen(&mut self, told: &[Told]) {
        self.heard = told.iter().fold(self.heard, |heard, told| heard | 1 << (told.from.0 & 15));
    }

    /// The duty after a round of `duty`, or the landing that ends it.
    pub(crate) fn next_duty(&self, round: &Round, duty: SwarmDuty) -> Next<SwarmDuty> {
        duty.next(round)
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(&self, config: &AgentConfig, _: &Round, duty: SwarmDuty) -> Wish {
        match duty {
            SwarmDuty::Hovering { .. } => Wish::Over {
                east: MetresPerSecond::ZERO,
                north: MetresPerSecond::ZERO,
                yaw: Radians::ZERO,
                yaw_rate: RadiansPerSecond::ZERO,
                height: config.flight.height,
            },
        }
    }

    /// Puts what the drone tells the others into `outbox`.
    pub(crate) fn tell(&self, _: &Round, outbox: &mut Outbox) {
        if let Some(payload) = Payload::new(&self.heard.to_le_bytes()) {
            // A mission tells no more than there is room for.
            let _ = outbox.push(payload);
        }
    }
}
