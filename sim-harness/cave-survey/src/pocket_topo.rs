//! Reads the two exports of PocketTopo that are text: "text", whose first line has the units in
//! brackets and whose shots name their trip in brackets, and "Therion", of sections such as `TRIP`.

use std::collections::HashMap;

use crate::draft::{Draft, Fix};
use crate::error::Refusal;
use crate::files::{self, Opened};
use crate::survex::measure::{self, Readings, Slope};
use crate::survex::settings::{FOOT, Settings};
use crate::survey::{LegFlags, Source};

/// A shot as both exports have it.
struct Shot<'a> {
    from: &'a str,
    /// The second station; `None` at a point on the wall.
    to: Option<&'a str>,
    length: f64,
    bearing: f64,
    slope: f64,
}

/// What is read of a file so far.
struct Reader {
    draft: Draft,
    source: Source,
    settings: Settings,
    /// Metres of a length, and radians of an angle.
    units: [f64; 2],
    /// The declination of each trip, rad.
    trips: HashMap<String, f64>,
    /// The declination of the trip that is open, rad, in the export for Therion.
    declination: f64,
    section: Section,
}

/// A part of the export for Therion.
#[derive(Clone, Copy, PartialEq)]
enum Section {
    /// The file is no such export.
    None,
    Fix,
    Trip,
    Data,
    /// A drawing.
    Other,
}

/// Reads one file.
pub(crate) fn read(opened: &Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    let mut reader = Reader {
        source: Source { file: draft.file(&opened.path), line: 0 },
        draft,
        settings: Settings::default(),
        units: [1.0, 1f64.to_radians()],
        trips: HashMap::new(),
        declination: 0.0,
        section: Section::None,
    };
    let text = files::text(&opened.bytes);
    for line in files::lines(&text) {
        reader.source.line = reader.source.line.saturating_add(1);
        reader.draft.require_line(line, reader.source)?;
        reader.line(line)?;
    }
    Ok(reader.draft)
}

