//! Holds what the commands of a centreline set for the lines of data that follow.

use std::rc::Rc;

use super::bearings::Declinations;
use super::legs::Traverse;
use crate::earth::{Day, System};
use crate::survex::settings::{Quantity, Reading, Settings, Unit};
use crate::survey::LegFlags;

/// A style of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DataStyle {
    Normal,
    Diving,
    Cylpolar,
    Cartesian,
    NoSurvey,
    Dimensions,
}

/// A system of coordinates as `cs` names it.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    pub(super) system: Rc<System>,
    /// Whether the second axis comes first, as in `lat-long`.
    pub(super) is_swapped: bool,
}

/// The declination that a centreline gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum North {
    /// From magnetic to true north, rad.
    True(f64),
    /// From magnetic north to that of the centreline's grid, rad.
    Grid(f64),
}

/// The settings of a centreline.
#[derive(Clone)]
pub(super) struct Centreline {
    pub(super) style: DataStyle,
    /// The readings of a line, in their order; empty before the first `data`.
    pub(super) order: Rc<[Reading]>,
    /// Units and calibrations. Zero errors are in the unit of the reading.
    pub(super) read: Settings,
    /// Variances alone: what is read is calibrated before it is weighed.
    pub(super) weighed: Settings,
    pub(super) flags: LegFlags,
    /// The declinations of the surveys around it.
    pub(super) declinations: Declinations,
    pub(super) north: Option<North>,
    pub(super) date: Option<Day>,
    pub(super) coordinates: Option<Coordinates>,
    pub(super) infers_equates: bool,
    pub(super) prefix: String,
    pub(super) suffix: String,
    pub(super) traverse: Traverse,
}

impl Default for Centreline {
    fn default() -> Self {
        Self {
            style: DataStyle::Normal,
            order: [].into(),
            read: Settings::default(),
            weighed: Settings::default(),
            flags: LegFlags::default(),
            declinations: Declinations::default(),
            north: None,
            date: None,
            coordinates: None,
            infers_equates: false,
            prefix: String::new(),
            suffix: String::new(),
            traverse: Traverse::default(),
        }
    }
}

impl Centreline {
    /// A number with its calibration and unit, in metres or radians.
    pub(super) fn calibrated(&self, quantity: Quantity, raw: f64) -> f64 {
        let instrument = self.read.of(quantity);
        let reading = (raw - instrument.zero) * instrument.scale;
        match instrument.unit {
            Unit::Plain(factor) => reading * factor,
            Unit::Tangent(factor) => (reading * factor).atan(),
            Unit::Quadrants => reading.to_radians(),
        }
    }
}
