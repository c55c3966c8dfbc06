//! Keeping to one hand where a gallery opens into a chamber.
//!
//! Where both walls end at once, the drone goes on until the wall of its preferred hand lies
//! behind it, turns a right angle towards that hand, and so has the wall at its side again: it
//! follows the side of the chamber (section IV-E) instead of crossing it and meeting the far wall
//! with nothing to tell which way leads on. Every drone of a chain keeps to the same hand and so
//! to the same way.

use core::f32::consts::FRAC_PI_2;

use units::{MetresPerSecond, Radians};

use crate::trail::wrapped;
use crate::{NavConfig, Side};

/// Where a drone is in getting round the end of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Rounding {
    /// There is a wall at its side.
    #[default]
    Beside,
    /// Turning to this heading.
    Turning {
        /// By gyro, in radians.
        to: f32,
    },
    /// Turned, looking for the wall.
    Turned,
}

/// A turn is over within this of its heading.
const DONE: f32 = 0.15;

impl Rounding {
    /// What it is after one more look. `beside` says whether any wall is seen, `open` whether both
    /// beams of the preferred hand look into the open and the drone is on its way.
    pub(crate) fn next(
        self,
        config: &NavConfig,
        beside: bool,
        open: bool,
        heading: Option<Radians>,
        speed: MetresPerSecond,
    ) -> Self {
        let Some(heading) = heading.filter(|_| !beside) else {
            return Self::Beside;
        };
        match self {
            Self::Beside if open => {
                let clockwise = (config.prefer == Side::Right) == (speed.0 >= 0.0);
                let turn = if clockwise { -FRAC_PI_2 } else { FRAC_PI_2 };
                Self::Turning { to: heading.0 + turn }
            }
            Self::Turning { to } if wrapped(to - heading.0).abs() < DONE => Self::Turned,
            same => same,
        }
    }

    /// How far there is still to turn, while turning.
    pub(crate) fn left_to_turn(&self, heading: Option<Radians>) -> Option<Radians> {
        match (self, heading) {
            (Self::Turning { to }, Some(heading)) => Some(Radians(wrapped(to - heading.0))),
            _ => None,
        }
    }
}
