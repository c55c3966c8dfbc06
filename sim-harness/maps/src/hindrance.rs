//! What keeps a drone from flying along a leg, and where the bounds are from.

use std::fmt;

/// The steepest leg that is flown, degrees from the horizontal.
///
/// A drone flies 0.3 m above the floor (`AgentConfig::DEFAULT`), and takes for a wall what its beams,
/// at 45° to its course, meet within 0.45 m (`Steering`'s `slow_below`). Their cones are 27° wide
/// (UM2555), so that the lower edge of one is 0.45 m · tan 13.5° = 0.11 m lower there, and meets a floor
/// that rises by the other 0.19 m on 0.45 m · cos 45°: one of 31.1°. The degree less is for the drone's
/// own tilt.
pub const STEEPEST_DEG: f64 = 30.0;

/// The height of a step that is flown over at any slope, m: that at which drones fly.
pub(super) const FLOWN_STEP: f64 = 0.3;

/// What is steeper than [`STEEPEST_DEG`] and no higher than this is called a step, m: from the flying
/// height above its edge the floor is 2.8 m below, which a VL53L1X ranges in its long distance mode in
/// the dark (DS12385, section 1: 4 m). It is a name only: missions have a level floor, and no code
/// that flies climbs a step.
pub const HIGHEST_STEP: f64 = 2.5;

/// What is higher than a step and steeper than this is called a shaft, degrees; the rest is a slope.
/// Ours: it leads farther down than along.
const SHAFT_DEG: f64 = 45.0;

/// What keeps a drone from flying along a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Hindrance {
    /// The name of the leg's first station.
    pub from: String,
    /// The name of the leg's second station.
    pub to: String,
    /// The reason.
    pub kind: HindranceKind,
    /// The length of the legs that no way leads to but over this leg, m.
    pub beyond_m: f64,
}

/// The reason why a leg cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HindranceKind {
    /// It lies under water: it was dived.
    Water,
    /// It is too steep, and neither a step nor a shaft.
    Slope {
        /// The angle from the horizontal, degrees.
        slope_deg: f64,
        /// The difference in height, m.
        height_m: f64,
    },
    /// It is too steep, and no higher than [`HIGHEST_STEP`].
    Step {
        /// The difference in height, m.
        height_m: f64,
    },
    /// It leads farther up or down than along, and is higher than a step.
    Shaft {
        /// The angle from the horizontal, degrees.
        slope_deg: f64,
        /// The difference in height, m.
        height_m: f64,
    },
    /// The passage is too narrow.
    Squeeze {
        /// The width, m.
        width_m: f64,
    },
    /// The survey calls the leg a squeeze, and gives no width.
    NamedSqueeze,
    /// The passage is too low.
    Low {
        /// The height from floor to ceiling, m.
        height_m: f64,
    },
    /// Nothing was measured along it.
    Unmeasured,
}

impl HindranceKind {
    /// The hindrance of a leg with this rise, if it is too steep.
    pub(super) fn of_rise(slope_deg: f64, height_m: f64) -> Option<Self> {
        if slope_deg <= STEEPEST_DEG || height_m <= FLOWN_STEP {
            return None;
        }
        Some(match height_m {
            _ if height_m <= HIGHEST_STEP => Self::Step { height_m },
            _ if slope_deg > SHAFT_DEG => Self::Shaft { slope_deg, height_m },
            _ => Self::Slope { slope_deg, height_m },
        })
    }

    /// The reason in one word, for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Water => "water",
            Self::Slope { .. } => "slope",
            Self::Step { .. } => "step",
            Self::Shaft { .. } => "shaft",
            Self::Squeeze { .. } | Self::NamedSqueeze => "squeeze",
            Self::Low { .. } => "low",
            Self::Unmeasured => "unmeasured",
        }
    }
}

impl fmt::Display for HindranceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Water => write!(f, "is under water"),
            Self::Slope { slope_deg, height_m } => {
                write!(f, "is a slope of {slope_deg:.0}°, {height_m:.1} m high")
            }
            Self::Step { height_m } => write!(f, "is a step of {height_m:.2} m"),
            Self::Shaft { slope_deg, height_m } => {
                write!(f, "is a shaft of {height_m:.1} m at {slope_deg:.0}°")
            }
            Self::Squeeze { width_m } => write!(f, "is a squeeze of {width_m:.2} m"),
            Self::NamedSqueeze => write!(f, "is called a squeeze, and has no measured width"),
            Self::Low { height_m } => write!(f, "is only {height_m:.2} m high"),
            Self::Unmeasured => write!(f, "was never measured"),
        }
    }
}

impl fmt::Display for Hindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, kind, beyond_m } = self;
        write!(f, "{from} to {to} {kind}")?;
        // Less than a metre is a station on the far side of the leg.
        if *beyond_m >= 1.0 { write!(f, " ({beyond_m:.0} m beyond)") } else { Ok(()) }
    }
}
