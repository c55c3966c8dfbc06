//! The link filter, section IV-C: it estimates the strength of one link from packets that are
//! noisy, late or lost.
//!
//! The paper's insight is that a link's strength changes because two drones move, and that both
//! know how fast they do: their optic flow measures it and their packets carry it. So the scalar
//! Kalman filter of equations (13) to (16) is *predicted* at every round with the change of
//! distance and *updated* once per packet; a lost packet only makes the estimate less certain.
//!
//! Two points of the paper are corrected here:
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

mod relief;
mod slopes;

use units::{Db, DbPerMetre, Dbm, Duration, Metres, MetresPerSecond};

use slopes::SlopeEstimate;
pub use slopes::{LinkStep, Separation, SlopeFilter, Wandering};

/// The fastest that two drones can separate: a neighbour that reports more is wrong, and must not
/// make the estimate overflow.
const FASTEST: MetresPerSecond = MetresPerSecond(10.0);

/// The farthest that one drone flies between two packets: more is an odometer that is wrong.
const FARTHEST: Metres = Metres(10.0);

/// The largest loss that a radio measures, dB; a larger one must not make the estimate overflow.
const MOST_LOSS: f32 = 1_000.0;

/// The natural logarithm of 10.
const LN_10: f32 = core::f32::consts::LN_10;

/// The law by which the path loss grows with distance: the A of equation (13), and the derivative
/// by which the movement policy divides.
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
    /// The slope A of equation (13).
    pub slope: Slope,
    /// The Q of equation (15), for one second: the variance in dB² by which the loss may change at
    /// random in a second of hovering.
    pub process_variance: f32,
    /// The relative uncertainty of a predicted change (one standard deviation, 0 to 1): the slope
    /// is only assumed, and a wrong slope matters only while the drones move. The paper has no such
    /// term.
    pub motion_doubt: f32,
    /// The R of equation (16), in dB²: the variance of one packet's RSSI about the link's true
    /// strength.
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
    /// The strength is estimated together with the slopes of both ends.
    Slopes(SlopeFilter),
}

/// The expected distribution of the next packet's RSSI: normal, with this mean and variance.
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

/// The estimate of a link, as far as its smoothing has one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Estimate {
    /// The loss r̂ in dB and its variance P in dB².
    Loss { loss: f32, variance: f32 },
    /// The loss and both slopes.
    Slopes(SlopeEstimate),
}

/// A link as a movement policy sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkState {
    /// The loss.
    pub loss: Db,
    /// The slopes of this drone's own motion and of its neighbour's.
    pub slopes: [DbPerMetre; 2],
    /// The variance of the loss, dB².
    pub variance: f32,
    /// The length at which the loss of the link steps, if the filter knows such a length near the
    /// present one.
    pub step: Option<LinkStep>,
    /// The largest loss that lengthening the link has ever taken away: zero where the signal falls
    /// evenly along the tunnel, but for noise.
    pub hump: Db,
}

