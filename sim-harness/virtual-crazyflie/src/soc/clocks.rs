//! The chip's clock frequencies, and the conversion of cycles to nanoseconds.
//!
//! The core's cycle counter is the one clock; moments in nanoseconds are derived from it by an
//! anchor, which is set anew whenever the frequency changes. The anchor is kept to 2⁻⁶⁴ ns, and
//! everything after it is exact, so there is no drift however long it runs.

use crate::soc::wiring::Nanos;

/// A frequency: `numerator / denominator` Hz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frequency {
    numerator: u64,
    denominator: u64,
}

impl Frequency {
    /// Must not be zero.
    pub(crate) const fn hertz(hertz: u32) -> Self {
        Self { numerator: hertz as u64, denominator: 1 }
    }

    pub(crate) const fn times(self, factor: u32) -> Self {
        Self { numerator: self.numerator * factor as u64, ..self }
    }

    pub(crate) const fn over(self, divisor: u32) -> Self {
        Self { denominator: self.denominator * divisor as u64, ..self }
    }

    /// The frequency in Hz, rounded down.
    pub(crate) const fn floor(self) -> u64 {
        self.numerator / self.denominator
    }

    /// Whether it is higher than so many Hz.
    pub(crate) const fn above(self, hertz: u64) -> bool {
        self.numerator > hertz * self.denominator
    }

    /// Whether it is lower than so many Hz.
    pub(crate) const fn below(self, hertz: u64) -> bool {
        self.numerator < hertz * self.denominator
    }

    /// The frequency as text.
    #[expect(clippy::cast_precision_loss, reason = "for people")]
    pub(crate) fn as_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

/// A span of time of whole nanoseconds and 2⁻⁶⁴ ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Moment {
    whole: u64,
    fraction: u64,
}

/// The clock tree as it stands.
#[derive(Clone, Debug)]
pub(crate) struct Clocks {
    hclk: Frequency,
    apb1: u64,
    apb2: u64,
    /// The moment of cycle `since`.
    anchor: Moment,
    since: u64,
    /// One cycle is `period.0 / period.1` ns, in lowest terms.
    period: (u64, u64),
    /// What of a nanosecond has to have passed, in parts of `period.1`, that with the anchor's
    /// fraction it is a whole one.
    carry: u64,
}

impl Clocks {
    /// A clock from cycle 0 at 0 ns, without prescalers.
    pub(crate) fn new(hclk: Frequency) -> Self {
        Self {
            hclk,
            apb1: 1,
            apb2: 1,
            anchor: Moment { whole: 0, fraction: 0 },
            since: 0,
            period: period(hclk),
            carry: period(hclk).1,
        }
    }

    /// Changes the clock from `now` on. `apb1` and `apb2` are HCLK over PCLK1 and PCLK2.
    pub(crate) fn change(&mut self, now: u64, hclk: Frequency, apb1: u64, apb2: u64) {
        if hclk != self.hclk {
            self.anchor = self.moment(now);
            self.since = now;
            self.hclk = hclk;
            self.period = period(hclk);
            self.carry = carry(self.anchor.fraction, self.period.1);
        }
        (self.apb1, self.apb2) = (apb1, apb2);
    }

    /// The core's frequency.
    pub(crate) const fn hclk(&self) -> Frequency {
        self.hclk
    }

    /// Cycles of the core in a cycle of APB1: a power of two.
    pub(crate) const fn apb1(&self) -> u64 {
        self.apb1
    }

    /// Cycles of the core in a cycle of APB2.
    pub(crate) const fn apb2(&self) -> u64 {
        self.apb2
    }

    /// Cycles of the core in a clock of APB1's timers, which run twice as fast as the bus when
    /// that is divided (RM0090, "Clocks").
    pub(crate) const fn timers1(&self) -> u64 {
        timers(self.apb1)
    }

