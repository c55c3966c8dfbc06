//! A filter that estimates a link's loss together with its two slopes: by how many decibels the
//! loss grows for each metre that this drone, and for each metre that its neighbour, flies away
//! from the other.
//!
//! The paper's filter treats the slope as known. Round a corner the slope is not known: the
//! log-distance law says 1 to 3 dB/m there, the truth is 20 to 30 dB/m, and the slopes of both ends
//! differ. With a slope that is ten times too small the filter lags by seconds and the movement
//! policy, which divides by the slope, has ten times its gain. Both slopes are observable while the
//! drones move, because both drones measure their ways by optic flow.
//!
//! The state is x = (r, a, b): the loss, the slope of this drone's own motion and the slope of the
//! neighbour's. It is predicted with the lengths p and q by which the two motions have separated the
//! ends,
//!
//! > r ← r + a·p + b·q,
//!
//! and updated with each packet's loss, which measures r. The state is linear in its unknowns, so
//! this is a Kalman filter and no approximation of one.

use units::{Db, DbPerMetre, Metres};

use super::Slope;
use super::relief::Relief;

/// The constants of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeFilter {
    /// The law that gives the first values of both slopes.
    pub prior: Slope,
    /// The relative uncertainty of the first slopes (one standard deviation).
    pub prior_doubt: f32,
    /// The relative uncertainty of a predicted change (one standard deviation).
    pub motion_doubt: f32,
    /// The least variance, in dB², by which the loss changes at random in a second of hovering.
    pub still_variance: f32,
    /// The constants by which the filter learns the multiple of that variance by which the loss
    /// really changes.
    pub wandering: Wandering,
    /// The variance, in dB², by which the loss may change for each metre of motion in addition to
    /// the slopes, through fading and the shadows of walls.
    pub way_variance: f32,
    /// The part by which a slope may change over a metre of motion (one standard deviation).
    pub bending: f32,
    /// The smallest step of a link's loss that the filter remembers.
    pub least_step: Db,
    /// Whether the filter also uses the strengths that the other end has measured.
    pub hears_both_ends: bool,
    /// The least and the largest variance of a packet's RSSI about the link's strength, dB².
    pub noise: [f32; 2],
    /// The variance that is assumed before any packet has come, dB².
    pub noise_at_first: f32,
    /// The least weight of a packet in the estimate of that variance. The first ones weigh more.
    pub noise_weight: f32,
}

/// The constants by which a filter learns how much the loss of its link changes at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wandering {
    /// The multiple of the least variance before any packet has come.
    pub at_first: f32,
    /// The largest multiple.
    pub most: f32,
    /// The change of the multiple's logarithm for two errors of one standard deviation each.
    pub weight: f32,
    /// The product of two successive errors, in variances, at which the multiple stays as it is:
    /// with zero the multiple would drift upwards by chance on a link whose loss does not change.
    pub bias: f32,
}

/// The least and the largest slope, dB/m: a line of sight of 20 m has 0.4; and what changes by more than
/// this, 2.4 dB within the 4 cm of a round at 0.2 m/s, is a step and no slope.
const SLOPES: [f32; 2] = [0.4, 60.0];

/// The loss of a packet that is farther from its expectation than this many standard deviations
/// counts as if it were this far (P. Huber's estimator).
const OUTLIER: f32 = 3.0;

/// A packet beyond this many standard deviations does not end a run of outliers on its side.
const NEARLY: f32 = 1.5;

/// So many outliers in a row on one side, while the drones move, are a step of the link and no
/// outliers.
const STEP_AFTER: u8 = 2;
/// The same while the drones hover, where a step is less likely than two weak packets by chance.
const STEP_AFTER_AT_REST: u8 = 5;

/// Metres of motion over the last second or so from which on outliers may be a step.
const STILL: f32 = 0.05;

/// Metres of motion over the last second or so up to which the noise is learned.
const SLOW: f32 = 0.2;

/// The first packets weigh as if this many had come before.
const PACKETS_BEFORE: f32 = 6.0;

/// The slope at which a link's loss may change without a step, dB for each metre of motion over the
/// last second.
const STEEPEST: f32 = 30.0;

/// A step is forgotten once the middle of the link is this far from where it was, m.
const FORGOTTEN: f32 = 1.5;

/// The time constant of the recent motion, s.
const RECENT_S: f32 = 1.0;

/// The estimate of one link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlopeEstimate {
    /// r, dB.
    pub(super) loss: f32,
    /// a and b, dB/m.
    pub(super) slopes: [f32; 2],
    /// The covariance of (r, a, b), symmetric.
    covariance: [[f32; 3]; 3],
    /// R, the variance of a packet's RSSI, dB².
    noise: f32,
    /// The weight of the next packet in the estimate of R.
    noise_weight: f32,
    /// The multiple of the least variance by which the loss wanders.
    wandering: f32,
    /// The last error, in standard deviations.
    last_error: f32,
    /// Metres flown in the last second or so.
    recent: f32,
    /// Outliers in a row: how many, with the sign of their side.
    outliers: i8,
    /// How much longer the link is than when its first packet came, m.
    length: f32,
    /// How far the middle of the link has moved since, m: without sign, as a step is forgotten
    /// after some way in either direction.
    shift: f32,
    /// The length when the last packet came that was no outlier.
    sound_length: f32,
    step: Option<Step>,
    relief: Relief,
}

