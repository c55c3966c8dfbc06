//! Estimates the battery's charge and endurance.
//!
//! The voltage under load says little about the charge: 0.3 V of it come and go with the throttle,
//! and with an aged battery 0.8 V. The resting voltage is estimated by adding the drop over the
//! internal resistance, which is measured at each take-off. The charge follows from the resting
//! voltage, and the endurance from the charge.

use units::{Duration, Instant, Volts};

use crate::io;

/// The constants of a battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryConfig {
    /// The charge of a full battery, A s.
    pub capacity: f32,
    /// Internal resistance of a new battery with connector and cables, Ω.
    pub resistance: f32,
    /// The least and the largest internal resistance that is believed, Ω.
    pub resistances: (f32, f32),
    /// After the motors have started, the internal resistance is measured from the first of these
    /// times to the second, s.
    pub measured_within: (f32, f32),
    /// Current at hover, A.
    pub hover_current: f32,
    /// The time constant of the smoothed voltage, s.
    pub smoothing: f32,
    /// The voltage under load below which the battery is critical, V, if it stays there for
    /// [`critical_for`](Self::critical_for).
    pub critical: f32,
    /// The time for which the voltage must stay below [`critical`](Self::critical).
    pub critical_for: Duration,
    /// The lowest resting voltage at which a flight may begin, V.
    pub least_to_fly: f32,
    /// A reading in flight is rejected if it raises the estimated resting voltage by more than this,
    /// V: that estimate does not depend on the load, and charging takes minutes. With the motors off
    /// a battery recovers, and when they have just started the resistance is not known, so no
    /// reading is rejected then.
    pub most_gain: f32,
    /// The time after which the last plausible reading is forgotten.
    pub kept_for: Duration,
    /// The fraction of the charge that the endurance leaves out.
    pub reserve: f32,
}

impl BatteryConfig {
    /// The Crazyflie's 250 mAh cell. A bare Crazyflie hovers for 7 minutes (product page), which is
    /// 2.1 A; power grows with thrust to the 3/2, so 13 % more mass need 2.5 A. The critical
    /// voltage, its 5 s and the time constant (0.01 of a step at 1 kHz) are the vendor's
    /// (`platform_defaults_cf2.h`). Internal resistance: 0.3 V between hover and rest at 2.1 A; one
    /// of 0.45 Ω leaves a full battery 3.1 V. The motors' speed has settled 0.3 s after the start,
    /// and in 1.5 s a hover takes a two-hundredth of the charge. A resting voltage of 3.7 V is a
    /// tenth of the charge. The uncertainty of the load's drop is 0.1 V.
    pub const DEFAULT: Self = Self {
        capacity: 0.250 * 3_600.0,
        resistance: 0.14,
        resistances: (0.08, 0.45),
        measured_within: (0.3, 1.5),
        hover_current: 2.5,
        smoothing: 0.1,
        critical: 3.0,
        critical_for: Duration::from_secs(5),
        least_to_fly: 3.7,
        most_gain: 0.25,
        kept_for: Duration::from_secs(10),
        reserve: 0.05,
    };
}

/// Charge, 0 to 1, over resting voltage, V, of a lithium-polymer cell at room temperature: the mean
/// of published discharge curves at 0.2 C, to ±5 %.
const CHARGE: [(f32, f32); 10] = [
    (3.30, 0.0),
    (3.60, 0.05),
    (3.69, 0.1),
    (3.74, 0.2),
    (3.77, 0.3),
    (3.80, 0.4),
    (3.85, 0.55),
    (3.95, 0.75),
    (4.08, 0.9),
    (4.20, 1.0),
];

/// The battery gauge: what the readings so far say about the battery.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gauge {
    /// Voltage under load, smoothed, V; `None` while it is unknown.
    volts: Option<f32>,
    /// Estimated resting voltage, smoothed over ten times as long, V.
    rest_volts: f32,
    /// When the last plausible reading came in.
    read: Instant,
    /// Since when the voltage has been below critical.
    critical_since: Option<Instant>,
    /// Internal resistance, Ω; `None` until it has been measured.
    resistance: Option<f32>,
    /// Smoothed voltage when the motors were last off, V; `None` if they never were.
    unloaded: Option<f32>,
    /// For how long the motors have been running, s.
    loaded_for: f32,
}

