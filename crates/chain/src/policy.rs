//! The movement policy, section IV-A: equation (11) as Algorithm 1 carries it out.
//!
//! With the losses r_f of the front link and r_b of the back link, e = r_f − r_b. Where e > 0 the
//! front link is the weaker one and the relay flies forward (towards the head), where e < 0 it
//! flies back, and where |e| ≤ T it hovers. The speed is
//!
//! > v = κ · e / g, limited to ±v_max
//!
//! with g the slope of a link in dB/m and κ in 1/s: within 1/κ seconds one drone's move alone
//! would take the whole of e from one link. Equation (11) asks for e/3 *per round*; at 5 Hz that
//! is κ = (1/3)/0.2 s = 1.67 1/s. With the 0.3 s lag of a real vehicle and a packet's delay this
//! gain oscillates even without noise (the chain's fastest mode has gain 4κ), so the default is
//! less than a tenth of it.

mod registry;

use units::{Db, DbPerMetre, Dbm, Metres, MetresPerSecond};

use crate::chain_wide::{Caution, ChainWide};
use crate::filter::{Kalman, Slope, SlopeFilter, Smoothing, Wandering};

pub use registry::{NAMES, Policy, REGISTRY};

/// The other end of one of a relay's links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEnd {
    /// The link's strength.
    pub rssi: Dbm,
    /// The neighbour's velocity along the tunnel, positive towards the head.
    pub velocity: MetresPerSecond,
}

impl LinkEnd {
    /// Returns the end of a link whose neighbour stands still, or whose motion is not known.
    #[must_use]
    pub const fn still(rssi: Dbm) -> Self {
        Self { rssi, velocity: MetresPerSecond::ZERO }
    }
}

/// The one of a relay's two links whose slope turns the imbalance into a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlopeOf {
    /// The weaker link, which equation (11) improves. With a log-distance law the stronger link
    /// is the steeper one and changes by more than the proof allows.
    WeakerLink,
    /// The steeper link, so that neither link changes by more than intended.
    SteeperLink,
}

/// The law by which the imbalance e becomes a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedLaw {
    /// The velocity is v = κ·e/g.
    Proportional {
        /// The gain κ, in 1/s.
        gain: f32,
        /// The model that gives the slope g.
        slope: Slope,
        /// The link whose slope is used.
        of: SlopeOf,
        /// The part, 0 to 1, of the velocity that would keep both links as they are:
        /// with g_f and g_b the slopes of the two links and v_f and v_b the neighbours'
        /// velocities, (g_f·v_f + g_b·v_b) / (g_f + g_b). The paper has none. Without it a gain
        /// that is low enough for a corner lags metres behind a moving head.
        follow: f32,
    },
    /// The rule of the authors' published firmware (`behavior_positioning.c`), which flew the
    /// paper's experiment: full speed one way or the other.
    BangBang {
        /// The speed towards the weaker link.
        speed: MetresPerSecond,
    },
    /// The chain-wide rule; where a neighbour reports no sums, the rule of
    /// [`PolicyConfig::K_TUNED`].
    ChainWide(ChainWide),
    /// A function that the program in which a simulated drone flies has given.
    #[cfg(feature = "called")]
    Called(CalledLaw),
}

/// A speed law that is a function: it is given the ends of the front link and of the back link, and
/// returns the forward velocity.
#[cfg(feature = "called")]
#[derive(Clone, Copy, Debug)]
pub struct CalledLaw(pub fn(LinkEnd, LinkEnd) -> MetresPerSecond);

#[cfg(feature = "called")]
impl PartialEq for CalledLaw {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::fn_addr_eq(self.0, other.0)
    }
}

/// The rule that keeps a relay at a distance from its neighbours: a tunnel has no room to pass, and
/// only the signal strength shows how near they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// A neighbour whose signal is stronger than this is too near.
    pub too_near: Dbm,
    /// The speed away from a neighbour that is too near.
    pub away: MetresPerSecond,
    /// Between two neighbours that are too near a relay stays, unless the signal of one is stronger
    /// by more than this: of drones that stand close together those at the ends leave first, and
    /// none is pushed into the next. With `None` a relay always flies back from the one in front, as
    /// the authors' firmware does.
    pub clearly_nearer: Option<Db>,
}

impl Clearance {
    /// The velocity of a relay whose neighbours are heard this strongly, if one is too near.
    fn velocity(&self, front: Dbm, back: Dbm) -> Option<MetresPerSecond> {
        let nearer_by = (front - back).0;
        match (front > self.too_near, back > self.too_near, self.clearly_nearer) {
            (false, false, _) => None,
            (false, true, _) => Some(self.away),
            (true, false, _) | (true, true, None) => Some(-self.away),
            (true, true, Some(clearly)) if nearer_by > clearly.0 => Some(-self.away),
            (true, true, Some(clearly)) if nearer_by < -clearly.0 => Some(self.away),
            (true, true, Some(_)) => Some(MetresPerSecond::ZERO),
        }
    }
}