/// A length at which the loss steps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    /// The largest length that is known to be on the good side.
    length: f32,
    /// Where the middle of the link was.
    shift: f32,
    /// By how much the loss steps, dB.
    height: f32,
    /// Whether the link is on the bad side now.
    is_beyond: bool,
}

/// A length at which the loss of a link steps, relative to the link's present length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkStep {
    /// The length that the link may still gain before its loss steps; negative beyond the step.
    pub room: Metres,
    /// The height of the step, positive.
    pub height: Db,
    /// Whether the link is on the bad side of the step.
    pub is_beyond: bool,
}

/// The lengths by which two motions have moved the ends of a link apart, negative when they
/// approached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Separation {
    /// The length by this drone's own motion.
    pub own: Metres,
    /// The length by its neighbour's motion.
    pub peer: Metres,
}

impl SlopeEstimate {
    /// The estimate after a link's first packet.
    pub(super) fn first(config: &SlopeFilter, loss: f32) -> Self {
        let slope = config.prior.at(Db(loss)).0.clamp(SLOPES[0], SLOPES[1]);
        let doubt = config.prior_doubt * slope;
        let variance = doubt * doubt;
        // In a straight corridor both slopes are the same.
        let shared = 0.5 * variance;
        let noise = config.noise_at_first;
        Self {
            loss,
            slopes: [slope; 2],
            covariance: [[noise, 0.0, 0.0], [0.0, variance, shared], [0.0, shared, variance]],
            noise,
            noise_weight: 1.0 / PACKETS_BEFORE,
            wandering: config.wandering.at_first,
            last_error: 0.0,
            recent: 0.0,
            outliers: 0,
            length: 0.0,
            shift: 0.0,
            sound_length: 0.0,
            step: None,
            relief: Relief::first(loss),
        }
    }

    /// Moves the estimate on over a separation.
    pub(super) fn separate(&mut self, config: &SlopeFilter, by: Separation) {
        let (p, q) = (by.own.0, by.peer.0);
        let [a, b] = self.slopes;
        let change = a * p + b * q;
        self.loss += change;
        let [[rr, ra, rb], [_, aa, ab], [_, _, bb]] = self.covariance;
        let way = p.abs() + q.abs();
        self.recent += way;
        self.length += p + q;
        self.shift += 0.5 * (q - p);
        self.relief.separate([p, q]);
        self.step = self.step.filter(|step| (step.shift - self.shift).abs() < FORGOTTEN);
        if let Some(step) = &mut self.step {
            // It is where it is not known to be otherwise.
            step.length = if step.is_beyond {
                step.length.min(self.length)
            } else {
                step.length.max(self.length)
            };
        }
        let doubt = config.motion_doubt * change;
        let new_rr = rr
            + 2.0 * (p * ra + q * rb)
            + p * p * aa
            + 2.0 * p * q * ab
            + q * q * bb
            + doubt * doubt
            + config.way_variance * way;
        let (new_ra, new_rb) = (ra + p * aa + q * ab, rb + p * ab + q * bb);
        let bend = |slope: f32| config.bending * config.bending * slope * slope * way;
        let (ta, tb) = (bend(a), bend(b));
        // Where a slope changes, the geometry has changed, and so does the other.
        let both = 0.5 * libm::sqrtf(ta * tb);
        self.covariance =
            [[new_rr, new_ra, new_rb], [new_ra, aa + ta, ab + both], [new_rb, ab + both, bb + tb]];
    }

    /// Lets the loss wander for `seconds`.
    pub(super) fn wait(&mut self, config: &SlopeFilter, seconds: f32) {
        self.covariance[0][0] += self.wandering * config.still_variance * seconds;
        self.recent *= libm::expf(-seconds / RECENT_S);
    }

    /// Takes in a packet's loss.
    pub(super) fn update(&mut self, config: &SlopeFilter, measured: f32) {
        let error = measured - self.loss;
        let expected = self.covariance[0][0] + self.noise;
        let deviation = libm::sqrtf(expected);
        let ratio = error.abs() / deviation;
        self.count_outlier(error, ratio);
        self.learn_noise(config, error, expected);
        self.learn_wandering(&config.wandering, error / deviation);
        let mut noise = self.noise;
        if self.has_stepped() {
            self.covariance[0][0] += error * error - expected;
            self.outliers = 0;
            self.remember_step(config, error, deviation);
        } else if ratio > OUTLIER {
            noise = expected * ratio / OUTLIER - self.covariance[0][0];
        } else {
            self.sound_length = self.length;
        }
        self.correct(error, noise);
        self.relief.note(self.loss);
    }