impl Gauge {
    pub(crate) const fn new() -> Self {
        Self {
            volts: None,
            rest_volts: 0.0,
            read: Instant::ZERO,
            critical_since: None,
            resistance: None,
            unloaded: None,
            loaded_for: 0.0,
        }
    }

    /// Advances by `dt` seconds in which the propellers give `load` times the thrust of a hover.
    pub(crate) fn step(
        &mut self,
        config: &BatteryConfig,
        now: Instant,
        reading: Option<Volts>,
        load: f32,
        dt: f32,
    ) {
        // Power grows with thrust to the 3/2, and current with power.
        let current = config.hover_current * load * libm::sqrtf(load.max(0.0));
        let drop = self.resistance.unwrap_or(config.resistance) * current;
        // A battery that powers a running drone has between 2 and 5 V.
        let plausible = |volts: &f32| {
            let gains = current > 0.0
                && self.loaded_for > config.measured_within.1
                && self.rest_volts > 0.0
                && volts + drop - self.rest_volts > config.most_gain;
            (2.0..5.0).contains(volts) && !gains
        };
        let Some(volts) = reading.map(|reading| reading.0).filter(plausible) else {
            if now.since(self.read) > config.kept_for {
                self.volts = None;
            }
            return;
        };
        // Readings come at 100 Hz, so the smoothing advances by the time since the last one.
        let gap = now.since(self.read).as_secs_f32().min(1.0).max(dt);
        self.read = now;
        let part = (gap / config.smoothing).min(1.0);
        let smooth = self.volts.map_or(volts, |smooth| smooth + part * (volts - smooth));
        self.volts = Some(smooth);
        if current > 0.0 {
            self.loaded_for += gap;
            self.measure_resistance(config, smooth, current);
        } else {
            (self.unloaded, self.loaded_for) = (Some(smooth), 0.0);
        }
        if self.rest_volts == 0.0 {
            self.rest_volts = volts + drop;
        } else if self.unloaded.is_none() || !self.is_measuring(config) {
            self.rest_volts += 0.1 * part * (volts + drop - self.rest_volts);
        }
        let low = self.volts.is_some_and(|volts| volts < config.critical);
        self.critical_since = if low { self.critical_since.or(Some(now)) } else { None };
    }

    /// Whether the motors have started so recently that the internal resistance is being measured.
    fn is_measuring(&self, config: &BatteryConfig) -> bool {
        let (_, until) = config.measured_within;
        self.loaded_for > 0.0 && self.loaded_for < until
    }

    /// Measures the internal resistance by what the motors take off the resting voltage.
    fn measure_resistance(&mut self, config: &BatteryConfig, volts: f32, current: f32) {
        let (from, _) = config.measured_within;
        if let Some(unloaded) = self.unloaded
            && self.loaded_for > from
            && self.is_measuring(config)
            && current > 0.5 * config.hover_current
        {
            let (least, most) = config.resistances;
            self.resistance = Some(((unloaded - volts) / current).max(least).min(most));
        }
    }

    /// The voltage under load for the mixer, V; nominal while it is unknown.
    pub(crate) fn volts(&self) -> f32 {
        self.volts.unwrap_or(3.7)
    }

    /// The estimated voltage without load, V; 0 while it is unknown.
    #[cfg(feature = "replay")]
    pub(crate) const fn rest_volts(&self) -> f32 {
        self.rest_volts
    }

    /// The internal resistance, Ω; `None` until it has been measured.
    #[cfg(feature = "replay")]
    pub(crate) const fn resistance(&self) -> Option<f32> {
        self.resistance
    }

    pub(crate) fn is_known(&self) -> bool {
        self.volts.is_some()
    }

    /// Whether the charge suffices to begin a flight.
    pub(crate) fn may_fly(&self, config: &BatteryConfig) -> bool {
        self.is_known() && self.rest_volts >= config.least_to_fly
    }

    /// Whether the drone has to land now.
    pub(crate) fn is_critical(&self, config: &BatteryConfig, now: Instant) -> bool {
        self.critical_since.is_some_and(|since| now.since(since) >= config.critical_for)
            || (self.is_known() && charge(self.rest_volts) <= 0.0)
    }

    /// For how long the battery can carry a hovering drone; `None` while the voltage is unknown.
    pub(crate) fn endurance(&self, config: &BatteryConfig) -> Option<Duration> {
        self.volts?;
        let usable = (charge(self.rest_volts) - config.reserve).max(0.0);
        let seconds = usable * config.capacity / config.hover_current;
        Some(Duration::from_millis((seconds * 1e3) as u32 as u64))
    }

