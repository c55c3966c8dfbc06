//! Fixes stations, in coordinates of the earth or of the survey's own.

use std::rc::Rc;

use super::Reader;
use super::centreline::Coordinates;
use super::words::{degrees, number};
use crate::draft::Fix;
use crate::earth::{EarthError, System};
use crate::error::Refusal;
use crate::matrix::{self, Vector};
use crate::survex::settings::Quantity;

impl Reader<'_> {
    /// Reads `cs name`.
    pub(super) fn coordinates(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let name = arguments.first().map_or("", String::as_str);
        let upper = name.to_ascii_uppercase();
        let is_swapped = upper == "LAT-LONG";
        self.settings().coordinates = match upper.as_str() {
            "LOCAL" => None,
            _ => {
                let system = System::named(if is_swapped { "LONG-LAT" } else { name });
                let system = system.map_err(|error| self.no_system(name, error))?;
                Some(Coordinates { system: Rc::new(system), is_swapped })
            }
        };
        Ok(())
    }

    fn no_system(&self, name: &str, error: EarthError) -> Refusal {
        let wrong = match error {
            EarthError::Unknown => format!("there is no coordinate system \"{name}\""),
            EarthError::Unsupported => {
                format!("the coordinate system \"{name}\" cannot be computed here")
            }
        };
        self.wrong(wrong, "give one such as UTM33N, long-lat or EPSG:3045")
    }

    /// Reads `fix station x y z`, perhaps with standard deviations.
    pub(super) fn fix(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let [name, numbers @ ..] = arguments else {
            return Err(self.wrong("fix names no station", "name it"));
        };
        let station = self.station(name)?;
        if !(3..=6).contains(&numbers.len()) {
            let wrong = "fix has no three coordinates";
            return Err(self.wrong(wrong, "give x, y and z, and perhaps their deviations"));
        }
        let coordinates = self.settings().coordinates.clone();
        let mut read = Vec::new();
        for (place, text) in numbers.iter().enumerate() {
            let is_angle =
                place < 2 && coordinates.as_ref().is_some_and(|it| it.system.is_angular());
            let one = if is_angle { degrees(text) } else { number(text) };
            let one = one.filter(|one| one.abs() < 1e9);
            read.push(
                one.ok_or_else(|| self.wrong(format!("\"{text}\" is no number"), "give one"))?,
            );
        }
        let [x, y, z, deviations @ ..] = read.as_slice() else { return Ok(()) };
        let position = |raw: f64| self.settings_ref(|it| it.calibrated(Quantity::Position, raw));
        let at = match &coordinates {
            None => {
                let at = [*x, *y, *z].map(position);
                if self.output.is_some() {
                    return Err(self.mixed());
                }
                self.local.get_or_insert(self.source);
                at
            }
            Some(Coordinates { system, is_swapped }) => {
                let [x, y] = if *is_swapped { [*y, *x] } else { [*x, *y] };
                let at = [x, y, position(*z)];
                if self.local.is_some() {
                    return Err(self.mixed());
                }
                self.placed(system, at)?
            }
        };
        if deviations.iter().any(|deviation| *deviation <= 0.0) {
            return Err(self.wrong("a standard deviation is not positive", "correct it"));
        }
        let covariance = match deviations {
            [] => None,
            [all] => Some([*all; 3]),
            [flat, up] => Some([*flat, *flat, *up]),
            [x, y, z, ..] => Some([*x, *y, *z]),
        };
        let covariance =
            covariance.map(|it| matrix::diagonal(it.map(|deviation| deviation.powi(2))));
        self.draft.fix(Fix { station, at, covariance, source: self.source, is_reference: false });
        Ok(())
    }

    fn mixed(&self) -> Refusal {
        let wrong = "some stations are fixed with a cs, and others without";
        self.wrong(wrong, "give the cs of each fix")
    }

    /// A value of the settings of the centreline that is open.
    fn settings_ref<T>(&self, of: impl Fn(&super::centreline::Centreline) -> T) -> T {
        match &self.centreline {
            Some(centreline) => of(centreline),
            None => of(&super::centreline::Centreline::default()),
        }
    }

    /// The coordinates of a point in the system of the positions: that of the first fixed station, or,
    /// where it has no axes in metres to the east and the north, one that has.
    fn placed(&mut self, system: &Rc<System>, at: Vector) -> Result<Vector, Refusal> {
        let cannot = |_| self.wrong("the place cannot be computed", "correct it, or its cs");
        let output = match &self.output {
            Some(output) => Rc::clone(&output.system),
            None => Rc::new(flat(system, at).map_err(cannot)?),
        };
        let at = system.to(&output, at).map_err(cannot)?;
        if !at.iter().all(|x| x.abs() < 1e9) {
            return Err(self.wrong("the place is not on the earth", "correct it, or its cs"));
        }
        let output =
            self.output.get_or_insert(Output { system: output, sum: [0.0; 3], count: 0.0 });
        output.sum = matrix::add(output.sum, at);
        output.count += 1.0;
        Ok(at)
    }
}

/// The system of the positions, with the sum of the places of the fixed stations and their number.
pub(super) struct Output {
    pub(super) system: Rc<System>,
    pub(super) sum: Vector,
    pub(super) count: f64,
}

/// A system whose axes lead east and north, in metres: the same, or else the zone of UTM of a point.
fn flat(system: &System, at: Vector) -> Result<System, EarthError> {
    if !system.is_angular() && !system.is_mirrored() {
        return Ok(system.clone());
    }
    let [longitude, latitude] = system.degrees(at)?;
    let zone = ((longitude + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u8 + 1;
    System::named(&format!("UTM{zone}{}", if latitude < 0.0 { 'S' } else { 'N' }))
}