    fn count_outlier(&mut self, error: f32, ratio: f32) {
        let side = if error > 0.0 { 1 } else { -1 };
        self.outliers = match self.outliers {
            before if ratio <= OUTLIER && ratio > NEARLY && before.signum() == side => before,
            _ if ratio <= OUTLIER => 0,
            before if before.signum() == side => before.saturating_add(side),
            _ => side,
        };
    }

    /// Whether so many outliers in a row are a step of the link.
    fn has_stepped(&self) -> bool {
        let enough = if self.recent > STILL { STEP_AFTER } else { STEP_AFTER_AT_REST };
        self.outliers.unsigned_abs() >= enough
    }

    /// Remembers where the loss has stepped by `error`. What a fast drone takes for a step may be a
    /// steep slope.
    fn remember_step(&mut self, config: &SlopeFilter, error: f32, deviation: f32) {
        let is_beyond = error > 0.0;
        let least = (OUTLIER * deviation).max(config.least_step.0) + STEEPEST * self.recent;
        match &mut self.step {
            Some(step) if error.abs() > 0.5 * step.height => {
                step.is_beyond = is_beyond;
                step.height = error.abs();
                step.length = if is_beyond { self.sound_length } else { self.length };
                step.shift = self.shift;
            }
            _ if error.abs() > least => {
                self.step = Some(Step {
                    length: if is_beyond { self.sound_length } else { self.length },
                    shift: self.shift,
                    height: error.abs(),
                    is_beyond,
                });
            }
            _ => {}
        }
        self.sound_length = self.length;
    }

    fn correct(&mut self, error: f32, noise: f32) {
        let [[rr, ra, rb], [_, aa, ab], [_, _, bb]] = self.covariance;
        let expected = rr + noise;
        let [kr, ka, kb] = [rr / expected, ra / expected, rb / expected];
        self.loss += kr * error;
        let [a, b] = self.slopes;
        self.slopes = [
            (a + ka * error).clamp(SLOPES[0], SLOPES[1]),
            (b + kb * error).clamp(SLOPES[0], SLOPES[1]),
        ];
        self.covariance = [
            [rr - kr * rr, ra - kr * ra, rb - kr * rb],
            [ra - kr * ra, aa - ka * ra, ab - ka * rb],
            [rb - kr * rb, ab - ka * rb, bb - kb * rb],
        ];
    }

    /// Learns R from the errors of a link whose ends move slowly: those of fast ones tell of the
    /// slopes' errors as well, and those of outliers, or near a step, of the step.
    fn learn_noise(&mut self, config: &SlopeFilter, error: f32, expected: f32) {
        let (most_way, most_outliers) =
            if self.step.is_some() { (STILL, 1) } else { (SLOW, u8::from(self.recent <= STILL)) };
        if self.recent > most_way || self.outliers.unsigned_abs() > most_outliers {
            return;
        }
        let square = (error * error).min(OUTLIER * OUTLIER * expected);
        let noise = self.noise + self.noise_weight * (square - expected);
        self.noise = noise.max(config.noise[0]).min(config.noise[1]);
        let next = 1.0 / (1.0 / self.noise_weight + 1.0);
        self.noise_weight = next.max(config.noise_weight);
    }

    /// Learns how much the loss wanders from this error and the last one, in standard deviations.
    /// Outliers are not used, nor is a link that is known to step: two errors after a step are on
    /// the same side, though the link does not wander.
    fn learn_wandering(&mut self, config: &Wandering, error: f32) {
        if error.abs() > OUTLIER || self.step.is_some() {
            self.last_error = 0.0;
            return;
        }
        let change = config.weight * (error * self.last_error - config.bias);
        self.wandering = (self.wandering * libm::expf(change)).max(1.0).min(config.most);
        self.last_error = error;
    }

    /// The variance of the loss, dB².
    pub(super) const fn variance(&self) -> f32 {
        self.covariance[0][0]
    }

    /// The variance of the next packet's RSSI, dB².
    pub(super) const fn expected_variance(&self) -> f32 {
        self.covariance[0][0] + self.noise
    }

    /// The step that is remembered.
    pub(super) fn step(&self) -> Option<LinkStep> {
        self.step.map(|step| LinkStep {
            room: Metres(step.length - self.length),
            height: Db(step.height),
            is_beyond: step.is_beyond,
        })
    }

    /// The largest loss that lengthening the link has taken away, dB.
    pub(super) const fn hump(&self) -> f32 {
        self.relief.hump()
    }

    /// The slopes of both ends.
    pub(super) const fn slopes(&self) -> [DbPerMetre; 2] {
        [DbPerMetre(self.slopes[0]), DbPerMetre(self.slopes[1])]
    }
}
