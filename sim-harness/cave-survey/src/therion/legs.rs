//! Makes legs and cross-sections of the lines of data.

use super::Reader;
use super::bearings::Bearing;
use super::centreline::{DataStyle, North};
use super::names::End;
use crate::error::Refusal;
use crate::survex::measure::{self, Fault, Measured, Readings};
use crate::survey::{CrossSection, StationId};

/// The distances to the walls left, right, up and down.
pub(super) type Sides = [Option<f64>; 4];

/// What one line of data gives, or two that are interleaved.
#[derive(Clone, Debug, Default)]
pub(super) struct Line {
    pub(super) from: Option<End>,
    pub(super) to: Option<End>,
    pub(super) readings: Readings,
    pub(super) is_backwards: bool,
    /// The dimensions at both stations.
    pub(super) sides: [Sides; 2],
}

/// What the lines before have left.
#[derive(Clone, Debug, Default)]
pub(super) struct Traverse {
    /// The line that is not complete.
    pub(super) line: Line,
    /// Whether the next line holds what stands after `newline` in the order.
    pub(super) is_second: bool,
    /// Whether the readings towards the next station are there.
    pub(super) has_readings: bool,
    /// The station at which the last passage with dimensions ended.
    last: Option<StationId>,
}

impl Reader<'_> {
    /// Takes the next station of interleaved data: the leg to it is complete.
    pub(super) fn next_station(&mut self, line: Line) -> Result<(), Refusal> {
        let traverse = &mut self.settings().traverse;
        let has_leg = std::mem::replace(&mut traverse.has_readings, false);
        traverse.is_second = true;
        // What was read at the station counts for the leg behind it too.
        let mut next =
            Line { to: line.to, sides: [Sides::default(), line.sides[1]], ..Line::default() };
        next.readings.depths[1] = line.readings.depths[1];
        next.readings.counts[1] = line.readings.counts[1];
        traverse.line = next;
        if has_leg { self.complete(line) } else { Ok(()) }
    }

    /// Makes what the line stands for.
    pub(super) fn complete(&mut self, line: Line) -> Result<(), Refusal> {
        let style = self.settings().style;
        let (Some(mut from), Some(mut to)) = (line.from, line.to) else {
            if let Some(station) = line.from.filter(|_| style == DataStyle::Dimensions) {
                self.cross_section(station.id, station.id, line.sides[1]);
                self.settings().traverse.last = Some(station.id);
            }
            return Ok(());
        };
        if from.is_splay && to.is_splay {
            return Err(
                self.wrong("the leg is between two points without names", "name one of them")
            );
        }
        self.dimensions(from, to, line.sides);
        if line.is_backwards {
            std::mem::swap(&mut from, &mut to);
        }
        let centreline = self.settings();
        let mut flags = centreline.flags;
        flags.splay |= from.is_splay || to.is_splay;
        let infers = centreline.infers_equates && style == DataStyle::Normal;
        if style == DataStyle::NoSurvey {
            self.draft.sight(from.id, to.id, flags, self.source);
            return Ok(());
        }
        if infers && line.readings.tape == Some(0.0) {
            self.draft.equate(from.id, to.id, self.source);
            return Ok(());
        }
        let mut remarks = Vec::new();
        let measured = self.measured(&line.readings, &mut remarks);
        for remark in remarks {
            self.remark(remark);
        }
        let measured = measured.map_err(|(wrong, remedy)| self.wrong(wrong, remedy))?;
        let before = self.draft.legs.len();
        self.draft.leg(measured.leg([from.id, to.id], flags, self.source), false)?;
        if self.draft.legs.len() > before {
            let centreline = self.settings();
            let inherited = || centreline.declinations.on(centreline.date).map(North::True);
            let given = centreline.north.or_else(inherited);
            let date = centreline.date;
            self.bearings.push(Bearing { leg: before, given, date });
        }
        Ok(())
    }

    /// The vector of a leg, from the compass's north.
    fn measured(
        &mut self,
        readings: &Readings,
        remarks: &mut Vec<String>,
    ) -> Result<Measured, Fault> {
        let centreline = self.settings();
        let settings = &centreline.weighed;
        match centreline.style {
            DataStyle::Diving => measure::diving(readings, settings, 0.0, remarks),
            DataStyle::Cylpolar => measure::cylpolar(readings, settings, 0.0, remarks),
            DataStyle::Cartesian => measure::cartesian(readings, settings),
            _ => measure::normal(readings, settings, 0.0, remarks),
        }
    }

    /// Notes the dimensions at the stations of a leg.
    fn dimensions(&mut self, from: End, to: End, sides: [Sides; 2]) {
        for ((station, before), sides) in [(from, from), (to, from)].into_iter().zip(sides) {
            if !station.is_splay && sides.iter().any(Option::is_some) {
                self.cross_section(station.id, before.id, sides);
                self.settings().traverse.last = Some(station.id);
            }
        }
    }

    /// Adds a cross-section to the passage that ended at the station `before`, or else to a new one.
    fn cross_section(&mut self, station: StationId, before: StationId, sides: Sides) {
        let last = self.settings().traverse.last;
        let goes_on = match self.settings().style {
            DataStyle::Dimensions => last.is_some(),
            _ => last == Some(before),
        };
        let [left, right, up, down] = sides;
        let section = CrossSection { station, left, right, up, down };
        self.draft.cross_section(section, self.source, goes_on);
    }
}
