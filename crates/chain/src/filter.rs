//! The link filter, section IV-C: it estimates the strength of one link from packets that are
//! noisy, late or lost.
//!
//! The paper's insight is that a link's strength changes because two drones move, and that both
//! know how fast they do: their optic flow measures it and their packets carry it. So the scalar
//! Kalman filter of equations (13) to (16) is *predicted* at every round with the change of
//! distance and *updated* once per packet; a lost packet costs nothing but certainty.
//!
//! Two readings of the paper are fixed here:
//! * u is the rate at which the two drones separate, a **difference** of velocities. The sum
//!   that Algorithm 1 prints makes the estimate worse than using no velocity at all.
//! * A is a slope in dB **per metre**, so the prediction is A·u·dt and the tuning does not depend
//!   on how many packets arrive.
//!
//! ```
//! use chain::filter::{LinkFilter, Smoothing};
//! use chain::policy::PolicyConfig;
//! use units::{Dbm, Duration, MetresPerSecond};
//!
//! let smoothing = PolicyConfig::K.smoothing;
//! let mut link = LinkFilter::new();
//! assert_eq!(link.rssi(), None); // nothing heard yet
//! link.update(&smoothing, Dbm(-60.0));
//! // Separating at 0.5 m/s: without a single packet the link is known to have become weaker.
//! link.predict(&smoothing, MetresPerSecond(0.5), Duration::from_secs(1));
//! assert!(link.rssi().unwrap() < Dbm(-60.0));
//! ```

use units::{Db, DbPerMetre, Dbm, Duration, Metres, MetresPerSecond};

/// The fastest that two drones can separate: a neighbour that reports more is wrong, and must not
/// make the estimate overflow.
const FASTEST: MetresPerSecond = MetresPerSecond(10.0);

/// The natural logarithm of 10.
const LN_10: f32 = core::f32::consts::LN_10;

/// How the path loss grows with distance: the A of equation (13), and the derivative that the
/// movement policy divides by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slope {
    /// The slope is the same everywhere, as the paper prints it.
    Constant(DbPerMetre),
    /// The derivative of the log-distance law at the distance that the present loss stands for:
    /// with r = r₁ + 10·α·log₁₀ d, dr/dd = 10·α / (ln 10 · d).
    LogDistance {
        /// α, the attenuation exponent: 2 in free space, up to 6 through walls (section V-A.2).
        exponent: f32,
        /// r₁, the loss at one metre. Equation (19) has none, a real 2.4 GHz link about 40 dB.
        loss_at_1m: Db,
    },
}

impl Slope {
    /// The nearest distance at which the log-distance law holds: two Crazyflies touch at 0.15 m,
    /// and the loss of equation (19) falls without end as the distance goes to zero.
    const NEAREST: Metres = Metres(0.3);
    /// The farthest distance that one hop of a 2.4 GHz link reaches underground.
    const FARTHEST: Metres = Metres(30.0);

    /// The same law for radios that lose this much over the first metre.
    #[must_use]
    pub(crate) const fn for_loss_at_1m(self, loss_at_1m: Db) -> Self {
        match self {
            Self::LogDistance { exponent, .. } => Self::LogDistance { exponent, loss_at_1m },
            Self::Constant(_) => self,
        }
    }

    /// The slope where the loss is `loss`, in dB/m, always positive.
    #[must_use]
    pub fn at(&self, loss: Db) -> DbPerMetre {
        match *self {
            Self::Constant(slope) => slope,
            Self::LogDistance { exponent, loss_at_1m } => {
                let decades = (loss.0 - loss_at_1m.0) / (10.0 * exponent);
                let distance = libm::expf(decades * LN_10).clamp(Self::NEAREST.0, Self::FARTHEST.0);
                DbPerMetre(10.0 * exponent / (LN_10 * distance))
            }
        }
    }
}