/// The estimate of a link, for observers; nothing is controlled by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEstimate {
    /// The strength.
    pub rssi: Dbm,
    /// The variance of the strength, dB²; zero for a smoothing that has no estimate of it.
    pub variance: f32,
    /// The slopes of this drone's own motion and of its neighbour's, where the smoothing estimates
    /// them.
    pub slopes: Option<[DbPerMetre; 2]>,
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
        if !separating.0.is_finite() {
            return;
        }
        let separated = separating.limited_to(FASTEST) * dt;
        match (smoothing, &mut self.estimate) {
            (Smoothing::Kalman(kalman), Some(Estimate::Loss { loss, variance })) => {
                let change = (kalman.slope.at(Db(*loss)) * separated).0;
                let doubt = kalman.motion_doubt * change;
                *loss += change;
                *variance += kalman.process_variance * dt.as_secs_f32() + doubt * doubt;
            }
            (Smoothing::Slopes(config), Some(Estimate::Slopes(estimate))) => {
                estimate.wait(config, dt.as_secs_f32());
                estimate.separate(config, Separation { own: Metres::ZERO, peer: separated });
            }
            _ => {}
        }
    }

    /// Updates the estimate for a measured separation, where the smoothing estimates slopes.
    pub fn separate(&mut self, smoothing: &Smoothing, by: Separation) {
        if let (Smoothing::Slopes(config), Some(Estimate::Slopes(estimate))) =
            (smoothing, &mut self.estimate)
            && by.own.0.is_finite()
            && by.peer.0.is_finite()
        {
            let [own, peer] = [by.own, by.peer].map(|way| way.limited_to(FARTHEST));
            estimate.separate(config, Separation { own, peer });
        }
    }

    /// Carries out equation (16), once per packet. NaN is ignored.
    pub fn update(&mut self, smoothing: &Smoothing, rssi: Dbm) {
        let measured = rssi.loss().0;
        if !measured.is_finite() {
            return;
        }
        let measured = measured.clamp(-MOST_LOSS, MOST_LOSS);
        match (&mut self.estimate, smoothing) {
            (Some(Estimate::Slopes(estimate)), Smoothing::Slopes(config)) => {
                estimate.update(config, measured);
            }
            (Some(Estimate::Loss { loss, variance }), _) => {
                let gain = match smoothing {
                    Smoothing::Raw | Smoothing::Slopes(_) => 1.0,
                    Smoothing::Average { weight } => *weight,
                    Smoothing::Kalman(kalman) => {
                        *variance / (*variance + kalman.measurement_variance)
                    }
                };
                *loss += gain * (measured - *loss);
                *variance *= 1.0 - gain;
            }
            (estimate, smoothing) => *estimate = Some(Self::first(smoothing, measured)),
        }
    }

    /// The estimate after a link's first packet.
    fn first(smoothing: &Smoothing, loss: f32) -> Estimate {
        match smoothing {
            Smoothing::Slopes(config) => Estimate::Slopes(SlopeEstimate::first(config, loss)),
            Smoothing::Kalman(kalman) => {
                Estimate::Loss { loss, variance: kalman.measurement_variance }
            }
            Smoothing::Raw | Smoothing::Average { .. } => Estimate::Loss { loss, variance: 0.0 },
        }
    }

    /// The link's strength, or `None` before the first packet.
    #[must_use]
    pub fn rssi(&self) -> Option<Dbm> {
        self.estimate.map(|estimate| match estimate {
            Estimate::Loss { loss, .. } => Dbm::after_loss(Db(loss)),
            Estimate::Slopes(estimate) => Dbm::after_loss(Db(estimate.loss)),
        })
    }

    /// The link's loss and slopes; `None` before the first packet, and for a smoothing that has no
    /// estimate of slopes.
    #[must_use]
    pub fn state(&self) -> Option<LinkState> {
        match self.estimate? {
            Estimate::Loss { .. } => None,
            Estimate::Slopes(estimate) => Some(LinkState {
                loss: Db(estimate.loss),
                slopes: estimate.slopes(),
                variance: estimate.variance(),
                step: estimate.step(),
                hump: Db(estimate.hump()),
            }),
        }
    }

    /// The estimate of the link; `None` before the first packet.
    #[must_use]
    pub fn estimate(&self) -> Option<LinkEstimate> {
        let rssi = self.rssi()?;
        Some(match self.estimate? {
            Estimate::Loss { variance, .. } => LinkEstimate { rssi, variance, slopes: None },
            Estimate::Slopes(estimate) => LinkEstimate {
                rssi,
                variance: estimate.variance(),
                slopes: Some(estimate.slopes()),
            },
        })
    }

    /// The distribution of the next packet's RSSI: mean r̂, variance P + R. Called between
    /// `predict` and `update`, it lets a caller compare the filter's predicted variance with its
    /// real errors.
    #[must_use]
    pub fn expectation(&self, smoothing: &Smoothing) -> Option<Expectation> {
        let rssi = self.rssi()?;
        let variance = match (self.estimate?, smoothing) {
            (Estimate::Loss { variance, .. }, Smoothing::Kalman(kalman)) => {
                Some(variance + kalman.measurement_variance)
            }
            (Estimate::Slopes(estimate), _) => Some(estimate.expected_variance()),
            _ => None,
        };
        Some(Expectation { rssi, variance })
    }

    /// Resets the estimate, after a neighbour was lost for so long that the estimate is no longer
    /// valid.
    pub fn reset(&mut self) {
        self.estimate = None;
    }
}
