//! A die that is brought up, read, given up and brought up again, all on its own.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use units::Instant;

use super::{Bmi088, Die};
use crate::Error;
use crate::bus::Health;

/// After so many samples that are equal to the last bit the die is frozen, or asleep: at 1 kHz and
/// with the noise of either, some two steps, this comes by chance once in days.
const MOST_REPEATS: u8 = 5;

/// The driver of a die, and what is known of the die's health.
///
/// ```text
/// loop: is_lost? ── yes ──> bring_up (which does nothing before its time)
///          └─ no ──> wait for a sample ──> read, or missed
/// ```
#[derive(Debug)]
pub struct Keeper<I2C, D: Die> {
    die: Bmi088<I2C, D>,
    health: Health,
    last: Option<D::Sample>,
    repeats: u8,
    /// Something went wrong since its configuration was seen.
    doubted: bool,
}

impl<I2C: I2c, D: Die> Keeper<I2C, D> {
    /// A die that has not been spoken to: lost, and due at once.
    pub const fn new(i2c: I2C, now: Instant) -> Self {
        Self {
            die: Bmi088::new(i2c),
            health: Health::new(D::TABLE.health, now),
            last: None,
            repeats: 0,
            doubted: false,
        }
    }

    /// Whether it must be brought up before it can be read.
    pub fn is_lost(&mut self, now: Instant) -> bool {
        self.health.is_lost(now)
    }

    /// Brings it up, if the time for an attempt has come.
    pub async fn bring_up<W: DelayNs>(&mut self, clock: impl Fn() -> Instant, delay: &mut W) {
        if !self.health.may_retry(clock()) {
            return;
        }
        match self.die.init(delay).await {
            Ok(()) => {
                self.health.started(clock());
                (self.last, self.repeats, self.doubted) = (None, 0, false);
            }
            Err(_) => self.health.bad(clock()),
        }
    }

    /// A new sample; `None` where there is none that can be believed.
    pub async fn read(&mut self, clock: impl Fn() -> Instant) -> Option<D::Sample> {
        let sample = self.die.read().await.ok().filter(|sample| !self.is_frozen(sample));
        if sample.is_some() && self.doubted {
            match self.die.verify().await {
                Ok(()) => self.doubted = false,
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

    /// A sample that should have come did not.
    pub fn missed(&mut self, now: Instant) {
        self.health.bad(now);
        self.doubted = true;
    }

    /// Samples that were missed and attempts to bring it up that failed, since the beginning.
    #[must_use]
    pub const fn errors(&self) -> u32 {
        self.health.errors()
    }

    /// How often it was given up after it had worked.
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
