//! Reads projects of Compass, which list survey files and the stations at which these are joined or
//! fixed.

use super::{datums, read_into};
use crate::draft::{Draft, Fix};
use crate::earth::{Base, System};
use crate::error::Refusal;
use crate::files::{self, Files, Opened};
use crate::matrix::Vector;
use crate::survex::settings::FOOT;
use crate::survex::{MOST_BYTES, MOST_FILES, unopened};
use crate::survey::Source;

/// The deepest that folders are in each other.
const DEEPEST: usize = 100;

/// A character of a project with the number of its line.
type Letter = (char, u32);

/// A project without its comments, each of which reaches from `/` to the next one or to the end of
/// the line. Comments and ends of lines may stand anywhere, even in the name of a file.
fn letters(text: &str) -> Vec<Letter> {
    let mut all = Vec::new();
    for (number, line) in (1..).zip(files::lines(text)) {
        let read = line.split('/').step_by(2).flat_map(str::chars);
        all.extend(read.chain(['\n']).map(|character| (character, number)));
    }
    all
}

/// What is read of a project so far.
struct Project<'a> {
    files: &'a dyn Files,
    entry: &'a str,
    draft: Draft,
    source: Source,
    letters: Vec<Letter>,
    at: usize,
    datum: String,
    zone: i32,
    /// The system of the coordinates of fixed stations, where datum and zone are known.
    system: Option<System>,
    /// The system of the positions: the first one that the project names.
    output: Option<System>,
    /// The place for which declinations are computed: east, north and up, m, and its zone.
    place: Option<(Vector, i32)>,
    base: Option<Base>,
    folders: Vec<String>,
    bytes: usize,
    count: usize,
}

/// Reads a project and the survey files that it lists.
pub(crate) fn project(files: &dyn Files, entry: &str, opened: &Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    let source = Source { file: draft.file(&opened.path), line: 0 };
    draft.require_project(&opened.bytes, source)?;
    let mut project = Project {
        files,
        entry,
        draft,
        source,
        letters: letters(&files::text(&opened.bytes)),
        at: 0,
        datum: String::new(),
        zone: 0,
        system: None,
        output: None,
        place: None,
        base: None,
        folders: Vec::new(),
        bytes: 0,
        count: 0,
    };
    while let Some(key) = project.next_letter() {
        project.command(key)?;
    }
    project.draft.is_on_earth = project.output.is_some();
    Ok(project.draft)
}

