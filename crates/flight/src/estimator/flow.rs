//! What the flow sensor ought to have counted, and what a count is worth.
//!
//! The vendor's model (crazyflie-firmware, `mm_flow.c`), integrated over the time between two
//! readings instead of taken at its end:
//!
//! ```text
//!     counts_x = k·∫(v_x·R₂₂/z − ω_y)dt        counts_y = k·∫(v_y·R₂₂/z + ω_x)dt
//! ```

use sensors::pmw3901::Motion;

use super::config::FlowConfig;
use super::covariance::{Covariance, Errors, Sight};
use super::verdict::{Nis, Unusable};
use crate::attitude::{Rotation, Vector, dot, scaled};

/// What has passed under the sensor since it was last read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passed {
    /// Seconds.
    pub(super) time: f32,
    /// ∫v·R₂₂/z dt along the board's x and y, rad.
    pub(super) slid: [f32; 2],
    /// ∫ω dt about the board's x and y, rad.
    pub(super) turned: [f32; 2],
}

impl Passed {
    pub(super) const NOTHING: Self = Self { time: 0.0, slid: [0.0; 2], turned: [0.0; 2] };

    /// A drone of this velocity (body axes, m/s) at this distance (m) from the floor.
    pub(super) fn pass(&mut self, velocity: Vector, distance: f32, turn: Vector, dt: f32) {
        let [slid_x, slid_y] = self.slid;
        let [turned_x, turned_y] = self.turned;
        let [x, y, _] = scaled(velocity, dt / distance);
        let [about_x, about_y, _] = turn;
        self.time += dt;
        self.slid = [slid_x + x, slid_y + y];
        self.turned = [turned_x + about_x, turned_y + about_y];
    }
}

/// The two counts as measurements: what they are off, how they depend on the errors, and their
/// variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Counts {
    pub(super) innovation: [f32; 2],
    pub(super) sight: [Sight; 2],
    pub(super) variance: [f32; 2],
}

impl Counts {
    /// The square of the velocity that would explain what they are off.
    pub(super) fn velocity_squared(&self) -> f32 {
        let [x, y] = self.innovation;
        let [Sight { velocity, .. }, _] = self.sight;
        (x * x + y * y) / dot(velocity, velocity)
    }
}

/// The two counts made independent of each other: for each what it says of the errors, P·Hᵀ, the
/// variance of its innovation, and the innovation. The second is what it still says when the
/// first is known, so taking one after the other is exactly taking both at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weighed {
    pub(super) seen: [Errors; 2],
    pub(super) variance: [f32; 2],
    pub(super) innovation: [f32; 2],
}

impl Weighed {
    pub(super) fn new(covariance: &Covariance, counts: &Counts) -> Self {
        let [sight_x, sight_y] = &counts.sight;
        let [noise_x, noise_y] = counts.variance;
        let [off_x, off_y] = counts.innovation;
        let seen_x = covariance.seen_by(sight_x);
        let seen_y = covariance.seen_by(sight_y);
        let x = sight_x.of(&seen_x) + noise_x;
        let both = sight_x.of(&seen_y);
        let y = sight_y.of(&seen_y) + noise_y;
        let known = both / x;
        Self {
            seen: [seen_x, seen_y.plus(&seen_x, -known)],
            variance: [x, y - known * both],
            innovation: [off_x, off_y - known * off_x],
        }
    }

    pub(super) fn nis(&self) -> Nis {
        let [x, y] = self.squares();
        Nis { value: x + y, degrees: 2 }
    }

    /// Whether neither is further off than so many standard deviations.
    pub(super) fn within(&self, gate: f32) -> bool {
        let [x, y] = self.squares();
        x.max(y) <= gate * gate
    }

    fn squares(&self) -> [f32; 2] {
        let [off_x, off_y] = self.innovation;
        let [x, y] = self.variance;
        [off_x * off_x / x, off_y * off_y / y]
    }
}

/// The vendor's model at the estimate: `height` over ground, attitude `rotation`.
pub(super) fn counts(
    config: &FlowConfig,
    motion: &Motion,
    passed: &Passed,
    height: f32,
    rotation: &Rotation,
) -> Counts {
    let scale = config.counts_per_radian;
    let [slid_x, slid_y] = scaled2(passed.slid, scale);
    let [turned_x, turned_y] = scaled2(passed.turned, scale);
    let cosine = rotation.tilt_cosine();
    let per_speed = scale * passed.time * cosine / height;
    let [lean_x, lean_y, _] = rotation.z;
    let sight = |slid: f32, along: Vector| Sight {
        height: -slid / height,
        velocity: scaled(along, per_speed),
        tilt: [slid * lean_y / cosine, -slid * lean_x / cosine],
    };
    let noise = noise(config, motion.shutter);
    let variance = |slid: f32| {
        let relief = config.scale_noise * slid;
        noise + relief * relief
    };
    Counts {
        innovation: [
            f32::from(motion.x) - (slid_x - turned_y),
            f32::from(motion.y) - (slid_y + turned_x),
        ],
        sight: [sight(slid_x, rotation.x), sight(slid_y, rotation.y)],
        variance: [variance(slid_x), variance(slid_y)],
    }
}

/// The variance of one count: the picture's, and that of rounding it.
fn noise(config: &FlowConfig, shutter: u16) -> f32 {
    let picture = config.noise + config.noise_per_shutter * f32::from(shutter);
    picture * picture + 1.0 / 12.0
}

/// Why a reading says nothing, if it does not.
pub(super) fn fault(
    config: &FlowConfig,
    motion: &Motion,
    passed: &Passed,
    distance: f32,
    cosine: f32,
) -> Option<Unusable> {
    let most = config.most_counts;
    let still = motion.x == 0 && motion.y == 0;
    if motion.shutter >= config.dark {
        Some(Unusable::Dark)
    } else if motion.squal < config.least_quality {
        Some(Unusable::Featureless)
    } else if motion.x.unsigned_abs() >= most || motion.y.unsigned_abs() >= most {
        Some(Unusable::OutOfRange)
    } else if !(motion.moved || still) {
        Some(Unusable::Invalid)
    } else if passed.time <= 0.0 || passed.time > config.longest {
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