/// The constants of one movement policy and of its filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicyConfig {
    /// The filter of the links that the policy compares.
    pub smoothing: Smoothing,
    /// The T of Algorithm 1: with an imbalance no larger than this the relay hovers.
    pub tolerance: Db,
    /// The law by which the imbalance becomes a velocity.
    pub law: SpeedLaw,
    /// The rule that keeps the relay off its neighbours, which the paper leaves out.
    pub clearance: Option<Clearance>,
    /// The largest speed, v_max.
    pub max_speed: MetresPerSecond,
}

/// The log-distance law with the exponent halfway between the 2 of air and the 4 of one wall: the
/// best assumption for equation (19) of a drone that does not know the walls. The first metre costs
/// 40 dB at 2.4 GHz (free space, 20·log₁₀(4π/λ)); the paper's equation leaves it out, which shifts
/// every link by the same amount and changes no velocity.
pub(crate) const PAPER_SLOPE: Slope = Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) };

/// Equation (11) to the letter: a third of the imbalance per round of 0.2 s.
const PAPER_LAW: SpeedLaw = SpeedLaw::Proportional {
    gain: (1.0 / 3.0) / 0.2,
    slope: PAPER_SLOPE,
    of: SlopeOf::WeakerLink,
    follow: 0.0,
};

/// MAX_SPEED of the authors' firmware (`tunnel_config.h`).
const MAX_SPEED: MetresPerSecond = MetresPerSecond(0.4);

/// The speed of a hovering relay, which the noise of its filter keeps moving (measured by
/// simulation in the corridors of the `chain` benchmark). Slower motion of a neighbour is not
/// followed.
const HOVER_NOISE: MetresPerSecond = MetresPerSecond(0.06);

impl PolicyConfig {
    /// The paper's policy T0, which uses the raw signal without a tolerance.
    pub const T0: Self = Self {
        smoothing: Smoothing::Raw,
        tolerance: Db(0.0),
        law: PAPER_LAW,
        clearance: None,
        max_speed: MAX_SPEED,
    };

    /// The paper's policy T5, which uses the raw signal and hovers at an imbalance of up to 5 dB.
    pub const T5: Self = Self { tolerance: Db(5.0), ..Self::T0 };

    /// The paper's policy K, which uses the Kalman filter. R is the variance of the paper's
    /// simulated noise; Q is 0.05 dB² per round of 0.2 s, hand-tuned like the paper's A.
    pub const K: Self = Self {
        smoothing: Smoothing::Kalman(Kalman {
            slope: PAPER_SLOPE,
            process_variance: 0.05 / 0.2,
            motion_doubt: 0.0,
            measurement_variance: 3.0,
        }),
        ..Self::T0
    };

    /// The rule of the authors' firmware: an exponential average of 0.27 (the steady state of their
    /// filter, whose velocity input was always zero), ±0.3 m/s outside a dead zone of 1.5 dB, away
    /// at 0.2 m/s from a neighbour above −40 dBm (`tunnel_config.h`, `behavior_positioning.c`).
    pub const AUTHORS: Self = Self {
        smoothing: Smoothing::Average { weight: 0.27 },
        tolerance: Db(1.5),
        law: SpeedLaw::BangBang { speed: MetresPerSecond(0.3) },
        clearance: Some(Clearance {
            too_near: Dbm(-40.0),
            away: MetresPerSecond(0.2),
            clearly_nearer: None,
        }),
        max_speed: MAX_SPEED,
    };

    /// The policy K with a gain that is stable with realistic lag and delay, also where a corner
    /// makes a link ten times as steep as the log-distance law says, and with the slope of the
    /// steeper link. The relay follows its neighbours' velocities, which compensates for the low
    /// gain. Gain, Q and the uncertainty of the motion were chosen from a search over the three
    /// corridors of the `chain` benchmark and the demonstration (gains of 0.07 to 0.4 1/s), by
    /// simulation; −37 dBm is 0.7 m in free space, twice the spacing of the drones at the mouth,
    /// and 3.5 dB are half as far again there.
    pub const K_TUNED: Self = Self {
        smoothing: Smoothing::Kalman(Kalman {
            slope: PAPER_SLOPE,
            process_variance: 0.02,
            motion_doubt: 0.6,
            measurement_variance: 3.0,
        }),
        law: SpeedLaw::Proportional {
            gain: 0.12,
            slope: PAPER_SLOPE,
            of: SlopeOf::SteeperLink,
            follow: 1.0,
        },
        clearance: Some(Clearance {
            too_near: Dbm(-37.0),
            away: MetresPerSecond(0.2),
            clearly_nearer: Some(Db(3.5)),
        }),
        ..Self::T0
    };

