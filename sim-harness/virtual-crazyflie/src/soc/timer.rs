//! The general-purpose and basic timers, counting up: TIM2 to TIM7 and TIM9 to TIM14 (RM0090).
//!
//! A counter is not stepped. It is an anchor, what it was at which cycle, and is brought up to date
//! when it is accessed or when an enabled interrupt is due. A compare flag is set as the counter
//! reaches the value by counting; being set to it, by software or by an update event that software
//! makes, is no match. A counter that is set beyond its reload value runs to the end of its width.
//!
//! Counting down, one pulse, slave modes, input capture, DMA requests, and output modes other than
//! frozen, forced and PWM are refused.

use crate::bus::Refused;

/// Bits of TIMx_CR1.
mod cr1 {
    pub(super) const CEN: u32 = 1 << 0;
    pub(super) const UDIS: u32 = 1 << 1;
    pub(super) const URS: u32 = 1 << 2;
    pub(super) const OPM: u32 = 1 << 3;
    pub(super) const DIR: u32 = 1 << 4;
    pub(super) const CMS: u32 = 3 << 5;
    pub(super) const ARPE: u32 = 1 << 7;
    pub(super) const CKD: u32 = 3 << 8;
}

/// Bit 0 of TIMx_SR, DIER and EGR: the update.
const UPDATE: u32 = 1;

/// Which timer it is: what the chip has of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Compare channels: 4, 2, 1 or none.
    pub(crate) channels: usize,
    /// 16 or 32 bits.
    pub(crate) bits: u32,
    /// The NVIC's number.
    pub(crate) interrupt: u8,
}

/// The output of a compare channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Output {
    /// TIMx_CCER, CCxE is clear: the pin is not driven.
    Off,
    Low,
    High,
    /// High for a part of each period of so many cycles of the core.
    Pwm {
        duty: f32,
        period: u64,
    },
}

/// A timer.
#[derive(Clone, Debug)]
pub(crate) struct Timer {
    shape: Shape,
    cr1: u32,
    dier: u32,
    sr: u32,
    ccmr: [u32; 2],
    ccer: u32,
    /// The registers as written; the counter uses those below.
    psc: u32,
    arr: u32,
    ccr: [u32; 4],
    psc_now: u32,
    arr_now: u32,
    ccr_now: [u32; 4],
    /// The counter at cycle `since`, and cycles that the prescaler had counted then.
    count: u32,
    phase: u64,
    since: u64,
    /// Cycles of the core in a clock of the timer.
    divider: u64,
    /// The timer's clock is on (RCC_APBxENR).
    clocked: bool,
}

impl Timer {
    pub(crate) fn new(shape: Shape) -> Self {
        let full = mask(shape.bits);
        Self {
            shape,
            cr1: 0,
            dier: 0,
            sr: 0,
            ccmr: [0; 2],
            ccer: 0,
            psc: 0,
            arr: full,
            ccr: [0; 4],
            psc_now: 0,
            arr_now: full,
            ccr_now: [0; 4],
            count: 0,
            phase: 0,
            since: 0,
            divider: 1,
            clocked: false,
        }
    }

    /// Cycles of the core in a count.
    const fn tick(&self) -> u64 {
        self.divider * (self.psc_now as u64 + 1)
    }

    const fn is_counting(&self) -> bool {
        // With a reload value of zero the counter is blocked.
        self.cr1 & cr1::CEN != 0 && self.clocked && self.arr_now != 0
    }

    /// Counts between `since` and `now`, and the cycles that are left over.
    const fn elapsed(&self, now: u64) -> (u64, u64) {
        if !self.is_counting() {
            return (0, self.phase);
        }
        let cycles = now.saturating_sub(self.since) + self.phase;
        (cycles / self.tick(), cycles % self.tick())
    }

    /// The value after which the counter is zero again.
    const fn last(&self) -> u32 {
        if self.count > self.arr_now { mask(self.shape.bits) } else { self.arr_now }
    }