impl Reader {
    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        self.draft.wrong(self.source, wrong, remedy)
    }

    fn line(&mut self, line: &str) -> Result<(), Refusal> {
        let known = match line.trim() {
            "" => return Ok(()),
            "FIX" => Some(Section::Fix),
            "TRIP" => Some(Section::Trip),
            "DATA" if self.section == Section::Trip => Some(Section::Data),
            "PLAN" | "ELEVATION" => Some(Section::Other),
            _ => None,
        };
        if let Some(section) = known {
            if section == Section::Trip {
                self.declination = 0.0;
                self.draft.end_repeats();
            }
            self.section = section;
            return Ok(());
        }
        match self.section {
            Section::None => self.text(line),
            Section::Fix => self.fix(&line.split_whitespace().collect::<Vec<_>>()),
            Section::Trip => {
                if let Some(angle) = line.trim().strip_prefix("DECLINATION") {
                    self.declination = self.number(angle.trim())?.to_radians();
                }
                Ok(())
            }
            Section::Data => self.row(line),
            Section::Other => Ok(()),
        }
    }

    fn number(&self, word: &str) -> Result<f64, Refusal> {
        let number = word.parse::<f64>().ok().filter(|number| number.abs() < 1e9);
        number.ok_or_else(|| self.wrong(format!("\"{word}\" is no number"), "give one"))
    }

    /// Reads a line of the export as text.
    fn text(&mut self, line: &str) -> Result<(), Refusal> {
        // Behind the first quotation mark stands a comment.
        let line = line.split('"').next().unwrap_or(line).trim();
        if let Some((title, units)) = line.rsplit_once('(').filter(|it| it.1.ends_with(')')) {
            self.draft.title.get_or_insert_with(|| title.trim().to_owned());
            return self.read_units(units.trim_end_matches(')'));
        }
        if let Some((trip, rest)) = line.strip_prefix('[').and_then(|it| it.split_once("]:")) {
            let declination = match rest.split_whitespace().nth(1) {
                Some(angle) => self.number(angle)? * self.units[1],
                None => 0.0,
            };
            self.draft.count_item();
            self.trips.insert(trip.trim().to_owned(), declination);
            return Ok(());
        }
        let (readings, trip) = line.split_once('[').unwrap_or((line, ""));
        let words: Vec<&str> = readings.split_whitespace().collect();
        let trip = trip.split(']').next().unwrap_or_default().trim();
        let declination = self.trips.get(trip).copied().unwrap_or(0.0);
        let (from, to, numbers) = match words.as_slice() {
            [] => return Ok(()),
            // What names no trip is the place of a station.
            [_, _, _, _] if !line.contains('[') => return self.fix(&words),
            [from, to, numbers @ ..] if numbers.len() == 3 => (*from, Some(*to), numbers),
            [from, numbers @ ..] if numbers.len() == 3 => (*from, None, numbers),
            // A shot of no length without a station is a place left for one.
            [_, _, _] => return Ok(()),
            _ => {
                let wrong = format!("\"{readings}\" is no shot");
                return Err(self.wrong(wrong, "give from, to, length, bearing and slope"));
            }
        };
        let mut read = [0.0; 3];
        for (number, word) in read.iter_mut().zip(numbers) {
            *number = self.number(word)?;
        }
        let [length, bearing, slope] = read;
        self.shot(&Shot { from, to, length, bearing, slope }, declination)
    }

    /// Reads `m, 360`.
    fn read_units(&mut self, units: &str) -> Result<(), Refusal> {
        let (length, circle) = units.split_once(',').unwrap_or((units, "360"));
        let metres = match length.trim() {
            "m" => 1.0,
            "ft" | "feet" => FOOT,
            _ => return Err(self.wrong(format!("\"{units}\" are no units"), "give (m, 360)")),
        };
        let degrees = match circle.trim() {
            "360" => 1.0,
            "400" => 0.9,
            _ => return Err(self.wrong(format!("\"{units}\" are no units"), "give (m, 360)")),
        };
        self.units = [metres, f64::to_radians(degrees)];
        Ok(())
    }

    /// Reads a row of the export for Therion: `from [to] bearing slope length direction`, between tabs.
    fn row(&mut self, line: &str) -> Result<(), Refusal> {
        let words: Vec<&str> = line.split('\t').map(str::trim).collect();
        let [from, to, bearing, slope, length, ..] = words.as_slice() else {
            let wrong = "the row has too few columns";
            return Err(self.wrong(wrong, "give from, to, bearing, slope and length between tabs"));
        };
        let to = Some(*to).filter(|to| !to.is_empty());
        let [bearing, slope, length] = [bearing, slope, length].map(|word| self.number(word));
        let shot = Shot { from, to, length: length?, bearing: bearing?, slope: slope? };
        if shot.from.is_empty() {
            return Ok(());
        }
        self.shot(&shot, self.declination)
    }

    /// Reads `station east north up`.
    fn fix(&mut self, words: &[&str]) -> Result<(), Refusal> {
        let [name, numbers @ ..] = words else { return Ok(()) };
        let mut at = [0.0; 3];
        if numbers.len() < at.len() {
            let wrong = format!("the coordinates of station \"{name}\" are no three numbers");
            return Err(self.wrong(wrong, "give east, north and up"));
        }
        for (axis, word) in at.iter_mut().zip(numbers) {
            *axis = self.number(word)?;
        }
        // A shot of no length from a station to nowhere looks the same.
        if at == [0.0; 3] {
            return Ok(());
        }
        let (station, source) = (self.draft.station(name, self.source).0, self.source);
        self.draft.fix(Fix { station, at, covariance: None, source, is_reference: true });
        Ok(())
    }

    fn shot(&mut self, shot: &Shot<'_>, declination: f64) -> Result<(), Refusal> {
        let from = self.draft.station(shot.from, self.source).0;
        let to = match shot.to {
            Some(name) => self.draft.station(name, self.source).0,
            None => self.draft.anonymous(true, self.source),
        };
        if shot.length == 0.0 {
            // Such a shot says that two names are of one station.
            if shot.to.is_some() && from != to {
                self.draft.equate(from, to, self.source);
            }
            return Ok(());
        }
        let [metres, radians] = self.units;
        let slope = shot.slope * radians;
        let is_plumb = (slope.abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-9;
        let readings = Readings {
            tape: Some(shot.length * metres),
            compass: Some(shot.bearing * radians),
            clino: match is_plumb {
                true => Slope::Plumb { up: slope > 0.0, is_inferred: true },
                false => Slope::Angle(slope),
            },
            ..Readings::default()
        };
        // Devices show a bearing for a plumbed shot too.
        let measured = measure::normal(&readings, &self.settings, declination, &mut Vec::new())
            .map_err(|(wrong, remedy)| self.wrong(wrong, remedy))?;
        let flags = LegFlags { splay: shot.to.is_none(), ..LegFlags::default() };
        let leg = measured.leg([from, to], flags, self.source);
        self.draft.leg(leg, false)
    }
}
