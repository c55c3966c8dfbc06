//! Checks the accelerometer, and replaces it by the thrust when it fails.
//!
//! In the air only its z axis is used, as on the Crazyflie (crazyflie-firmware, `kalman_core.c`). A
//! multicopter's propellers push along z only, so the specific force along x and y is drag: under
//! 0.1 m/s² at the speeds of a tunnel, which is less than the sensor's own offset.
//!
//! For the same reason the sensor can be checked: its reading minus the thrust must be small. That
//! needs the ratio of true to commanded thrust, since motors, propellers and masses differ by a
//! tenth, and by three tenths once they are worn. The ratio is learnt quickly, and without any
//! check, in the first [`AccelConfig::first_learnt_for`] after the drone has left the floor; and
//! slowly from then on while the sensor is sound. When the accelerometer fails, the ratio gives the
//! thrust that replaces it.
//!
//! The propellers shake the sensor by several m/s² at the frequency of their rotation. So whatever
//! is judged by a single reading is judged behind the vendor's low-pass ([`LowPass::HZ_30`]).

use units::Instant;

use crate::airframe::GRAVITY;
use crate::lowpass::{LowPass, LowPassState};
use crate::monitor::SensorMonitor;

/// The learnt thrust stays within these multiples of the commanded thrust; beyond them the
/// airframe's constants are those of another drone.
pub(crate) const MIN_THRUST_SCALE: f32 = 0.6;
pub(crate) const MAX_THRUST_SCALE: f32 = 1.5;

/// The constants of the accelerometer's checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelConfig {
    /// Low-pass filter between the accelerometer and the detection of blows.
    pub filter: LowPass,
    /// Time constant of the smoothed residual (reading minus thrust), s.
    pub smoothing: f32,
    /// The largest residual of a sound accelerometer on any axis, m/s². A motor at 70 % causes 0.7,
    /// ground effect 1, offset and drag together 0.3.
    pub most_residual: f32,
    /// The time constant with which the ratio of true to commanded thrust is learnt, s.
    pub thrust_time_constant: f32,
    /// Time for which the ratio is learnt quickly after the drone has left the floor, s. Meanwhile
    /// the residual along z says nothing.
    pub first_learnt_for: f32,
    /// Time constant with which it is learnt then, s.
    pub first_time_constant: f32,
    /// The ratio is learnt only while the vertical residual is smaller than this, m/s².
    pub learns_below: f32,
    /// After this many bit-identical samples the sensor counts as frozen.
    pub most_repeats: u16,
}

impl AccelConfig {
    /// The constants for a Crazyflie; their reasons stand at the fields. The first learning lasts
    /// for five of its time constants, and these are three times the lag of the motors.
    pub const DEFAULT: Self = Self {
        filter: LowPass::HZ_30,
        smoothing: 0.1,
        most_residual: 1.5,
        thrust_time_constant: 2.0,
        first_learnt_for: 1.0,
        first_time_constant: 0.2,
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
    filter: LowPassState,
    /// The readings behind the filter, m/s².
    filtered: [f32; 3],
    /// Smoothed difference between reading and thrust, m/s².
    residual: [f32; 3],
    /// Commanded thrust per mass behind the motors' lag, m/s².
    specific_thrust: f32,
    /// Learnt ratio of true to commanded thrust.
    thrust_scale: f32,
    /// For how long the ratio has been learnt since the drone left the floor, s.
    learnt_for: f32,
}

impl Accel {
    pub(crate) const fn new() -> Self {
        Self {
            monitor: SensorMonitor::new(),
            read: None,
            filter: LowPassState::new(),
            filtered: [0.0; 3],
            residual: [0.0; 3],
            specific_thrust: 0.0,
            thrust_scale: 1.0,
            learnt_for: 0.0,
        }
    }

    /// Advances by `dt` seconds. `specific_thrust` is the commanded thrust per mass in m/s², which
    /// the motors follow with a first-order lag of `lag` seconds. `lifted` says that the drone has
    /// left the floor.
    #[expect(clippy::too_many_arguments, reason = "a sample is checked against all of these")]
    pub(crate) fn step(
        &mut self,
        config: &AccelConfig,
        now: Instant,
        reading: Option<[f32; 3]>,
        specific_thrust: f32,
        lag: f32,
        lifted: bool,
        dt: f32,
    ) {
        self.specific_thrust += (dt / lag).min(1.0) * (specific_thrust - self.specific_thrust);
        let reading = self.monitor.accept(now, reading, config.most_repeats);
        self.read = reading.filter(|force| force.iter().all(|part| part.is_finite()));
        let Some(force) = self.read else { return };
        self.filtered = self.filter.step(&config.filter, force);
        let part = (dt / config.smoothing).min(1.0);
        let [x, y, z] = force;
        for (kept, new) in
            self.residual.iter_mut().zip([x, y, z - self.thrust_scale * self.specific_thrust])
        {
            *kept += part * (new - *kept);
        }
        if self.specific_thrust > 0.5 * GRAVITY {
            self.learn_thrust_scale(config, lifted, dt);
        }
    }

    fn learn_thrust_scale(&mut self, config: &AccelConfig, lifted: bool, dt: f32) {
        let [_, _, residual] = &mut self.residual;
        let [_, _, z] = self.filtered;
        let learnt = if self.learnt_for >= config.first_learnt_for {
            let sound = residual.abs() < config.learns_below;
            if sound {
                dt / config.thrust_time_constant * *residual / self.specific_thrust
            } else {
                0.0
            }
        } else if lifted {
            self.learnt_for += dt;
            *residual = 0.0;
            dt / config.first_time_constant * (z / self.specific_thrust - self.thrust_scale)
        } else {
            0.0
        };
        let scale = self.thrust_scale + learnt;
        self.thrust_scale = scale.max(MIN_THRUST_SCALE).min(MAX_THRUST_SCALE);
    }

