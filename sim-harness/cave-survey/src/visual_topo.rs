//! Reads the files of VisualTopo, `.tro`.
//!
//! The program's own documentation says little of them: the columns are those that its users' tools
//! write and read, TopoDroid's and Survex's among them. `Param` says how the shots behind it were
//! measured; what it says and is not read here is refused.

use crate::draft::Draft;
use crate::error::Refusal;
use crate::files::{self, Opened};
use crate::survex::measure::{self, Readings, Slope};
use crate::survex::settings::Settings;
use crate::survey::{CrossSection, LegFlags, Source, StationId};

/// A unit of angles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unit {
    Degrees,
    /// Degrees, and minutes in the place of the decimals: 12.30 is 12° 30′.
    Minutes,
    Grads,
}

impl Unit {
    fn named(name: &str) -> Option<Self> {
        match name {
            "Degd" => Some(Self::Degrees),
            "Deg" => Some(Self::Minutes),
            "Gra" => Some(Self::Grads),
            _ => None,
        }
    }

    fn radians(self, number: f64) -> f64 {
        match self {
            Self::Degrees => number.to_radians(),
            Self::Minutes => (number.trunc() + number.fract() / 0.6).to_radians(),
            Self::Grads => (number * 0.9).to_radians(),
        }
    }
}

/// What `Param` says.
#[derive(Clone, Copy, Debug)]
struct Param {
    compass: Unit,
    clino: Unit,
    /// The declination, rad.
    declination: f64,
    /// Whether dimensions are those at the second station.
    is_at_second: bool,
}

impl Default for Param {
    fn default() -> Self {
        let unit = Unit::Degrees;
        Self { compass: unit, clino: unit, declination: 0.0, is_at_second: true }
    }
}

/// What is read of a file so far.
struct Reader {
    draft: Draft,
    source: Source,
    settings: Settings,
    param: Param,
    /// The second station of the shot before, which `*` stands for.
    before: Option<StationId>,
    /// The station at which the last shot with dimensions ended.
    last: Option<StationId>,
    entrances: Vec<String>,
}

/// Reads one file.
pub(crate) fn read(opened: &Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    let source = Source { file: draft.file(&opened.path), line: 0 };
    let settings = Settings::default();
    let param = Param::default();
    let entrances = Vec::new();
    let mut reader = Reader { draft, source, settings, param, before: None, last: None, entrances };
    let text = files::text(&opened.bytes);
    for line in files::lines(&text) {
        reader.source.line = reader.source.line.saturating_add(1);
        reader.draft.require_line(line, reader.source)?;
        let line = line.split(';').next().unwrap_or(line).trim();
        // What follows is of the program's windows.
        if line.starts_with("[Configuration") {
            break;
        }
        reader.line(line)?;
    }
    for name in std::mem::take(&mut reader.entrances) {
        if let Some(station) = reader.draft.known(&name) {
            reader.draft.stations[station].is_entrance = true;
        }
    }
    Ok(reader.draft)
}

