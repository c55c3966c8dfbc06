//! Which exceptions are pending, active and enabled, with what priority, and which of them may
//! come in (DDI 0403, B1.5.4, and B3.4 for interrupts).
//!
//! Each change computes the highest pending exception anew, so that the run loop's question is one
//! load.

/// Interrupts of an STM32F405: 0 to 81 (RM0090, "Vector table").
pub(crate) const INTERRUPTS: u16 = 82;
/// Exceptions: those of the core, then the interrupts.
const EXCEPTIONS: usize = 16 + INTERRUPTS as usize;

/// Numbers of the exceptions that the core has by itself (B1.5.2).
pub(crate) mod number {
    pub(crate) const NMI: u16 = 2;
    pub(crate) const HARD_FAULT: u16 = 3;
    pub(crate) const MEM_MANAGE: u16 = 4;
    pub(crate) const BUS_FAULT: u16 = 5;
    pub(crate) const USAGE_FAULT: u16 = 6;
    pub(crate) const SV_CALL: u16 = 11;
    pub(crate) const DEBUG_MONITOR: u16 = 12;
    pub(crate) const PEND_SV: u16 = 14;
    pub(crate) const SYS_TICK: u16 = 15;
    pub(crate) const FIRST_INTERRUPT: u16 = 16;
}

use number::{FIRST_INTERRUPT, HARD_FAULT, NMI, PEND_SV, SV_CALL, SYS_TICK};

/// The priority of what no exception has interrupted: lower than any.
const BASE: i16 = 256;

/// The exceptions that are always enabled.
const ALWAYS: u128 = bit(NMI) | bit(HARD_FAULT) | bit(SV_CALL) | bit(PEND_SV) | bit(SYS_TICK);

const ALL_INTERRUPTS: u128 = ((1 << INTERRUPTS) - 1) << FIRST_INTERRUPT;

/// Sets of exceptions are words in which bit n stands for exception n.
pub(crate) const fn bit(exception: u16) -> u128 {
    1 << exception
}

/// The state of all exceptions.
#[derive(Clone, Debug)]
pub(crate) struct Priorities {
    pending: u128,
    active: u128,
    enabled: u128,
    /// Interrupts whose line is high.
    lines: u128,
    priority: [u8; EXCEPTIONS],
    /// AIRCR.PRIGROUP.
    grouping: u8,
    primask: bool,
    faultmask: bool,
    basepri: u8,
    /// The highest of the pending and enabled exceptions, and its group priority.
    best: Option<u16>,
    best_priority: i16,
    /// The highest group priority of what is active.
    running: i16,
    wants_in: bool,
}

impl Default for Priorities {
    fn default() -> Self {
        Self {
            pending: 0,
            active: 0,
            enabled: ALWAYS,
            lines: 0,
            priority: [0; EXCEPTIONS],
            grouping: 0,
            primask: false,
            faultmask: false,
            basepri: 0,
            best: None,
            best_priority: BASE,
            running: BASE,
            wants_in: false,
        }
    }
}

impl Priorities {
    /// Whether a pending exception has a higher priority than the running code.
    #[inline(always)]
    pub(crate) const fn wants_in(&self) -> bool {
        self.wants_in
    }

    /// The exception that would come in first, whether it may or not.
    pub(crate) const fn best(&self) -> Option<u16> {
        self.best
    }

    /// ExecutionPriority().
    pub(crate) fn execution(&self) -> i16 {
        let masks = match (self.faultmask, self.primask) {
            (true, _) => -1,
            (false, true) => 0,
            (false, false) => self.basepri_ceiling(),
        };
        masks.min(self.running)
    }

    /// The priority of BASEPRI: exceptions at it and below are masked.
    fn basepri_ceiling(&self) -> i16 {
        if self.basepri == 0 { BASE } else { self.group(i16::from(self.basepri)) }
    }

    /// Whether something pending ends WFI: what would come in if PRIMASK were clear (B1.5.19).
    pub(crate) fn wakes(&self) -> bool {
        let mask = if self.faultmask { -1 } else { self.basepri_ceiling() };
        self.best.is_some() && self.best_priority < mask.min(self.running)
    }

    /// ICSR.VECTPENDING: like [`best`](Self::best), but nothing that FAULTMASK or BASEPRI masks.
    pub(crate) fn vect_pending(&self) -> u16 {
        let mask = if self.faultmask { -1 } else { self.basepri_ceiling() };
        self.best.filter(|_| self.best_priority < mask).unwrap_or(0)
    }

    /// The priority of an exception, with its subpriority.
    pub(crate) fn priority(&self, exception: u16) -> i16 {
        match exception {
            0..=1 => -3,
            NMI => -2,
            HARD_FAULT => -1,
            _ => i16::from(self.priority[usize::from(exception)]),
        }
    }

    /// The part of a priority that decides which exception interrupts which (B1.5.4, "Priority
    /// grouping").
    fn group(&self, priority: i16) -> i16 {
        if priority < 0 { priority } else { priority & !((2 << self.grouping) - 1) }
    }

