//! Carries out the directives of Walls, the lines that begin with `#`.

use super::fields::{Fields, options};
use super::numbers;
use super::numbers::AngleUnit;
use super::units::OptionFault;
use super::variances::{Deviations, of_fix};
use super::{LONGEST_LINE, MOST_SAVED, Reader};
use crate::draft::Fix;
use crate::earth::System;
use crate::error::Refusal;
use crate::survex::date::{self, DateError};
use crate::survey::LegFlags;

impl Reader {
    /// Carries out a directive, which is given without its `#`.
    pub(super) fn directive(&mut self, line: &str) -> Result<(), Refusal> {
        let line = line.trim_start();
        let ends = |it: char| it.is_whitespace() || it == ',' || it == ';' || it == '/';
        let (key, rest) = line.split_at(line.find(ends).unwrap_or(line.len()));
        let expanded = self.expanded(rest)?;
        let rest = expanded.as_str();
        match &*key.to_ascii_lowercase() {
            "u" | "units" => self.set_units(rest),
            "fix" => self.fix(rest),
            "date" => self.set_date(rest),
            "p" | "prefix" | "prefix1" => self.set_prefix(0, rest),
            "prefix2" => self.set_prefix(1, rest),
            "prefix3" => self.set_prefix(2, rest),
            "s" | "seg" | "segment" => {
                self.segment = compass_flags(rest);
                Ok(())
            }
            "f" | "flag" => {
                self.flag(rest);
                Ok(())
            }
            // Notes and symbols move no station.
            "n" | "note" | "sym" | "symbol" => Ok(()),
            _ => self.unknown_directive(key, rest),
        }
    }

    /// Passes over what Walls passes over, with a remark: a directive before a comma, or none.
    fn unknown_directive(&mut self, key: &str, rest: &str) -> Result<(), Refusal> {
        let word = rest.split(char::is_whitespace).next().unwrap_or_default();
        if key.contains(',') || word.contains(',') || (key.is_empty() && rest.is_empty()) {
            self.remark(format!("#{key} is passed over"));
            return Ok(());
        }
        let known = "units, fix, date, prefix, segment, flag, note or symbol";
        Err(self.wrong(format!("there is no directive #{key}"), format!("give {known}")))
    }

    /// The line with each `$(name)` replaced by what the macro of that name stands for.
    fn expanded(&self, line: &str) -> Result<String, Refusal> {
        let mut done = String::new();
        let mut rest = line;
        while let Some((before, behind)) = rest.split_once("$(") {
            let Some((name, after)) = behind.split_once(')') else { break };
            let Some(text) = self.macros.get(&name.to_ascii_lowercase()) else {
                let wrong = format!("there is no macro \"{name}\"");
                return Err(self.wrong(wrong, format!("define it: #units ${name}=\"…\"")));
            };
            done += before;
            done += text;
            rest = after;
            if done.len() > LONGEST_LINE {
                return Err(self.wrong("macros make the line too long", "use fewer of them"));
            }
        }
        Ok(done + rest)
    }

