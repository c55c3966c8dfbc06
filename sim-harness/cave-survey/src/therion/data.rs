//! Reads the lines of data.

use std::rc::Rc;

use super::Reader;
use super::centreline::DataStyle;
use super::legs::{Line, Sides};
use super::words::{degrees, is_omitted, number, split};
use crate::error::Refusal;
use crate::survex::measure::Slope;
use crate::survex::settings::{DEFAULT_ORDER, Quantity, Reading};

impl Reader<'_> {
    pub(super) fn data(&mut self, words: &[String]) -> Result<(), Refusal> {
        if self.settings().order.is_empty() {
            self.default_order(words)?;
        }
        let order = Rc::clone(&self.settings().order);
        let newline = order.iter().position(|reading| *reading == Reading::Newline);
        let (first, second) = order.split_at(newline.unwrap_or(order.len()));
        let is_second = self.settings().traverse.is_second;
        let part = if is_second { second.get(1..).unwrap_or_default() } else { first };
        let mut line = std::mem::take(&mut self.settings().traverse.line);
        if newline.is_none() {
            line = Line::default();
        }
        self.fields(part, words, &mut line)?;
        match (newline, is_second) {
            (None, _) => self.complete(line),
            (Some(_), true) => {
                let traverse = &mut self.settings().traverse;
                (traverse.line, traverse.is_second, traverse.has_readings) = (line, false, true);
                Ok(())
            }
            (Some(_), false) => self.next_station(line),
        }
    }

    /// Sets the order of a centreline without `data`, where the line is one of it.
    fn default_order(&mut self, words: &[String]) -> Result<(), Refusal> {
        let is_reading =
            |word: &String| plumb(word).is_some() || is_omitted(word) || degrees(word).is_some();
        if words.len() == DEFAULT_ORDER.len() && words.iter().skip(2).all(is_reading) {
            self.settings().order = DEFAULT_ORDER.into();
            return Ok(());
        }
        let word = words.first().map_or("", String::as_str);
        let wrong =
            format!("\"{word}\" is no command of a centreline, and no data says what it is");
        Err(self.wrong(wrong, "correct it, or give data before it"))
    }

    /// Reads the words of a line in their order.
    fn fields(
        &mut self,
        order: &[Reading],
        words: &[String],
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let mut words = words.iter();
        for &reading in order {
            if reading == Reading::IgnoreAll {
                return Ok(());
            }
            let Some(word) = words.next() else {
                let wrong = format!("the line has fewer readings than the {} of data", order.len());
                return Err(self.wrong(wrong, "give - for what was not measured"));
            };
            self.field(reading, word, line)?;
        }
        match words.next() {
            None => Ok(()),
            Some(word) => {
                let wrong = format!("\"{word}\" is more than the {} readings of data", order.len());
                Err(self.wrong(wrong, "remove it, or begin a comment with #"))
            }
        }
    }

    fn field(&mut self, reading: Reading, word: &str, line: &mut Line) -> Result<(), Refusal> {
        match reading {
            Reading::From => line.from = Some(self.end(word)?),
            Reading::To => line.to = Some(self.end(word)?),
            Reading::Station if self.settings().style == DataStyle::Dimensions => {
                let id = self.station(word)?;
                line.from = Some(super::names::End { id, is_splay: false });
            }
            Reading::Station => {
                line.from = line.to;
                line.to = Some(self.end(word)?);
            }
            Reading::Direction => match word {
                "f" | "F" => line.is_backwards = false,
                "b" | "B" => line.is_backwards = true,
                _ => return Err(self.wrong(format!("\"{word}\" is no direction"), "give f or b")),
            },
            Reading::FromDepth => line.readings.depths[0] = self.number(Quantity::Depth, word)?,
            Reading::ToDepth => line.readings.depths[1] = self.number(Quantity::Depth, word)?,
            Reading::Depth => {
                let depth = self.number(Quantity::Depth, word)?;
                line.readings.depths = [line.readings.depths[1], depth];
            }
            Reading::DepthChange => {
                line.readings.depth_change = self.number(Quantity::Depth, word)?;
            }
            Reading::FromCount => line.readings.counts[0] = self.number(Quantity::Count, word)?,
            Reading::ToCount => line.readings.counts[1] = self.number(Quantity::Count, word)?,
            Reading::Count => {
                let count = self.number(Quantity::Count, word)?;
                line.readings.counts = [line.readings.counts[1], count];
            }
            Reading::Value(quantity) => self.value(quantity, word, line)?,
            _ => {}
        }
        Ok(())
    }

    fn value(&mut self, quantity: Quantity, word: &str, line: &mut Line) -> Result<(), Refusal> {
        let readings = &mut line.readings;
        match quantity {
            Quantity::Length | Quantity::BackLength => {
                let length = self.number(quantity, word)?;
                if length.is_some_and(|length| length < 0.0) {
                    self.remark("the tape's reading is negative");
                }
                let tape = match quantity {
                    Quantity::Length => &mut readings.tape,
                    _ => &mut readings.back_tape,
                };
                *tape = length;
            }
            Quantity::Bearing => readings.compass = self.bearing(quantity, word)?,
            Quantity::BackBearing => readings.back_compass = self.bearing(quantity, word)?,
            Quantity::Gradient => readings.clino = self.slope(quantity, word)?,
            Quantity::BackGradient => readings.back_clino = self.slope(quantity, word)?,
            Quantity::Dx => readings.steps[0] = self.number(quantity, word)?,
            Quantity::Dy => readings.steps[1] = self.number(quantity, word)?,
            Quantity::Dz => readings.steps[2] = self.number(quantity, word)?,
            Quantity::Left => self.side(quantity, 0, word, line)?,
            Quantity::Right => self.side(quantity, 1, word, line)?,
            Quantity::Up => self.side(quantity, 2, word, line)?,
            Quantity::Down => self.side(quantity, 3, word, line)?,
            _ => {}
        }
        Ok(())
    }

    /// A number with calibration and unit; `None` where it is left out.
    fn number(&mut self, quantity: Quantity, word: &str) -> Result<Option<f64>, Refusal> {
        if is_omitted(word) {
            return Ok(None);
        }
        let read = number(word).or_else(|| degrees(word).filter(|_| quantity.is_angle()));
        match read {
            Some(raw) => Ok(Some(self.settings().calibrated(quantity, raw))),
            None => Err(self.wrong(format!("\"{word}\" is no number"), "give one, or - for none")),
        }
    }

    fn bearing(&mut self, quantity: Quantity, word: &str) -> Result<Option<f64>, Refusal> {
        use std::f64::consts::TAU;
        let Some(bearing) = self.number(quantity, word)? else { return Ok(None) };
        if !(-TAU..2.0 * TAU).contains(&bearing) {
            self.remark("the compass reading is not of one full circle");
        }
        Ok(Some(bearing.rem_euclid(TAU)))
    }

    fn slope(&mut self, quantity: Quantity, word: &str) -> Result<Slope, Refusal> {
        use std::f64::consts::{FRAC_PI_2, PI};
        if let Some(up) = plumb(word) {
            return Ok(Slope::Plumb { up, is_inferred: false });
        }
        let Some(angle) = self.number(quantity, word)? else { return Ok(Slope::Omitted) };
        // Some instruments count slopes downwards from a full circle.
        let angle = if (1.5 * PI - 1e-6..=2.0 * PI + 1e-6).contains(&angle) {
            angle - 2.0 * PI
        } else {
            angle
        };
        let off_plumb = angle.abs() - FRAC_PI_2;
        if off_plumb.abs() < 1e-9 {
            return Ok(Slope::Plumb { up: angle > 0.0, is_inferred: true });
        }
        if off_plumb > 0.0 {
            self.remark("the clino reading is over a right angle");
        }
        Ok(Slope::Angle(angle))
    }

    /// Reads a dimension. In a line with both stations one alone is that of the second, and two in
    /// brackets are those of both.
    fn side(
        &mut self,
        quantity: Quantity,
        side: usize,
        word: &str,
        line: &mut Line,
    ) -> Result<(), Refusal> {
        let mut read = Vec::new();
        for part in split(word) {
            let size = self.number(quantity, &part)?;
            read.push(size.filter(|size| (0.0..1e6).contains(size)));
        }
        let set = |sides: &mut Sides, size: Option<f64>| {
            if let Some(slot) = sides.get_mut(side) {
                *slot = size;
            }
        };
        match read.as_slice() {
            [here] => set(&mut line.sides[1], *here),
            [there, here] => {
                set(&mut line.sides[0], *there);
                set(&mut line.sides[1], *here);
            }
            _ => return Err(self.wrong(format!("\"{word}\" is no dimension"), "give one or two")),
        }
        Ok(())
    }
}

/// Whether a plumbed slope leads up; `None` where the word is no such slope.
fn plumb(word: &str) -> Option<bool> {
    match word {
        "up" | "Up" | "UP" => Some(true),
        "down" | "Down" | "DOWN" => Some(false),
        _ => None,
    }
}
