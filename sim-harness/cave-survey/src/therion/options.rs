//! Carries out the commands of a centreline.

use super::Reader;
use super::blocks::BlockKind;
use super::centreline::{Centreline, North};
use super::words::{is_omitted, number};
use crate::error::Refusal;
use crate::survex::date;
use crate::survex::settings::{FOOT, Quantity, Unit};

/// Commands that move no station.
const PASSED_OVER: &[&str] = &[
    "attr",
    "author",
    "copyright",
    "explo-date",
    "explo-team",
    "extend",
    "grade",
    "id",
    "instrument",
    "mark",
    "team",
    "title",
    "vthreshold",
    "walls",
];

/// The unit of angles of that name.
#[derive(Clone, Copy)]
pub(super) struct AngleUnit(Unit);

impl AngleUnit {
    /// Radians of one unit; `None` where it is one of slopes alone.
    pub(super) const fn radians(self) -> Option<f64> {
        match self.0 {
            Unit::Plain(factor) => Some(factor),
            _ => None,
        }
    }
}

pub(super) fn angle_unit(name: &str) -> Option<AngleUnit> {
    let degree = 1f64.to_radians();
    Some(AngleUnit(match name {
        "deg" | "degree" | "degrees" => Unit::Plain(degree),
        "min" | "minute" | "minutes" => Unit::Plain(degree / 60.0),
        "grad" | "grads" | "mil" | "mils" => Unit::Plain(0.9 * degree),
        "percent" | "percentage" => Unit::Tangent(0.01),
        _ => return None,
    }))
}

/// Metres of the unit of lengths of that name.
fn length_unit(name: &str) -> Option<f64> {
    Some(match name {
        "m" | "meter" | "meters" | "metre" | "metres" | "metric" => 1.0,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 0.01,
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 0.001,
        "in" | "inch" | "inches" => FOOT / 12.0,
        "ft" | "feet" | "feets" => FOOT,
        "yd" | "yard" | "yards" => 3.0 * FOOT,
        _ => return None,
    })
}

/// The quantities of that name.
pub(super) fn quantities(name: &str) -> &'static [Quantity] {
    use Quantity as Q;
    match name {
        "length" | "tape" => &[Q::Length, Q::BackLength],
        "backlength" | "backtape" => &[Q::BackLength],
        "bearing" | "compass" => &[Q::Bearing, Q::BackBearing],
        "backbearing" | "backcompass" => &[Q::BackBearing],
        "gradient" | "clino" => &[Q::Gradient, Q::BackGradient],
        "backgradient" | "backclino" => &[Q::BackGradient],
        "count" | "counter" => &[Q::Count],
        "depth" | "depthchange" => &[Q::Depth],
        "dx" | "easting" => &[Q::Dx],
        "dy" | "northing" => &[Q::Dy],
        "dz" | "altitude" => &[Q::Dz],
        "x" | "y" | "z" | "position" | "gps" => &[Q::Position],
        "left" => &[Q::Left],
        "right" => &[Q::Right],
        "up" | "ceiling" => &[Q::Up],
        "down" | "floor" => &[Q::Down],
        "dimensions" => &[Q::Left, Q::Right, Q::Up, Q::Down],
        _ => &[],
    }
}

