//! Holds what commands have set for the lines that follow: units, calibrations, accuracies, the
//! order of readings, flags. `*begin` saves all of it, and `*end` brings it back.

use std::rc::Rc;

use super::characters::Characters;
use crate::earth::{Day, System};
use crate::survey::LegFlags;

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Length,
    BackLength,
    Count,
    Dx,
    Dy,
    Dz,
    Bearing,
    BackBearing,
    Gradient,
    BackGradient,
    Depth,
    Left,
    Right,
    Up,
    Down,
    Declination,
    Plumb,
    Level,
    Position,
}

const QUANTITIES: usize = Quantity::Position as usize + 1;

impl Quantity {
    /// The quantity of that name or synonym, in lower case.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "length" | "tape" => Self::Length,
            "backlength" | "backtape" => Self::BackLength,
            "count" | "counter" => Self::Count,
            "dx" | "easting" => Self::Dx,
            "dy" | "northing" => Self::Dy,
            "dz" | "altitude" => Self::Dz,
            "bearing" | "compass" => Self::Bearing,
            "backbearing" | "backcompass" => Self::BackBearing,
            "gradient" | "clino" => Self::Gradient,
            "backgradient" | "backclino" => Self::BackGradient,
            "depth" => Self::Depth,
            "left" => Self::Left,
            "right" => Self::Right,
            "up" | "ceiling" => Self::Up,
            "down" | "floor" => Self::Down,
            "declination" => Self::Declination,
            "plumb" => Self::Plumb,
            "level" => Self::Level,
            "position" => Self::Position,
            _ => return None,
        })
    }

    /// Whether it is an angle.
    pub(crate) const fn is_angle(self) -> bool {
        matches!(
            self,
            Self::Bearing
                | Self::BackBearing
                | Self::Gradient
                | Self::BackGradient
                | Self::Declination
                | Self::Plumb
                | Self::Level
        )
    }

    /// Whether it is read from a clinometer.
    pub(crate) const fn is_gradient(self) -> bool {
        matches!(self, Self::Gradient | Self::BackGradient)
    }
}

/// A unit in which a quantity is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unit {
    /// Metres or radians of one unit.
    Plain(f64),
    /// The tangent of a slope, of which one unit is so much: 0.01 is one percent.
    Tangent(f64),
    /// Bearings such as `S34E`.
    Quadrants,
}

/// Metres of a foot and of a yard: the international ones, of 1959.
pub(crate) const FOOT: f64 = 0.3048;

impl Unit {
    /// The unit of that name, in lower case, and whether it is one of angles.
    pub(super) fn named(name: &str) -> Option<(Self, bool)> {
        let degree = 1f64.to_radians();
        Some(match name {
            "metres" | "meters" | "metric" => (Self::Plain(1.0), false),
            "feet" => (Self::Plain(FOOT), false),
            "yards" => (Self::Plain(3.0 * FOOT), false),
            "degs" | "degrees" => (Self::Plain(degree), true),
            "grads" | "mils" => (Self::Plain(0.9 * degree), true),
            "minutes" => (Self::Plain(degree / 60.0), true),
            "percent" | "percentage" => (Self::Tangent(0.01), true),
            "quads" | "quadrants" => (Self::Quadrants, true),
            _ => return None,
        })
    }

    /// Metres, radians or the tangent of one unit.
    pub(super) const fn factor(self) -> f64 {
        match self {
            Self::Plain(factor) | Self::Tangent(factor) => factor,
            Self::Quadrants => std::f64::consts::PI / 180.0,
        }
    }
}

/// What is known of the instruments for one quantity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instrument {
    pub(crate) unit: Unit,
    /// The reading of something that is zero, in metres or radians.
    pub(crate) zero: f64,
    pub(crate) scale: f64,
    /// The variance of a reading, m² or rad².
    pub(crate) variance: f64,
}

/// The declination that compass readings are corrected by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Declination {
    /// An angle, rad.
    Given(f64),
    /// That of a place in degrees and a height in metres, on the day of the survey, from the
    /// north of the grid.
    Of { place: [f64; 2], up: f64 },
}

/// The north from which coordinate legs are turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum North {
    True,
    Grid,
    Magnetic,
}

/// The style of data lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    Normal,
    Diving,
    Cartesian,
    Cylpolar,
    NoSurvey,
    Passage,
    Ignore,
}

