//! Reads the processed surveys of Survex, `.3d`, version 8, as Survex's document "Survex 3d Format
//! Specification" describes it.
//!
//! Such a file has positions and no measurements: legs are lines between coordinates in whole
//! centimetres, a station is a label at coordinates, and no misclosure is known any more. A leg's end where no label is becomes a
//! station without a name.

use std::collections::HashMap;

use crate::draft::{MOST_ITEMS, MOST_LEGS, MOST_WARNINGS};
use crate::error::{Place, Refusal, Warning};
use crate::files::Opened;
use crate::matrix::Vector;
use crate::sets::Sets;
use crate::survey::{CrossSection, Leg, LegFlags, Source, Station, Survey};

/// The bytes of a file, read one after the other.
struct Bytes<'a> {
    rest: &'a [u8],
    path: &'a str,
    length: usize,
}

impl<'a> Bytes<'a> {
    fn wrong(&self, wrong: impl Into<String>) -> Refusal {
        let at = self.length - self.rest.len();
        let place = Place { file: self.path.into(), line: 0, column: 0 };
        let wrong = format!("{} (at byte {at})", wrong.into());
        Refusal::new(wrong, "process the survey anew with cavern").at(place)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        if self.rest.len() < count {
            return Err(self.wrong("the file ends in the middle of an item"));
        }
        let (taken, rest) = self.rest.split_at(count);
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Refusal> {
        Ok(self.take(1)?.first().copied().unwrap_or(0))
    }

    fn word(&mut self) -> Result<i32, Refusal> {
        let bytes = self.take(4)?;
        Ok(bytes.try_into().map_or(0, i32::from_le_bytes))
    }

    fn half(&mut self) -> Result<i16, Refusal> {
        let bytes = self.take(2)?;
        Ok(bytes.try_into().map_or(0, i16::from_le_bytes))
    }

    fn line(&mut self) -> Result<&'a [u8], Refusal> {
        let Some(end) = self.rest.iter().position(|&byte| byte == b'\n') else {
            return Err(self.wrong("the head is not complete"));
        };
        let line = self.take(end)?;
        self.take(1)?;
        Ok(line)
    }

    /// Coordinates, cm.
    fn point(&mut self) -> Result<[i32; 3], Refusal> {
        Ok([self.word()?, self.word()?, self.word()?])
    }

    /// The number of bytes to take from, or to add to, the label.
    fn count(&mut self) -> Result<usize, Refusal> {
        match self.byte()? {
            255 => {
                let long = self.word()?;
                usize::try_from(long).map_err(|_| self.wrong("a label has no sensible length"))
            }
            short => Ok(usize::from(short)),
        }
    }

    /// Changes the label as an item says.
    fn relabel(&mut self, label: &mut Vec<u8>) -> Result<(), Refusal> {
        let (cut, add) = match self.byte()? {
            0 => (self.count()?, self.count()?),
            both => (usize::from(both >> 4), usize::from(both & 15)),
        };
        let Some(kept) = label.len().checked_sub(cut) else {
            return Err(self.wrong("a label is cut shorter than it is"));
        };
        label.truncate(kept);
        label.extend_from_slice(self.take(add)?);
        if label.len() > LONGEST {
            return Err(self.wrong(format!("a label is longer than {LONGEST} bytes")));
        }
        Ok(())
    }
}

/// The longest label, in bytes.
const LONGEST: usize = 4096;

/// What is read of the file.
#[derive(Default)]
struct Image {
    survey: Survey,
    /// The first station at each point.
    at: HashMap<[i32; 3], usize>,
    names: HashMap<Vec<u8>, usize>,
    passage: Vec<CrossSection>,
    /// How many cross-sections there are.
    sections: usize,
}

impl Image {
    /// The first station at a point, or a new one without a name.
    fn station(&mut self, at: [i32; 3]) -> usize {
        if let Some(&known) = self.at.get(&at) {
            return known;
        }
        self.label(Vec::new(), at, 0)
    }

    fn label(&mut self, name: Vec<u8>, at: [i32; 3], flags: u8) -> usize {
        let number = self.survey.stations.len();
        let point = self.at.get(&at).map_or(number, |&first| first);
        self.at.entry(at).or_insert(number);
        let is_named = flags & ANONYMOUS == 0 && !name.is_empty();
        self.survey.stations.push(Station {
            name: if is_named {
                String::from_utf8_lossy(&name).into_owned()
            } else {
                String::new()
            },
            position: metres(at),
            point,
            is_wall: flags & WALL != 0,
            is_entrance: flags & ENTRANCE != 0,
            source: Source::default(),
        });
        if is_named {
            self.names.insert(name, number);
        }
        number
    }
}

const ENTRANCE: u8 = 0x04;
const ANONYMOUS: u8 = 0x20;
const WALL: u8 = 0x40;

fn metres(at: [i32; 3]) -> Vector {
    at.map(|x| f64::from(x) / 100.0)
}

/// A leg whose ends are not yet stations: labels may come after it.
struct Line {
    ends: [[i32; 3]; 2],
    flags: u8,
    is_measured: bool,
    is_dived: bool,
}

