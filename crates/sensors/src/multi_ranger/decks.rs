//! Which of the two decks there are, asked once at boot.

use embedded_hal_async::i2c::I2c;

use super::{Beam, RangerConfig};
use crate::expander::{Expander, Lines};
use crate::vl53l1x::{self, DEFAULT_ADDRESS};

/// How often decks are asked for before one counts as not there.
const MOST_ASKED: u8 = 20;

/// Finds out which decks there are, so that one that is missing does not keep the other's rangers
/// from ranging.
///
/// A Multi-ranger deck counts as missing only if its expander has not answered once: one that
/// answers with errors is there, and its rangers may be at 0x29. What cannot be told from no deck
/// is a deck whose expander alone is dead, and its rangers not: on a drone that carries one, the
/// sides must have been seen to range before it flies.
#[derive(Clone, Copy, Debug)]
pub struct DeckProbe {
    asked: u8,
    /// The ranger that looks down has answered.
    ground: bool,
    /// The expander has answered, or the bus kept it from being asked.
    expander: bool,
    /// It has put the other rangers in reset.
    lines: bool,
}

impl DeckProbe {
    /// Nobody has been asked yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { asked: 0, ground: false, expander: false, lines: false }
    }

    /// Asks once, with no more than 13 transactions, and puts all rangers of a Multi-ranger deck in
    /// reset. Says which configuration fits as soon as both decks have answered, and the 20th time
    /// in any case: [`RangerConfig::DEFAULT`] unless it is known that a deck is missing. To be
    /// called 20 times a second or so.
    pub async fn ask<I2C: I2c>(&mut self, mut i2c: I2C) -> Option<RangerConfig> {
        self.asked = self.asked.saturating_add(1);
        let is_there = Expander::new(&mut i2c).answers().await.unwrap_or(true);
        self.expander |= is_there;
        let in_reset = is_there && Expander::new(&mut i2c).drive(Lines::NONE).await.is_ok();
        self.lines |= in_reset;
        if in_reset || !is_there {
            self.ground |= sees_ground(&mut i2c).await;
        }
        match (self.ground, self.expander) {
            (true, true) if self.lines => Some(RangerConfig::DEFAULT),
            _ if self.asked < MOST_ASKED => None,
            (true, false) => Some(RangerConfig::FLOW_DECK),
            (false, true) if self.lines => Some(RangerConfig::MULTI_RANGER),
            _ => Some(RangerConfig::DEFAULT),
        }
    }
}

impl Default for DeckProbe {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether the one ranger without a reset line answers: at its own address if only the processor
/// was reset.
async fn sees_ground<I2C: I2c>(i2c: &mut I2C) -> bool {
    for address in [Beam::Down.address(), DEFAULT_ADDRESS] {
        if vl53l1x::answers(i2c, address).await.unwrap_or(false) {
            return true;
        }
    }
    false
}