    /// Sets the options of `#Units` or `.OPTIONS`.
    pub(super) fn set_units(&mut self, line: &str) -> Result<(), Refusal> {
        for (key, value) in options(line) {
            if let Some(name) = key.strip_prefix('$') {
                self.draft.count_item();
                self.macros.insert(name.to_owned(), value.unwrap_or_default());
                continue;
            }
            match key.as_str() {
                "save" if self.saved.len() >= MOST_SAVED => {
                    let wrong = format!("options are saved {MOST_SAVED} times at once");
                    return Err(self.wrong(wrong, "add a restore between them"));
                }
                "save" => self.saved.push(self.units.clone()),
                "restore" => match self.saved.pop() {
                    Some(units) => self.units = units,
                    None => return Err(self.wrong("restore has no save", "remove it")),
                },
                key => match self.units.set(key, value.as_deref()) {
                    Ok(()) => {}
                    Err(OptionFault::Unknown) => {
                        let wrong = format!("there is no option {key}");
                        return Err(self.wrong(wrong, "correct it, or remove it"));
                    }
                    Err(OptionFault::Junk(junk)) => {
                        self.remark(format!("\"{junk}\" of the option {key} is passed over"));
                    }
                    Err(OptionFault::PassedOver) => {
                        let value = value.map(|value| format!("={value}")).unwrap_or_default();
                        let shown: String = format!("{key}{value}").chars().take(40).collect();
                        self.remark(format!("the option {shown} is passed over"));
                    }
                    Err(OptionFault::Unusable(wanted)) => {
                        let value = value.unwrap_or_default();
                        let wrong = format!("\"{value}\" is no value of {key}");
                        return Err(self.wrong(wrong, format!("give {wanted}")));
                    }
                },
            }
        }
        Ok(())
    }

    /// Walls reads the first word of a prefix, and passes over others.
    fn set_prefix(&mut self, level: usize, line: &str) -> Result<(), Refusal> {
        let prefix = Fields::new(line).name().unwrap_or_default();
        prefix.clone_into(&mut self.units.prefix[level]);
        Ok(())
    }

    /// Reads the date, behind which Walls reads nothing. Where a place on the earth is known, the
    /// declination follows from it, whatever `DECL=` said before.
    fn set_date(&mut self, line: &str) -> Result<(), Refusal> {
        let line = Fields::new(line).rest();
        let is_part = |it: char| it.is_ascii_digit() || it == '-' || it == '/';
        let (text, rest) = line.split_at(line.find(|it| !is_part(it)).unwrap_or(line.len()));
        let parts: Vec<&str> = text.split(['-', '/']).collect();
        let day = match parts.as_slice() {
            [year, month, day] if year.len() == 4 => date::days(&format!("{year}.{month}.{day}")),
            // The order of the United States.
            [month, day, year] => date::days(&format!("{year}.{month}.{day}")),
            _ => Err(DateError::NoDate),
        };
        self.date = match day {
            Ok([day, _]) => Some(day),
            // The date is none of the calendar: without one nothing follows from it.
            Err(DateError::Odd(why)) => {
                self.remark(format!("date {text}: {why}"));
                None
            }
            Err(DateError::NoDate | DateError::Backwards) => {
                let wrong = format!("\"{line}\" is no date");
                return Err(self.wrong(wrong, "give year-month-day, such as 2021-06-13"));
            }
        };
        if self.earth.is_some() && self.date.is_some() {
            self.units.declination = None;
        }
        if !rest.is_empty() {
            let rest: String = rest.chars().take(20).collect();
            self.remark(format!("\"{}\" behind the date is passed over", rest.trim()));
        }
        Ok(())
    }

    /// Notes the stations that `#Flag A B /name` calls entrances.
    fn flag(&mut self, line: &str) {
        let line = Fields::new(line).rest();
        let Some((names, flag)) = line.split_once(['/', '\\']) else { return };
        let mut words = flag.split(|it: char| !it.is_alphanumeric());
        if words.any(|word| word.eq_ignore_ascii_case("entrance")) {
            let mut names = Fields::new(names);
            while let Some(name) = names.name() {
                self.draft.count_item();
                self.entrances.push(self.units.full_name(name));
            }
        }
    }

    /// The flags of a segment at the end of a line of a leg, `#S /L`.
    pub(super) fn segment_flags(&mut self, text: &str) -> LegFlags {
        let text = text.trim_start_matches('#').trim_start();
        let (key, rest) = text.split_at(text.find(char::is_whitespace).unwrap_or(text.len()));
        match &*key.to_ascii_lowercase() {
            "s" | "seg" | "segment" => compass_flags(rest),
            _ => {
                self.remark(format!("#{key} is passed over"));
                self.segment
            }
        }
    }

