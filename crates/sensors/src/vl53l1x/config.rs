//! The configuration of a sensor (distance mode, timing budget and period), and its conversion to
//! register values.

use units::Duration;

/// A distance mode: one of the two presets of ST's Ultra Lite Driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DistanceMode {
    /// Ranges up to 1.3 m, hardly disturbed by sunlight.
    Short,
    /// Ranges up to 4 m in the dark.
    Long,
}

/// The distance mode and timing of one sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// The distance mode.
    pub mode: DistanceMode,
    /// The time for one measurement: 20 to 500 ms, in [`DistanceMode::Short`] 15 to 500 ms.
    pub budget: Duration,
    /// The time from one measurement to the next: at least the budget (UM2510), at most a minute.
    /// If it equals the budget, the next measurement begins as soon as the last is over.
    pub period: Duration,
}

impl Config {
    /// The configuration of the ranger that looks down: 25 ms, 40 measurements a second, as in
    /// crazyflie-firmware's `zranger2.c`, which uses a preset for middle distances that the Ultra
    /// Lite Driver does not have.
    ///
    /// That driver knows no 25 ms, but the sensor does: it is given no budget, only timeouts, and
    /// ST's full driver, which the vendor's firmware links, makes them of any budget:
    /// (25 ms - 4.5 ms) / 2 for each of two measurements (`vl53l1_api.c`,
    /// `VL53L1_SetMeasurementTimingBudgetMicroSeconds`). Those here, between the ones of 20 and 33
    /// ms in the Ultra Lite Driver's table, are half as long: the measurement is over in time.
    /// ST recommends 33 ms for long distances (UM2356); less light is gathered in 25, so that σ is
    /// larger and the reach over a dark floor shorter.
    pub const DOWN: Self = Self {
        mode: DistanceMode::Long,
        budget: Duration::from_millis(25),
        period: Duration::from_millis(25),
    };

    /// The configuration of the rangers that look sideways and up: 33 ms, 30 measurements a second,
    /// the shortest budget that ST recommends for all distances (UM2356). The data sheet's reach in
    /// the dark, 3.6 m on white and 1.7 m on 17 % grey, is for a budget of 100 ms, of which 80 ms
    /// are spent ranging; here 19 ms are, and σ is about twice as large.
    pub const SIDE: Self = Self {
        mode: DistanceMode::Long,
        budget: Duration::from_millis(33),
        period: Duration::from_millis(33),
    };

    const LONGEST_PERIOD: Duration = Duration::from_secs(60);

    /// The register values of this configuration for a sensor whose oscillator was calibrated to
    /// `oscillator`; `None` if the sensor does not support it.
    pub(super) fn registers(&self, oscillator: u16) -> Option<Registers> {
        if self.period < self.budget || self.period > Self::LONGEST_PERIOD {
            return None;
        }
        let (timeout_a, timeout_b) = timeouts(self.mode, self.budget)?;
        Some(Registers {
            preset: Preset::of(self.mode),
            timeout_a,
            timeout_b,
            period: period_word(self.period, oscillator),
        })
    }
}

/// The register values that depend on a [`Config`].
#[derive(Clone, Copy)]
pub(super) struct Registers {
    pub(super) preset: Preset,
    pub(super) timeout_a: u16,
    pub(super) timeout_b: u16,
    pub(super) period: u32,
}

/// The register values of a distance mode (`VL53L1X_SetDistanceMode`).
#[derive(Clone, Copy)]
pub(super) struct Preset {
    pub(super) phasecal_timeout: u8,
    pub(super) vcsel_period_a: u8,
    pub(super) vcsel_period_b: u8,
    pub(super) valid_phase_high: u8,
    pub(super) window: u16,
    pub(super) initial_phase: u16,
}

impl Preset {
    const fn of(mode: DistanceMode) -> Self {
        match mode {
            DistanceMode::Short => Self {
                phasecal_timeout: 0x14,
                vcsel_period_a: 0x07,
                vcsel_period_b: 0x05,
                valid_phase_high: 0x38,
                window: 0x0705,
                initial_phase: 0x0606,
            },
            DistanceMode::Long => Self {
                phasecal_timeout: 0x0A,
                vcsel_period_a: 0x0F,
                vcsel_period_b: 0x0D,
                valid_phase_high: 0xB8,
                window: 0x0F0D,
                initial_phase: 0x0E0E,
            },
        }
    }
}

/// A budget in ms and the register values of its two timeouts.
type Row = (u32, u16, u16);

/// The table of `VL53L1X_SetTimingBudgetInMs` for short distances.
const SHORT: [Row; 7] = [
    (15, 0x001D, 0x0027),
    (20, 0x0051, 0x006E),
    (33, 0x00D6, 0x006E),
    (50, 0x01AE, 0x01E8),
    (100, 0x02E1, 0x0388),
    (200, 0x03E1, 0x0496),
    (500, 0x0591, 0x05C1),
];

/// The table of `VL53L1X_SetTimingBudgetInMs` for long distances.
const LONG: [Row; 6] = [
    (20, 0x001E, 0x0022),
    (33, 0x0060, 0x006E),
    (50, 0x00AD, 0x00C6),
    (100, 0x01CC, 0x01EA),
    (200, 0x02D9, 0x02F8),
    (500, 0x048F, 0x04A4),
];