impl Reader {
    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        self.draft.wrong(self.source, wrong, remedy)
    }

    fn line(&mut self, line: &str) -> Result<(), Refusal> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((key, rest)) = words.split_first() else { return Ok(()) };
        match *key {
            "Version" | "Verification" | "Club" | "Couleur" | "Surface" | "Toporobot" => {}
            "Trou" => {
                let name = line.get(4..).unwrap_or_default().split(',').next().unwrap_or_default();
                if !name.trim().is_empty() {
                    self.draft.title.get_or_insert_with(|| name.trim().to_owned());
                }
            }
            "Entree" => {
                self.entrances.extend(rest.first().map(|name| (*name).to_owned()));
                self.draft.count_item();
            }
            "Param" => {
                self.param = self.read_param(rest)?;
                self.draft.end_repeats();
            }
            _ => self.shot(&words)?,
        }
        Ok(())
    }

    /// Reads `Deca unit Clino unit declination Dir,Dir,Dir [Arr|Dep] …`.
    fn read_param(&self, words: &[&str]) -> Result<Param, Refusal> {
        let mut param = Param::default();
        let not_read = |what: &str| {
            let wrong = format!("shots of VisualTopo by \"{what}\" are not read");
            self.wrong(wrong, "export a .3d or a .svx")
        };
        let [tape, compass, clino, slope, rest @ ..] = words else {
            return Err(
                self.wrong("Param is too short", "give Deca Degd Clino Degd 0.0 Dir,Dir,Dir")
            );
        };
        for (word, known) in [(tape, "Deca"), (clino, "Clino")] {
            if *word != known {
                return Err(not_read(word));
            }
        }
        param.compass = Unit::named(compass).ok_or_else(|| not_read(compass))?;
        param.clino = Unit::named(slope).ok_or_else(|| not_read(slope))?;
        for (place, word) in rest.iter().enumerate() {
            match *word {
                "Arr" => param.is_at_second = true,
                "Dep" => param.is_at_second = false,
                _ if word.split(',').any(|part| part == "Inv") => return Err(not_read(word)),
                number if place == 0 => {
                    let angle = number.parse::<f64>().ok().filter(|angle| angle.abs() < 360.0);
                    let wrong =
                        || self.wrong(format!("\"{number}\" is no declination"), "give degrees");
                    param.declination = angle.ok_or_else(wrong)?.to_radians();
                }
                _ => {}
            }
        }
        Ok(param)
    }

    /// The number of a word; `None` where it was left out.
    fn number(&self, word: &str) -> Result<Option<f64>, Refusal> {
        if matches!(word, "*" | "-") {
            return Ok(None);
        }
        let number = word.parse::<f64>().ok().filter(|number| number.abs() < 1e9);
        let wrong = || self.wrong(format!("\"{word}\" is no number"), "give one, or * for none");
        number.ok_or_else(wrong).map(Some)
    }

    /// Reads `from to length bearing slope left right up down N I …`, where `*` stands for the station
    /// before, or for a point on the wall.
    fn shot(&mut self, words: &[&str]) -> Result<(), Refusal> {
        let [from, to, length, bearing, slope, rest @ ..] = words else {
            let wrong = format!("\"{}\" is no shot", words.join(" "));
            return Err(self.wrong(wrong, "give from, to, length, bearing and slope"));
        };
        let from = match (*from, self.before) {
            ("*", Some(before)) => before,
            ("*", None) => return Err(self.wrong("no shot is before this *", "name the station")),
            (name, _) => self.draft.station(name, self.source).0,
        };
        let is_splay = *to == "*";
        let to = match is_splay {
            true => self.draft.anonymous(true, self.source),
            false => self.draft.station(to, self.source).0,
        };
        if !is_splay {
            self.before = Some(to);
        }
        let (length, bearing, slope) =
            (self.number(length)?, self.number(bearing)?, self.number(slope)?);
        if !is_splay {
            self.dimensions([from, to], rest)?;
        }
        // The first shot leads from the entrance to itself, and gives its dimensions.
        if from == to {
            return Ok(());
        }
        // Behind the dimensions stands how the shot is drawn, and then whether it counts.
        let is_excluded = rest.get(5) == Some(&"E");
        let readings = Readings {
            tape: length,
            compass: bearing.map(|bearing| self.param.compass.radians(bearing)),
            clino: self.slope(slope),
            ..Readings::default()
        };
        let mut remarks = Vec::new();
        let measured =
            measure::normal(&readings, &self.settings, self.param.declination, &mut remarks)
                .map_err(|(wrong, remedy)| self.wrong(wrong, remedy))?;
        for remark in remarks {
            self.draft.warn(self.source, 0, remark);
        }
        let flags = LegFlags {
            duplicate: is_excluded && !is_splay,
            splay: is_splay,
            ..LegFlags::default()
        };
        let leg = measured.leg([from, to], flags, self.source);
        self.draft.leg(leg, false)
    }

    fn slope(&mut self, slope: Option<f64>) -> Slope {
        let Some(angle) = slope.map(|slope| self.param.clino.radians(slope)) else {
            return Slope::Omitted;
        };
        let off_plumb = angle.abs() - std::f64::consts::FRAC_PI_2;
        if off_plumb.abs() < 1e-9 {
            return Slope::Plumb { up: angle > 0.0, is_inferred: true };
        }
        if off_plumb > 0.0 {
            self.draft.warn(self.source, 0, "the clino reading is over a right angle");
        }
        Slope::Angle(angle)
    }

    fn dimensions(&mut self, [from, to]: [StationId; 2], words: &[&str]) -> Result<(), Refusal> {
        let mut sides = [None; 4];
        for (side, word) in sides.iter_mut().zip(words) {
            *side = self.number(word)?.filter(|size| (0.0..1e6).contains(size));
        }
        let [left, right, up, down] = sides;
        let [station, before] = if self.param.is_at_second { [to, from] } else { [from, from] };
        let section = CrossSection { station, left, right, up, down };
        if section.is_measured() {
            let goes_on = self.last == Some(before);
            self.draft.cross_section(section, self.source, goes_on);
        }
        self.last = section.is_measured().then_some(to);
        Ok(())
    }
}
