//! Checks the accelerometer, and replaces it by the thrust when it fails.
//!
//! In the air only its z axis is used, as on the Crazyflie (crazyflie-firmware, `kalman_core.c`). A
//! multicopter's propellers push along z only, so the specific force along x and y is drag: under
//! 0.1 m/s² at the speeds of a tunnel, which is less than the sensor's own offset.
//!
//! For the same reason the sensor can be checked: its reading minus the thrust must be small. While
//! it is sound, the code learns the ratio of true to commanded thrust, since batteries and
//! propellers differ by a tenth. When the accelerometer fails, that ratio gives the thrust that
//! replaces it.

use units::Instant;

use crate::airframe::GRAVITY;
use crate::monitor::SensorMonitor;

/// The learnt thrust stays within these multiples of the commanded thrust; beyond them the
/// airframe's constants are those of another drone.
const MIN_THRUST_SCALE: f32 = 0.7;
const MAX_THRUST_SCALE: f32 = 1.4;

/// The constants of the accelerometer's checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelConfig {
    /// The time constant of the smoothed residual (reading minus thrust), s.
    pub smoothing: f32,
    /// The largest residual of a sound accelerometer on any axis, m/s². A motor at 70 % causes 0.7,
    /// ground effect 1, offset and drag together 0.3.
    pub most_residual: f32,
    /// The time constant with which the ratio of true to commanded thrust is learnt, s.
    pub thrust_time_constant: f32,
    /// The ratio is learnt only while the vertical residual is smaller than this, m/s².
    pub learns_below: f32,
    /// After this many bit-identical samples the sensor counts as frozen.
    pub most_repeats: u16,
}

impl AccelConfig {
    /// The constants for a Crazyflie; the fields give the reasons for them.
    pub const DEFAULT: Self = Self {
        smoothing: 0.2,
        most_residual: 1.5,
        thrust_time_constant: 2.0,
        learns_below: 1.2,
        most_repeats: 4,
    };
}

/// The specific force of the drone: measured, or derived from the thrust.
#[derive(Clone, Debug)]
pub(crate) struct Accel {
    monitor: SensorMonitor<[f32; 3]>,
    /// The latest reading, m/s²; `None` without one.
    read: Option<[f32; 3]>,
    /// Smoothed difference between reading and thrust, m/s².
    residual: [f32; 3],
    /// Commanded thrust per mass behind the motors' lag, m/s².
    specific_thrust: f32,
    /// Learnt ratio of true to commanded thrust.
    thrust_scale: f32,
}

impl Accel {
    pub(crate) const fn new() -> Self {
        Self {
            monitor: SensorMonitor::new(),
            read: None,
            residual: [0.0; 3],
            specific_thrust: 0.0,
            thrust_scale: 1.0,
        }
    }

    /// Advances by `dt` seconds. `specific_thrust` is the commanded thrust per mass in m/s², which
    /// the motors follow with a first-order lag of `lag` seconds.
    pub(crate) fn step(
        &mut self,
        config: &AccelConfig,
        now: Instant,
        reading: Option<[f32; 3]>,
        specific_thrust: f32,
        lag: f32,
        dt: f32,
    ) {
        self.specific_thrust += (dt / lag).min(1.0) * (specific_thrust - self.specific_thrust);
        let reading = self.monitor.accept(now, reading, config.most_repeats);
        self.read = reading.filter(|force| force.iter().all(|part| part.is_finite()));
        if let Some([x, y, z]) = self.read {
            let part = (dt / config.smoothing).min(1.0);
            for (kept, new) in
                self.residual.iter_mut().zip([x, y, z - self.thrust_scale * self.specific_thrust])
            {
                *kept += part * (new - *kept);
            }
            self.learn_thrust_scale(config, dt);
        }
    }

    fn learn_thrust_scale(&mut self, config: &AccelConfig, dt: f32) {
        let [_, _, z] = self.residual;
        if self.specific_thrust > 0.5 * GRAVITY && z.abs() < config.learns_below {
            let scale =
                self.thrust_scale + dt / config.thrust_time_constant * z / self.specific_thrust;
            self.thrust_scale = scale.max(MIN_THRUST_SCALE).min(MAX_THRUST_SCALE);
        }
    }

