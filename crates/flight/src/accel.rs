//! The accelerometer, and what stands in for it.
//!
//! In the air only its z axis is used, as the Crazyflie does (crazyflie-firmware,
//! `kalman_core.c`): a multicopter's propellers push along z and nowhere else, so that what it
//! measures along x and y is drag (under 0.1 m/s² at the speeds of a tunnel), less than its own
//! offset. For the same reason it can be checked: what is left of it after the thrust has been
//! taken off must be small. And while it is sound it tells by how much this drone's thrust is not
//! what the commands say, for batteries and propellers differ by a tenth, so that a drone that
//! loses it knows its thrust.

use units::Instant;

use crate::airframe::GRAVITY;
use crate::watch::Watch;

/// A drone that is heavier or lighter than this, as a part of what the airframe says, is another.
const LEAST_PART: f32 = 0.7;
const MOST_PART: f32 = 1.4;

/// What is believed of an accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelConfig {
    /// Smoothed over this time, s …
    pub smoothing: f32,
    /// … what is left of it without the thrust may be this long, m/s²; a motor at 70 % is worth
    /// 0.7, ground effect 1, an offset and drag 0.3.
    pub most_residual: f32,
    /// Over this time the thrust is compared with the commands, s, …
    pub thrust_time: f32,
    /// … while no more than this is left, m/s².
    pub learns_below: f32,
    /// After so many samples that are equal to the last bit, it is frozen.
    pub most_repeats: u16,
}

impl AccelConfig {
    /// See the fields.
    pub const DEFAULT: Self = Self {
        smoothing: 0.2,
        most_residual: 1.5,
        thrust_time: 2.0,
        learns_below: 1.2,
        most_repeats: 4,
    };
}

/// Specific force, however it is known.
#[derive(Clone, Debug)]
pub(crate) struct Accel {
    watch: Watch<[f32; 3]>,
    /// The latest reading; `None` while there is none.
    read: Option<[f32; 3]>,
    /// Smoothed difference between reading and thrust.
    residual: [f32; 3],
    /// Thrust per mass as the motors should give it by now, m/s².
    push: f32,
    /// What they give of it.
    part: f32,
}

impl Accel {
    pub(crate) const fn new() -> Self {
        Self { watch: Watch::new(), read: None, residual: [0.0; 3], push: 0.0, part: 1.0 }
    }

    /// One step of `dt` seconds. `push` is the thrust per mass that the motors were last told to
    /// give, and follows them with `lag` seconds.
    pub(crate) fn step(
        &mut self,
        config: &AccelConfig,
        now: Instant,
        reading: Option<[f32; 3]>,
        push: f32,
        lag: f32,
        dt: f32,
    ) {
        self.push += (dt / lag).min(1.0) * (push - self.push);
        let reading = self.watch.pass(now, reading, config.most_repeats);
        self.read = reading.filter(|force| force.iter().all(|part| part.is_finite()));
        if let Some([x, y, z]) = self.read {
            let part = (dt / config.smoothing).min(1.0);
            for (kept, new) in self.residual.iter_mut().zip([x, y, z - self.part * self.push]) {
                *kept += part * (new - *kept);
            }
            self.learn(config, dt);
        }
    }

    fn learn(&mut self, config: &AccelConfig, dt: f32) {
        let [_, _, z] = self.residual;
        if self.push > 0.5 * GRAVITY && z.abs() < config.learns_below {
            let part = self.part + dt / config.thrust_time * z / self.push;
            self.part = part.max(LEAST_PART).min(MOST_PART);
        }
    }

    /// Forgets what it felt: on the ground its reading says nothing about thrust.
    pub(crate) fn rest(&mut self) {
        self.residual = [0.0; 3];
    }

    /// As read.
    pub(crate) const fn reading(&self) -> Option<[f32; 3]> {
        self.read
    }

    /// Specific force in the air.
    pub(crate) fn in_flight(&self, config: &AccelConfig) -> [f32; 3] {
        match self.read {
            Some([_, _, z]) if self.is_sound(config) => [0.0, 0.0, z],
            _ => [0.0, 0.0, self.part * self.push],
        }
    }

    /// Whether it is there, and says what a flying drone feels.
    pub(crate) fn is_sound(&self, config: &AccelConfig) -> bool {
        let within = self.residual.iter().all(|part| part.abs() <= config.most_residual);
        self.read.is_some() && within
    }

    /// What of the vertical part the motors do not explain, m/s².
    pub(crate) fn unexplained(&self) -> f32 {
        let [_, _, z] = self.residual;
        if self.read.is_some() { z } else { 0.0 }
    }

    /// The vertical part beyond what the motors give, m/s², just now.
    pub(crate) fn upwards(&self) -> f32 {
        self.read.map_or(0.0, |[_, _, z]| z - self.part * self.push)
    }

    /// The horizontal part, without what it has been for a while: a blow.
    pub(crate) fn sideways(&self) -> f32 {
        let [rx, ry, _] = self.residual;
        self.read.map_or(0.0, |[x, y, _]| libm::sqrtf((x - rx) * (x - rx) + (y - ry) * (y - ry)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: AccelConfig = AccelConfig::DEFAULT;

    /// So many milliseconds of hovering in which this is read.
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
    fn in_the_air_the_vertical_is_read_and_the_rest_is_known() {
        let accel = hovering();
        let [x, y, z] = accel.in_flight(&CONFIG);
        assert!(accel.is_sound(&CONFIG) && x == 0.0 && y == 0.0 && (z - 9.81).abs() < 0.2);
    }

    #[test]
    fn one_that_is_missing_or_says_what_no_drone_feels_is_replaced_by_the_thrust() {
        let lies = [
            None,
            Some([2.0, 0.0, 9.81]),
            Some([0.0, -2.0, 9.81]),
            Some([0.0, 0.0, 11.81]),
            Some([f32::NAN, 0.0, 9.81]),
        ];
        for lie in lies {
            let mut accel = hovering();
            during(&mut accel, 2_000, 500, lie);
            assert!(!accel.is_sound(&CONFIG), "{lie:?}");
            assert!((accel.in_flight(&CONFIG)[2] - 9.81).abs() < 0.15, "{lie:?}");
            during(&mut accel, 2_500, 500, Some([0.0, 0.0, 9.81]));
            assert!(accel.is_sound(&CONFIG), "{lie:?}");
        }
    }

    #[test]
    fn a_blow_is_felt_and_a_lasting_force_is_not_one() {
        let mut accel = hovering();
        during(&mut accel, 2_000, 1, Some([3.0, 3.0, 9.81]));
        assert!(accel.sideways() > 4.0);
        during(&mut accel, 2_001, 1_500, Some([1.0, 0.0, 9.81]));
        assert!(accel.sideways() < 0.3);
    }
}
