//! How the board is mounted under the mind: the one place where the two sets of axes meet.
//!
//! The drone flies along the tunnel with the board's front-right diagonal ahead, as the authors of
//! U-Chain flew theirs: so the four beams of a stock Multi-ranger deck, which look along the
//! board's own axes, look along the diagonals of the way. Motor M1 leads.
//!
//! ```text
//!                 nose
//!        front     ▲ M1    right            board │ beam
//!          nw  ╲   │   ╱  ne                ──────┼─────
//!               ╲  │  ╱                     front │ nw
//!         M4 ────  ●  ──── M2               right │ ne
//!               ╱     ╲                     back  │ se
//!          sw  ╱       ╲  se                left  │ sw
//!        left     M3      back
//! ```
//!
//! What the mind calls forward and lateral is along the nose and to its left, what the flight code
//! calls so is along the board's x and y. Nothing else in the house knows of both.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

use sensors::vl53l1x::{RangeStatus, Reading};
use tunnel_nav::{Diagonals, Range};
use units::{Metres, MetresPerSecond, Radians};

use crate::{BodyVelocity, Fitness, Setpoint};

/// The four side beams, by where they look from the board.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beams {
    /// Along x.
    pub front: Range,
    /// Against y.
    pub right: Range,
    /// Against x.
    pub back: Range,
    /// Along y.
    pub left: Range,
}

impl Beams {
    /// By where they look from the nose.
    #[must_use]
    pub const fn diagonals(&self) -> Diagonals {
        Diagonals { nw: self.front, ne: self.right, se: self.back, sw: self.left }
    }
}

/// What a side beam says by its latest reading; `None` is a sensor that has none to give.
///
/// A sensor that gets no light back, or whose phase is out of bounds, looks into the open. What it
/// doubts otherwise is no measurement.
#[must_use]
pub fn side_beam(reading: Option<&Reading>, reach: Metres) -> Range {
    let Some(reading) = reading else { return Range::Invalid };
    match reading.status {
        RangeStatus::Valid => Range::measured(reading.distance, reach),
        RangeStatus::SignalFail | RangeStatus::OutOfBounds | RangeStatus::LackOfSignal => {
            Range::Clear
        }
        _ => Range::Invalid,
    }
}

/// The mind's set-point, in the board's axes.
#[must_use]
pub fn to_board(setpoint: Setpoint) -> Setpoint {
    match setpoint {
        Setpoint::Off | Setpoint::Stop => setpoint,
        Setpoint::Fly { forward, lateral, yaw_rate, height } => Setpoint::Fly {
            forward: (forward + lateral) * FRAC_1_SQRT_2,
            lateral: (lateral - forward) * FRAC_1_SQRT_2,
            yaw_rate,
            height,
        },
    }
}

/// The board's velocity over ground, as the mind sees it.
#[must_use]
pub fn from_board([x, y]: [MetresPerSecond; 2]) -> BodyVelocity {
    BodyVelocity { forward: (x - y) * FRAC_1_SQRT_2, lateral: (x + y) * FRAC_1_SQRT_2 }
}

/// Where the nose points, within half a turn, when the board's x points to `yaw`.
#[must_use]
pub fn heading(yaw: Radians) -> Radians {
    let nose = yaw.0 - FRAC_PI_4;
    Radians(if nose < -PI { nose + 2.0 * PI } else { nose })
}

/// What the mind needs to know of what the flight code is doing.
#[must_use]
pub const fn fitness(mode: flight::Mode) -> Fitness {
    match mode {
        flight::Mode::Grounded { waits_for: None } | flight::Mode::Flying { .. } => Fitness::Fit,
        flight::Mode::Grounded { waits_for: Some(_) } => Fitness::Unfit,
        flight::Mode::Landing { why, .. } => Fitness::Landing(why),
        flight::Mode::Landed { why } => Fitness::Landed(why),
        flight::Mode::Stopped { .. } => Fitness::Stopped,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::RadiansPerSecond;

    /// Flying ahead is flying along the board's front-right diagonal, and what flies that way is
    /// seen to fly ahead.
    #[test]
    fn the_nose_is_the_front_right_diagonal() {
        let ahead = Setpoint::Fly {
            forward: MetresPerSecond(1.0),
            lateral: MetresPerSecond(0.0),
            yaw_rate: RadiansPerSecond(0.3),
            height: Metres(0.3),
        };
        let Setpoint::Fly { forward, lateral, .. } = to_board(ahead) else { panic!() };
        assert!((forward.0 - FRAC_1_SQRT_2).abs() < 1e-6);
        assert!((lateral.0 + FRAC_1_SQRT_2).abs() < 1e-6, "to the right");
        let seen = from_board([forward, lateral]);
        assert!((seen.forward.0 - 1.0).abs() < 1e-6 && seen.lateral.0.abs() < 1e-6);
        assert!((heading(Radians(FRAC_PI_4)).0).abs() < 1e-6);
    }

    #[test]
    fn there_and_back_is_the_same() {
        for n in 0..100 {
            let (forward, lateral) = (MetresPerSecond(0.01 * n as f32), MetresPerSecond(0.3));
            let height = Metres(0.3);
            let yaw_rate = RadiansPerSecond(0.0);
            let wanted = Setpoint::Fly { forward, lateral, yaw_rate, height };
            let Setpoint::Fly { forward: x, lateral: y, .. } = to_board(wanted) else { panic!() };
            let seen = from_board([x, y]);
            assert!((seen.forward - forward).0.abs() < 1e-6);
            assert!((seen.lateral - lateral).0.abs() < 1e-6);
        }
    }

    #[test]
    fn headings_stay_within_half_a_turn() {
        for n in -314..=314 {
            let nose = heading(Radians(0.01 * n as f32)).0;
            assert!((-PI..=PI).contains(&nose), "{nose}");
        }
    }
}
