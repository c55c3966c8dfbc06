//! The measurement model of the optic flow sensor.
//!
//! It is the vendor's model (crazyflie-firmware, `mm_flow.c`), integrated over the time between two
//! readings instead of evaluated at the end of it:
//!
//! ```text
//!     counts_x = k·∫(v_x·R₂₂/z − ω_y)dt        counts_y = k·∫(v_y·R₂₂/z + ω_x)dt
//! ```

use sensors::pmw3901::Motion;

use super::config::FlowConfig;
use super::covariance::{Covariance, ErrorState, MeasurementRow};
use super::verdict::{Nis, Unusable};
use crate::attitude::{Rotation, Vector, dot, scaled};

/// The image motion that the estimate predicts, integrated since the last reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowIntegral {
    /// Time since the last reading, s.
    pub(super) time: f32,
    /// Image motion by translation, ∫v·R₂₂/z dt along the board's x and y, rad.
    pub(super) translation: [f32; 2],
    /// Rotation, ∫ω dt about the board's x and y, rad.
    pub(super) turn: [f32; 2],
}

impl FlowIntegral {
    pub(super) const ZERO: Self = Self { time: 0.0, translation: [0.0; 2], turn: [0.0; 2] };

    /// Adds `dt` seconds at this velocity (body axes, m/s), distance from the floor (m) and
    /// rotation (rad).
    pub(super) fn add(&mut self, velocity: Vector, distance: f32, turn: Vector, dt: f32) {
        let [translation_x, translation_y] = self.translation;
        let [turn_x, turn_y] = self.turn;
        let [x, y, _] = scaled(velocity, dt / distance);
        let [about_x, about_y, _] = turn;
        self.time += dt;
        self.translation = [translation_x + x, translation_y + y];
        self.turn = [turn_x + about_x, turn_y + about_y];
    }
}

/// The two counts as measurements: their innovations, their rows of H and their variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowMeasurement {
    pub(super) innovation: [f32; 2],
    pub(super) row: [MeasurementRow; 2],
    pub(super) variance: [f32; 2],
}

impl FlowMeasurement {
    /// The square of the velocity error that would explain the innovations, m²/s².
    pub(super) fn velocity_squared(&self) -> f32 {
        let [x, y] = self.innovation;
        let [MeasurementRow { velocity, .. }, _] = self.row;
        (x * x + y * y) / dot(velocity, velocity)
    }
}

/// The two counts, decorrelated: for each its P·Hᵀ, the variance of its innovation, and its
/// innovation. The second count is conditioned on the first, so that updating with one after the
/// other equals one update with both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decorrelated {
    pub(super) p_ht: [ErrorState; 2],
    pub(super) variance: [f32; 2],
    pub(super) innovation: [f32; 2],
}

impl Decorrelated {
    pub(super) fn new(covariance: &Covariance, counts: &FlowMeasurement) -> Self {
        let [row_x, row_y] = &counts.row;
        let [noise_x, noise_y] = counts.variance;
        let [innovation_x, innovation_y] = counts.innovation;
        let p_ht_x = covariance.p_h_transpose(row_x);
        let p_ht_y = covariance.p_h_transpose(row_y);
        let x = row_x.times(&p_ht_x) + noise_x;
        let cross = row_x.times(&p_ht_y);
        let y = row_y.times(&p_ht_y) + noise_y;
        let gain = cross / x;
        Self {
            p_ht: [p_ht_x, p_ht_y.plus_scaled(&p_ht_x, -gain)],
            variance: [x, y - gain * cross],
            innovation: [innovation_x, innovation_y - gain * innovation_x],
        }
    }

    pub(super) fn nis(&self) -> Nis {
        let [x, y] = self.squares();
        Nis { value: x + y, degrees: 2 }
    }

    /// Whether both innovations are within this many standard deviations.
    pub(super) fn within(&self, gate: f32) -> bool {
        let [x, y] = self.squares();
        x.max(y) <= gate * gate
    }

    fn squares(&self) -> [f32; 2] {
        let [innovation_x, innovation_y] = self.innovation;
        let [x, y] = self.variance;
        [innovation_x * innovation_x / x, innovation_y * innovation_y / y]
    }
}

/// Evaluates the vendor's model at the estimate: `height` over ground and attitude `rotation`.
pub(super) fn measurement(
    config: &FlowConfig,
    motion: &Motion,
    flow_integral: &FlowIntegral,
    height: f32,
    rotation: &Rotation,
) -> FlowMeasurement {
    let scale = config.counts_per_radian;
    let [translation_x, translation_y] = scaled2(flow_integral.translation, scale);
    let [turn_x, turn_y] = scaled2(flow_integral.turn, scale);
    let cosine = rotation.tilt_cosine();
    let per_speed = scale * flow_integral.time * cosine / height;
    let [body_z_x, body_z_y, _] = rotation.z;
    let row = |translation: f32, along: Vector| MeasurementRow {
        height: -translation / height,
        velocity: scaled(along, per_speed),
        tilt: [translation * body_z_y / cosine, -translation * body_z_x / cosine],
    };
    let noise = noise(config, motion.shutter);
    let variance = |translation: f32| {
        let relief = config.scale_noise * translation;
        noise + relief * relief
    };
    FlowMeasurement {
        innovation: [
            f32::from(motion.x) - (translation_x - turn_y),
            f32::from(motion.y) - (translation_y + turn_x),
        ],
        row: [row(translation_x, rotation.x), row(translation_y, rotation.y)],
        variance: [variance(translation_x), variance(translation_y)],
    }
}

/// The variance of one count: that of the image, and that of rounding it to an integer.
fn noise(config: &FlowConfig, shutter: u16) -> f32 {
    let picture = config.noise + config.noise_per_shutter * f32::from(shutter);
    picture * picture + 1.0 / 12.0
}

/// Why this reading cannot be used; `None` if it can.
pub(super) fn fault(
    config: &FlowConfig,
    motion: &Motion,
    flow_integral: &FlowIntegral,
    distance: f32,
    cosine: f32,
) -> Option<Unusable> {
    let most = config.most_counts;
    let still = motion.x == 0 && motion.y == 0;
    if motion.shutter >= config.dark && motion.squal < config.least_quality_in_the_dark {
        Some(Unusable::Dark)
    } else if motion.squal < config.least_quality {
        Some(Unusable::Featureless)
    } else if motion.x.unsigned_abs() >= most || motion.y.unsigned_abs() >= most {
        Some(Unusable::OutOfRange)
    } else if !(motion.moved || still) {
        Some(Unusable::Invalid)
    } else if flow_integral.time <= 0.0 || flow_integral.time > config.longest_interval {
        Some(Unusable::Stale)
    } else if cosine < config.least_tilt_cosine {
        Some(Unusable::Tilted)
    } else if distance < config.nearest {
        Some(Unusable::TooLow)
    } else {
        None
    }
}

fn scaled2([x, y]: [f32; 2], by: f32) -> [f32; 2] {
    [x * by, y * by]
}
