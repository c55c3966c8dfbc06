//! [`DeckProbe`], which detects at boot which of the two decks the drone carries.

use embedded_hal_async::i2c::I2c;

use super::{Beam, RangerConfig};
use crate::expander::{Expander, Lines};
use crate::vl53l1x::{self, DEFAULT_ADDRESS};

/// Number of rounds after which a deck that has not answered counts as missing.
const MOST_ROUNDS: u8 = 20;

/// A probe for the two decks. With its result a missing deck does not stop the other deck's
/// rangers.
///
/// A Multi-ranger deck counts as missing only if its expander has never answered: an expander that
/// answers with errors is there, and its rangers may be at 0x29. The probe cannot distinguish a
/// missing deck from one whose expander alone is defective: a drone that carries a Multi-ranger
/// deck must not fly before its side rangers have measured.
#[derive(Clone, Copy, Debug)]
pub struct DeckProbe {
    rounds: u8,
    /// Whether the ranger that looks down has answered.
    ground: bool,
    /// Whether the expander has answered, or an error of the bus has left it open.
    expander: bool,
    /// Whether the expander has put the side rangers in reset.
    in_reset: bool,
}

impl DeckProbe {
    /// A probe that has not asked any deck yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { rounds: 0, ground: false, expander: false, in_reset: false }
    }

    /// Asks both decks once, with at most 13 transactions, and puts all rangers of a Multi-ranger
    /// deck in reset. Returns the configuration that fits as soon as both decks have answered, and
    /// at the 20th call in any case: [`RangerConfig::DEFAULT`] unless a deck is known to be
    /// missing. Call it about 20 times a second.
    pub async fn ask<I2C: I2c>(&mut self, mut i2c: I2C) -> Option<RangerConfig> {
        self.rounds = self.rounds.saturating_add(1);
        let answers = Expander::new(&mut i2c).answers().await.unwrap_or(true);
        self.expander |= answers;
        let in_reset = answers && Expander::new(&mut i2c).drive(Lines::NONE).await.is_ok();
        self.in_reset |= in_reset;
        if in_reset || !answers {
            self.ground |= down_answers(&mut i2c).await;
        }
        match (self.ground, self.expander) {
            (true, true) if self.in_reset => Some(RangerConfig::DEFAULT),
            _ if self.rounds < MOST_ROUNDS => None,
            (true, false) => Some(RangerConfig::FLOW_DECK),
            (false, true) if self.in_reset => Some(RangerConfig::MULTI_RANGER),
            _ => Some(RangerConfig::DEFAULT),
        }
    }
}

impl Default for DeckProbe {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether the ranger that looks down, which has no reset line, answers: at its own address if only
/// the processor was reset, else at the default address.
async fn down_answers<I2C: I2c>(i2c: &mut I2C) -> bool {
    for address in [Beam::Down.address(), DEFAULT_ADDRESS] {
        if vl53l1x::answers(i2c, address).await.unwrap_or(false) {
            return true;
        }
    }
    false
}
