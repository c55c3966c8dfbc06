//! Reads the files of Compass: surveys, `.dat`, and projects, `.mak`, that list them.
//!
//! The format is that of Compass's own help pages, "Survey data file format" and "Project file
//! format", and what `cavern` 1.4.4 makes of it where they leave a choice. Numbers are in feet and
//! degrees whatever the header says of the notes. Compass's coordinates of a base and its grid's
//! convergence move nothing here, as they move nothing there.

use crate::draft::{Draft, DraftLeg, Fix};
use crate::error::Refusal;
use crate::files::{self, Files, Opened};
use crate::survex::characters::{Characters, Cursor};
use crate::survex::measure::{self, Readings, Slope};
use crate::survex::settings::{Declination, FOOT, Infer, Quantity, Settings};
use crate::survex::{MOST_BYTES, unopened};
use crate::survey::{CrossSection, LegFlags, Source, StationId};

/// A reading at or below this is one that was left out: Compass writes −999 or −9999.
const MISSING: f64 = -900.0;

/// The character that separates the surveys of a file.
const FORM_FEED: u8 = 0x0c;

/// Reads one survey file.
pub(crate) fn survey(opened: Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    read_into(&mut draft, &opened)?;
    Ok(draft)
}

/// What the header of a survey says of its lines.
struct Header {
    settings: Settings,
    /// Whether lines have backsights after the dimensions.
    has_backsights: bool,
    /// Whether dimensions are those at the second station.
    is_at_second: bool,
}

impl Default for Header {
    fn default() -> Self {
        let infer = Infer { plumbs: true, equates: true, exports: false };
        let settings = Settings { infer, ..Settings::default() };
        Self { settings, has_backsights: false, is_at_second: false }
    }
}

impl Header {
    /// Reads the line `DECLINATION: d FORMAT: f CORRECTIONS: c b l CORRECTIONS2: c2 b2`.
    fn read(&mut self, line: &str) {
        *self = Self::default();
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |n: usize| words.get(n).and_then(|word| word.parse::<f64>().ok());
        let degrees = |n: usize| number(n).filter(|x| x.is_finite()).unwrap_or(0.0).to_radians();
        for (n, word) in words.iter().enumerate() {
            match *word {
                "DECLINATION:" => {
                    self.settings.declination = Declination::Given(degrees(n + 1));
                }
                "FORMAT:" => {
                    let format = words.get(n + 1).map_or(&b""[..], |word| word.as_bytes());
                    // Twelve or more letters: the unit of each item, their order, and flags.
                    self.has_backsights =
                        format.get(11) == Some(&b'B') || format.get(14) == Some(&b'B');
                    self.is_at_second = format.len() > 11 && format.last() == Some(&b'T');
                }
                // Corrections are added, where a zero error is taken away.
                "CORRECTIONS:" => {
                    self.settings.change(Quantity::Bearing).zero = -degrees(n + 1);
                    self.settings.change(Quantity::Gradient).zero = -degrees(n + 2);
                    let length = number(n + 3).filter(|x| x.is_finite()).unwrap_or(0.0);
                    self.settings.change(Quantity::Length).zero = -length * FOOT;
                }
                "CORRECTIONS2:" => {
                    self.settings.change(Quantity::BackBearing).zero = -degrees(n + 1);
                    self.settings.change(Quantity::BackGradient).zero = -degrees(n + 2);
                }
                _ => {}
            }
        }
    }
}

/// The part of a file that a line belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Before the line of the declination.
    Head,
    /// Before the names of the columns.
    Columns,
    Lines,
}

