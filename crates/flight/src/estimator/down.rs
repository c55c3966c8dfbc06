//! The measurement model of the ranger that looks down: d = z/R₂₂.

use sensors::vl53l1x::{RangeStatus, Reading};

use super::config::DownConfig;
use super::covariance::MeasurementRow;
use super::verdict::Unusable;
use crate::attitude::Rotation;

/// A range as a measurement: its innovation, its row of H and its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RangeMeasurement {
    pub(super) innovation: f32,
    pub(super) row: MeasurementRow,
    pub(super) variance: f32,
}

/// Evaluates the model at the estimate. The cosine of the tilt must not be zero.
pub(super) fn measurement(
    config: &DownConfig,
    reading: &Reading,
    height: f32,
    rotation: &Rotation,
) -> RangeMeasurement {
    let cosine = rotation.tilt_cosine();
    let expected = height / cosine;
    let [body_z_x, body_z_y, _] = rotation.z;
    let per_tilt = expected / cosine;
    RangeMeasurement {
        innovation: reading.distance.0 - expected,
        row: MeasurementRow {
            height: 1.0 / cosine,
            velocity: [0.0; 3],
            tilt: [-per_tilt * body_z_y, per_tilt * body_z_x],
        },
        variance: variance(config, reading),
    }
}

/// The variance of a reading: the larger of the vendor's noise model and the sensor's own estimate,
/// plus that of the floor.
fn variance(config: &DownConfig, reading: &Reading) -> f32 {
    let distance = reading.distance.0;
    let beyond = (distance - config.doubled_at) / config.noise_grows_over;
    let usual = config.noise * (1.0 + libm::expf(beyond));
    let near = if distance < config.nearest { config.near_noise } else { 0.0 };
    let doubted = if reading.status.is_valid() { 0.0 } else { config.doubted_noise };
    let own = usual.max(reading.sigma.0).max(near).max(doubted);
    own * own + config.relief * config.relief
}

/// Why this reading cannot be used; `None` if it can. A σ above the sensor's limit is a warning, and
/// no error like the others (ST's UM2931, table 7, for the VL53L1X's sibling VL53L4CD): the distance
/// is measured, if not well. The vendor's firmware takes every reading below 5 m (`zranger2.c`), those
/// that have wrapped too.
pub(super) fn fault(config: &DownConfig, reading: &Reading, cosine: f32) -> Option<Unusable> {
    let distance = reading.distance.0;
    if !(reading.status.is_valid() || reading.status == RangeStatus::SigmaFail) {
        Some(Unusable::Invalid)
    } else if !(0.0..config.farthest).contains(&distance) {
        Some(Unusable::OutOfRange)
    } else if cosine < config.least_tilt_cosine {
        Some(Unusable::Tilted)
    } else {
        None
    }
}
