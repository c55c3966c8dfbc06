//! Carries out the commands that say what instruments measure, and how well.

use std::rc::Rc;

use crate::error::Refusal;
use crate::survex::Reader;
use crate::survex::characters::Cursor;
use crate::survex::settings::{Declination, North, Quantity, Unit};

impl Reader<'_> {
    /// Quantities up to the first word that is none, which is left; `None` for `default`.
    pub(super) fn quantities(
        &self,
        cursor: &mut Cursor<'_>,
    ) -> Result<Option<Vec<Quantity>>, Refusal> {
        let mut all = Vec::new();
        loop {
            let before = *cursor;
            let word = cursor.keyword(&self.settings.characters);
            match (Quantity::named(&word), &*word) {
                (Some(quantity), _) => all.push(quantity),
                (None, "default") if all.is_empty() => return Ok(None),
                (None, _) if all.is_empty() => {
                    let wrong = format!("\"{word}\" is no quantity");
                    return Err(self.wrong(&before, wrong, "give one such as tape or compass"));
                }
                (None, _) => {
                    *cursor = before;
                    return Ok(Some(all));
                }
            }
        }
    }

    /// A unit that suits all quantities.
    pub(super) fn unit(
        &self,
        cursor: &mut Cursor<'_>,
        quantities: &[Quantity],
    ) -> Result<Unit, Refusal> {
        let mut place = *cursor;
        place.skip_blanks(&self.settings.characters);
        let word = cursor.keyword(&self.settings.characters);
        let Some((unit, is_angle)) = Unit::named(&word) else {
            let wrong = format!("\"{word}\" is no unit");
            return Err(self.wrong(&place, wrong, "give one such as metres, feet or degrees"));
        };
        let suits = |quantity: &Quantity| match unit {
            Unit::Tangent(_) => quantity.is_gradient(),
            Unit::Quadrants => matches!(quantity, Quantity::Bearing | Quantity::BackBearing),
            Unit::Plain(_) => quantity.is_angle() == is_angle,
        };
        if quantities.iter().all(suits) {
            return Ok(unit);
        }
        let wrong = format!("the quantity is not measured in {word}");
        Err(self.wrong(&place, wrong, "give lengths in metres or feet, and angles in degrees"))
    }

    pub(super) fn units(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let Some(quantities) = self.quantities(cursor)? else {
            self.settings.default_units();
            return Ok(());
        };
        let place = *cursor;
        let factor = cursor.number(&self.settings.characters).unwrap_or(1.0);
        if factor == 0.0 {
            return Err(self.wrong(&place, "the factor of a unit is 0", "give another"));
        }
        let unit = match self.unit(cursor, &quantities)? {
            Unit::Plain(one) => Unit::Plain(one * factor),
            Unit::Tangent(one) => Unit::Tangent(one * factor),
            other => other,
        };
        for quantity in quantities {
            self.settings.change(quantity).unit = unit;
        }
        Ok(())
    }

    pub(super) fn calibrate(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let Some(quantities) = self.quantities(cursor)? else {
            self.settings.default_calibration();
            return Ok(());
        };
        let place = *cursor;
        let angles = quantities.iter().filter(|quantity| quantity.is_angle()).count();
        if angles != 0 && angles != quantities.len() {
            let wrong = "angles and lengths are calibrated together";
            return Err(self.wrong(&place, wrong, "calibrate them in two commands"));
        }
        let zero = self.plain_number(cursor)?;
        let mut ahead = *cursor;
        // With a unit the zero error was measured from outside, and is not scaled.
        let unit = if ahead.keyword(&characters).is_empty() {
            None
        } else {
            Some(self.unit(cursor, &quantities)?)
        };
        let scale_place = *cursor;
        let scale = if cursor.is_done(&characters) { 1.0 } else { self.plain_number(cursor)? };
        if scale == 0.0 {
            return Err(self.wrong(&scale_place, "the scale factor is 0", "give another"));
        }
        for quantity in quantities {
            if quantity == Quantity::Declination {
                if scale != 1.0 {
                    let wrong = "a declination has no scale factor";
                    return Err(self.wrong(&scale_place, wrong, "remove it"));
                }
                let unit = unit.unwrap_or(self.settings.of(quantity).unit);
                self.settings.declination = Declination::Given(-zero * unit.factor());
                continue;
            }
            let instrument = self.settings.change(quantity);
            instrument.scale = scale;
            instrument.zero = match unit {
                Some(unit) => zero * unit.factor() / scale,
                None => zero * instrument.unit.factor(),
            };
        }
        Ok(())
    }

    pub(super) fn deviation(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let Some(quantities) = self.quantities(cursor)? else {
            self.settings.default_variances();
            return Ok(());
        };
        let place = *cursor;
        let deviation = self.plain_number(cursor)?;
        if deviation <= 0.0 {
            return Err(self.wrong(
                &place,
                "a standard deviation is not positive",
                "give one that is",
            ));
        }
        let deviation = deviation * self.unit(cursor, &quantities)?.factor();
        for quantity in quantities {
            // Far below any instrument's, and far from the end of what can be squared.
            self.settings.change(quantity).variance = deviation.clamp(1e-6, 1e6).powi(2);
        }
        Ok(())
    }

    pub(super) fn set_declination(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let place = *cursor;
        let mut ahead = *cursor;
        if ahead.keyword(&self.settings.characters) != "auto" {
            let angle = self.plain_number(cursor)?;
            let angle = angle * self.unit(cursor, &[Quantity::Declination])?.factor();
            self.settings.declination = Declination::Given(angle);
            return Ok(());
        }
        *cursor = ahead;
        let mut at = [0.0; 3];
        for axis in &mut at {
            *axis = self.plain_number(cursor)?;
        }
        let Some(system) = &self.settings.system else {
            let wrong = "*declination auto has no coordinate system";
            return Err(self.wrong(&place, wrong, "give *cs before it"));
        };
        let degrees = system.degrees(at).map_err(|error| self.no_system(&place, error))?;
        self.settings.declination = Declination::Of { place: degrees, up: at[2] };
        Ok(())
    }

    pub(super) fn cartesian(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let place = *cursor;
        self.settings.north = match &*cursor.keyword(&characters) {
            "true" => North::True,
            "grid" => North::Grid,
            "magnetic" => North::Magnetic,
            _ => return Err(self.wrong(&place, "no north", "give grid, magnetic or true")),
        };
        self.settings.turn = 0.0;
        if !cursor.is_done(&characters) {
            let angle = self.plain_number(cursor)?;
            let unit = self.unit(cursor, &[Quantity::Declination])?;
            self.settings.turn = angle * unit.factor();
        }
        Ok(())
    }
}
