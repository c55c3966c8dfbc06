//! A TIMER in timer mode: 16 MHz divided by a power of two, four values to compare with, and shortcuts
//! that clear or stop it.

use super::interrupts::Events;
use crate::{Cycles, NEVER};

/// The offsets of the registers.
mod offset {
    pub(super) const START: u32 = 0x000;
    pub(super) const STOP: u32 = 0x004;
    pub(super) const CLEAR: u32 = 0x00C;
    pub(super) const SHUTDOWN: u32 = 0x010;
    pub(super) const CAPTURE: u32 = 0x040;
    pub(super) const CAPTURE_END: u32 = 0x050;
    pub(super) const SHORTS: u32 = 0x200;
    pub(super) const MODE: u32 = 0x504;
    pub(super) const BITMODE: u32 = 0x508;
    pub(super) const PRESCALER: u32 = 0x510;
    pub(super) const CC: u32 = 0x540;
    pub(super) const CC_END: u32 = 0x550;
}

/// The event of the first compare register, in the order of the event registers.
const COMPARE: u32 = 16;
/// The values to compare with.
const CHANNELS: usize = 4;

/// One timer.
#[derive(Clone, Debug)]
pub(super) struct Timer {
    events: Events,
    /// Whether it counts.
    runs: bool,
    /// The count at `since`.
    base: u32,
    since: Cycles,
    shorts: u32,
    mode: u32,
    bit_mode: u32,
    prescaler: u32,
    compare: [u32; CHANNELS],
    due: Cycles,
}

impl Timer {
    pub(super) const fn new() -> Self {
        Self {
            events: Events::new(15 << COMPARE),
            runs: false,
            base: 0,
            since: 0,
            shorts: 0,
            mode: 0,
            bit_mode: 0,
            prescaler: 4,
            compare: [0; CHANNELS],
            due: NEVER,
        }
    }

    /// The largest count.
    const fn mask(&self) -> u32 {
        match self.bit_mode & 3 {
            0 => 0xFFFF,
            1 => 0xFF,
            2 => 0xFF_FFFF,
            _ => u32::MAX,
        }
    }

    const fn count(&self, now: Cycles) -> u32 {
        if !self.runs {
            return self.base;
        }
        self.base.wrapping_add(((now - self.since) >> self.prescaler) as u32) & self.mask()
    }

    /// Keeps the count, and begins to count anew from it.
    const fn rebase(&mut self, now: Cycles) {
        if self.runs {
            let ticks = (now - self.since) >> self.prescaler;
            self.base = self.count(now);
            self.since += ticks << self.prescaler;
        } else {
            self.since = now;
        }
    }

    const fn clear(&mut self, now: Cycles) {
        self.base = 0;
        self.since = now;
    }

    /// When the count next reaches the value of a channel; a count that equals it has reached it.
    fn reaches(&self, channel: usize) -> Cycles {
        let ticks = self.compare[channel].wrapping_sub(self.base) & self.mask();
        let ticks = if ticks == 0 { u64::from(self.mask()) + 1 } else { ticks.into() };
        self.since + (ticks << self.prescaler)
    }

    fn plan(&mut self) {
        let counts = self.runs && self.mode & 1 == 0;
        let next = (0..CHANNELS).map(|channel| self.reaches(channel)).min();
        self.due = if counts { next.unwrap_or(NEVER) } else { NEVER };
    }

    pub(super) const fn due(&self) -> Cycles {
        self.due
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    /// What happens until now happens.
    pub(super) fn advance(&mut self, now: Cycles) {
        while self.due <= now {
            let at = self.due;
            let reached: Vec<_> = (0..CHANNELS).filter(|it| self.reaches(*it) == at).collect();
            self.rebase(at);
            for channel in reached {
                self.events.raise(COMPARE + channel as u32);
                if self.shorts & 1 << channel != 0 {
                    self.clear(at);
                }
                if self.shorts & 1 << (8 + channel) != 0 {
                    self.runs = false;
                }
            }
            self.plan();
        }
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::SHORTS => self.shorts,
            offset::MODE => self.mode,
            offset::BITMODE => self.bit_mode,
            offset::PRESCALER => self.prescaler,
            offset::CC..offset::CC_END => self.compare[(offset - offset::CC) as usize / 4],
            _ => return self.events.read(offset),
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        self.rebase(now);
        match offset {
            offset::START if value & 1 != 0 => {
                self.since = if self.runs { self.since } else { now };
                self.runs = true;
            }
            offset::STOP | offset::SHUTDOWN if value & 1 != 0 => self.runs = false,
            offset::CLEAR if value & 1 != 0 => self.clear(now),
            offset::START | offset::STOP | offset::CLEAR | offset::SHUTDOWN => {}
            offset::CAPTURE..offset::CAPTURE_END => {
                self.compare[(offset - offset::CAPTURE) as usize / 4] = self.base;
            }
            offset::SHORTS => self.shorts = value,
            offset::MODE => self.mode = value,
            offset::BITMODE => self.bit_mode = value,
            offset::PRESCALER => self.prescaler = value & 15,
            offset::CC..offset::CC_END => {
                self.compare[(offset - offset::CC) as usize / 4] = value;
            }
            _ => self.events.write(offset, value)?,
        }
        self.plan();
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A timer at 1 MHz that is compared with a value and then cleared.
    fn every(ticks: u32) -> Timer {
        let mut timer = Timer::new();
        for (offset, value) in [(offset::CC, ticks), (offset::SHORTS, 1), (0x304, 1 << COMPARE)] {
            timer.write(0, offset, value).unwrap();
        }
        timer.write(100, offset::START, 1).unwrap();
        timer
    }

    #[test]
    fn a_timer_that_is_cleared_at_its_value_has_that_period() {
        let mut timer = every(1000);
        for period in 1..=5 {
            assert_eq!(timer.due(), 100 + period * 16_000);
            timer.advance(timer.due());
            assert!(timer.line());
            timer.write(timer.since, 0x140, 0).unwrap();
            assert!(!timer.line());
        }
    }

    #[test]
    fn a_timer_that_stops_at_its_last_value_starts_again_from_zero() {
        let mut timer = Timer::new();
        let set =
            [(offset::PRESCALER, 0), (offset::CC + 12, 320), (offset::SHORTS, 1 << 3 | 1 << 11)];
        for (offset, value) in set {
            timer.write(0, offset, value).unwrap();
        }
        timer.write(50, offset::START, 1).unwrap();
        timer.advance(10_000);
        assert_eq!(timer.read(0x14C), Some(1));
        assert_eq!(timer.due(), NEVER);
        timer.write(10_000, offset::START, 1).unwrap();
        timer.advance(10_320);
        assert!(!timer.runs);
    }
}
