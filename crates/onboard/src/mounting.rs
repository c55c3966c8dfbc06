//! Rotates between the board's axes and those of the drone's nose. No other code uses both.
//!
//! The drone flies along the tunnel with the board's front-right diagonal ahead, as the authors of
//! U-Chain flew theirs: so the four beams of a standard Multi-ranger deck, which look along the
//! board's own axes, look diagonally ahead and back. Motor M1 leads.
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
//! The agent's forward and lateral are along the nose and to its left, those of the flight code along
//! the board's x and y.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

use agent::{BodyVelocity, Fitness};
use sensors::vl53l1x::{RangeStatus, Reading};
use tunnel_nav::{Diagonals, Range};
use units::{Metres, MetresPerSecond, Radians, Setpoint};

/// The latest readings of the four side rangers, by their direction from the board; `None` is a
/// ranger without a valid reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// The ranger along x.
    pub front: Option<Reading>,
    /// The ranger against y.
    pub right: Option<Reading>,
    /// The ranger against x.
    pub back: Option<Reading>,
    /// The ranger along y.
    pub left: Option<Reading>,
}

impl Sides {
    /// Returns the ranges of the beams by their direction from the nose.
    #[must_use]
    pub fn diagonals(&self, reach: Metres) -> Diagonals {
        let beam = |reading: &Option<Reading>| side_beam(reading.as_ref(), reach);
        Diagonals {
            nw: beam(&self.front),
            ne: beam(&self.right),
            se: beam(&self.back),
            sw: beam(&self.left),
        }
    }

    /// Whether each of the four rangers gives readings, valid or not.
    #[must_use]
    pub const fn are_all_there(&self) -> bool {
        self.front.is_some() && self.right.is_some() && self.back.is_some() && self.left.is_some()
    }
}

/// The range of a side beam by its ranger's latest reading.
///
/// A sensor that gets no light back, or whose phase is out of bounds, sees no wall: the beam is clear.
/// A reading with any other error is invalid.
fn side_beam(reading: Option<&Reading>, reach: Metres) -> Range {
    let Some(reading) = reading else { return Range::Invalid };
    match reading.status {
        RangeStatus::Valid => Range::measured(reading.distance, reach),
        RangeStatus::SignalFail | RangeStatus::OutOfBounds | RangeStatus::LackOfSignal => {
            Range::Clear
        }
        _ => Range::Invalid,
    }
}

/// The agent's set-point, in the board's axes.
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

/// The board's velocity over ground, in the axes of the nose.
#[must_use]
pub fn from_board([x, y]: [MetresPerSecond; 2]) -> BodyVelocity {
    BodyVelocity { forward: (x - y) * FRAC_1_SQRT_2, lateral: (x + y) * FRAC_1_SQRT_2 }
}

/// The heading of the nose, within half a turn, when the board's x points to `yaw`.
#[must_use]
pub fn heading(yaw: Radians) -> Radians {
    let nose = yaw.0 - FRAC_PI_4;
    Radians(if nose < -PI { nose + 2.0 * PI } else { nose })
}

/// The heading of the board's x, within half a turn, when the nose points to `nose`.
#[must_use]
pub fn board_heading(nose: Radians) -> Radians {
    let yaw = nose.0 + FRAC_PI_4;
    Radians(if yaw > PI { yaw - 2.0 * PI } else { yaw })
}

/// Returns the drone's fitness from the mode of the flight code.
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
            let yaw = Radians(0.01 * n as f32);
            let nose = heading(yaw);
            assert!((-PI..=PI).contains(&nose.0), "{nose:?}");
            let back = board_heading(nose);
            assert!((-PI..=PI).contains(&back.0) && (back - yaw).0.abs() < 1e-5, "{back:?}");
        }
    }
}