/// A reading in a data line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    From,
    To,
    Station,
    Direction,
    /// A number of this quantity, of the leg or of the station.
    Value(Quantity),
    FromDepth,
    ToDepth,
    Depth,
    DepthChange,
    FromCount,
    ToCount,
    Count,
    Newline,
    /// A note of one word or in quotation marks.
    Note,
    /// A note to the end of the line.
    NoteAll,
    Ignore,
    IgnoreAll,
}

/// How the case of letters in names counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Case {
    Preserve,
    Upper,
    Lower,
}

/// What `*infer` makes the reader infer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Infer {
    pub(crate) plumbs: bool,
    pub(crate) equates: bool,
    pub(crate) exports: bool,
}

/// All settings.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The full name of the current survey; empty at the root.
    pub(crate) prefix: Rc<str>,
    pub(crate) characters: Rc<Characters>,
    pub(crate) case: Case,
    pub(crate) truncate: usize,
    pub(crate) instruments: [Instrument; QUANTITIES],
    pub(crate) declination: Declination,
    /// The north of coordinate legs.
    pub(crate) north: North,
    /// The angle by which coordinate legs are turned clockwise from it, rad.
    pub(crate) turn: f64,
    pub(crate) style: Style,
    pub(crate) order: Rc<[Reading]>,
    pub(crate) flags: LegFlags,
    pub(crate) infer: Infer,
    /// Whether `-` stands for an anonymous station on the wall.
    pub(crate) dash_is_wall: bool,
    pub(crate) date: Option<Day>,
    pub(crate) system: Option<Rc<System>>,
}

/// The order of readings where `*data` says nothing.
pub(crate) const DEFAULT_ORDER: [Reading; 5] = [
    Reading::From,
    Reading::To,
    Reading::Value(Quantity::Length),
    Reading::Value(Quantity::Bearing),
    Reading::Value(Quantity::Gradient),
];

impl Default for Settings {
    fn default() -> Self {
        let mut settings = Self {
            prefix: "".into(),
            characters: Rc::default(),
            case: Case::Lower,
            truncate: usize::MAX,
            instruments: [Instrument {
                unit: Unit::Plain(1.0),
                zero: 0.0,
                scale: 1.0,
                variance: 0.0,
            }; QUANTITIES],
            declination: Declination::Given(0.0),
            north: North::True,
            turn: 0.0,
            style: Style::Normal,
            order: DEFAULT_ORDER.into(),
            flags: LegFlags::default(),
            infer: Infer::default(),
            dash_is_wall: false,
            date: None,
            system: None,
        };
        settings.default_units();
        settings.default_variances();
        settings
    }
}

impl Settings {
    pub(crate) const fn of(&self, quantity: Quantity) -> &Instrument {
        &self.instruments[quantity as usize]
    }

    pub(crate) const fn change(&mut self, quantity: Quantity) -> &mut Instrument {
        &mut self.instruments[quantity as usize]
    }

    /// The units of Survex's manual, under `*units`: metres and degrees.
    pub(super) fn default_units(&mut self) {
        for quantity in ALL {
            let factor = if quantity.is_angle() { 1f64.to_radians() } else { 1.0 };
            self.change(quantity).unit = Unit::Plain(factor);
        }
    }

    /// No instrument has an error, and the compass shows the grid's north.
    pub(super) fn default_calibration(&mut self) {
        for instrument in &mut self.instruments {
            instrument.zero = 0.0;
            instrument.scale = 1.0;
        }
        self.declination = Declination::Given(0.0);
    }

    /// The accuracies of BCRA grade 5 as Survex understands it (its `bcra5.svx`): 0.05 m and 0.5°.
    /// A plumbed or levelled leg is as accurate as 0.25°, as in Survex's `commands.c`.
    pub(super) fn default_variances(&mut self) {
        for quantity in ALL {
            let deviation: f64 = match quantity {
                Quantity::Plumb | Quantity::Level => 0.25f64.to_radians(),
                angle if angle.is_angle() => 0.5f64.to_radians(),
                _ => 0.05,
            };
            self.change(quantity).variance = deviation * deviation;
        }
    }
}

/// All quantities.
const ALL: [Quantity; QUANTITIES] = [
    Quantity::Length,
    Quantity::BackLength,
    Quantity::Count,
    Quantity::Dx,
    Quantity::Dy,
    Quantity::Dz,
    Quantity::Bearing,
    Quantity::BackBearing,
    Quantity::Gradient,
    Quantity::BackGradient,
    Quantity::Depth,
    Quantity::Left,
    Quantity::Right,
    Quantity::Up,
    Quantity::Down,
    Quantity::Declination,
    Quantity::Plumb,
    Quantity::Level,
    Quantity::Position,
];
