//! Reads the numbers of data lines, and what may stand in their place.

use std::rc::Rc;

use crate::error::Refusal;
use crate::survex::Reader;
use crate::survex::characters::{Class, Cursor};
use crate::survex::measure::Slope;
use crate::survex::settings::{Quantity, Unit};

impl Reader<'_> {
    /// A dimension of the passage with its calibration; a negative one is none.
    pub(super) fn dimension(&self, quantity: Quantity, number: Option<f64>) -> Option<f64> {
        let instrument = self.settings.of(quantity);
        let calibrated = number.map(|number| (number - instrument.zero) * instrument.scale);
        calibrated.filter(|dimension| *dimension >= 0.0)
    }

    /// Whether the next field is left out; then it is read.
    pub(in crate::survex) fn is_omitted(&self, cursor: &mut Cursor<'_>) -> bool {
        let characters = &self.settings.characters;
        cursor.skip_blanks(characters);
        let mut ahead = *cursor;
        if !ahead.sees(Class::Omit, characters) {
            return false;
        }
        ahead.next();
        let ends = ahead.peek().is_none()
            || ahead.sees(Class::Blank, characters)
            || ahead.sees(Class::Comment, characters);
        if ends {
            *cursor = ahead;
        }
        ends
    }

    /// The next number times the unit; `None` where it is left out.
    pub(super) fn number(
        &self,
        cursor: &mut Cursor<'_>,
        factor: f64,
    ) -> Result<Option<f64>, Refusal> {
        if self.is_omitted(cursor) {
            return Ok(None);
        }
        self.plain_number(cursor).map(|number| Some(number * factor))
    }

    /// The next number.
    pub(in crate::survex) fn plain_number(&self, cursor: &mut Cursor<'_>) -> Result<f64, Refusal> {
        let characters = &self.settings.characters;
        if let Some(number) = cursor.number(characters) {
            return Ok(number);
        }
        let place = *cursor;
        let found = String::from_utf8_lossy(cursor.word(characters)).into_owned();
        let wrong = match found.as_str() {
            "" => "a number is missing".to_owned(),
            found => format!("\"{found}\" is no number"),
        };
        Err(self.wrong(&place, wrong, "give a number"))
    }

    pub(super) fn bearing(
        &mut self,
        quantity: Quantity,
        cursor: &mut Cursor<'_>,
    ) -> Result<Option<f64>, Refusal> {
        use std::f64::consts::TAU;
        let unit = self.settings.of(quantity).unit;
        if unit == Unit::Quadrants {
            if self.is_omitted(cursor) {
                return Ok(None);
            }
            return self.quadrant(cursor).map(Some);
        }
        let before = *cursor;
        let Some(bearing) = self.number(cursor, unit.factor())? else { return Ok(None) };
        // Rounding, as of 400 grads.
        const SLACK: f64 = 1e-8;
        if !(0.0..=TAU + SLACK).contains(&bearing) {
            self.warn(&before, "the compass reading is not of one full circle");
        }
        Ok(Some(bearing.rem_euclid(TAU)))
    }

    /// A bearing such as `S34E`, or `N`.
    pub(super) fn quadrant(&self, cursor: &mut Cursor<'_>) -> Result<f64, Refusal> {
        let place = *cursor;
        let word = String::from_utf8_lossy(cursor.word(&self.settings.characters)).to_uppercase();
        let degrees = match word.as_str() {
            "N" => Some(0.0),
            "E" => Some(90.0),
            "S" => Some(180.0),
            "W" => Some(270.0),
            _ => word.is_ascii().then_some(()).and_then(|()| {
                let (first, rest) = word.split_at_checked(1)?;
                let (angle, last) = rest.split_at_checked(rest.len().checked_sub(1)?)?;
                let angle: f64 = angle.parse().ok().filter(|angle| (0.0..=90.0).contains(angle))?;
                match (first, last) {
                    ("N", "E") => Some(angle),
                    ("S", "E") => Some(180.0 - angle),
                    ("S", "W") => Some(180.0 + angle),
                    ("N", "W") => Some(360.0 - angle),
                    _ => None,
                }
            }),
        };
        degrees.map(f64::to_radians).ok_or_else(|| {
            self.wrong(
                &place,
                format!("\"{word}\" is no quadrant bearing"),
                "give one such as S34E",
            )
        })
    }

    pub(super) fn slope(
        &mut self,
        quantity: Quantity,
        cursor: &mut Cursor<'_>,
    ) -> Result<Slope, Refusal> {
        use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        let characters = Rc::clone(&self.settings.characters);
        let mut ahead = *cursor;
        if self.is_omitted(cursor) {
            return Ok(Slope::Omitted);
        }
        let signed = ahead.sees(Class::Minus, &characters) || ahead.sees(Class::Plus, &characters);
        if signed {
            ahead.next();
        }
        let is_negative = cursor.sees(Class::Minus, &characters);
        let plumb = |up| Slope::Plumb { up, is_inferred: false };
        let word = match (signed, &*ahead.keyword(&characters)) {
            (true, "v") => Some(plumb(!is_negative)),
            (false, "u" | "up") => Some(plumb(true)),
            (false, "d" | "down") => Some(plumb(false)),
            (false, "h" | "level") => Some(Slope::Level),
            _ => None,
        };
        if let Some(word) = word {
            *cursor = ahead;
            return Ok(word);
        }
        let before = *cursor;
        let instrument = *self.settings.of(quantity);
        let reading = self.plain_number(cursor)? * instrument.unit.factor();
        let is_tangent = matches!(instrument.unit, Unit::Tangent(_));
        let angle = if is_tangent { reading.atan() } else { reading };
        const SLACK: f64 = 1e-8;
        let off_plumb = angle.abs() - FRAC_PI_2;
        if self.settings.infer.plumbs && off_plumb.abs() <= SLACK {
            return Ok(Slope::Plumb { up: angle > 0.0, is_inferred: true });
        }
        // A topofil reads from 0 to 180 degrees, which its zero error tells.
        let is_topofil = (FRAC_PI_4..3.0 * FRAC_PI_4).contains(&instrument.zero);
        let fits =
            if is_topofil { (0.0..=PI + SLACK).contains(&angle) } else { off_plumb <= SLACK };
        if !fits {
            self.warn(&before, "the clino reading is over a right angle");
        }
        Ok(Slope::Angle(angle))
    }
}
