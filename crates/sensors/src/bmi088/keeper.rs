//! [`Keeper`], which starts a die, reads it, detects its failure and starts it again.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use units::Instant;

use super::{Bmi088, Die};
use crate::Error;
use crate::bus::Health;

/// Number of successive samples, each equal to the one before to the last bit, above which the die
/// counts as frozen or asleep. At 1 kHz and with the noise of either die, some two steps, this
/// happens by chance once in days.
const MOST_REPEATS: u8 = 5;

/// The driver of a die together with the die's health.
///
/// ```text
/// loop: is_lost? ── yes ──> bring_up (which does nothing before an attempt is due)
///          └─ no ──> wait for a sample ──> read, or missed
/// ```
#[derive(Debug)]
pub struct Keeper<I2C, D: Die> {
    die: Bmi088<I2C, D>,
    health: Health,
    last: Option<D::Sample>,
    repeats: u8,
    /// Whether a read has failed since the configuration was last verified.
    unverified: bool,
}

impl<I2C: I2c, D: Die> Keeper<I2C, D> {
    /// A keeper of a die that has not been started: it counts as lost, and is started at once.
    pub const fn new(i2c: I2C, now: Instant) -> Self {
        Self {
            die: Bmi088::new(i2c),
            health: Health::new(D::TABLE.health, now),
            last: None,
            repeats: 0,
            unverified: false,
        }
    }

    /// Whether the die must be started before it can be read.
    pub fn is_lost(&mut self, now: Instant) -> bool {
        self.health.is_lost(now)
    }

    /// Starts the die, if an attempt is due.
    pub async fn bring_up<W: DelayNs>(&mut self, clock: impl Fn() -> Instant, delay: &mut W) {
        if !self.health.may_retry(clock()) {
            return;
        }
        match self.die.init(delay).await {
            Ok(()) => {
                self.health.started(clock());
                (self.last, self.repeats, self.unverified) = (None, 0, false);
            }
            Err(_) => self.health.bad(clock()),
        }
    }

    /// Reads a new sample; `None` if the read fails, the die is frozen, or its configuration is
    /// lost.
    pub async fn read(&mut self, clock: impl Fn() -> Instant) -> Option<D::Sample> {
        let sample = self.die.read().await.ok().filter(|sample| !self.is_frozen(sample));
        if sample.is_some() && self.unverified {
            match self.die.verify().await {
                Ok(()) => self.unverified = false,
                Err(Error::NotKept { .. }) => {
                    self.health.lose(clock());
                    return None;
                }
                Err(_) => {
                    self.missed(clock());
                    return None;
                }
            }
        }
        match sample {
            Some(_) => self.health.good(clock()),
            None => self.missed(clock()),
        }
        sample
    }

    /// Records that a sample that was due did not come.
    pub fn missed(&mut self, now: Instant) {
        self.health.bad(now);
        self.unverified = true;
    }

    /// Number of missed samples and of failed attempts to start the die, since the beginning.
    #[must_use]
    pub const fn errors(&self) -> u32 {
        self.health.errors()
    }

    /// Number of times that the die was lost after it had been started.
    #[must_use]
    pub const fn losses(&self) -> u32 {
        self.health.losses()
    }

    fn is_frozen(&mut self, sample: &D::Sample) -> bool {
        let repeats = self.last.as_ref() == Some(sample);
        self.last = Some(*sample);
        self.repeats = if repeats { self.repeats.saturating_add(1) } else { 0 };
        self.repeats > MOST_REPEATS
    }
}