    /// Reads `#Fix name east north up (variances) /note`, in the order of the axes.
    fn fix(&mut self, line: &str) -> Result<(), Refusal> {
        let mut fields = Fields::new(line);
        let name = fields.name();
        let name = name.ok_or_else(|| self.wrong("the name of a station is missing", "give it"))?;
        let mut at = [0.0; 3];
        let mut in_degrees = 0;
        for axis in self.units.axes.clone() {
            let text = fields.reading().unwrap_or_default();
            let degrees = if axis == 2 { None } else { degrees(text, axis) };
            in_degrees += usize::from(degrees.is_some());
            let read = degrees.or_else(|| numbers::length(text, self.units.distance));
            let read = read.filter(|it| it.abs() < 1e9);
            at[axis] = read.ok_or_else(|| {
                let wrong = format!("the coordinates of station \"{name}\" are no three numbers");
                self.wrong(wrong, "give east, north and up, or their ORDER=")
            })?;
        }
        let at = match in_degrees {
            0 => at,
            2 => self.projected(at)?,
            _ => return Err(self.wrong("only one coordinate is in degrees", "give both so")),
        };
        let mut deviations = Deviations::default();
        if fields.peek() == Some('(') {
            let inside = fields.bracketed();
            let inside =
                inside.ok_or_else(|| self.wrong("the ( is not closed", "close it"))?.to_owned();
            deviations = self.deviations(&inside)?;
        }
        let covariance = of_fix(deviations);
        let name = self.units.full_name(name);
        let station = self.draft.station(&name, self.source).0;
        let source = self.source;
        // Walls keeps to the first place of a station that is fixed exactly.
        if covariance.is_none() && !self.fixed.insert(station) {
            self.remark(format!("\"{name}\" is fixed before: its first place counts"));
            return Ok(());
        }
        self.draft.fix(Fix { station, at, covariance, source, is_reference: false });
        Ok(())
    }

    /// The coordinates of a place that is given by longitude and latitude.
    fn projected(&self, at: [f64; 3]) -> Result<[f64; 3], Refusal> {
        let Some(earth) = &self.earth else {
            let wrong = "the station is fixed in degrees, and no zone is known";
            return Err(self.wrong(wrong, "give the project (.wpj) that has a .REF"));
        };
        let system = System::named("LONG-LAT");
        let found = system.and_then(|system| system.to(&earth.system, at));
        found.map_err(|_| self.wrong("the place cannot be computed", "give metres instead"))
    }
}

/// A longitude or latitude such as `W97:43:52.5`, degrees east or north; `None` where it is none of
/// that axis.
fn degrees(text: &str, axis: usize) -> Option<f64> {
    let letter = text.chars().next()?.to_ascii_uppercase();
    let sign = match (letter, axis) {
        ('E', 0) | ('N', 1) => 1.0,
        ('W', 0) | ('S', 1) => -1.0,
        _ => return None,
    };
    let (limit, size) = ([180.0, 90.0][axis.min(1)], text.get(1..)?);
    let size = numbers::angle(size, AngleUnit::Degrees)?.to_degrees();
    (0.0..=limit).contains(&size).then_some(sign * size)
}

/// The flags that the name of a segment gives where it holds nothing but Compass's letters, which
/// stay when Walls imports a survey of Compass. What Compass would leave out, `X`, Walls does not:
/// it counts as a duplicate, as in `cavern`.
fn compass_flags(text: &str) -> LegFlags {
    let text = text.split(';').next().unwrap_or(text).trim().to_ascii_uppercase();
    let letters = text.strip_prefix(['/', '\\']).unwrap_or(&text);
    if !letters.chars().all(|letter| "CLPSX".contains(letter)) {
        return LegFlags::default();
    }
    LegFlags {
        surface: letters.contains('P'),
        duplicate: letters.contains(['L', 'X']),
        splay: letters.contains('S'),
        ..LegFlags::default()
    }
}