    /// The group priority of an exception.
    pub(crate) fn group_priority(&self, exception: u16) -> i16 {
        self.group(self.priority(exception))
    }

    /// Whether a synchronous exception would come in at once. Otherwise it escalates.
    pub(crate) fn may_enter(&self, exception: u16) -> bool {
        self.enabled & bit(exception) != 0 && self.group_priority(exception) < self.execution()
    }

    /// Makes exceptions pending. Says whether any was not.
    pub(crate) fn pend(&mut self, set: u128) -> bool {
        let new = set & !self.pending;
        self.pending |= set;
        if new != 0 {
            self.choose();
        }
        new != 0
    }

    /// Takes back that they are pending. An interrupt whose line is high is still asked for.
    pub(crate) fn unpend(&mut self, set: u128) {
        self.pending &= !(set & !self.lines);
        self.choose();
    }

    /// The levels of all interrupt lines, bit 0 for interrupt 0. Each that has risen makes its
    /// interrupt pending, be it active or not. Says whether any was not.
    #[inline]
    pub(crate) fn set_lines(&mut self, lines: u128) -> bool {
        let lines = lines << FIRST_INTERRUPT & ALL_INTERRUPTS;
        let risen = lines & !self.lines;
        self.lines = lines;
        risen != 0 && self.pend(risen)
    }

    /// Whether these are the levels already.
    #[inline(always)]
    pub(crate) const fn has_lines(&self, lines: u128) -> bool {
        lines == self.lines >> FIRST_INTERRUPT
    }

    /// Enters an exception: it is active, and no longer pending.
    pub(crate) fn activate(&mut self, exception: u16) {
        self.pending &= !bit(exception);
        self.active |= bit(exception);
        self.rank();
        self.choose();
    }

    /// It returns. An interrupt whose line is still high becomes pending again, and FAULTMASK is
    /// cleared by every return but NMI's (DeActivate()).
    pub(crate) fn deactivate(&mut self, exception: u16) {
        self.active &= !bit(exception);
        self.pending |= self.lines & bit(exception);
        if exception != NMI {
            self.faultmask = false;
        }
        self.rank();
        self.choose();
    }

    /// Sets or clears active bits as SHCSR lets software do.
    pub(crate) fn set_active(&mut self, set: u128, active: bool) {
        self.active = if active { self.active | set } else { self.active & !set };
        self.rank();
    }

    /// Enables or disables.
    pub(crate) fn set_enabled(&mut self, set: u128, enabled: bool) {
        self.enabled = if enabled { self.enabled | set } else { self.enabled & !set };
        self.choose();
    }

    /// The upper four bits exist.
    pub(crate) fn set_priority(&mut self, exception: u16, priority: u8) {
        if let Some(at) = self.priority.get_mut(usize::from(exception)) {
            *at = priority & 0xF0;
        }
        self.rank();
        self.choose();
    }

    /// AIRCR.PRIGROUP.
    pub(crate) fn set_grouping(&mut self, grouping: u8) {
        self.grouping = grouping & 7;
        self.rank();
        self.choose();
    }

    /// PRIMASK.
    #[inline]
    pub(crate) fn set_primask(&mut self, on: bool) {
        self.primask = on;
        self.weigh();
    }

    /// FAULTMASK.
    pub(crate) fn set_faultmask(&mut self, on: bool) {
        self.faultmask = on;
        self.weigh();
    }

    /// BASEPRI.
    pub(crate) fn set_basepri(&mut self, value: u8) {
        self.basepri = value & 0xF0;
        self.weigh();
    }

    pub(crate) const fn primask(&self) -> bool {
        self.primask
    }

    pub(crate) const fn faultmask(&self) -> bool {
        self.faultmask
    }

    pub(crate) const fn basepri(&self) -> u8 {
        self.basepri
    }

    pub(crate) const fn grouping(&self) -> u8 {
        self.grouping
    }

    pub(crate) const fn pending(&self) -> u128 {
        self.pending
    }

    pub(crate) const fn active(&self) -> u128 {
        self.active
    }

    pub(crate) const fn enabled(&self) -> u128 {
        self.enabled
    }

    /// Of what is pending and enabled, the highest priority with its subpriority; of several, the
    /// lowest number.
    fn choose(&mut self) {
        let mut left = self.pending & self.enabled;
        let (mut best, mut priority) = (None, BASE);
        while left != 0 {
            let exception = left.trailing_zeros() as u16;
            left &= left - 1;
            let its = self.priority(exception);
            if its < priority {
                (best, priority) = (Some(exception), its);
            }
        }
        self.best = best;
        self.best_priority = best.map_or(BASE, |_| self.group(priority));
        self.weigh();
    }

    /// The highest group priority of what is active.
    fn rank(&mut self) {
        let mut left = self.active;
        self.running = BASE;
        while left != 0 {
            let exception = left.trailing_zeros() as u16;
            left &= left - 1;
            self.running = self.running.min(self.group_priority(exception));
        }
        self.weigh();
    }

    #[inline]
    fn weigh(&mut self) {
        self.wants_in = self.best_priority < self.execution();
    }
}

#[cfg(test)]
mod tests;