    /// Clears the residual: on the ground a reading says nothing about thrust. The ratio of true to
    /// commanded thrust is kept for the next flight, which corrects it.
    pub(crate) fn rest(&mut self) {
        self.residual = [0.0; 3];
        self.learnt_for = 0.0;
    }

    /// The learnt ratio of true to commanded thrust.
    pub(crate) const fn thrust_scale(&self) -> f32 {
        self.thrust_scale
    }

    /// The latest reading, m/s².
    pub(crate) const fn reading(&self) -> Option<[f32; 3]> {
        self.read
    }

    /// Magnitude of the latest reading behind the filter, m/s²; `None` without one.
    pub(crate) fn magnitude(&self) -> Option<f32> {
        let [x, y, z] = self.filtered;
        self.read.map(|_| libm::sqrtf(x * x + y * y + z * z))
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
        let [x, y, z] = self.residual;
        let z = if self.has_learnt(config) { z } else { 0.0 };
        let within = [x, y, z].iter().all(|part| part.abs() <= config.most_residual);
        self.read.is_some() && within
    }

    /// Whether the ratio of true to commanded thrust is known, so that the residual along z means
    /// something.
    fn has_learnt(&self, config: &AccelConfig) -> bool {
        self.learnt_for >= config.first_learnt_for
    }

    /// Smoothed vertical specific force that the motors do not explain, m/s².
    pub(crate) fn vertical_residual(&self, config: &AccelConfig) -> f32 {
        let [_, _, z] = self.residual;
        if self.read.is_some() && self.has_learnt(config) { z } else { 0.0 }
    }

    /// Smoothed horizontal specific force, m/s²: more than drag and offset where something leans
    /// against the drone.
    pub(crate) fn lateral_residual(&self) -> f32 {
        let [x, y, _] = self.residual;
        self.read.map_or(0.0, |_| libm::sqrtf(x * x + y * y))
    }

    /// Momentary vertical specific force that the motors do not explain, m/s²: large on a blow from
    /// below.
    pub(crate) fn vertical_excess(&self) -> f32 {
        let [_, _, z] = self.filtered;
        self.read.map_or(0.0, |_| z - self.thrust_scale * self.specific_thrust)
    }

    /// Momentary horizontal specific force beyond its smoothed value, m/s²: large on an impact.
    pub(crate) fn lateral_impact(&self) -> f32 {
        let ([x, y, _], [rx, ry, _]) = (self.filtered, self.residual);
        self.read.map_or(0.0, |_| libm::sqrtf((x - rx) * (x - rx) + (y - ry) * (y - ry)))
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
            accel.step(&CONFIG, Instant::from_millis(now), reading, 9.81, 0.04, true, 1e-3);
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
    fn a_blow_is_detected_and_a_lasting_force_is_none() {
        let mut accel = hovering();
        // A wall takes 0.1 m/s within 2 ms.
        during(&mut accel, 2_000, 2, Some([50.0, 0.0, 9.81]));
        let mut most: f32 = 0.0;
        for ms in 2_002..2_020 {
            during(&mut accel, ms, 1, Some([0.0, 0.0, 9.81]));
            most = most.max(accel.lateral_impact());
        }
        assert!((6.0..9.0).contains(&most), "{most}");
        during(&mut accel, 2_020, 1_500, Some([1.0, 0.0, 9.81]));
        assert!(accel.lateral_impact() < 0.3);
    }

    #[test]
    fn the_vibration_of_propellers_is_no_blow() {
        for hertz in [230.0, 270.0, 330.0, 400.0] {
            let mut accel = hovering();
            // 0.5 g rms in the plane, and half as much along z.
            let size = 0.5 * GRAVITY;
            for ms in 2_000..4_000_u64 {
                let (sin, cos) = libm::sincosf(core::f32::consts::TAU * hertz * 1e-3 * ms as f32);
                let shaken = [size * cos, size * sin, 9.81 + 0.5 * size * cos];
                during(&mut accel, ms, 1, Some(shaken));
                if ms > 2_050 {
                    assert!(accel.lateral_impact() < 0.4, "{hertz} Hz: {}", accel.lateral_impact());
                    assert!(accel.vertical_excess().abs() < 0.4, "{hertz} Hz");
                }
            }
            assert!(accel.is_sound(&CONFIG));
        }
    }

    #[test]
    fn the_thrust_of_a_worn_or_a_strong_drone_is_learnt_within_a_second() {
        for scale in [0.7, 0.8, 1.2, 1.3] {
            let mut accel = Accel::new();
            during(&mut accel, 0, 1_200, Some([0.0, 0.0, 9.81 * scale]));
            assert!((accel.thrust_scale() / scale - 1.0).abs() < 0.03, "{scale}: {accel:?}");
            assert!(accel.vertical_residual(&CONFIG).abs() < 0.3 && accel.is_sound(&CONFIG));
            // From then on, a jump is the sensor's fault or the floor's.
            during(&mut accel, 1_200, 800, Some([0.0, 0.0, 9.81 * scale + 2.0]));
            assert!(!accel.is_sound(&CONFIG));
        }
    }
}
