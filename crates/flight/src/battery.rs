//! The battery: a smoothed voltage, and how long it will last.
//!
//! The voltage under load says little: 0.3 V of it come and go with the throttle. What the battery
//! would show at rest is estimated by adding the drop over its inner resistance, the charge is
//! read from that voltage, and the time from the charge.

use units::{Duration, Instant, Volts};

use crate::io;

/// A battery's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryConfig {
    /// Charge when full, A s.
    pub capacity: f32,
    /// Battery, connector and cables, Ω.
    pub resistance: f32,
    /// Current of a drone that hovers, A.
    pub hover_current: f32,
    /// Time constant of the smoothing, s.
    pub smoothing: f32,
    /// Below this for [`low_for`](Self::low_for) it has no endurance left, V.
    pub critical: f32,
    /// How long that must last.
    pub low_for: Duration,
    /// At rest it must stand at this to be flown at all, V.
    pub least_to_fly: f32,
    /// A battery does not gain more than this from one reading to the next, V: the estimate at
    /// rest hides the load, and a charger works for minutes.
    pub most_gain: f32,
    /// A reading older than this is forgotten.
    pub believed_for: Duration,
    /// The part of the charge that is never planned with.
    pub reserve: f32,
}

impl BatteryConfig {
    /// The Crazyflie's 250 mAh cell. It hovers for 7 minutes bare (product page), so with 2.1 A,
    /// and as thrust costs its power 3/2, with 13 % more mass 2.5 A. Its critical voltage, and 5 s
    /// of it, are the vendor's (`platform_defaults_cf2.h`), and so is the time constant: 0.01 of a
    /// step at 1 kHz. Inner resistance: 0.3 V between hovering and resting at 2.1 A. 3.7 V at rest
    /// is a tenth of its charge. What is known of the load leaves 0.1 V of doubt.
    pub const DEFAULT: Self = Self {
        capacity: 0.250 * 3_600.0,
        resistance: 0.14,
        hover_current: 2.5,
        smoothing: 0.1,
        critical: 3.0,
        low_for: Duration::from_secs(5),
        least_to_fly: 3.7,
        most_gain: 0.25,
        believed_for: Duration::from_secs(10),
        reserve: 0.05,
    };
}

/// Charge by voltage at rest of a lithium-polymer cell at room temperature, 0 to 1: the mean of
/// published discharge curves at 0.2 C, to ±5 %.
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

/// What is known of the battery.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gauge {
    /// Under load, smoothed.
    volts: Option<f32>,
    /// What it would be at rest, smoothed over ten times as long.
    rest: f32,
    /// When it was last read.
    read: Instant,
    /// Since when it has been under the critical voltage.
    low_since: Option<Instant>,
}

impl Gauge {
    pub(crate) const fn new() -> Self {
        Self { volts: None, rest: 0.0, read: Instant::ZERO, low_since: None }
    }

    /// One step of `dt` seconds in which the propellers give `load` of a hovering drone's thrust.
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
        // What is connected to a running drone has between 2 and 5 V.
        let sane = |volts: &f32| {
            let gains = volts + config.resistance * current - self.rest > config.most_gain;
            (2.0..5.0).contains(volts) && !(self.rest > 0.0 && gains)
        };
        let Some(volts) = reading.map(|reading| reading.0).filter(sane) else {
            if now.since(self.read) > config.believed_for {
                self.volts = None;
            }
            return;
        };
        // Between two readings the smoothing stands still: they come at 100 Hz.
        let gap = now.since(self.read).as_secs_f32().min(1.0).max(dt);
        self.read = now;
        let rest = volts + config.resistance * current;
        let part = (gap / config.smoothing).min(1.0);
        match &mut self.volts {
            None => (self.volts, self.rest) = (Some(volts), rest),
            Some(smooth) => {
                *smooth += part * (volts - *smooth);
                self.rest += 0.1 * part * (rest - self.rest);
            }
        }
        let low = self.volts.is_some_and(|volts| volts < config.critical);
        self.low_since = if low { self.low_since.or(Some(now)) } else { None };
    }

    /// Under load, for the mixer: nominal while it is not known.
    pub(crate) fn volts(&self) -> f32 {
        self.volts.unwrap_or(3.7)
    }

    pub(crate) fn is_known(&self) -> bool {
        self.volts.is_some()
    }

    /// Whether it holds enough to begin a flight.
    pub(crate) fn may_fly(&self, config: &BatteryConfig) -> bool {
        self.is_known() && self.rest >= config.least_to_fly
    }

    /// Whether the drone has to come down now.
    pub(crate) fn is_critical(&self, config: &BatteryConfig, now: Instant) -> bool {
        self.low_since.is_some_and(|since| now.since(since) >= config.low_for)
            || (self.is_known() && charge(self.rest) <= 0.0)
    }

    /// How long it still carries a drone that hovers.
    pub(crate) fn endurance(&self, config: &BatteryConfig) -> Option<Duration> {
        self.volts?;
        let usable = (charge(self.rest) - config.reserve).max(0.0);
        let seconds = usable * config.capacity / config.hover_current;
        Some(Duration::from_millis((seconds * 1e3) as u32 as u64))
    }

    pub(crate) fn status(&self, config: &BatteryConfig) -> io::Battery {
        io::Battery { volts: Volts(self.volts()), endurance: self.endurance(config) }
    }
}

/// The part of its charge that a cell at rest at this voltage holds.
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
    fn a_full_battery_lasts_for_minutes_and_an_empty_one_for_none() {
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
    fn a_dip_is_not_the_end_but_five_seconds_are() {
        let mut gauge = hovering(3.4);
        let mut now = 10_000;
        let mut critical_after = |volts, until: u64| {
            while now < until {
                now += 10;
                let at = Instant::from_millis(now);
                gauge.step(&CONFIG, at, Some(Volts(volts)), 1.0, 1e-3);
            }
            gauge
                .low_since
                .is_some_and(|since| Instant::from_millis(now).since(since) >= CONFIG.low_for)
        };
        assert!(!critical_after(2.9, 12_000));
        assert!(!critical_after(3.4, 13_000));
        assert!(critical_after(2.9, 19_000));
    }

    #[test]
    fn what_is_not_read_is_forgotten_in_the_end() {
        let mut gauge = hovering(3.8);
        gauge.step(&CONFIG, Instant::from_millis(11_000), None, 1.0, 1e-3);
        assert!(gauge.is_known());
        gauge.step(&CONFIG, Instant::from_millis(21_000), Some(Volts(0.3)), 1.0, 1e-3);
        assert_eq!(gauge.endurance(&CONFIG), None);
    }
}
