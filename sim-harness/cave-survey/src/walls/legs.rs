//! Reads the lines between the directives of Walls: legs with the dimensions of passages.

use super::Reader;
use super::fields::Fields;
use super::numbers::{self, AngleUnit, is_omitted};
use super::units::{Item, Taping};
use super::variances::Deviations;
use crate::error::Refusal;
use crate::matrix;
use crate::survex::measure::{self, Fault, Measured, Readings, Slope};
use crate::survex::settings::Settings;
use crate::survey::{CrossSection, LegFlags, StationId, names_squeeze};

/// The variance of the rise of a leg by coordinates that leaves it out, m², as `cavern` has it.
const UNMEASURED_RISE_M2: f64 = 10.0;

/// What a line of a leg has behind its readings.
#[derive(Default)]
struct Tail<'a> {
    deviations: Deviations,
    dimensions: Option<&'a str>,
    flags: Option<LegFlags>,
    /// What belongs nowhere.
    rest: Option<String>,
}

impl Reader {
    pub(super) fn data(&mut self, line: &str) -> Result<(), Refusal> {
        let mut fields = Fields::new(line);
        let from = self.name_in(&mut fields)?;
        if fields.sees_closed_dimensions() {
            return self.lone_dimensions(from, fields);
        }
        let is_suspect = fields.sees_dimensions();
        let to = self.name_in(&mut fields)?;
        if is_suspect && self.draft.known(&self.units.full_name(to)).is_none() {
            self.remark(format!("\"{to}\" is taken for a station, or dimensions are not closed"));
        }
        if fields.sees_dimensions() {
            self.remark("the line has no readings: only its dimensions are read");
            return self.lone_dimensions(from, fields);
        }
        if is_omitted(from) && is_omitted(to) {
            return Err(self.wrong("the leg is between two walls", "name one of its stations"));
        }
        let (from, mut flags) = (self.end(from), self.segment);
        let to = self.end(to);
        let ends_at_wall = [from, to].into_iter().any(|end| self.draft.stations[end].is_wall);
        let measured = match self.units.is_rect {
            true => self.rect(&mut fields)?,
            false => self.taped(&mut fields, ends_at_wall)?,
        };
        let tail = self.tail(&mut fields)?;
        if let Some(rest) = tail.rest {
            let wrong = format!("\"{rest}\" is more than belongs here");
            return Err(self.wrong(wrong, "remove it, or begin a comment with ;"));
        }
        flags = tail.flags.unwrap_or(flags);
        flags.splay |= ends_at_wall;
        flags.squeeze |= line.split_once(';').is_some_and(|(_, comment)| names_squeeze(comment));
        if let Some(text) = tail.dimensions {
            let [here, before] = if self.units.is_at_second { [to, from] } else { [from, from] };
            let goes_on = self.last == Some(before);
            let section = self.section(here, text);
            let is_measured = section.is_some() && !ends_at_wall;
            if let Some(section) = section.filter(|_| !self.draft.stations[here].is_wall) {
                self.draft.cross_section(section, self.source, goes_on && !ends_at_wall);
            }
            self.last = if ends_at_wall { self.last } else { is_measured.then_some(to) };
        }
        let Some(mut measured) = measured else {
            self.draft.first.get_or_insert(from);
            self.draft.count_item();
            self.joined.push((from, to, self.source));
            return Ok(());
        };
        self.weigh(&mut measured, tail.deviations);
        let leg = measured.leg([from, to], flags, self.source);
        self.draft.leg(leg, false)
    }

