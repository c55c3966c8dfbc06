//! What the ranger that looks down ought to read, and what a reading is worth: d = z/R₂₂.

use sensors::vl53l1x::Reading;

use super::config::DownConfig;
use super::covariance::Sight;
use super::verdict::Unusable;
use crate::attitude::Rotation;

/// The range as a measurement: what it is off, how it depends on the errors, and its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) innovation: f32,
    pub(super) sight: Sight,
    pub(super) variance: f32,
}

/// The model at the estimate. The tilt cosine must not be zero.
pub(super) fn range(
    config: &DownConfig,
    reading: &Reading,
    height: f32,
    rotation: &Rotation,
) -> Range {
    let cosine = rotation.tilt_cosine();
    let expected = height / cosine;
    let [lean_x, lean_y, _] = rotation.z;
    let per_tilt = expected / cosine;
    Range {
        innovation: reading.distance.0 - expected,
        sight: Sight {
            height: 1.0 / cosine,
            velocity: [0.0; 3],
            tilt: [-per_tilt * lean_y, per_tilt * lean_x],
        },
        variance: variance(config, reading),
    }
}

/// Of a reading: what the vendor measured, or what the sensor says, whichever is more; and the
/// floor's.
fn variance(config: &DownConfig, reading: &Reading) -> f32 {
    let distance = reading.distance.0;
    let beyond = (distance - config.doubled_at) / config.noise_grows_over;
    let usual = config.noise * (1.0 + libm::expf(beyond));
    let near = if distance < config.nearest { config.near_noise } else { 0.0 };
    let own = usual.max(reading.sigma.0).max(near);
    own * own + config.relief * config.relief
}

/// Why a reading says nothing, if it does not.
pub(super) fn fault(config: &DownConfig, reading: &Reading, cosine: f32) -> Option<Unusable> {
    let distance = reading.distance.0;
    if !reading.status.is_valid() {
        Some(Unusable::Invalid)
    } else if !(0.0..config.farthest).contains(&distance) {
        Some(Unusable::OutOfRange)
    } else if cosine < config.least_tilt_cosine {
        Some(Unusable::Tilted)
    } else {
        None
    }
}