    /// Everything up to `now` has happened. Says whether anything has but counting, so that another
    /// moment may be due than before.
    pub(crate) fn advance(&mut self, now: u64) -> bool {
        let (ticks, phase) = self.elapsed(now);
        if ticks > u64::from(self.last() - self.count) {
            self.run_over(now, ticks, phase);
            return true;
        }
        let flags = self.sr;
        self.count_on(now, ticks, phase);
        self.sr != flags
    }

    /// Counts beyond the end of the counter.
    #[cold]
    fn run_over(&mut self, now: u64, mut ticks: u64, mut phase: u64) {
        while ticks > u64::from(self.last() - self.count) {
            ticks -= u64::from(self.last() - self.count) + 1;
            self.match_between(self.count, self.last());
            let tick = self.tick();
            self.overflow();
            if self.tick() != tick {
                // The prescaler's new value is in force from the overflow on.
                let cycles = ticks * tick + phase;
                (ticks, phase) = (cycles / self.tick(), cycles % self.tick());
            }
            // Whole periods are all alike, now that what was preloaded is in use.
            let period = u64::from(self.arr_now) + 1;
            if self.arr_now == 0 {
                ticks = 0;
            } else if ticks >= period {
                ticks %= period;
                self.match_between(0, self.arr_now);
                self.overflow();
            }
        }
        self.count_on(now, ticks, phase);
    }

