//! The radio between the robots: who receives a packet.

use radio_model::{Geometry, LogDistance, Obstruction, PathLoss, Reception};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use units::{Db, Dbm, Point2};

use crate::world::World;

/// The power of the Crazyflie 2.1's amplified radio (Bitcraze's data sheet: 20 dBm).
const POWER: Dbm = Dbm(20.0);
/// The bytes of a packet beside its payload: preamble, address, control field and CRC.
const FRAMING: usize = 9;

/// How packets come from robot to robot (thesis, section 4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Network {
    /// Robots send each other's packets on: an ad hoc network with several hops.
    #[default]
    Mesh,
    /// Robots hear each other directly alone.
    AdHoc,
    /// All packets go through an access point, which stands where the robots begin and leads. Robots that
    /// it does not hear are on their own.
    AccessPoint,
}

/// The radio of all robots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// The law of the path loss.
    pub loss: PathLoss,
    /// The receivers.
    pub reception: Reception,
    /// The network.
    pub network: Network,
}

impl Air {
    /// The log-distance law through concrete, with receivers at 2 Mbit/s of which each loses this
    /// part of all packets whatever the signal, and a mesh.
    #[must_use]
    pub const fn losing(loss_rate: f32) -> Self {
        let loss = PathLoss::LogDistance(LogDistance::DEFAULT);
        let sensitivity = Reception::NRF51_AT_2_MBIT;
        let reception = Reception { loss_rate, sensitivity, ..Reception::PAPER };
        Self { loss, reception, network: Network::Mesh }
    }

    /// The strength of the signal from one point at another.
    pub(crate) fn strength(&self, world: &World, from: Point2, to: Point2) -> Dbm {
        let (walls, rock) = world.rock_between(from, to);
        let term = self.loss.term(Obstruction { walls, rock });
        let between = Geometry::in_sight(units::Metres(from.distance(to).0.max(0.1)));
        POWER - Db(self.loss.loss(between, term).0)
    }

    /// Whether a packet is received over a link of that strength.
    pub(crate) fn is_received(&self, strength: Dbm, bytes: usize, luck: &mut ChaCha8Rng) -> bool {
        let bits = 8 * (bytes + FRAMING) as u64;
        uniform(luck) >= self.reception.loss_rate_of(strength, bits)
    }
}

/// A number from 0 up to 1.
pub(crate) fn uniform(stream: &mut ChaCha8Rng) -> f32 {
    (stream.next_u32() >> 8) as f32 / 16_777_216.0
}