    /// The same for APB2's timers.
    pub(crate) const fn timers2(&self) -> u64 {
        timers(self.apb2)
    }

    /// The moment of a cycle, rounded down. Of a cycle before the last change of frequency, what
    /// it would have been at today's.
    pub(crate) fn nanos(&self, cycle: u64) -> Nanos {
        let (whole, rest) = self.split(cycle);
        self.anchor.whole.saturating_add(whole).saturating_add(u64::from(rest >= self.carry))
    }

    /// The first cycle whose moment, as [`Self::nanos`] has it, is not before `nanos`.
    /// `u64::MAX` for `u64::MAX`, and for what is too far to be counted.
    pub(crate) fn cycle(&self, nanos: Nanos) -> u64 {
        let Some(after) = nanos.checked_sub(self.anchor.whole).filter(|after| *after != 0) else {
            return self.since;
        };
        if nanos == Nanos::MAX {
            return u64::MAX;
        }
        // The least n with n·p >= (after - 1)·q + carry.
        let (p, q) = self.period;
        let parts = (after - 1).checked_mul(q).and_then(|parts| parts.checked_add(self.carry));
        let cycles = match parts {
            Some(parts) => parts.div_ceil(p),
            None => {
                let parts = u128::from(after - 1) * u128::from(q) + u128::from(self.carry);
                u64::try_from(parts.div_ceil(p.into())).unwrap_or(u64::MAX)
            }
        };
        self.since.saturating_add(cycles)
    }

    /// Nanoseconds since the anchor, and parts of one.
    fn split(&self, cycle: u64) -> (u64, u64) {
        let (p, q) = self.period;
        let cycles = cycle.saturating_sub(self.since);
        match cycles.checked_mul(p) {
            Some(product) => (product / q, product % q),
            None => wide(cycles, p, q),
        }
    }

    fn moment(&self, cycle: u64) -> Moment {
        let (_, rest) = self.split(cycle);
        #[expect(clippy::cast_possible_truncation, reason = "rest is less than the divisor")]
        let part = ((u128::from(rest) << 64) / u128::from(self.period.1)) as u64;
        let fraction = self.anchor.fraction.wrapping_add(part);
        Moment { whole: self.nanos(cycle), fraction }
    }
}

/// The least `rest` with rest / q + fraction / 2⁶⁴ >= 1.
fn carry(fraction: u64, q: u64) -> u64 {
    let missing = (1_u128 << 64) - u128::from(fraction);
    #[expect(clippy::cast_possible_truncation, reason = "no more than q")]
    let carry = (missing * u128::from(q)).div_ceil(1 << 64) as u64;
    carry
}

fn wide(cycles: u64, p: u64, q: u64) -> (u64, u64) {
    let product = u128::from(cycles) * u128::from(p);
    let whole = u64::try_from(product / u128::from(q)).unwrap_or(u64::MAX);
    #[expect(clippy::cast_possible_truncation, reason = "a remainder of q")]
    let rest = (product % u128::from(q)) as u64;
    (whole, rest)
}

const fn timers(bus: u64) -> u64 {
    if bus == 1 { 1 } else { bus / 2 }
}

