//! Reads the lines between the commands: legs, passages, and pairs of stations that see each other.

mod numbers;

use std::rc::Rc;

use super::Reader;
use super::characters::Cursor;
use super::measure::{self, Fault, Readings};
use super::names::{NameKind, Named};
use super::settings::{Declination, North, Quantity, Reading, Style};
use crate::earth::Day;
use crate::error::Refusal;
use crate::survey::{CrossSection, Source, names_squeeze};

/// What the lines before have left: in interleaved data a leg is on several lines.
#[derive(Debug, Default)]
pub(super) struct Traverse {
    last: Option<Named>,
    next: Option<Named>,
    readings: Readings,
    is_backwards: bool,
    /// Whether the next line holds what stands after NEWLINE in the order.
    is_second: bool,
    /// The passage that the lines belong to, if one has begun.
    passage: Option<usize>,
}

/// The place in degrees, the height in metres and the day of a magnetic declination.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Occasion {
    place: [f64; 2],
    up: f64,
    day: Day,
}

/// What the fields of a line have given.
#[derive(Default)]
struct Line {
    from: Option<Named>,
    to: Option<Named>,
    /// Whether the second station is the first in the line.
    to_is_first: bool,
    dimensions: [Option<f64>; 4],
}

impl Reader<'_> {
    /// Ends the traverse of interleaved data; a passage goes on.
    pub(super) fn end_traverse(&mut self) {
        let passage = self.traverse.passage;
        self.traverse = Traverse { passage, ..Traverse::default() };
    }

    /// Ends the traverse at a line that has no data, where the leg that was read has both stations.
    pub(super) fn complete_traverse(&mut self, cursor: &Cursor<'_>) -> Result<(), Refusal> {
        let order = &self.settings.order;
        let is_interleaved = order.contains(&Reading::Newline) && order.contains(&Reading::Station);
        if is_interleaved && self.traverse.next.is_some() && !self.traverse.is_second {
            let wrong = "a leg has no second station";
            return Err(self.wrong(cursor, wrong, "give its station on the next line"));
        }
        self.end_traverse();
        Ok(())
    }

    /// Ends the passage too.
    pub(super) fn end_passage(&mut self) {
        self.traverse = Traverse::default();
    }

    /// Reads a line of data.
    pub(super) fn data(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        if self.settings.style == Style::Ignore {
            return Ok(());
        }
        let order = Rc::clone(&self.settings.order);
        let newline = order.iter().position(|reading| *reading == Reading::Newline);
        let is_interleaved =
            order.contains(&Reading::Station) && self.settings.style != Style::Passage;
        let (first, second) = order.split_at(newline.unwrap_or(order.len()));
        let mut line = Line::default();
        if newline.is_some() && self.traverse.is_second {
            self.fields(second.get(1..).unwrap_or_default(), cursor, &mut line)?;
            self.traverse.is_second = false;
            // A leg whose two stations are on one line ends here.
            return match is_interleaved {
                true => Ok(()),
                false => self.end_leg(false, cursor),
            };
        }
        self.fields(first, cursor, &mut line)?;
        match self.settings.style {
            Style::Passage => self.cross_section(&line),
            Style::NoSurvey => self.sight(&line),
            _ if is_interleaved => self.next_station(newline.is_some(), cursor),
            _ if newline.is_some() => {
                (self.traverse.last, self.traverse.next) = (line.from, line.to);
                self.traverse.is_second = true;
                Ok(())
            }
            _ => {
                (self.traverse.last, self.traverse.next) = (line.from, line.to);
                self.end_leg(line.to_is_first, cursor)
            }
        }
    }

    /// A line with the next station of a traverse: the leg to it is complete.
    fn next_station(&mut self, has_second: bool, cursor: &Cursor<'_>) -> Result<(), Refusal> {
        self.traverse.is_second = has_second;
        if self.traverse.last.is_none() {
            return Ok(());
        }
        let keep = (self.traverse.next, self.traverse.readings);
        self.leg(true, cursor)?;
        let (next, old) = keep;
        self.traverse.readings = Readings::default();
        // What was read at the station counts for the leg behind it too.
        self.traverse.readings.depths[1] = old.depths[1];
        self.traverse.readings.counts[1] = old.counts[1];
        self.traverse.next = next;
        self.traverse.is_backwards = false;
        Ok(())
    }

    fn end_leg(&mut self, to_is_first: bool, cursor: &Cursor<'_>) -> Result<(), Refusal> {
        self.leg(to_is_first, cursor)?;
        self.end_traverse();
        Ok(())
    }

    /// Reads the fields of this order.
    fn fields(
        &mut self,
        order: &[Reading],
        cursor: &mut Cursor<'_>,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        for &reading in order {
            cursor.skip_blanks(&characters);
            match reading {
                Reading::From => line.from = Some(self.named(cursor)?),
                Reading::To => {
                    line.to_is_first = line.from.is_none();
                    line.to = Some(self.named(cursor)?);
                }
                Reading::Station if self.settings.style == Style::Passage => {
                    let id = self.station(cursor)?;
                    line.from = Some(Named { id, kind: NameKind::Plain });
                }
                Reading::Station => {
                    self.traverse.last = self.traverse.next;
                    self.traverse.next = Some(self.named(cursor)?);
                }
                Reading::Direction => match &*cursor.keyword(&characters) {
                    "f" => self.traverse.is_backwards = false,
                    "b" => self.traverse.is_backwards = true,
                    _ => return Err(self.wrong(cursor, "no direction", "give F or B")),
                },
                Reading::Ignore => {
                    cursor.word(&characters);
                }
                Reading::Note if self.is_omitted(cursor) => {}
                Reading::Note => {
                    if cursor.quoted(&characters).is_none() {
                        return Err(self.wrong(cursor, "a quotation mark is missing", "add it"));
                    }
                }
                Reading::IgnoreAll | Reading::NoteAll => return Ok(()),
                Reading::Newline => {}
                number => self.reading(number, cursor, line)?,
            }
        }
        self.require_end(cursor)
    }

    /// Reads a number, or what stands for one.
    fn reading(
        &mut self,
        reading: Reading,
        cursor: &mut Cursor<'_>,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let counts = self.settings.of(Quantity::Count).unit.factor();
        let depths = self.settings.of(Quantity::Depth).unit.factor();
        match reading {
            Reading::FromCount => self.traverse.readings.counts[0] = self.number(cursor, counts)?,
            Reading::ToCount => self.traverse.readings.counts[1] = self.number(cursor, counts)?,
            Reading::Count => {
                let count = self.number(cursor, counts)?;
                let both = &mut self.traverse.readings.counts;
                *both = [both[1], count];
            }
            Reading::FromDepth => self.traverse.readings.depths[0] = self.number(cursor, depths)?,
            Reading::ToDepth => self.traverse.readings.depths[1] = self.number(cursor, depths)?,
            Reading::Depth => {
                let depth = self.number(cursor, depths)?;
                let both = &mut self.traverse.readings.depths;
                *both = [both[1], depth];
            }
            Reading::DepthChange => {
                self.traverse.readings.depth_change = self.number(cursor, depths)?;
            }
            Reading::Value(quantity) => self.value(quantity, cursor, line)?,
            _ => {}
        }
        Ok(())
    }

    fn value(
        &mut self,
        quantity: Quantity,
        cursor: &mut Cursor<'_>,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        if quantity.is_gradient() {
            let slope = self.slope(quantity, cursor)?;
            match quantity {
                Quantity::BackGradient => self.traverse.readings.back_clino = slope,
                _ => self.traverse.readings.clino = slope,
            }
            return Ok(());
        }
        if matches!(quantity, Quantity::Bearing | Quantity::BackBearing) {
            let bearing = self.bearing(quantity, cursor)?;
            match quantity {
                Quantity::BackBearing => self.traverse.readings.back_compass = bearing,
                _ => self.traverse.readings.compass = bearing,
            }
            return Ok(());
        }
        let before = *cursor;
        let number = self.number(cursor, self.settings.of(quantity).unit.factor())?;
        let readings = &mut self.traverse.readings;
        match quantity {
            Quantity::Length => readings.tape = number,
            Quantity::BackLength => readings.back_tape = number,
            Quantity::Dx => readings.steps[0] = number,
            Quantity::Dy => readings.steps[1] = number,
            Quantity::Dz => readings.steps[2] = number,
            Quantity::Left => line.dimensions[0] = self.dimension(quantity, number),
            Quantity::Right => line.dimensions[1] = self.dimension(quantity, number),
            Quantity::Up => line.dimensions[2] = self.dimension(quantity, number),
            Quantity::Down => line.dimensions[3] = self.dimension(quantity, number),
            _ => {}
        }
        if matches!(quantity, Quantity::Length | Quantity::BackLength)
            && number < Some(0.0)
            && number.is_some()
        {
            self.warn(&before, "the tape's reading is negative");
        }
        Ok(())
    }

    /// Makes the leg of what was read.
    fn leg(&mut self, to_is_first: bool, cursor: &Cursor<'_>) -> Result<(), Refusal> {
        let (Some(mut from), Some(mut to)) = (self.traverse.last, self.traverse.next) else {
            return Ok(());
        };
        if from.kind != NameKind::Plain && to.kind != NameKind::Plain {
            let wrong = "the leg is between two anonymous stations";
            return Err(self.wrong(cursor, wrong, "name one of them"));
        }
        if self.traverse.is_backwards {
            std::mem::swap(&mut from, &mut to);
        }
        let readings = self.traverse.readings;
        let infers = self.settings.infer.equates && self.settings.style == Style::Normal;
        if infers && (readings.tape == Some(0.0)) {
            self.draft.equate(from.id, to.id, self.source);
            return Ok(());
        }
        let mut remarks = Vec::new();
        let measured = self.measured(&readings, &mut remarks);
        for remark in remarks {
            self.draft.warn(self.source, 0, remark);
        }
        let measured =
            measured.map_err(|(wrong, remedy)| self.draft.wrong(self.source, wrong, remedy))?;
        let mut flags = self.settings.flags;
        flags.splay |= [from.kind, to.kind].contains(&NameKind::Splay);
        flags.squeeze |= names_squeeze(&String::from_utf8_lossy(cursor.rest()));
        let leg = measured.leg([from.id, to.id], flags, self.source);
        self.draft.leg(leg, to_is_first)
    }

    fn measured(
        &mut self,
        readings: &Readings,
        remarks: &mut Vec<String>,
    ) -> Result<measure::Measured, Fault> {
        if self.settings.style == Style::Cartesian {
            let turn = self.turn()?;
            return measure::cartesian(readings, &self.settings).map(|leg| leg.turned(turn));
        }
        let declination = self.declination()?;
        match self.settings.style {
            Style::Diving => measure::diving(readings, &self.settings, declination, remarks),
            Style::Cylpolar => measure::cylpolar(readings, &self.settings, declination, remarks),
            _ => measure::normal(readings, &self.settings, declination, remarks),
        }
    }

    /// The angle by which coordinate legs are turned clockwise, rad.
    fn turn(&mut self) -> Result<f64, Fault> {
        let place = match self.settings.declination {
            Declination::Of { place, .. } => Some(place),
            Declination::Given(_) => None,
        };
        let input = self.settings.system.clone();
        let north = match (self.settings.north, place) {
            (North::Magnetic, _) => self.declination()?,
            (_, None) => 0.0,
            (North::True, Some(place)) => -self.convergence(place)?,
            (North::Grid, Some(place)) => {
                let input = input.and_then(|system| system.convergence(place).ok());
                input.unwrap_or(0.0) - self.convergence(place)?
            }
        };
        Ok(north + self.settings.turn)
    }

    /// The angle from true north to that of the positions' grid at a place in degrees, rad.
    fn convergence(&mut self, place: [f64; 2]) -> Result<f64, Fault> {
        if let Some((known, angle)) = self.last_convergence
            && known == place
        {
            return Ok(angle);
        }
        let Some(output) = &self.output else {
            return Err(("no *cs out says in which system positions are", "add *cs out before"));
        };
        let cannot = |_| ("the north of *cs out cannot be computed here", "give another system");
        let angle = output.convergence(place).map_err(cannot)?;
        self.last_convergence = Some((place, angle));
        Ok(angle)
    }

    /// The declination for the present line, rad.
    fn declination(&mut self) -> Result<f64, Fault> {
        let (place, up) = match self.settings.declination {
            Declination::Given(angle) => return Ok(angle),
            Declination::Of { place, up } => (place, up),
        };
        let convergence = self.convergence(place)?;
        let Some(day) = self.settings.date else {
            if !std::mem::replace(&mut self.warned_of_date, true) {
                let text = "the survey has no date, so that its declination is taken for 0";
                self.draft.warn(self.source, 0, text);
            }
            return Ok(-convergence);
        };
        let occasion = Occasion { place, up, day };
        if let Some((known, angle)) = self.last_declination
            && known == occasion
        {
            return Ok(angle);
        }
        let magnetic = crate::earth::magnetic_declination(place, up, day).unwrap_or(0.0);
        self.last_declination = Some((occasion, magnetic - convergence));
        Ok(magnetic - convergence)
    }

    fn cross_section(&mut self, line: &Line) -> Result<(), Refusal> {
        let Some(station) = line.from else { return Ok(()) };
        let [left, right, up, down] = line.dimensions;
        let section = CrossSection { station: station.id, left, right, up, down };
        let passage = match self.traverse.passage {
            Some(passage) => passage,
            None => {
                self.draft.count_item();
                self.draft.passages.push(Vec::new());
                self.draft.passages.len() - 1
            }
        };
        self.traverse.passage = Some(passage);
        self.draft.count_item();
        self.draft.passages[passage].push((section, self.source));
        Ok(())
    }

    fn sight(&mut self, line: &Line) -> Result<(), Refusal> {
        let pair = match (line.from, line.to) {
            (Some(from), Some(to)) => Some((from, to)),
            _ => self.traverse.last.zip(self.traverse.next),
        };
        if let Some((from, to)) = pair {
            let source: Source = self.source;
            self.draft.sight(from.id, to.id, self.settings.flags, source);
        }
        Ok(())
    }
}