/// The timeouts of a budget: ST's own where ST gives them, interpolated in between. The
/// interpolation keeps the time beside ranging between the values that it has at the two budgets of
/// ST's table.
fn timeouts(mode: DistanceMode, budget: Duration) -> Option<(u16, u16)> {
    let table: &[Row] = match mode {
        DistanceMode::Short => &SHORT,
        DistanceMode::Long => &LONG,
    };
    let micros = u32::try_from(budget.as_micros()).ok()?;
    table.windows(2).find_map(|pair| match pair {
        [low, high] => interpolated(micros, *low, *high),
        _ => None,
    })
}

/// The timeouts of a budget that is interpolated between the rows `low` and `high`, if it lies
/// there.
fn interpolated(micros: u32, low: Row, high: Row) -> Option<(u16, u16)> {
    let (from, to) = (low.0 * 1_000, high.0 * 1_000);
    if !(from..=to).contains(&micros) {
        return None;
    }
    let at = |low: u16, high: u16| {
        let (low, high) = (macro_periods(low), macro_periods(high));
        let part = (high.saturating_sub(low) * (micros - from)).checked_div(to - from)?;
        Some(encode(low + part))
    };
    Some((at(low.1, high.1)?, at(low.2, high.2)?))
}

/// Decodes a timeout register to macro periods: (low byte · 2^high byte) + 1.
const fn macro_periods(word: u16) -> u32 {
    (((word & 0xFF) as u32) << ((word >> 8) & 0x0F)) + 1
}

/// Encodes the longest timeout that is not longer than `periods` macro periods.
fn encode(periods: u32) -> u16 {
    let value = periods.saturating_sub(1);
    let exponent = (u32::BITS - value.leading_zeros()).saturating_sub(8);
    ((exponent as u16) << 8) | (value >> exponent) as u16
}

/// The value of SYSTEM__INTERMEASUREMENT_PERIOD: the low ten bits of the oscillator's calibration
/// are its ticks in a millisecond, and the factor 1.075 is ST's
/// (`VL53L1X_SetInterMeasurementInMs`).
fn period_word(period: Duration, oscillator: u16) -> u32 {
    let ticks = u64::from(oscillator & 0x03FF);
    let word = ticks * period.as_micros() * 1_075 / 1_000_000;
    u32::try_from(word).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_of_sts_table_has_the_tables_timeouts() {
        for (mode, table) in [(DistanceMode::Short, &SHORT[..]), (DistanceMode::Long, &LONG[..])] {
            for (ms, a, b) in table {
                let budget = Duration::from_millis(u64::from(*ms));
                assert_eq!(timeouts(mode, budget), Some((*a, *b)), "{mode:?}, {ms} ms");
            }
        }
    }

    /// Two measurements of 10.2 ms each, as ST's full driver would have them. A macro period is 2304
    /// periods of the laser, of 32 and 28 clocks, of 1.324 ns (`vl53l1_core.c`,
    /// `VL53L1_calc_macro_period_us`, at the usual 11.8 MHz).
    #[test]
    fn the_budget_of_the_ranger_that_looks_down_is_long_enough_for_its_timeouts() {
        let (a, b) = timeouts(Config::DOWN.mode, Config::DOWN.budget).unwrap();
        for (word, clocks) in [(a, 32.0), (b, 28.0)] {
            let micros = f64::from(macro_periods(word)) * 2304.0 * clocks * 1.324e-3;
            assert!((5_000.0..0.6 * 10_200.0).contains(&micros), "{micros}");
        }
    }

    #[test]
    fn a_longer_budget_never_has_a_shorter_timeout() {
        for mode in [DistanceMode::Short, DistanceMode::Long] {
            let mut before = (0, 0);
            for micros in (20_000..=500_000).step_by(250) {
                let (a, b) = timeouts(mode, Duration::from_micros(micros)).unwrap();
                let now = (macro_periods(a), macro_periods(b));
                assert!(now.0 >= before.0 && now.1 >= before.1, "{mode:?} at {micros} us");
                before = now;
            }
        }
    }

    #[test]
    fn a_budget_outside_sts_table_is_refused() {
        for (mode, micros) in [
            (DistanceMode::Short, 14_999),
            (DistanceMode::Long, 19_999),
            (DistanceMode::Short, 500_001),
            (DistanceMode::Long, u64::MAX),
            (DistanceMode::Long, 0),
        ] {
            assert_eq!(timeouts(mode, Duration::from_micros(micros)), None, "{mode:?} {micros}");
        }
    }

    #[test]
    fn encoding_never_lengthens_a_timeout_and_shortens_it_by_less_than_one_part_in_128() {
        for periods in (1..70_000).step_by(7) {
            let kept = macro_periods(encode(periods));
            assert!(kept <= periods && periods - kept <= periods / 128, "{kept} of {periods}");
        }
    }

    #[test]
    fn a_period_is_sts_number_of_ticks() {
        // 100 ms with 0x03FF ticks: (uint32_t)(1023 * 100 * 1.075).
        assert_eq!(period_word(Duration::from_millis(100), 0xFFFF), 109_972);
        assert_eq!(period_word(Duration::from_millis(33), 800), 28_380);
    }
}