    /// Clears the residual: on the ground a reading says nothing about thrust.
    pub(crate) fn rest(&mut self) {
        self.residual = [0.0; 3];
    }

    /// The latest reading, m/s².
    pub(crate) const fn reading(&self) -> Option<[f32; 3]> {
        self.read
    }

    /// The specific force in the air, m/s²: along z from the sensor if it is sound, else from the
    /// thrust.
    pub(crate) fn in_flight(&self, config: &AccelConfig) -> [f32; 3] {
        match self.read {
            Some([_, _, z]) if self.is_sound(config) => [0.0, 0.0, z],
            _ => [0.0, 0.0, self.thrust_scale * self.specific_thrust],
        }
    }

    /// Whether there is a reading and the residual is one that a flying drone can cause.
    pub(crate) fn is_sound(&self, config: &AccelConfig) -> bool {
        let within = self.residual.iter().all(|part| part.abs() <= config.most_residual);
        self.read.is_some() && within
    }

    /// Smoothed vertical specific force that the motors do not explain, m/s².
    pub(crate) fn vertical_residual(&self) -> f32 {
        let [_, _, z] = self.residual;
        if self.read.is_some() { z } else { 0.0 }
    }

    /// Momentary vertical specific force that the motors do not explain, m/s².
    pub(crate) fn vertical_excess(&self) -> f32 {
        self.read.map_or(0.0, |[_, _, z]| z - self.thrust_scale * self.specific_thrust)
    }

    /// Momentary horizontal specific force beyond its smoothed value, m/s²: large on an impact.
    pub(crate) fn lateral_impact(&self) -> f32 {
        let [rx, ry, _] = self.residual;
        self.read.map_or(0.0, |[x, y, _]| libm::sqrtf((x - rx) * (x - rx) + (y - ry) * (y - ry)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: AccelConfig = AccelConfig::DEFAULT;

    /// Hovers for `ms` milliseconds with this reading plus noise.
    fn during(accel: &mut Accel, from: u64, ms: u64, reading: Option<[f32; 3]>) {
        for now in from..from + ms {
            let noise = 0.1 * libm::sinf(now as f32);
            let reading = reading.map(|force| force.map(|part| part + noise));
            accel.step(&CONFIG, Instant::from_millis(now), reading, 9.81, 0.04, 1e-3);
        }
    }

    fn hovering() -> Accel {
        let mut accel = Accel::new();
        during(&mut accel, 0, 400, None);
        during(&mut accel, 400, 1_600, Some([0.0, 0.0, 9.81]));
        accel
    }

    #[test]
    fn in_the_air_z_is_measured_and_x_and_y_are_zero() {
        let accel = hovering();
        let [x, y, z] = accel.in_flight(&CONFIG);
        assert!(accel.is_sound(&CONFIG) && x == 0.0 && y == 0.0 && (z - 9.81).abs() < 0.2);
    }

    #[test]
    fn a_missing_or_implausible_reading_is_replaced_by_the_thrust() {
        let faults = [
            None,
            Some([2.0, 0.0, 9.81]),
            Some([0.0, -2.0, 9.81]),
            Some([0.0, 0.0, 11.81]),
            Some([f32::NAN, 0.0, 9.81]),
        ];
        for fault in faults {
            let mut accel = hovering();
            during(&mut accel, 2_000, 500, fault);
            assert!(!accel.is_sound(&CONFIG), "{fault:?}");
            assert!((accel.in_flight(&CONFIG)[2] - 9.81).abs() < 0.15, "{fault:?}");
            during(&mut accel, 2_500, 500, Some([0.0, 0.0, 9.81]));
            assert!(accel.is_sound(&CONFIG), "{fault:?}");
        }
    }

    #[test]
    fn an_impact_is_detected_and_a_lasting_force_is_not_an_impact() {
        let mut accel = hovering();
        during(&mut accel, 2_000, 1, Some([3.0, 3.0, 9.81]));
        assert!(accel.lateral_impact() > 4.0);
        during(&mut accel, 2_001, 1_500, Some([1.0, 0.0, 9.81]));
        assert!(accel.lateral_impact() < 0.3);
    }
}