    /// Counts some ticks, which the counter has room for.
    #[inline]
    fn count_on(&mut self, now: u64, ticks: u64, phase: u64) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "no more than the counter has room for"
        )]
        let count = self.count + ticks as u32;
        self.match_between(self.count, count);
        (self.count, self.phase, self.since) = (count, phase, now);
    }

    /// Compare flags of the values after `from` up to `to`.
    fn match_between(&mut self, from: u32, to: u32) {
        for channel in 0..self.shape.channels {
            let value = self.ccr_now[channel];
            if value > from && value <= to {
                self.sr |= 2 << channel;
            }
        }
    }

    /// From the last value to zero. A channel whose value is beyond the last one is flagged here
    /// (TIMx_SR, CC1IF).
    fn overflow(&mut self) {
        let last = self.last();
        self.count = 0;
        for channel in 0..self.shape.channels {
            if self.ccr_now[channel] > last {
                self.sr |= 2 << channel;
            }
        }
        if self.cr1 & cr1::UDIS == 0 {
            self.sr |= UPDATE;
            self.reload();
        }
        // The counter has come to zero by counting.
        for channel in 0..self.shape.channels {
            if self.ccr_now[channel] == 0 {
                self.sr |= 2 << channel;
            }
        }
    }

    /// Applies the preloaded registers.
    fn reload(&mut self) {
        self.psc_now = self.psc;
        self.arr_now = self.arr;
        self.ccr_now = self.ccr;
    }

    fn is_preloaded(&self, channel: usize) -> bool {
        self.ccmr[channel / 2] >> (8 * (channel % 2)) & 1 << 3 != 0
    }

    /// The cycle at which an enabled interrupt whose flag is not set will set it.
    pub(crate) fn due(&self) -> u64 {
        let wanted = self.dier & !self.sr & self.flags();
        if wanted == 0 || !self.is_counting() {
            return u64::MAX;
        }
        let to_overflow = u64::from(self.last() - self.count) + 1;
        let mut ticks = u64::MAX;
        if wanted & UPDATE != 0 {
            ticks = to_overflow;
        }
        for channel in 0..self.shape.channels {
            if wanted & 2 << channel != 0 {
                let value = self.ccr_now[channel];
                // What comes after the overflow may be another value by then, so that is looked at
                // again at the overflow.
                let ahead = value > self.count && value <= self.last();
                ticks = ticks.min(if ahead { u64::from(value - self.count) } else { to_overflow });
            }
        }
        self.since.saturating_add(ticks.saturating_mul(self.tick()) - self.phase)
    }

    /// The flags that this timer has: the update's and the channels'.
    const fn flags(&self) -> u32 {
        ((2 << self.shape.channels) - 1) | UPDATE
    }

    pub(crate) fn lines(&self) -> u128 {
        u128::from(self.sr & self.dier & self.flags() != 0) << self.shape.interrupt
    }

    /// The register, which is that of `now` after [`Self::advance`].
    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        let channels = self.shape.channels;
        Ok(match offset {
            0x00 => self.cr1,
            0x04 | 0x08 => 0,
            0x0C => self.dier,
            0x10 => self.sr,
            0x14 => 0,
            0x18 => self.ccmr[0],
            0x1C => self.ccmr[1],
            0x20 => self.ccer,
            0x24 => self.count,
            0x28 => self.psc,
            0x2C => self.arr,
            0x34..=0x40 if (offset as usize - 0x34) / 4 < channels => {
                self.ccr[(offset as usize - 0x34) / 4]
            }
            0x48 | 0x50 => 0,
            _ => return Err(Refused::Unmodelled { what: "TIM: a register it does not have" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, now: u64) -> Result<(), Refused> {
        let full = mask(self.shape.bits);
        let channels = self.shape.channels;
        self.advance(now);
        match offset {
            0x00 => self.set_cr1(value)?,
            0x04 => refuse(value & 0xF8 != 0, "TIM_CR2: master mode, DMA selection")?,
            0x08 => refuse(value != 0, "TIM_SMCR: slave mode, external clock")?,
            0x0C => {
                refuse(value & !self.flags() & 0x7F5F != 0, "TIM_DIER: trigger or DMA request")?;
                self.dier = value & self.flags();
            }
            // Written with 0 to clear.
            0x10 => self.sr &= value,
            0x14 => self.set_egr(value)?,
            0x18 | 0x1C => self.set_ccmr((offset as usize - 0x18) / 4, value)?,
            0x20 => {
                // Sixteen bits, which a halfword's store has in both halves of the word.
                let value = value & 0xFFFF;
                refuse(
                    value & !self.enables() != 0,
                    "TIM_CCER: a complementary or missing channel",
                )?;
                self.ccer = value;
            }
            0x24 => self.count = value & full,
            0x28 => self.psc = value & 0xFFFF,
            0x2C => {
                self.arr = value & full;
                if self.cr1 & cr1::ARPE == 0 {
                    self.arr_now = self.arr;
                }
            }
            0x34..=0x40 if (offset as usize - 0x34) / 4 < channels => {
                let channel = (offset as usize - 0x34) / 4;
                self.ccr[channel] = value & full;
                if !self.is_preloaded(channel) {
                    self.ccr_now[channel] = self.ccr[channel];
                }
            }
            0x48 | 0x4C => return Err(Refused::Unmodelled { what: "TIM_DCR, TIM_DMAR: bursts" }),
            0x50 => refuse(value != 0, "TIM_OR: remapping")?,
            _ => return Err(Refused::Unmodelled { what: "TIM: a register it does not have" }),
        }
        Ok(())
    }

    fn set_cr1(&mut self, value: u32) -> Result<(), Refused> {
        refuse(value & cr1::OPM != 0, "TIM_CR1: one-pulse mode")?;
        refuse(value & (cr1::DIR | cr1::CMS) != 0, "TIM_CR1: counting down")?;
        const KNOWN: u32 = cr1::CEN | cr1::UDIS | cr1::URS | cr1::ARPE | cr1::CKD;
        self.cr1 = value & KNOWN;
        if value & cr1::ARPE == 0 {
            self.arr_now = self.arr;
        }
        Ok(())
    }

    fn set_egr(&mut self, value: u32) -> Result<(), Refused> {
        refuse(value & !self.flags() & 0xFF != 0, "TIM_EGR: trigger, break or missing channel")?;
        self.sr |= value & self.flags() & !UPDATE;
        if value & UPDATE != 0 {
            (self.count, self.phase) = (0, 0);
            if self.cr1 & cr1::UDIS == 0 {
                self.reload();
                if self.cr1 & cr1::URS == 0 {
                    self.sr |= UPDATE;
                }
            }
        }
        Ok(())
    }

    fn set_ccmr(&mut self, half: usize, value: u32) -> Result<(), Refused> {
        refuse(2 * half >= self.shape.channels, "TIM_CCMR: a register it does not have")?;
        for channel in [2 * half, 2 * half + 1] {
            let field = value >> (8 * (channel % 2)) & 0xFF;
            refuse(field != 0 && channel >= self.shape.channels, "TIM_CCMR: a missing channel")?;
            refuse(field & 3 != 0, "TIM_CCMR: input capture")?;
            refuse(field & 0x84 != 0, "TIM_CCMR: OCxFE, OCxCE")?;
            refuse(
                matches!(field >> 4 & 7, 1..=3),
                "TIM_CCMR: active, inactive or toggle on match",
            )?;
        }
        self.ccmr[half] = value & 0xFFFF;
        for channel in 2 * half..(2 * half + 2).min(self.shape.channels) {
            if !self.is_preloaded(channel) {
                self.ccr_now[channel] = self.ccr[channel];
            }
        }
        Ok(())
    }

    /// TIMx_CCER: CCxE and CCxP of the channels that are there.
    const fn enables(&self) -> u32 {
        ((0x3333_u32 as u64) & ((1 << (4 * self.shape.channels)) - 1)) as u32
    }

    /// The output of a channel; channel 0 is the first.
    pub(crate) fn output(&self, channel: usize, now: u64) -> Output {
        if channel >= self.shape.channels || self.ccer >> (4 * channel) & 1 == 0 {
            return Output::Off;
        }
        let mut timer = self.clone();
        timer.advance(now);
        timer.output_now(channel)
    }

    fn output_now(&self, channel: usize) -> Output {
        let is_inverted = self.ccer >> (4 * channel) & 2 != 0;
        let level = |high: bool| if high != is_inverted { Output::High } else { Output::Low };
        let (compare, period) = (self.ccr_now[channel], u64::from(self.arr_now) + 1);
        let first = match self.ccmr[channel / 2] >> (8 * (channel % 2) + 4) & 7 {
            5 => return level(true),
            6 => true,
            7 => false,
            // Frozen since reset, or forced inactive.
            _ => return level(false),
        };
        let high = u64::from(compare).min(period);
        if !self.is_counting() || high == 0 || high == period {
            return level((self.count < compare) == first);
        }
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let share = high as f32 / period as f32;
        let duty = if first != is_inverted { share } else { 1.0 - share };
        Output::Pwm { duty, period: period * self.tick() }
    }

    /// The timer's clock is another from `now` on, or is switched on or off.
    pub(crate) fn clock(&mut self, now: u64, divider: u64, clocked: bool) {
        self.advance(now);
        if divider != self.divider {
            // What the prescaler had counted, in the new unit.
            self.phase = self.phase / self.divider * divider;
            self.divider = divider;
        }
        self.clocked = clocked;
    }

    pub(crate) fn reset(&mut self, now: u64) {
        *self = Self {
            since: now,
            divider: self.divider,
            clocked: self.clocked,
            ..Self::new(self.shape)
        };
    }

    /// Everything that tells one state from another, as it is at `now`.
    pub(crate) fn words(&self, now: u64) -> [u32; 12] {
        let mut timer = self.clone();
        timer.advance(now);
        let [one, two, three, four] = timer.ccr;
        [
            timer.cr1,
            timer.dier,
            timer.sr,
            timer.ccer,
            timer.count,
            timer.psc,
            timer.arr,
            one,
            two,
            three,
            four,
            timer.ccmr[0] | timer.ccmr[1] << 16,
        ]
    }
}

const fn mask(bits: u32) -> u32 {
    u32::MAX >> (32 - bits)
}

fn refuse(is_unknown: bool, what: &'static str) -> Result<(), Refused> {
    if is_unknown { Err(Refused::Unmodelled { what }) } else { Ok(()) }
}