/// The constants of the Kalman filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kalman {
    /// A of equation (13).
    pub slope: Slope,
    /// Q of equation (15), for one second: dB² that the link may wander in a second of hovering.
    pub process_variance: f32,
    /// The part of a predicted change that may be wrong (one standard deviation, 0 to 1): the
    /// slope is a guess, and a wrong guess matters only while the drones move. The paper has none.
    pub motion_doubt: f32,
    /// R of equation (16), dB²: the variance of one packet's RSSI about the link's true strength.
    pub measurement_variance: f32,
}

/// The way in which raw RSSI becomes the strength that the movement policy compares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothing {
    /// The strength is the last packet's RSSI: the paper's T0 and T5.
    Raw,
    /// The strength is an exponential average of the packets.
    Average {
        /// The weight of a new packet, between 0 and 1.
        weight: f32,
    },
    /// The strength is estimated by equations (13) to (16).
    Kalman(Kalman),
}

/// The distribution of the next packet's RSSI: normal, with this mean and variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// The mean.
    pub rssi: Dbm,
    /// The variance in dB², or `None` for a smoothing that has no estimate of it.
    pub variance: Option<f32>,
}

/// The filter of one link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkFilter {
    estimate: Option<Estimate>,
}

/// The loss r̂ in dB and its variance P in dB².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Estimate {
    loss: f32,
    variance: f32,
}

impl LinkFilter {
    /// The filter of a link on which no packet has come.
    #[must_use]
    pub const fn new() -> Self {
        Self { estimate: None }
    }

    /// Carries out equation (15), once per round: the two ends separated at `separating` (negative
    /// when they approached) for `dt`. Before the first packet, and without a Kalman filter, it
    /// does nothing.
    pub fn predict(&mut self, smoothing: &Smoothing, separating: MetresPerSecond, dt: Duration) {
        let (Smoothing::Kalman(kalman), Some(estimate)) = (smoothing, &mut self.estimate) else {
            return;
        };
        if !separating.0.is_finite() {
            return;
        }
        let separated = separating.limited_to(FASTEST) * dt;
        let change = (kalman.slope.at(Db(estimate.loss)) * separated).0;
        let doubt = kalman.motion_doubt * change;
        estimate.loss += change;
        estimate.variance += kalman.process_variance * dt.as_secs_f32() + doubt * doubt;
    }

    /// Carries out equation (16), once per packet. NaN is ignored.
    pub fn update(&mut self, smoothing: &Smoothing, rssi: Dbm) {
        let measured = rssi.loss().0;
        if !measured.is_finite() {
            return;
        }
        let measurement_variance = match smoothing {
            Smoothing::Kalman(kalman) => kalman.measurement_variance,
            Smoothing::Raw | Smoothing::Average { .. } => 0.0,
        };
        let Some(estimate) = &mut self.estimate else {
            self.estimate = Some(Estimate { loss: measured, variance: measurement_variance });
            return;
        };
        let gain = match smoothing {
            Smoothing::Raw => 1.0,
            Smoothing::Average { weight } => *weight,
            Smoothing::Kalman(_) => estimate.variance / (estimate.variance + measurement_variance),
        };
        estimate.loss += gain * (measured - estimate.loss);
        estimate.variance *= 1.0 - gain;
    }

    /// The link's strength, or `None` before the first packet.
    #[must_use]
    pub fn rssi(&self) -> Option<Dbm> {
        self.estimate.map(|estimate| Dbm::after_loss(Db(estimate.loss)))
    }

    /// The distribution of the next packet's RSSI: mean r̂, variance P + R. Called between
    /// `predict` and `update`, it lets a caller judge the filter by its own claim.
    #[must_use]
    pub fn expectation(&self, smoothing: &Smoothing) -> Option<Expectation> {
        let estimate = self.estimate?;
        let variance = match smoothing {
            Smoothing::Kalman(kalman) => Some(estimate.variance + kalman.measurement_variance),
            Smoothing::Raw | Smoothing::Average { .. } => None,
        };
        Some(Expectation { rssi: Dbm::after_loss(Db(estimate.loss)), variance })
    }

    /// Forgets the estimate, after a neighbour was lost for so long that it no longer holds.
    pub fn reset(&mut self) {
        self.estimate = None;
    }
}