    fn name_in<'t>(&self, fields: &mut Fields<'t>) -> Result<&'t str, Refusal> {
        fields.name().ok_or_else(|| self.wrong("the name of a station is missing", "give it"))
    }

    /// The station at an end of a leg: dashes stand for a point on the wall.
    fn end(&mut self, name: &str) -> StationId {
        if is_omitted(name) {
            return self.draft.anonymous(true, self.source);
        }
        if name.ends_with(':') {
            self.remark(format!("\"{name}\" has a prefix and no name"));
        }
        let name = self.units.full_name(name);
        self.draft.station(&name, self.source).0
    }

    fn lone_dimensions(&mut self, name: &str, mut fields: Fields<'_>) -> Result<(), Refusal> {
        let station = self.end(name);
        let tail = self.tail(&mut fields)?;
        if let Some(rest) = tail.rest {
            self.remark(format!("\"{rest}\" is passed over"));
        }
        let goes_on = self.last == Some(station);
        if let Some(section) = self.section(station, tail.dimensions.unwrap_or_default()) {
            self.draft.cross_section(section, self.source, goes_on);
        }
        self.last = None;
        Ok(())
    }

    /// The next reading of a line that wants it.
    fn wanted<'t>(&self, fields: &mut Fields<'t>, what: &str) -> Result<&'t str, Refusal> {
        let missing = || self.wrong(format!("the {what} is missing"), "give it, or correct ORDER=");
        fields.reading().ok_or_else(missing)
    }

    pub(super) fn unread(&self, text: &str, what: &str) -> Refusal {
        self.wrong(format!("\"{text}\" is no {what}"), "correct it, or its unit")
    }

    /// Reads a leg by coordinates; `None` where both stations are one.
    fn rect(&mut self, fields: &mut Fields<'_>) -> Result<Option<Measured>, Refusal> {
        let mut readings = Readings { steps: [None, None, Some(0.0)], ..Readings::default() };
        for axis in self.units.axes.clone() {
            let text = self.wanted(fields, "coordinate")?;
            let step = numbers::length(text, self.units.size);
            readings.steps[axis] = Some(step.ok_or_else(|| self.unread(text, "coordinate"))?);
        }
        let measured = measure::cartesian(&readings, &self.units.settings);
        let mut measured = measured.map_err(|(wrong, remedy)| self.wrong(wrong, remedy))?;
        if !self.units.axes.contains(&2) {
            measured.covariance[2][2] = UNMEASURED_RISE_M2;
        }
        let turn = self.units.turn - self.earth.as_ref().map_or(0.0, |earth| earth.convergence);
        let [east, north, up] = measured.vector;
        let (sin, cos) = turn.sin_cos();
        measured.vector = [east * cos + north * sin, north * cos - east * sin, up];
        Ok((measured.length > 0.0).then_some(measured))
    }

    /// Reads a leg by tape and compass; `None` where both stations are one. A splay may lack its
    /// slope.
    fn taped(
        &mut self,
        fields: &mut Fields<'_>,
        is_splay: bool,
    ) -> Result<Option<Measured>, Refusal> {
        let mut readings = Readings::default();
        for item in self.units.order.clone() {
            match item {
                Item::Distance => {
                    let text = self.wanted(fields, "distance")?;
                    let length = numbers::length(text, self.units.distance);
                    let length = length.ok_or_else(|| self.unread(text, "distance"))?;
                    if length < 0.0 {
                        self.remark("the tape's reading is negative");
                    }
                    readings.tape = Some(length);
                }
                Item::Azimuth => {
                    let text = self.wanted(fields, "bearing")?;
                    [readings.compass, readings.back_compass] = self.bearings(text)?;
                }
                Item::Vertical if is_splay && ends_readings(fields) => {}
                Item::Vertical => {
                    let text = self.wanted(fields, "slope")?;
                    [readings.clino, readings.back_clino] = self.slopes(text)?;
                }
            }
        }
        let mut heights = [None; 2];
        for height in &mut heights {
            if ends_readings(fields) {
                break;
            }
            let text = self.wanted(fields, "height")?;
            if !is_omitted(text) {
                let read = numbers::length(text, self.units.size);
                *height = Some(read.ok_or_else(|| self.unread(text, "height"))?);
            }
        }
        let [here, there] = heights.map(Option::unwrap_or_default);
        let is_dive = !self.units.order.contains(&Item::Vertical);
        if readings.tape == Some(0.0) && (heights == [None; 2] || is_dive && here == there) {
            return Ok(None);
        }
        self.measured(&readings, heights).map(Some)
    }

    /// Makes a vector of readings and the heights of instrument and target.
    fn measured(
        &mut self,
        readings: &Readings,
        heights: [Option<f64>; 2],
    ) -> Result<Measured, Refusal> {
        let declination = self.declination();
        let rise = heights[0].unwrap_or(0.0) - heights[1].unwrap_or(0.0);
        let has_heights = heights != [None; 2];
        let is_level = readings.clino == Slope::Omitted && readings.back_clino == Slope::Omitted;
        let has_slopes = self.units.order.contains(&Item::Vertical);
        let by_depth = Readings { depth_change: Some(rise), ..*readings };
        type Measure = fn(&Readings, &Settings, f64, &mut Vec<String>) -> Result<Measured, Fault>;
        let (measure, lift): (Measure, f64) = match self.units.taping {
            Taping::InstrumentToTarget if !has_slopes => (measure::cylpolar, 0.0),
            Taping::InstrumentToTarget => (measure::normal, rise + self.units.height),
            Taping::StationToStation if is_level && (has_heights || !has_slopes) => {
                (measure::diving, 0.0)
            }
            _ => {
                if has_heights {
                    self.remark("heights do not go with this TAPE= and are passed over");
                }
                (measure::normal, self.units.height)
            }
        };
        let mut remarks = Vec::new();
        let measured = measure(&by_depth, &self.units.settings, declination, &mut remarks);
        for remark in remarks {
            self.remark(remark);
        }
        let mut measured = measured.map_err(|(wrong, remedy)| self.wrong(wrong, remedy))?;
        // Without slopes and depths the leg is level, and nothing says that it was dived.
        measured.by_depth &= has_heights;
        if lift != 0.0 {
            measured.vector[2] += lift;
            measured.length = matrix::norm(measured.vector);
        }
        Ok(measured)
    }

    /// Reads the bearings `foresight/backsight`, rad.
    fn bearings(&mut self, text: &str) -> Result<[Option<f64>; 2], Refusal> {
        let mut both = [None; 2];
        let (fore, back) = text.split_once('/').unwrap_or((text, ""));
        for (n, text) in [fore, back].into_iter().enumerate().filter(|it| !is_omitted(it.1)) {
            let bearing = numbers::bearing(text, self.units.azimuth[n]);
            let bearing = bearing.filter(|_| self.units.azimuth[n] != AngleUnit::Percent);
            let bearing = bearing.ok_or_else(|| self.unread(text, "bearing"))?;
            if !(0.0..=std::f64::consts::TAU + 1e-9).contains(&bearing) {
                self.remark("the compass reading is not of one full circle");
            }
            let turned = n == 1 && self.units.is_corrected[0];
            both[n] = Some(if turned { bearing + std::f64::consts::PI } else { bearing });
        }
        Ok(both)
    }

    /// Reads the slopes `foresight/backsight`.
    fn slopes(&mut self, text: &str) -> Result<[Slope; 2], Refusal> {
        let mut both = [Slope::Omitted; 2];
        let (fore, back) = text.split_once('/').unwrap_or((text, ""));
        for (n, text) in [fore, back].into_iter().enumerate().filter(|it| !is_omitted(it.1)) {
            let slope = numbers::angle(text, self.units.vertical[n]);
            let mut slope = slope.ok_or_else(|| self.unread(text, "slope"))?;
            let beyond = slope.abs() - std::f64::consts::FRAC_PI_2;
            if beyond > 1e-9 {
                self.remark("the clino reading is over a right angle");
            }
            if n == 1 && self.units.is_corrected[1] {
                slope = -slope;
            }
            both[n] = if beyond.abs() < 1e-9 {
                Slope::Plumb { up: slope > 0.0, is_inferred: true }
            } else {
                Slope::Angle(slope)
            };
        }
        Ok(both)
    }

    /// Reads what stands behind the readings, in any order.
    fn tail<'t>(&mut self, fields: &mut Fields<'t>) -> Result<Tail<'t>, Refusal> {
        let mut tail = Tail::default();
        loop {
            let open = match fields.peek() {
                None => return Ok(tail),
                Some('#') => {
                    tail.flags = Some(self.segment_flags(fields.rest()));
                    return Ok(tail);
                }
                Some(open @ ('(' | '<' | '*')) => open,
                Some(_) => {
                    tail.rest = Some(fields.rest().chars().take(20).collect());
                    return Ok(tail);
                }
            };
            let Some(inside) = fields.bracketed() else {
                return Err(self.wrong(format!("the {open} is not closed"), "close it"));
            };
            match open {
                '(' => tail.deviations = self.deviations(inside)?,
                _ => {
                    tail.dimensions = Some(inside);
                    if let Some(junk) = fields.junk() {
                        self.remark(format!("\"{junk}\" is passed over"));
                    }
                }
            }
        }
    }

    /// Reads the dimensions at a station; `None` where there are none. Exports write zeros for
    /// dimensions that were not measured, so that four of them are none.
    fn section(&mut self, station: StationId, text: &str) -> Option<CrossSection> {
        let split = |it: char| it == ',' || it.is_whitespace();
        let parts: Vec<&str> = text.split(split).filter(|part| !part.is_empty()).collect();
        let size = |place: usize| {
            let text = parts.get(place).filter(|text| !is_omitted(text))?;
            numbers::length(text, self.units.size).filter(|size| (0.0..1e6).contains(size))
        };
        let [left, right, up, down] = self.units.dimensions.map(size);
        let omitted = parts.iter().take(4).filter(|part| is_omitted(part)).count();
        if [left, right, up, down].iter().flatten().count() + omitted < 4 {
            self.remark("the dimensions are not four lengths: the others are taken as left out");
        }
        let section = CrossSection { station, left, right, up, down };
        let is_zero = [left, right, up, down].iter().all(|size| *size == Some(0.0));
        Some(section).filter(|section| section.is_measured() && !is_zero)
    }
}

/// Whether what follows is no reading.
fn ends_readings(fields: &Fields<'_>) -> bool {
    matches!(fields.peek(), None | Some('<' | '*' | '(' | '#'))
}