/// Reads a `.3d` file.
pub(crate) fn read(opened: Opened) -> Result<Survey, Refusal> {
    let mut bytes = Bytes { rest: &opened.bytes, path: &opened.path, length: opened.bytes.len() };
    let mut image = Image::default();
    image.survey.title = head(&mut bytes)?;
    let (mut label, mut here) = (Vec::new(), [0; 3]);
    let mut lines: Vec<Line> = Vec::new();
    let mut style = None;
    loop {
        let code = bytes.byte()?;
        match code {
            // The style of tape, compass and clino, set where it is set already, ends the file.
            0 if style == Some(0) => break,
            0..=4 => style = Some(code),
            0x0f => here = bytes.point()?,
            0x10 => {}
            0x11 => drop(bytes.take(2)?),
            0x12 => drop(bytes.take(3)?),
            0x13 => drop(bytes.take(4)?),
            // How well a traverse closes, as a ratio to what its instruments let expect: no metres.
            0x1f => drop(bytes.take(20)?),
            0x30..=0x33 => cross_section(&mut bytes, code, &mut label, &mut image)?,
            0x40..=0x7f => {
                if code & 0x20 == 0 {
                    bytes.relabel(&mut label)?;
                }
                let there = bytes.point()?;
                if lines.len() >= MOST_LEGS {
                    return Err(bytes.wrong(format!("there are more than {MOST_LEGS} legs")));
                }
                lines.push(Line {
                    ends: [here, there],
                    flags: code & 7,
                    is_measured: style != Some(4),
                    // Both styles with a depth gauge, diving and cylpolar.
                    is_dived: matches!(style, Some(1 | 3)),
                });
                here = there;
            }
            0x80..=0xff => {
                bytes.relabel(&mut label)?;
                let at = bytes.point()?;
                if image.survey.stations.len() >= MOST_ITEMS {
                    return Err(bytes.wrong(format!("there are more than {MOST_ITEMS} stations")));
                }
                if !image.names.contains_key(&label) || code & ANONYMOUS != 0 {
                    image.label(label.clone(), at, code & 0x7f);
                }
            }
            _ => return Err(bytes.wrong(format!("there is no item of code {code:#04x}"))),
        }
    }
    close_passage(&mut image);
    Ok(finish(image, &lines))
}

/// Reads the head; returns the title.
fn head(bytes: &mut Bytes<'_>) -> Result<Option<String>, Refusal> {
    if bytes.line().ok() != Some(b"Survex 3D Image File") {
        return Err(bytes.wrong("this is no 3d file of Survex"));
    }
    let version = bytes.line()?;
    if version != b"v8" {
        let version = String::from_utf8_lossy(version).into_owned();
        return Err(bytes.wrong(format!("this is version {version:?} of the format, not v8")));
    }
    let title = bytes.line()?.split(|&byte| byte == 0).next().unwrap_or_default();
    bytes.line()?;
    bytes.byte()?;
    let title = String::from_utf8_lossy(title).into_owned();
    Ok(Some(title).filter(|title| !title.is_empty()))
}

fn cross_section(
    bytes: &mut Bytes<'_>,
    code: u8,
    label: &mut Vec<u8>,
    image: &mut Image,
) -> Result<(), Refusal> {
    image.sections += 1;
    if image.sections > MOST_ITEMS {
        return Err(bytes.wrong(format!("there are more than {MOST_ITEMS} dimensions")));
    }
    bytes.relabel(label)?;
    let mut sides = [None; 4];
    for side in &mut sides {
        let centimetres = if code >= 0x32 { bytes.word()? } else { i32::from(bytes.half()?) };
        *side = (centimetres >= 0).then_some(f64::from(centimetres) / 100.0);
    }
    let [left, right, up, down] = sides;
    match image.names.get(label) {
        Some(&station) => image.passage.push(CrossSection { station, left, right, up, down }),
        None => {
            let name = String::from_utf8_lossy(label).into_owned();
            let text = format!("dimensions of \"{name}\", which is no station, are left out");
            if image.survey.warnings.len() < MOST_WARNINGS {
                image.survey.warnings.push(Warning { place: None, text });
            }
        }
    }
    if code & 1 != 0 {
        close_passage(image);
    }
    Ok(())
}

fn close_passage(image: &mut Image) {
    let passage = std::mem::take(&mut image.passage);
    if !passage.is_empty() {
        image.survey.passages.push(passage);
    }
}

fn finish(mut image: Image, lines: &[Line]) -> Survey {
    for line in lines {
        let [from, to] = line.ends.map(|end| image.station(end));
        let flags = LegFlags {
            surface: line.flags & 1 != 0,
            duplicate: line.flags & 2 != 0,
            splay: line.flags & 4 != 0,
            dived: line.is_dived,
            squeeze: false,
        };
        let [a, b] = line.ends.map(metres);
        let length = crate::matrix::norm(crate::matrix::sub(b, a));
        let length = line.is_measured.then_some(length);
        image.survey.legs.push(Leg { from, to, flags, length, source: Source::default() });
    }
    let mut survey = image.survey;
    // Stations at one point hang together, so that each name but the first is joined by itself.
    let mut sets = Sets::new(survey.stations.len());
    let mut components = survey.stations.len();
    let points: Vec<usize> = survey.stations.iter().map(|station| station.point).collect();
    let mut joined = 0;
    for (number, &point) in points.iter().enumerate() {
        if sets.join(number, point) {
            components -= 1;
            joined += 1;
        }
    }
    let measured = survey.legs.iter().filter(|leg| leg.length.is_some());
    let mut legs = 0;
    for leg in measured {
        legs += 1;
        components -= usize::from(sets.join(leg.from, leg.to));
    }
    survey.loops = (legs + joined + components).saturating_sub(survey.stations.len());
    survey
}