impl Reader<'_> {
    /// The settings of the centreline that is open.
    pub(super) fn settings(&mut self) -> &mut Centreline {
        self.centreline.get_or_insert_default()
    }

    /// Reads a line within a centreline: a command, or else data.
    pub(super) fn in_centreline(
        &mut self,
        key: &str,
        arguments: &[String],
        words: &[String],
    ) -> Result<(), Refusal> {
        match key {
            "endcentreline" | "endcenterline" => {
                self.close(BlockKind::Centreline)?;
                self.centreline = None;
                self.draft.end_repeats();
            }
            "group" => self.begin_group()?,
            "endgroup" => self.end_group()?,
            "data" => self.order(arguments)?,
            "break" => self.settings().traverse = Default::default(),
            "units" => self.units(arguments)?,
            "calibrate" => self.calibrate(arguments)?,
            "sd" => self.deviation(arguments)?,
            "declination" => self.declination(arguments, North::True)?,
            "grid-angle" => self.declination(arguments, North::Grid)?,
            "flags" => self.flags(arguments)?,
            "infer" => self.infer(arguments)?,
            "date" => self.date(arguments)?,
            "cs" => self.coordinates(arguments)?,
            "fix" => self.fix(arguments)?,
            "equate" => self.equate(arguments)?,
            "station" => self.flag_station(arguments)?,
            "station-names" => {
                let part = |n: usize| arguments.get(n).cloned().unwrap_or_default();
                let (prefix, suffix) = (part(0), part(1));
                let centreline = self.settings();
                (centreline.prefix, centreline.suffix) = (prefix, suffix);
            }
            _ if PASSED_OVER.contains(&key) => {}
            _ => return self.data(words),
        }
        Ok(())
    }

    /// Splits arguments into quantities and the rest.
    fn split<'t>(&self, arguments: &'t [String]) -> Result<(Vec<Quantity>, &'t [String]), Refusal> {
        let named = |word: &&String| !quantities(word).is_empty();
        let count = arguments.iter().take_while(named).count();
        let (names, rest) = arguments.split_at(count);
        let all: Vec<Quantity> = names.iter().flat_map(|name| quantities(name)).copied().collect();
        if all.is_empty() {
            let found = arguments.first().map_or("", String::as_str);
            let wrong = format!("\"{found}\" is no quantity");
            return Err(self.wrong(wrong, "give one such as length or compass"));
        }
        Ok((all, rest))
    }

    /// The unit that suits the quantities.
    fn unit(&self, name: &str, quantities: &[Quantity]) -> Result<Unit, Refusal> {
        let unit = match (length_unit(name), angle_unit(name)) {
            (Some(metres), _) => Some((Unit::Plain(metres), false)),
            (_, Some(AngleUnit(unit))) => Some((unit, true)),
            _ => None,
        };
        let suits = |(unit, is_angle): &(Unit, bool)| {
            let slopes = matches!(unit, Unit::Tangent(_));
            quantities.iter().all(|quantity| match slopes {
                true => quantity.is_gradient(),
                false => (quantity.is_angle() && *quantity != Quantity::Position) == *is_angle,
            })
        };
        unit.filter(suits).map(|(unit, _)| unit).ok_or_else(|| {
            let wrong = format!("the quantity is not measured in \"{name}\"");
            self.wrong(wrong, "give lengths in metres or feet, and angles in degrees or grads")
        })
    }

    fn units(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        // Therion takes any one word for the quantities, and then sets nothing.
        if let [word, unit] = arguments
            && quantities(word).is_empty()
            && (length_unit(unit).is_some() || angle_unit(unit).is_some())
        {
            self.remark(format!("\"{word}\" is no quantity: its unit is passed over"));
            return Ok(());
        }
        let (quantities, rest) = self.split(arguments)?;
        let (factor, name) = match rest {
            [name] => (Some(1.0), name),
            [factor, name] => (number(factor).filter(|factor| *factor != 0.0), name),
            _ => return Err(self.wrong("units names no unit", "give one such as metres")),
        };
        let factor =
            factor.ok_or_else(|| self.wrong("the factor of a unit is no number", "correct it"))?;
        let unit = match self.unit(name, &quantities)? {
            Unit::Plain(one) => Unit::Plain(one * factor),
            Unit::Tangent(one) => Unit::Tangent(one * factor),
            other => other,
        };
        for quantity in quantities {
            self.settings().read.change(quantity).unit = unit;
        }
        Ok(())
    }

    fn calibrate(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let (quantities, rest) = self.split(arguments)?;
        let numbers: Option<Vec<f64>> = rest.iter().map(|word| number(word)).collect();
        let (zero, scale) = match numbers.as_deref() {
            Some([zero]) => (*zero, 1.0),
            Some([zero, scale]) if *scale != 0.0 => (*zero, *scale),
            _ => {
                let wrong = "calibrate has no zero error, or a scale that is none";
                return Err(self.wrong(wrong, "give the zero error, and perhaps a scale"));
            }
        };
        for quantity in quantities {
            let instrument = self.settings().read.change(quantity);
            (instrument.zero, instrument.scale) = (zero, scale);
        }
        Ok(())
    }

    fn deviation(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let (quantities, rest) = self.split(arguments)?;
        let [size, name] = rest else {
            return Err(self.wrong("sd has no number with a unit", "give both"));
        };
        let size = number(size).filter(|size| *size > 0.0);
        let size =
            size.ok_or_else(|| self.wrong("a standard deviation is not positive", "correct it"))?;
        let Unit::Plain(factor) = self.unit(name, &quantities)? else { return Ok(()) };
        for quantity in quantities {
            let variance = (size * factor).clamp(1e-6, 1e6).powi(2);
            self.settings().weighed.change(quantity).variance = variance;
        }
        Ok(())
    }

    fn declination(
        &mut self,
        arguments: &[String],
        north: fn(f64) -> North,
    ) -> Result<(), Refusal> {
        self.settings().north = match arguments {
            [none] if is_omitted(none) => None,
            [angle, name] => {
                let unit = angle_unit(name).and_then(AngleUnit::radians);
                let angle = number(angle).zip(unit).map(|(angle, factor)| angle * factor);
                let wrong = || self.wrong("this is no declination", "give one such as 3.5 degrees");
                Some(north(angle.ok_or_else(wrong)?))
            }
            _ => return Err(self.wrong("the declination has no unit", "give one such as degrees")),
        };
        Ok(())
    }

    fn flags(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let mut on = true;
        for word in arguments {
            if on && word == "not" {
                on = false;
                continue;
            }
            if let Some(flag) = self.settings().flags.named(word) {
                *flag = on;
            } else if !["approx", "approximate"].contains(&word.as_str()) {
                let wrong = format!("there is no flag \"{word}\"");
                return Err(self.wrong(wrong, "give duplicate, splay, surface or approximate"));
            }
            on = true;
        }
        Ok(())
    }

    fn infer(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let on = match arguments.get(1).map(String::as_str) {
            Some("on") => true,
            Some("off") => false,
            _ => return Err(self.wrong("neither on nor off", "give on or off")),
        };
        match arguments.first().map(String::as_str) {
            // A slope of a right angle is plumbed either way.
            Some("plumbs") => {}
            Some("equates") => self.settings().infers_equates = on,
            _ => return Err(self.wrong("this cannot be inferred", "give plumbs or equates")),
        }
        Ok(())
    }

    /// Reads `2021.05.02`, a day with its hour behind `@`, or two with `-` between them. Therion reads
    /// nothing behind a date.
    fn date(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let text = arguments.join(" ");
        let mut words = text.split_whitespace();
        let first = words.next().unwrap_or_default();
        let second = match (words.next(), words.next()) {
            (Some("-"), Some(second)) => second,
            (None, _) => first,
            (Some(rest), _) => {
                self.remark(format!("\"{rest}\" behind the date is passed over"));
                first
            }
        };
        let day = |part: &str| date::days(part.split('@').next().unwrap_or(part));
        self.settings().date = match (day(first), day(second)) {
            _ if is_omitted(first) => None,
            (Ok([begin, _]), Ok([_, end])) => begin.middle(end),
            _ => {
                let wrong = format!("\"{text}\" is no date");
                return Err(self.wrong(wrong, "give one such as 2021.06.13"));
            }
        };
        Ok(())
    }

    /// Reads `station name "comment" flags`.
    fn flag_station(&mut self, arguments: &[String]) -> Result<(), Refusal> {
        let [name, flags @ ..] = arguments else {
            return Err(self.wrong("the name of a station is missing", "give it"));
        };
        let station = self.station(name)?;
        let mut before = "";
        for flag in flags.iter().skip(1) {
            if flag == "entrance" {
                self.draft.stations[station].is_entrance = before != "not";
            }
            before = flag;
        }
        Ok(())
    }
}