    /// The chain-wide policy, the default of the firmware: it estimates slopes in flight and uses
    /// sums over the whole chain. The gain is limited by the stability of a chain of 15 links whose
    /// sums take one round for each hop (κ ≤ 4 / (15 · 0.2 s / 0.8), from the study behind the
    /// book's chapter "Chain control"); the other constants were chosen by simulation in the
    /// corridors of the `chain` benchmark, on seeds and corridors other than those that the book
    /// reports.
    pub const CHAIN: Self = Self {
        smoothing: Smoothing::Slopes(SlopeFilter {
            prior: PAPER_SLOPE,
            prior_doubt: 0.7,
            motion_doubt: 0.2,
            still_variance: 0.05,
            wandering: Wandering { at_first: 4.0, most: 300.0, weight: 0.1, bias: 0.1 },
            way_variance: 0.15,
            bending: 0.6,
            least_step: Db(6.0),
            hears_both_ends: true,
            noise: [2.0, 100.0],
            noise_at_first: 6.0,
            noise_weight: 0.02,
        }),
        law: SpeedLaw::ChainWide(ChainWide {
            gain: 0.3,
            local_gain: 0.4,
            follow: 1.0,
            near: Metres(0.03),
            deviations: 1.0,
            tolerance: Db(0.3),
            margin: Metres(0.08),
            caution: Caution {
                least: 0.2,
                down: 0.6,
                up: 1.06,
                whole_gain_from: MetresPerSecond(0.1),
            },
        }),
        ..Self::K_TUNED
    };

    /// Returns the same policy for radios that lose this much over the first metre.
    #[must_use]
    pub fn for_loss_at_1m(mut self, loss_at_1m: Db) -> Self {
        if let Smoothing::Kalman(kalman) = &mut self.smoothing {
            kalman.slope = kalman.slope.for_loss_at_1m(loss_at_1m);
        }
        if let Smoothing::Slopes(slopes) = &mut self.smoothing {
            slopes.prior = slopes.prior.for_loss_at_1m(loss_at_1m);
        }
        if let SpeedLaw::Proportional { slope, .. } = &mut self.law {
            *slope = slope.for_loss_at_1m(loss_at_1m);
        }
        if let Some(clearance) = &mut self.clearance {
            clearance.too_near = clearance.too_near + (Self::LOSS_AT_1M - loss_at_1m);
        }
        self
    }

    /// The loss over the first metre that the named policies are made for.
    const LOSS_AT_1M: Db = Db(40.0);

    /// Whether the policy's filter estimates slopes.
    #[must_use]
    pub const fn estimates_slopes(&self) -> bool {
        matches!(self.smoothing, Smoothing::Slopes(_))
    }

    /// Returns the forward velocity of a relay between these two neighbours, by Algorithm 1.
    #[must_use]
    pub fn velocity(&self, front: LinkEnd, back: LinkEnd) -> MetresPerSecond {
        let away = self.clearance.and_then(|clearance| clearance.velocity(front.rssi, back.rssi));
        let wanted = away.unwrap_or_else(|| self.towards_weaker(front, back));
        wanted.limited_to(self.max_speed)
    }

    /// Whether a neighbour whose link is this strong is too near.
    #[must_use]
    pub fn is_too_near(&self, rssi: Dbm) -> bool {
        self.clearance.is_some_and(|clearance| rssi > clearance.too_near)
    }

    fn towards_weaker(&self, front: LinkEnd, back: LinkEnd) -> MetresPerSecond {
        let imbalance = front.rssi.loss() - back.rssi.loss();
        let balanced = imbalance.abs() <= self.tolerance;
        match self.law {
            SpeedLaw::BangBang { .. } if balanced => MetresPerSecond::ZERO,
            SpeedLaw::BangBang { speed } => MetresPerSecond(speed.0.copysign(imbalance.0)),
            SpeedLaw::ChainWide(_) => Self::K_TUNED.towards_weaker(front, back),
            #[cfg(feature = "called")]
            SpeedLaw::Called(CalledLaw(law)) => law(front, back),
            SpeedLaw::Proportional { gain, slope, of, follow } => {
                let (g_f, g_b) = (slope.at(front.rssi.loss()), slope.at(back.rssi.loss()));
                let carried =
                    (g_f.0 * front.velocity.0 + g_b.0 * back.velocity.0) / (g_f.0 + g_b.0);
                let steepness = slope_of(of, front.rssi, back.rssi, g_f, g_b);
                let correction = if balanced { 0.0 } else { gain * imbalance.0 / steepness.0 };
                // The noise of hovering neighbours must not be followed.
                let led = carried - carried.clamp(-HOVER_NOISE.0, HOVER_NOISE.0);
                MetresPerSecond(correction + follow * led)
            }
        }
    }
}

impl Default for PolicyConfig {
    fn default() -> Self {
        Self::CHAIN
    }
}

fn slope_of(of: SlopeOf, front: Dbm, back: Dbm, g_f: DbPerMetre, g_b: DbPerMetre) -> DbPerMetre {
    let front_counts = match of {
        SlopeOf::WeakerLink => front <= back,
        SlopeOf::SteeperLink => g_f >= g_b,
    };
    if front_counts { g_f } else { g_b }
}