fn read_into(draft: &mut Draft, opened: &Opened) -> Result<(), Refusal> {
    let file = draft.file(&opened.path);
    let characters = Characters::compass();
    let (mut header, mut part) = (Header::default(), Part::Head);
    let mut last: Option<StationId> = None;
    let mut any = false;
    for (number, line) in opened.bytes.split(|&byte| byte == b'\n').enumerate() {
        let source = Source { file, line: u32::try_from(number + 1).unwrap_or(u32::MAX) };
        // What stands before a form feed in its line belongs to the survey that it ends.
        for (piece, line) in line.split(|&byte| byte == FORM_FEED).enumerate() {
            if piece > 0 {
                (part, last) = (Part::Head, None);
            }
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let line = line.strip_suffix(b"\x1a").unwrap_or(line);
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let text = String::from_utf8_lossy(line);
            match part {
                Part::Head if text.trim_start().starts_with("DECLINATION:") => {
                    header.read(&text);
                    part = Part::Columns;
                }
                Part::Head => {}
                Part::Columns => {
                    let mut words = text.split_whitespace();
                    if words.next() != Some("FROM") {
                        let wrong = "the names of the columns are missing";
                        let remedy = "add the line FROM TO LENGTH BEARING …";
                        return Err(draft.wrong(source, wrong, remedy));
                    }
                    (part, any) = (Part::Lines, true);
                }
                Part::Lines => {
                    shot(draft, &header, Cursor::new(line), &characters, source, &mut last)?
                }
            }
        }
    }
    draft.end_repeats();
    if !any {
        let source = Source { file, line: 0 };
        let wrong = "there is no survey in it, with DECLINATION: and FROM TO LENGTH …";
        return Err(draft.wrong(source, wrong, "give a survey file of Compass"));
    }
    Ok(())
}

/// Reads a line of a survey: `FROM TO LENGTH BEARING INC LEFT UP DOWN RIGHT [AZM2 INC2] [#|flags#]`.
fn shot(
    draft: &mut Draft,
    header: &Header,
    mut cursor: Cursor<'_>,
    characters: &Characters,
    source: Source,
    last: &mut Option<StationId>,
) -> Result<(), Refusal> {
    let mut name = |draft: &mut Draft| {
        let word = String::from_utf8_lossy(cursor.word(characters)).into_owned();
        if word.is_empty() {
            return Err(draft.wrong(source, "the name of a station is missing", "give it"));
        }
        Ok(draft.station(&word, source).0)
    };
    let (from, to) = (name(draft)?, name(draft)?);
    let count = if header.has_backsights { 9 } else { 7 };
    let mut numbers = [None; 9];
    for number in numbers.iter_mut().take(count) {
        cursor.skip_blanks(characters);
        let column = cursor.column();
        let Some(read) = cursor.number(characters) else {
            let word = String::from_utf8_lossy(cursor.word(characters)).into_owned();
            let refusal = Refusal::new(
                format!("\"{word}\" is no number, where the line wants {count} after the names"),
                "give it, or -999 where it was not measured",
            );
            return Err(match draft.place(source, column) {
                Some(place) => refusal.at(place),
                None => refusal,
            });
        };
        *number = Some(read).filter(|read| *read > MISSING);
    }
    let flags = String::from_utf8_lossy(cursor.rest()).trim_start().to_owned();
    let flags = flags.strip_prefix("#|").and_then(|rest| rest.split('#').next()).unwrap_or("");
    if flags.contains('X') {
        *last = None;
        return Ok(());
    }
    let [length, bearing, slope, left, up, down, right, back_bearing, back_slope] = numbers;
    let dimension = |number: Option<f64>| number.filter(|number| *number >= 0.0).map(|x| x * FOOT);
    let at = if header.is_at_second { to } else { from };
    let section = CrossSection {
        station: at,
        left: dimension(left),
        right: dimension(right),
        up: dimension(up),
        down: dimension(down),
    };
    if section.is_measured() {
        let goes_on = last.is_some_and(|last| last == if header.is_at_second { from } else { at });
        draft.cross_section(section, source, goes_on);
    }
    *last = section.is_measured().then_some(to);
    if length == Some(0.0) || from == to {
        if from == to {
            draft.warn(source, 0, "the shot leads from a station to itself");
        } else {
            draft.equate(from, to, source);
        }
        return Ok(());
    }
    let angle = |slope: Option<f64>| match slope {
        None => Slope::Omitted,
        Some(slope) if slope.abs() == 90.0 => Slope::Plumb { up: slope > 0.0, is_inferred: true },
        Some(slope) => Slope::Angle(slope.to_radians()),
    };
    let readings = Readings {
        tape: length.map(|length| length * FOOT),
        compass: bearing.map(f64::to_radians),
        back_compass: back_bearing.map(f64::to_radians),
        clino: angle(slope),
        back_clino: angle(back_slope),
        ..Readings::default()
    };
    let declination = match header.settings.declination {
        Declination::Given(angle) => angle,
        Declination::Of { .. } => 0.0,
    };
    let mut remarks = Vec::new();
    let measured = measure::normal(&readings, &header.settings, declination, &mut remarks)
        .map_err(|(wrong, remedy)| draft.wrong(source, wrong, remedy))?;
    for remark in remarks {
        draft.warn(source, 0, remark);
    }
    let leg = DraftLeg {
        from,
        to,
        vector: measured.vector,
        covariance: measured.covariance,
        length: measured.length,
        flags: LegFlags { duplicate: flags.contains('L'), ..LegFlags::default() },
        source,
        repeats: 1,
    };
    draft.leg(leg, false)
}

