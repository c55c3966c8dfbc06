//! The constants of a medium, and the strengths of its links.

use radio_model::{Fades, Reception};
use units::{Db, Dbm};
use wire::radio::Datarate;

use super::Polling;

/// How strongly stations hear each other.
pub trait Ether {
    /// The strength of `from`'s signal at `to`, without noise; `None` where one of them is dead.
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm>;
}

impl<F: FnMut(usize, usize) -> Option<Dbm>> Ether for F {
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm> {
        self(from, to)
    }
}

/// The constants of the air and of the radios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumConfig {
    /// The rate at which all stations send.
    pub datarate: Datarate,
    /// Noise, chance and sensitivity.
    pub reception: Reception,
    /// The fades of each link, the same in both directions.
    pub fades: Fades,
    /// A packet is decoded through another that is weaker by this much. 12 dB is what Nordic's
    /// support names as the co-channel ratio of the nRF24L01 at 2 Mbit/s; the nRF51, whose radio
    /// descends from it, may differ by a few dB.
    pub capture: Db,
    /// The operator's dongle, if one is at work.
    pub polling: Option<Polling>,
    /// Where packets arrive.
    pub arrives: Arrives,
}

/// Where a packet arrives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrives {
    /// At the processor: behind the receiver's radio chip and serial line.
    #[default]
    AtProcessor,
    /// At the antenna, as soon as it is off the air: the owner of the stations has their radio chips
    /// and serial lines.
    AtAntenna,
}

impl MediumConfig {
    /// At the drones' default rate, without a dongle that polls.
    #[must_use]
    pub const fn of(reception: Reception) -> Self {
        Self {
            datarate: Datarate::Mbit2,
            reception,
            fades: Fades::NONE,
            capture: Db(12.0),
            polling: None,
            arrives: Arrives::AtProcessor,
        }
    }
}
