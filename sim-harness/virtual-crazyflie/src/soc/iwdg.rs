//! The independent watchdog (RM0090, "Independent watchdog"): it has an oscillator of its own, and
//! runs in nanoseconds, whatever the clocks do.
//!
//! A write to its prescaler or reload value takes five periods of the oscillator to come into
//! force, during which IWDG_SR says so. The prescaler is not restarted by feeding on the chip; here
//! it is, so the reset may come up to one count late.

use crate::bus::Refused;
use crate::soc::wiring::Nanos;

/// Periods of the oscillator that an update takes.
const UPDATE_PERIODS: u64 = 5;

/// A register that changes with a delay.
#[derive(Clone, Copy, Debug)]
struct Delayed {
    now: u32,
    next: Option<(Nanos, u32)>,
}

impl Delayed {
    const fn new(value: u32) -> Self {
        Self { now: value, next: None }
    }

    /// The value that is read: the one that was written last.
    fn value(self) -> u32 {
        self.next.map_or(self.now, |(_, value)| value)
    }

    fn take(&mut self, now: Nanos) -> Option<Nanos> {
        let (at, value) = self.next.filter(|(at, _)| *at <= now)?;
        *self = Self::new(value);
        Some(at)
    }
}

/// The counter: so many counts are left at a moment.
#[derive(Clone, Copy, Debug)]
struct Counter {
    since: Nanos,
    left: u64,
}

/// The watchdog.
#[derive(Clone, Debug)]
pub(crate) struct Iwdg {
    /// The frequency of the watchdog's oscillator, in Hz.
    lsi: u32,
    unlocked: bool,
    pr: Delayed,
    rlr: Delayed,
    counter: Option<Counter>,
    /// When it bites if nothing else happens; `u64::MAX` for never.
    bites_at: Nanos,
}

impl Iwdg {
    pub(crate) fn new(lsi: u32) -> Self {
        let (pr, rlr) = (Delayed::new(0), Delayed::new(0xFFF));
        Self { lsi, unlocked: false, pr, rlr, counter: None, bites_at: Nanos::MAX }
    }

    /// The duration of some periods of the oscillator, rounded up.
    fn periods(&self, count: u64) -> Nanos {
        (count * 1_000_000_000).div_ceil(u64::from(self.lsi))
    }

    /// Periods of the oscillator in a count: 4 to 256.
    fn divider(&self) -> u64 {
        4 << self.pr.now.min(6)
    }

    pub(crate) fn read(&mut self, offset: u32, now: Nanos) -> Result<u32, Refused> {
        self.settle(now);
        Ok(match offset {
            0x00 => 0,
            0x04 => self.pr.value(),
            0x08 => self.rlr.value(),
            0x0C => u32::from(self.pr.next.is_some()) | u32::from(self.rlr.next.is_some()) << 1,
            _ => return Err(Refused::Unmodelled { what: "IWDG: a reserved register" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, now: Nanos) -> Result<(), Refused> {
        self.settle(now);
        let at = now + self.periods(UPDATE_PERIODS);
        match offset {
            0x00 => self.key(value & 0xFFFF, now),
            // Protected: nothing happens.
            0x04 | 0x08 if !self.unlocked => {}
            0x04 if self.pr.next.is_none() => self.pr.next = Some((at, value & 7)),
            0x08 if self.rlr.next.is_none() => self.rlr.next = Some((at, value & 0xFFF)),
            0x04 | 0x08 => {
                return Err(Refused::Unmodelled { what: "IWDG: written while an update goes on" });
            }
            0x0C => {}
            _ => return Err(Refused::Unmodelled { what: "IWDG: a reserved register" }),
        }
        Ok(())
    }

    fn key(&mut self, key: u32, now: Nanos) {
        self.unlocked = key == 0x5555;
        let reload = Counter { since: now, left: u64::from(self.rlr.now) + 1 };
        match key {
            0xAAAA if self.counter.is_some() => self.counter = Some(reload),
            0xCCCC if self.counter.is_none() => self.counter = Some(reload),
            _ => {}
        }
        self.plan();
    }

    /// Updates that are over come into force, each at its own moment.
    fn settle(&mut self, now: Nanos) {
        let divider = self.divider();
        self.rlr.take(now);
        let Some(at) = self.pr.take(now) else { return };
        if let Some(counter) = &mut self.counter {
            // What was counted until then was counted at the old speed.
            let period = (divider * 1_000_000_000).div_ceil(u64::from(self.lsi));
            let counted = at.saturating_sub(counter.since) / period;
            *counter = Counter { since: at, left: counter.left.saturating_sub(counted).max(1) };
        }
        self.plan();
    }

    /// When it bites if nothing else happens, or has to be looked at; `u64::MAX` for never.
    pub(crate) fn due(&self) -> Nanos {
        let update = [self.pr, self.rlr].into_iter().filter_map(|r| r.next).map(|(at, _)| at).min();
        update.unwrap_or(Nanos::MAX).min(self.bites_at)
    }

    /// When it bites if nothing else happens; `u64::MAX` for never.
    pub(crate) const fn bites_at(&self) -> Nanos {
        self.bites_at
    }

    fn plan(&mut self) {
        self.bites_at = self.counter.map_or(Nanos::MAX, |counter| {
            counter.since + self.periods(counter.left * self.divider())
        });
    }

    /// Whether the watchdog has fired by now.
    pub(crate) fn fired(&mut self, now: Nanos) -> bool {
        self.settle(now);
        self.bites_at <= now
    }

    /// Whether the watchdog runs, which switches its oscillator on.
    pub(crate) const fn is_started(&self) -> bool {
        self.counter.is_some()
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.lsi);
    }

    pub(crate) fn words(&self) -> [u32; 3] {
        [self.pr.value(), self.rlr.value(), u32::from(self.counter.is_some())]
    }
}