    pub(crate) fn status(&self, config: &BatteryConfig) -> io::Battery {
        io::Battery { volts: Volts(self.volts()), endurance: self.endurance(config) }
    }
}

/// The charge, 0 to 1, of a cell with this resting voltage.
fn charge(volts: f32) -> f32 {
    let mut below = (0.0, 0.0);
    for (v, part) in CHARGE {
        if volts < v {
            let (v0, part0) = below;
            return part0 + (part - part0) * (volts - v0) / (v - v0);
        }
        below = (v, part);
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: BatteryConfig = BatteryConfig::DEFAULT;

    fn hovering(volts: f32) -> Gauge {
        let mut gauge = Gauge::new();
        for n in 0..1_000 {
            let now = Instant::from_millis(10 * n);
            gauge.step(&CONFIG, now, Some(Volts(volts)), 1.0, 1e-3);
        }
        gauge
    }

    #[test]
    fn endurance_falls_with_the_voltage_to_zero() {
        let last = |volts| hovering(volts).endurance(&CONFIG).unwrap().as_secs_f32();
        assert!((300.0..400.0).contains(&last(3.85)), "{}", last(3.85));
        assert!(last(3.2) < 1.0);
        let mut lasts = f32::MAX;
        for n in 0..100 {
            let less = last(4.0 - 0.01 * n as f32);
            assert!(less <= lasts);
            lasts = less;
        }
    }

    #[test]
    fn a_short_dip_is_not_critical_but_five_seconds_are() {
        let mut gauge = hovering(3.4);
        let mut now = 10_000;
        let mut critical_after = |volts, until: u64| {
            while now < until {
                now += 10;
                let at = Instant::from_millis(now);
                gauge.step(&CONFIG, at, Some(Volts(volts)), 1.0, 1e-3);
            }
            gauge
                .critical_since
                .is_some_and(|since| Instant::from_millis(now).since(since) >= CONFIG.critical_for)
        };
        assert!(!critical_after(2.9, 12_000));
        assert!(!critical_after(3.4, 13_000));
        assert!(critical_after(2.9, 19_000));
    }

    /// The voltage of a battery that has this voltage at rest and this resistance, at 2.5 A per load.
    fn under_load(rest: f32, ohm: f32, load: f32) -> Option<Volts> {
        Some(Volts(rest - ohm * 2.5 * load))
    }

    #[test]
    fn an_aged_battery_is_known_again_after_its_flight() {
        for ohm in [0.1, 0.14, 0.24, 0.35, 0.4] {
            let mut gauge = Gauge::new();
            for n in 0..6_000_u64 {
                // A minute: ten seconds at rest, ten of flight, and at rest again.
                let (rest, load) =
                    if (1_000..2_000).contains(&n) { (4.0, 1.0) } else { (4.05, 0.0) };
                let at = Instant::from_millis(10 * n);
                gauge.step(&CONFIG, at, under_load(rest, ohm, load), load, 1e-3);
                assert!(n == 0 || gauge.is_known() && gauge.may_fly(&CONFIG), "{ohm} Ω, {n}");
            }
        }
    }

    #[test]
    fn the_endurance_of_an_aged_battery_is_that_of_its_charge() {
        for ohm in [0.1, 0.14, 0.24, 0.35] {
            let mut gauge = Gauge::new();
            for n in 0..2_000_u64 {
                let load = if n < 500 { 0.0 } else { 1.0 };
                let at = Instant::from_millis(10 * n);
                gauge.step(&CONFIG, at, under_load(3.9, ohm, load), load, 1e-3);
            }
            let lasts = gauge.endurance(&CONFIG).unwrap().as_secs_f32();
            let wanted = (charge(3.9) - CONFIG.reserve) * CONFIG.capacity / CONFIG.hover_current;
            assert!((lasts / wanted - 1.0).abs() < 0.1, "{ohm} Ω: {lasts} {wanted}");
        }
    }

    #[test]
    fn an_old_voltage_is_forgotten() {
        let mut gauge = hovering(3.8);
        gauge.step(&CONFIG, Instant::from_millis(11_000), None, 1.0, 1e-3);
        assert!(gauge.is_known());
        gauge.step(&CONFIG, Instant::from_millis(21_000), Some(Volts(0.3)), 1.0, 1e-3);
        assert_eq!(gauge.endurance(&CONFIG), None);
    }
}