/// Reads a project and the survey files that it lists.
pub(crate) fn project(files: &dyn Files, entry: &str, opened: Opened) -> Result<Draft, Refusal> {
    let mut draft = Draft::default();
    let file = draft.file(&opened.path);
    let text = String::from_utf8_lossy(&opened.bytes).into_owned();
    let mut bytes = 0usize;
    for (line, command) in commands(&text) {
        let source = Source { file, line };
        // Other commands set a datum, a zone, a base, a convergence, or open folders.
        let Some(command) = command.strip_prefix('#') else { continue };
        let (name, links) = command.split_once(',').unwrap_or((command, ""));
        let name = name.trim();
        let found = files::open_named(files, entry, name, &[".dat"]);
        let (_, found) = found.map_err(|error| {
            let (wrong, remedy) = unopened(name, &error);
            draft.wrong(source, wrong, remedy)
        })?;
        bytes = bytes.saturating_add(found.bytes.len());
        if bytes > MOST_BYTES {
            let wrong = format!("the survey has more than {} MB", MOST_BYTES >> 20);
            return Err(draft.wrong(source, wrong, "give a part of it"));
        }
        fixes(&mut draft, links, source)?;
        read_into(&mut draft, &found)?;
    }
    Ok(draft)
}

/// The commands of a project, each with the line at which it begins. A command ends with `;`; a line
/// that begins with `/` is a comment.
fn commands(text: &str) -> Vec<(u32, String)> {
    let mut all = Vec::new();
    let mut command = String::new();
    let mut begin = 1;
    for (number, line) in (1..).zip(text.lines()) {
        if line.starts_with('/') {
            continue;
        }
        for character in line.chars() {
            if command.is_empty() && !character.is_whitespace() {
                begin = number;
            }
            match character {
                ';' => all.push((begin, std::mem::take(&mut command))),
                character if command.is_empty() && character.is_whitespace() => {}
                character => command.push(character),
            }
        }
    }
    all
}

/// Reads the link stations behind a file's name, `A1[f,x,y,z],S2`: those with coordinates, in feet
/// or metres, are fixed.
fn fixes(draft: &mut Draft, links: &str, source: Source) -> Result<(), Refusal> {
    let mut rest = links;
    while let Some((before, behind)) = rest.split_once('[') {
        let Some((inside, after)) = behind.split_once(']') else {
            return Err(draft.wrong(source, "a bracket is not closed", "add ]"));
        };
        let name = before.rsplit(',').next().unwrap_or(before).trim().to_owned();
        let mut parts = inside.split(',').map(str::trim);
        let factor = match parts.next() {
            Some("f" | "F") => FOOT,
            Some("m" | "M") => 1.0,
            _ => return Err(draft.wrong(source, "a fixed station has no unit", "give f or m")),
        };
        let numbers: Vec<f64> = parts.filter_map(|part| part.parse().ok()).collect();
        let Ok(at) = <[f64; 3]>::try_from(numbers) else {
            let wrong = format!("the coordinates of station \"{name}\" are no three numbers");
            return Err(draft.wrong(source, wrong, "give east, north and up"));
        };
        let at = at.map(|x| x * factor);
        if !at.iter().all(|x| x.abs() < 1e9) {
            let wrong = format!("the coordinates of station \"{name}\" are too large");
            return Err(draft.wrong(source, wrong, "correct them"));
        }
        let station = draft.station(&name, source).0;
        draft.fix(Fix { station, at, covariance: None, source, is_reference: false });
        rest = after;
    }
    Ok(())
}