impl Project<'_> {
    /// The next character that is no blank, whose line becomes the present one.
    fn next_letter(&mut self) -> Option<char> {
        loop {
            let (letter, line) = *self.letters.get(self.at)?;
            self.at += 1;
            if !letter.is_whitespace() {
                self.source.line = line;
                return Some(letter);
            }
        }
    }

    fn peek(&self) -> Option<char> {
        self.letters.get(self.at).map(|(letter, _)| *letter)
    }

    /// The text up to one of `ends`, which is left.
    fn until(&mut self, ends: &[char]) -> String {
        let mut text = String::new();
        while let Some((letter, line)) = self.letters.get(self.at).copied() {
            if ends.contains(&letter) {
                break;
            }
            if text.trim_start().is_empty() {
                self.source.line = line;
            }
            text.push(letter);
            self.at += 1;
        }
        text
    }

    /// The same for a name, without the ends of lines in it and the blanks around it.
    fn name_until(&mut self, ends: &[char]) -> String {
        self.until(ends).replace('\n', "").trim().to_owned()
    }

    /// The text of a command up to its semicolon, which is read too.
    fn rest(&mut self) -> String {
        let text = self.name_until(&[';']);
        self.at += 1;
        text
    }

    /// Reads the semicolon that ends a command, where it is there.
    fn end(&mut self) {
        let before = self.at;
        if self.next_letter() != Some(';') {
            self.at = before;
        }
    }

    fn wrong(&self, wrong: impl Into<String>, remedy: impl Into<String>) -> Refusal {
        self.draft.wrong(self.source, wrong, remedy)
    }

    fn command(&mut self, key: char) -> Result<(), Refusal> {
        match key {
            '#' => return self.survey(),
            '$' => {
                let number = self.number();
                self.zone = number.map_or(0, |number| number.clamp(-100.0, 100.0) as i32);
                self.end();
                self.set_system();
            }
            '&' => {
                self.datum = self.rest();
                self.set_system();
            }
            '@' => self.base_place(),
            '[' => {
                if self.folders.len() >= DEEPEST {
                    let wrong = format!("folders are in each other {DEEPEST} deep");
                    return Err(self.wrong(wrong, "give a part of the project"));
                }
                let folder = self.rest();
                self.folders.push(folder);
            }
            ']' => {
                if self.folders.pop().is_none() {
                    self.draft.warn(self.source, 0, "this ] closes no folder");
                }
                self.end();
            }
            // The convergence of the grid follows from datum and zone; the rest is for Compass's
            // own windows.
            '%' | '*' | '!' => drop(self.rest()),
            _ => {
                let rest: String = self.rest().chars().take(20).collect();
                let text = format!("the command \"{key}{rest}\" is not known, and passed over");
                self.draft.warn(self.source, 0, text);
            }
        }
        Ok(())
    }

    /// The next number; `None`, and nothing read but blanks, where there is none.
    fn number(&mut self) -> Option<f64> {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
        let mut text = String::new();
        while let Some(letter) = self.peek() {
            let is_sign = text.is_empty() && "+-".contains(letter);
            if !is_sign && !letter.is_ascii_digit() && letter != '.' {
                break;
            }
            text.push(letter);
            self.at += 1;
        }
        text.parse().ok()
    }

    fn set_system(&mut self) {
        self.system = None;
        if self.datum.is_empty() || self.zone == 0 {
            return;
        }
        self.system = self.system_of(self.zone);
        if self.output.is_none() {
            self.output = self.system.clone();
        }
    }

    /// The system of a zone in the present datum, with a remark where it is not known.
    fn system_of(&mut self, zone: i32) -> Option<System> {
        match datums::system(&self.datum, zone) {
            Some((system, false)) => Some(system),
            Some((system, true)) => {
                let text = format!("the datum \"{}\" is taken for WGS 1984", self.datum);
                self.draft.warn(self.source, 0, text);
                Some(system)
            }
            None => {
                let text = format!("zone {zone} of the datum \"{}\" is not known", self.datum);
                self.draft.warn(self.source, 0, text);
                None
            }
        }
    }

    /// Reads `@east,north,up,zone,convergence;`. The datum may follow.
    fn base_place(&mut self) {
        let text = self.rest();
        let mut parts = text.split(',').map(|part| part.trim().parse::<f64>().ok());
        let mut number = || parts.next().flatten().filter(|number| number.abs() < 1e8);
        let (Some(east), Some(north), Some(up), Some(zone)) =
            (number(), number(), number(), number())
        else {
            self.draft.warn(self.source, 0, "this @ gives no place, and is passed over");
            return;
        };
        self.place = Some(([east, north, up], zone as i32)).filter(|(_, zone)| *zone != 0);
    }

    /// Computes what the present @ says, now that the datum is known.
    fn set_base(&mut self) {
        let Some((place, zone)) = self.place.take() else { return };
        if self.datum.is_empty() {
            return;
        }
        let Some(system) = self.system_of(zone) else { return };
        let output = self.output.get_or_insert_with(|| system.clone());
        self.base = Base::new(&system, output, place);
        if self.system.is_none() {
            self.system = Some(system);
        }
        if self.base.is_none() {
            let text = "the place of @ cannot be computed, and is passed over";
            self.draft.warn(self.source, 0, text);
        }
    }

    /// Reads a survey file and its link stations, `#name,A1[f,x,y,z],S2;`.
    fn survey(&mut self) -> Result<(), Refusal> {
        let name = self.name_until(&[',', ';']);
        let named = self.source;
        if !name.is_empty() {
            self.set_base();
            let path = self.folders.iter().map(|folder| folder.as_str()).chain([name.as_str()]);
            let path = path.collect::<Vec<_>>().join("/");
            let found = files::open_named(self.files, self.entry, &path, &[".dat"]);
            let (_, found) = found.map_err(|error| {
                let (wrong, remedy) = unopened(&path, &error);
                self.wrong(wrong, remedy)
            })?;
            self.bytes = self.bytes.saturating_add(found.bytes.len());
            self.count += 1;
            if self.bytes > MOST_BYTES || self.count > MOST_FILES {
                let most = MOST_BYTES >> 20;
                let wrong = format!("the survey has more than {most} MB or {MOST_FILES} files");
                return Err(self.wrong(wrong, "give a part of it"));
            }
            read_into(&mut self.draft, &found, &mut self.base)?;
        }
        self.source = named;
        while self.next_letter() == Some(',') {
            self.link()?;
        }
        Ok(())
    }

    /// Reads a link station up to the comma or the semicolon behind it. One with coordinates is
    /// fixed, and is an entrance, as Compass has it.
    fn link(&mut self) -> Result<(), Refusal> {
        let name = self.name_until(&[',', ';', '[']);
        if self.peek() != Some('[') || name.is_empty() {
            self.until(&[',', ';']);
            return Ok(());
        }
        self.at += 1;
        let at = self.coordinates(&name)?;
        let at = match (&self.system, &self.output) {
            (Some(from), Some(to)) => from.to(to, at).map_err(|_| {
                let wrong = format!("the place of station \"{name}\" cannot be computed");
                self.wrong(wrong, "correct it, or its zone")
            })?,
            _ => at,
        };
        let source = self.source;
        let station = self.draft.station(&name, source).0;
        self.draft.stations[station].is_entrance = true;
        self.draft.fix(Fix { station, at, covariance: None, source, is_reference: true });
        self.until(&[',', ';']);
        Ok(())
    }

    /// Reads a unit and three numbers, with anything between them, up to the closing bracket.
    fn coordinates(&mut self, name: &str) -> Result<Vector, Refusal> {
        let source = self.source;
        let inside = self.until(&[']']);
        let inside = inside.trim_start();
        self.source = source;
        if self.peek().is_none() {
            return Err(self.wrong("a bracket is not closed", "add ]"));
        }
        self.at += 1;
        let factor = match inside.chars().next() {
            Some('f' | 'F') => FOOT,
            Some('m' | 'M') => 1.0,
            _ => return Err(self.wrong("a fixed station has no unit", "give f or m")),
        };
        let part = |letter: char| letter.is_ascii_digit() || "+-.".contains(letter);
        let rest = inside.get(1..).unwrap_or_default();
        let numbers = rest.split(|letter| !part(letter)).filter(|text| !text.is_empty());
        let numbers: Vec<Option<f64>> = numbers.map(|text| text.parse().ok()).collect();
        let [Some(x), Some(y), Some(z)] = numbers.as_slice() else {
            let wrong = format!("the coordinates of station \"{name}\" are no three numbers");
            return Err(self.wrong(wrong, "give east, north and up"));
        };
        let at = [*x, *y, *z].map(|x| x * factor);
        if !at.iter().all(|x| x.abs() < 1e9) {
            let wrong = format!("the coordinates of station \"{name}\" are too large");
            return Err(self.wrong(wrong, "correct them"));
        }
        Ok(at)
    }
}