/// Nanoseconds of a cycle, in lowest terms.
const fn period(frequency: Frequency) -> (u64, u64) {
    let nanos = frequency.denominator * 1_000_000_000;
    let (mut a, mut b) = (nanos, frequency.numerator);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    (nanos / a, frequency.numerator / a)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Frequencies as RCC makes them of 16 or 8 MHz.
    fn frequency() -> impl Strategy<Value = Frequency> {
        (
            prop_oneof![Just(16_000_000_u32), Just(8_000_000), 15_840_000..16_160_000_u32],
            2..=63_u32,
            50..=432_u32,
            1..=512_u32,
        )
            .prop_map(|(source, m, n, over)| Frequency::hertz(source).times(n).over(m).over(over))
    }

    fn changed(steps: &[(u64, Frequency)]) -> (Clocks, u64) {
        let mut clocks = Clocks::new(Frequency::hertz(16_000_000));
        let mut now = 0;
        for (cycles, frequency) in steps {
            now += cycles;
            clocks.change(now, *frequency, 1, 1);
        }
        (clocks, now)
    }

    proptest! {
        #[test]
        fn the_cycle_of_a_moment_is_the_first_that_is_not_before_it(
            steps in prop::collection::vec((0..1_000_000_000_u64, frequency()), 0..6),
            after in 1..1_000_000_000_000_u64,
        ) {
            let (clocks, now) = changed(&steps);
            let moment = clocks.nanos(now) + after;
            let cycle = clocks.cycle(moment);
            prop_assert!(clocks.nanos(cycle) >= moment);
            prop_assert!(clocks.nanos(cycle - 1) < moment);
        }

        #[test]
        fn a_cycle_comes_back_from_its_moment_or_one_that_shares_it(
            steps in prop::collection::vec((0..1_000_000_000_u64, frequency()), 0..6),
            after in 1..10_000_000_000_u64,
        ) {
            let (clocks, now) = changed(&steps);
            let cycle = clocks.cycle(clocks.nanos(now + after));
            prop_assert!(cycle <= now + after);
            prop_assert_eq!(clocks.nanos(cycle), clocks.nanos(now + after));
        }

        #[test]
        fn time_does_not_jump_when_the_frequency_changes(
            steps in prop::collection::vec((0..1_000_000_000_u64, frequency()), 1..20),
        ) {
            let mut clocks = Clocks::new(Frequency::hertz(16_000_000));
            let mut now = 0;
            for (cycles, frequency) in steps {
                now += cycles;
                let before = clocks.nanos(now);
                clocks.change(now, frequency, 1, 1);
                prop_assert_eq!(clocks.nanos(now), before);
            }
        }

        /// Against exact fractions: a day at one frequency after a second at another.
        #[test]
        fn there_is_no_drift(frequency in frequency(), cycles in 0..1_u64 << 43) {
            let (clocks, now) = changed(&[(16_000_000, frequency)]);
            let exact = u128::from(cycles) * u128::from(frequency.denominator) * 1_000_000_000
                / u128::from(frequency.numerator);
            prop_assert_eq!(u128::from(clocks.nanos(now + cycles)), 1_000_000_000 + exact);
        }
    }

    #[test]
    fn a_thousand_changes_of_frequency_do_not_add_up_to_a_nanosecond() {
        let pll = Frequency::hertz(8_000_000).times(336).over(16);
        let steps: Vec<_> = (0..1000)
            .map(|n| (168_001, if n % 2 == 0 { pll } else { Frequency::hertz(16_000_000) }))
            .collect();
        let (clocks, now) = changed(&steps);
        // 500 stretches at each, of 125/2 and 125/21 ns a cycle.
        let exact = 168_001_u64 * 500 * 125 * 23 / 42;
        assert!(clocks.nanos(now).abs_diff(exact) <= 1);
    }

    #[test]
    fn what_never_happens_has_no_cycle() {
        let clocks = Clocks::new(Frequency::hertz(16_000_000));
        assert_eq!(clocks.cycle(Nanos::MAX), u64::MAX);
        assert_eq!(clocks.cycle(0), 0);
    }

    #[test]
    fn timers_run_twice_as_fast_as_a_divided_bus() {
        let mut clocks = Clocks::new(Frequency::hertz(168_000_000));
        clocks.change(0, Frequency::hertz(168_000_000), 4, 2);
        assert_eq!((clocks.apb1(), clocks.timers1()), (4, 2));
        assert_eq!((clocks.apb2(), clocks.timers2()), (2, 1));
        clocks.change(0, Frequency::hertz(16_000_000), 1, 1);
        assert_eq!((clocks.timers1(), clocks.timers2()), (1, 1));
    }
}
