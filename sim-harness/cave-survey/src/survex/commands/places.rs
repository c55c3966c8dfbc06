//! Carries out the commands that say where stations are, and which are the same.

use std::rc::Rc;

use crate::draft::Fix;
use crate::earth::{EarthError, System};
use crate::error::Refusal;
use crate::matrix::{self, Vector};
use crate::survex::Reader;
use crate::survex::characters::Cursor;

impl Reader<'_> {
    pub(super) fn equate(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let first = self.station(cursor)?;
        if cursor.is_done(&characters) {
            let wrong = "*equate names only one station";
            return Err(self.wrong(cursor, wrong, "name the other too"));
        }
        while !cursor.is_done(&characters) {
            let place = *cursor;
            let other = self.station(cursor)?;
            if other == first {
                self.warn(&place, "a station is equated to itself");
                continue;
            }
            self.draft.equate(first, other, self.source);
        }
        Ok(())
    }

    pub(super) fn export(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        if !self.may_export {
            let wrong = "*export is not at the beginning of a survey";
            return Err(self.wrong(cursor, wrong, "put it right behind *begin with a name"));
        }
        self.exports.are_given = true;
        loop {
            let place = *cursor;
            let name = self.name(cursor)?;
            let station = self.station_of(&name)?;
            let export = self.exports.of.entry(station).or_default();
            let level = 1 << name.levels;
            if export.levels & level != 0 {
                let wrong = format!("\"{}\" is exported twice", name.full);
                return Err(self.wrong(&place, wrong, "remove one of them"));
            }
            export.levels |= level;
            self.hints.push((station, self.source, "export"));
            if cursor.is_done(&self.settings.characters) {
                return Ok(());
            }
        }
    }

    pub(super) fn fix(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let station = self.station(cursor)?;
        let mut ahead = *cursor;
        let is_reference = ahead.keyword(&characters) == "reference";
        if is_reference {
            *cursor = ahead;
        }
        let place = *cursor;
        if cursor.is_done(&characters) {
            if self.settings.system.is_some() || self.output.is_some() {
                let wrong = "a fixed station has no coordinates, though there is a *cs";
                return Err(self.wrong(&place, wrong, "give them"));
            }
            if self.origin.replace(station).is_some_and(|other| other != station) {
                let wrong = "two stations are fixed without coordinates";
                return Err(self.wrong(&place, wrong, "give the coordinates"));
            }
            self.warn(&place, "*fix has no coordinates; the station is put at 0, 0, 0");
        }
        let mut numbers = Vec::new();
        while !cursor.is_done(&characters) && numbers.len() < 9 {
            numbers.push(self.plain_number(cursor)?);
        }
        if !matches!(numbers.len(), 0 | 3 | 4 | 5 | 6 | 9) {
            let wrong = "*fix has too few numbers";
            return Err(self.wrong(cursor, wrong, "give x, y and z, and perhaps their deviations"));
        }
        let at = [0, 1, 2].map(|n| numbers.get(n).copied().unwrap_or(0.0));
        let at = self.placed(at, &place)?;
        let covariance = numbers.get(3..).filter(|rest| !rest.is_empty()).map(|rest| match *rest {
            [all] => matrix::diagonal([all * all; 3]),
            [flat, up] => matrix::diagonal([flat * flat, flat * flat, up * up]),
            [x, y, z, xy, yz, zx] => [[x * x, xy, zx], [xy, y * y, yz], [zx, yz, z * z]],
            _ => matrix::diagonal([0, 1, 2].map(|n| rest.get(n).map_or(0.0, |x| x * x))),
        });
        if covariance.is_some_and(|matrix| (0..3).any(|n| matrix[n][n] <= 0.0))
            || numbers.iter().skip(3).take(3).any(|deviation| *deviation <= 0.0)
        {
            let wrong = "a standard deviation is not positive";
            return Err(self.wrong(&place, wrong, "give one that is, or leave them out"));
        }
        if numbers.iter().skip(3).any(|number| number.abs() > 1e9) {
            return Err(self.wrong(&place, "a standard deviation is too large", "give metres"));
        }
        if at.iter().any(|x| x.abs() > 1e9) {
            return Err(self.wrong(&place, "a coordinate is too large", "give metres"));
        }
        self.draft.fix(Fix { station, at, covariance, source: self.source, is_reference });
        Ok(())
    }

    /// Coordinates of the present system in the one of the output.
    pub(super) fn placed(&mut self, at: Vector, place: &Cursor<'_>) -> Result<Vector, Refusal> {
        match (&self.settings.system, &self.output) {
            (None, None) => Ok(at),
            (Some(_), None) => {
                let wrong = "*cs gives the system of the coordinates, but no *cs out does";
                Err(self.wrong(place, wrong, "add *cs out"))
            }
            (None, Some(_)) => {
                let wrong = "*cs out is given, but no *cs gives the system of these coordinates";
                Err(self.wrong(place, wrong, "add *cs"))
            }
            (Some(from), Some(to)) => from.to(to, at).map_err(|error| self.no_system(place, error)),
        }
    }

    pub(super) fn no_system(&self, place: &Cursor<'_>, error: EarthError) -> Refusal {
        match error {
            EarthError::Unknown => {
                self.wrong(place, "there is no such coordinate system", "give one such as UTM33N")
            }
            EarthError::Unsupported => self.wrong(
                place,
                "this coordinate system cannot be computed here",
                "give coordinates in another, such as UTM33N",
            ),
        }
    }

    pub(super) fn system(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let place = *cursor;
        let mut word = String::from_utf8_lossy(cursor.word(&characters)).into_owned();
        let is_output = word.eq_ignore_ascii_case("out");
        if is_output {
            word = String::from_utf8_lossy(cursor.word(&characters)).into_owned();
        }
        let system = if word.eq_ignore_ascii_case("custom") {
            let Some(definition) = cursor.quoted(&characters) else {
                return Err(self.wrong(&place, "a quotation mark is missing", "add it"));
            };
            System::custom(&definition)
        } else {
            System::named(&word)
        };
        let system = Rc::new(system.map_err(|error| self.no_system(&place, error))?);
        if !is_output {
            self.settings.system = Some(system);
        } else if system.is_angular() {
            let wrong = "positions cannot be computed in degrees";
            return Err(self.wrong(&place, wrong, "give a *cs out in metres, such as UTM33N"));
        } else if system.is_mirrored() {
            let wrong = "the axes of this system lead west and south";
            return Err(self.wrong(&place, wrong, "give *cs out iJTSK"));
        } else {
            self.output.get_or_insert(system);
        }
        Ok(())
    }
}
