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
//! gain oscillates even without noise (the chain's fastest mode has gain 4κ), so the default is a
//! quarter of it.

use units::{Db, DbPerMetre, Dbm, MetresPerSecond};

use crate::filter::{Kalman, Slope, Smoothing};

/// Which of a relay's two links tells how far to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlopeOf {
    /// The weaker link, which equation (11) improves. With a log-distance law the stronger link
    /// is the steeper one and changes by more than the proof allows.
    WeakerLink,
    /// The steeper one, so that neither link changes by more than was meant.
    SteeperLink,
}

/// How the imbalance e becomes a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedLaw {
    /// v = κ·e/g.
    Proportional {
        /// κ, in 1/s.
        gain: f32,
        /// The model that g is taken from.
        slope: Slope,
        /// The link at which it is taken.
        of: SlopeOf,
    },
    /// The rule that flew (the authors' published firmware, `behavior_positioning.c`): full speed
    /// one way or the other, and away from a neighbour that is very near.
    BangBang {
        /// Speed towards the weaker link.
        speed: MetresPerSecond,
        /// Above this a neighbour is too near,
        too_near: Dbm,
        /// and this is the speed away from it.
        away: MetresPerSecond,
    },
}

/// One movement policy with its filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicyConfig {
    /// What the policy compares.
    pub smoothing: Smoothing,
    /// T of Algorithm 1: an imbalance no larger than this moves nothing.
    pub tolerance: Db,
    /// Imbalance to velocity.
    pub law: SpeedLaw,
    /// v_max.
    pub max_speed: MetresPerSecond,
}

/// The log-distance law with the exponent halfway between the 2 of air and the 4 of one wall: what
/// a drone can assume of equation (19) without knowing the walls. The first metre costs 40 dB at
/// 2.4 GHz (free space, 20·log₁₀(4π/λ)); the paper's equation leaves it out, which shifts every
/// link by the same amount and moves nothing.
const PAPER_SLOPE: Slope = Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) };

/// Equation (11) to the letter: a third of the imbalance per round of 0.2 s.
const PAPER_LAW: SpeedLaw =
    SpeedLaw::Proportional { gain: (1.0 / 3.0) / 0.2, slope: PAPER_SLOPE, of: SlopeOf::WeakerLink };

/// MAX_SPEED of the authors' firmware (`tunnel_config.h`).
const MAX_SPEED: MetresPerSecond = MetresPerSecond(0.4);

impl PolicyConfig {
    /// The paper's T0: raw signal, no tolerance.
    pub const T0: Self = Self {
        smoothing: Smoothing::Raw,
        tolerance: Db(0.0),
        law: PAPER_LAW,
        max_speed: MAX_SPEED,
    };

    /// The paper's T5: raw signal, an imbalance of up to 5 dB is let be.
    pub const T5: Self = Self { tolerance: Db(5.0), ..Self::T0 };

    /// The paper's K: the Kalman filter. R is the variance of the paper's simulated noise; Q is
    /// 0.05 dB² per round of 0.2 s, hand-tuned like the paper's A.
    pub const K: Self = Self {
        smoothing: Smoothing::Kalman(Kalman {
            slope: PAPER_SLOPE,
            process_variance: 0.05 / 0.2,
            motion_doubt: 0.0,
            measurement_variance: 3.0,
        }),
        ..Self::T0
    };

    /// What the authors flew: an exponential average of 0.27 (the steady state of their filter,
    /// whose velocity input was always zero), ±0.3 m/s outside a dead zone of 1.5 dB, away at
    /// 0.2 m/s from a neighbour above −40 dBm (`tunnel_config.h`, `behavior_positioning.c`).
    pub const AUTHORS: Self = Self {
        smoothing: Smoothing::Average { weight: 0.27 },
        tolerance: Db(1.5),
        law: SpeedLaw::BangBang {
            speed: MetresPerSecond(0.3),
            too_near: Dbm(-40.0),
            away: MetresPerSecond(0.2),
        },
        max_speed: MAX_SPEED,
    };

    /// K with a gain that is stable with real lag and delay, and the slope of the steeper link.
    pub const DEFAULT: Self = Self {
        law: SpeedLaw::Proportional { gain: 0.4, slope: PAPER_SLOPE, of: SlopeOf::SteeperLink },
        ..Self::K
    };

    /// The same policy for radios that lose this much over the first metre.
    #[must_use]
    pub fn for_loss_at_1m(mut self, loss_at_1m: Db) -> Self {
        if let Smoothing::Kalman(kalman) = &mut self.smoothing {
            kalman.slope = kalman.slope.for_loss_at_1m(loss_at_1m);
        }
        match &mut self.law {
            SpeedLaw::Proportional { slope, .. } => *slope = slope.for_loss_at_1m(loss_at_1m),
            SpeedLaw::BangBang { too_near, .. } => *too_near = Dbm::after_loss(loss_at_1m),
        }
        self
    }

    /// Algorithm 1: the forward velocity of a relay whose links to the front and back neighbours
    /// have these strengths.
    #[must_use]
    pub fn velocity(&self, front: Dbm, back: Dbm) -> MetresPerSecond {
        let imbalance = front.loss() - back.loss();
        let wanted = match self.law {
            SpeedLaw::BangBang { too_near, away, .. } if front > too_near => -away,
            SpeedLaw::BangBang { too_near, away, .. } if back > too_near => away,
            _ if imbalance.abs() <= self.tolerance => MetresPerSecond::ZERO,
            SpeedLaw::BangBang { speed, .. } => MetresPerSecond(speed.0.copysign(imbalance.0)),
            SpeedLaw::Proportional { gain, slope, of } => {
                let slope = slope_of(of, &slope, front, back);
                MetresPerSecond(gain * imbalance.0 / slope.0)
            }
        };
        wanted.limited_to(self.max_speed)
    }
}

impl Default for PolicyConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

fn slope_of(of: SlopeOf, model: &Slope, front: Dbm, back: Dbm) -> DbPerMetre {
    let (front_slope, back_slope) = (model.at(front.loss()), model.at(back.loss()));
    let front_counts = match of {
        SlopeOf::WeakerLink => front <= back,
        SlopeOf::SteeperLink => front_slope >= back_slope,
    };
    if front_counts { front_slope } else { back_slope }
}
