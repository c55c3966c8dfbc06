//! Reads projects of Walls: a tree of books and the survey files in them.

use super::units::Units;
use super::{Earth, Reader};
use crate::draft::Draft;
use crate::earth::System;
use crate::error::Refusal;
use crate::files::{self, Files, Opened};
use crate::survex::{MOST_BYTES, MOST_FILES, unopened};
use crate::survey::Source;

/// The bit of `.STATUS` of what is not processed with the book that it is in. The outermost book
/// has it always.
const DETACHED: u32 = 1 << 1;
/// The bit of what is no survey.
const OTHER: u32 = 1 << 16;
/// The deepest that books are in each other.
const DEEPEST: usize = 100;

/// The kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EntryKind {
    Book,
    Survey,
    EndBook,
}

/// An entry of the project with what it says of itself.
struct Entry<'a> {
    kind: EntryKind,
    title: &'a str,
    /// The line of its name, or else its first.
    line: u32,
    pub name: &'a str,
    path: &'a str,
    status: u32,
    /// The lines of its options.
    options: Vec<(u32, &'a str)>,
    reference: Option<(u32, &'a str)>,
}

/// What the entries of a book inherit.
#[derive(Clone)]
struct Book {
    folder: String,
    units: Units,
    earth: Option<Earth>,
}

/// Reads a project and the survey files that it lists.
pub(crate) fn project(files: &dyn Files, entry: &str, opened: &Opened) -> Result<Draft, Refusal> {
    let mut reader = Reader::default();
    let file = reader.draft.file(&opened.path);
    let text = files::text(&opened.bytes).into_owned();
    reader.source = Source { file, line: 0 };
    reader.draft.require_project(&opened.bytes, reader.source)?;
    let entries = reader.entries(&text);
    let mut books: Vec<Book> = Vec::new();
    // How many books are open in one that is not processed, that one included.
    let mut detached = 0usize;
    let (mut bytes, mut count) = (0usize, 0usize);
    for item in &entries {
        reader.source = Source { file, line: item.line };
        match item.kind {
            EntryKind::Book if detached > 0 => detached += 1,
            EntryKind::EndBook if detached > 0 => detached -= 1,
            _ if detached > 0 => {}
            EntryKind::EndBook => {
                if books.pop().is_none() {
                    return Err(reader.wrong("this .ENDBOOK has no .BOOK", "remove it"));
                }
            }
            EntryKind::Book if item.status & DETACHED != 0 && !books.is_empty() => {
                reader.remark(format!("the book \"{}\" is detached, and passed over", item.title));
                detached = 1;
            }
            EntryKind::Book => {
                if books.len() >= DEEPEST {
                    let wrong = format!("books are in each other {DEEPEST} deep");
                    return Err(reader.wrong(wrong, "give a part of the project"));
                }
                if books.is_empty() && !item.title.is_empty() {
                    reader.draft.title.get_or_insert_with(|| item.title.to_owned());
                }
                let book = reader.inherited(books.last(), item)?;
                books.push(book);
            }
            EntryKind::Survey if item.status & OTHER != 0 || item.name.is_empty() => {}
            EntryKind::Survey if item.status & DETACHED != 0 => {
                reader.remark(format!("survey \"{}\" is detached, and passed over", item.title));
            }
            EntryKind::Survey => {
                let book = reader.inherited(books.last(), item)?;
                (reader.units, reader.earth) = (book.units, book.earth);
                let name = format!("{}{}", book.folder, item.name);
                let found = files::open_named(files, entry, &name, &[".srv"]);
                let (_, found) = found.map_err(|error| {
                    let (wrong, remedy) = unopened(&format!("{name}.srv"), &error);
                    reader.wrong(wrong, remedy)
                })?;
                bytes = bytes.saturating_add(found.bytes.len());
                count += 1;
                if bytes > MOST_BYTES || count > MOST_FILES {
                    let most = MOST_BYTES >> 20;
                    let wrong = format!("the survey has more than {most} MB or {MOST_FILES} files");
                    return Err(reader.wrong(wrong, "give a part of it"));
                }
                reader.last_declination = None;
                reader.file(&found)?;
            }
        }
    }
    Ok(reader.finished())
}

impl Reader {
    /// Cuts a project into its entries.
    fn entries<'t>(&mut self, text: &'t str) -> Vec<Entry<'t>> {
        let mut all: Vec<Entry<'t>> = Vec::new();
        for (line, text) in (1..).zip(text.lines()) {
            let Some(command) = text.trim().strip_prefix('.') else { continue };
            let end = command.find(char::is_whitespace).unwrap_or(command.len());
            let (key, value) = command.split_at(end);
            let value = value.trim();
            let mut begin = |kind| {
                let (name, path, title) = ("", "", value);
                let (status, options, reference) = (0, Vec::new(), None);
                all.push(Entry { kind, title, line, name, path, status, options, reference });
            };
            match (&*key.to_ascii_lowercase(), value) {
                ("book", _) => begin(EntryKind::Book),
                ("survey", _) => begin(EntryKind::Survey),
                ("endbook", _) => begin(EntryKind::EndBook),
                (key, value) => {
                    let known = all.last_mut().is_some_and(|entry| {
                        match key {
                            "name" => (entry.name, entry.line) = (value, line),
                            "path" => entry.path = value,
                            "status" => entry.status = value.parse().unwrap_or(0),
                            "options" => entry.options.push((line, value)),
                            "ref" => entry.reference = Some((line, value)),
                            _ => return false,
                        }
                        true
                    });
                    if !known {
                        self.source.line = line;
                        self.remark(format!(".{key} is passed over"));
                    }
                }
            }
        }
        all
    }

    /// What holds in an entry: what its book says, and what it says itself.
    fn inherited(&mut self, book: Option<&Book>, entry: &Entry<'_>) -> Result<Book, Refusal> {
        let outermost = || Book { folder: String::new(), units: Units::default(), earth: None };
        let mut book = book.cloned().unwrap_or_else(outermost);
        if !entry.path.is_empty() {
            let path = entry.path.replace('\\', "/");
            book.folder = format!("{}{}/", book.folder, path.trim_end_matches('/'));
        }
        if let Some((line, reference)) = entry.reference {
            self.source.line = line;
            book.earth = self.reference(reference)?.or(book.earth);
        }
        self.units = book.units;
        for &(line, options) in &entry.options {
            self.source.line = line;
            self.set_units(options)?;
        }
        book.units = std::mem::take(&mut self.units);
        self.source.line = entry.line;
        Ok(book)
    }

    /// Reads `.REF`: north, east and the zone of UTM, the convergence, the height, a bitmap, the
    /// same place in degrees, minutes and seconds, and the number and the name of the datum.
    fn reference(&mut self, line: &str) -> Result<Option<Earth>, Refusal> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |place: usize| words.get(place).and_then(|word| word.parse::<f64>().ok());
        let sound = |place| number(place).filter(|number| number.abs() < 1e8);
        let zone = words.get(2).and_then(|word| word.parse::<i32>().ok());
        let zone = zone.filter(|zone| (1..=60).contains(&zone.abs()));
        let (Some(north), Some(east), Some(zone), Some(up)) = (sound(0), sound(1), zone, sound(4))
        else {
            self.remark("this .REF gives no place in a zone of UTM, and is passed over");
            return Ok(None);
        };
        let datum = line.split('"').nth(1).unwrap_or_default();
        let system = self.system(datum, zone);
        let cannot = |_| self.wrong("the place of .REF cannot be computed", "correct it");
        let system = system.map_err(cannot)?;
        let place = system.degrees([east, north, up]).map_err(cannot)?;
        let convergence = system.convergence(place).map_err(cannot)?;
        if !place.into_iter().chain([convergence]).all(f64::is_finite) {
            return Err(self.wrong("the place of .REF is not on the earth", "correct it"));
        }
        Ok(Some(Earth { system, place, up, convergence }))
    }

    /// The system of a zone of UTM, which is south of the equator where it is negative.
    fn system(&mut self, datum: &str, zone: i32) -> Result<System, crate::earth::EarthError> {
        let number = zone.abs();
        let north = zone > 0;
        // The codes are those of EPSG, whose last digits are the zone.
        match datum {
            "NAD83" if north && number <= 23 => System::named(&format!("EPSG:{}", 26900 + number)),
            "NAD27 CONUS" if north && (10..=22).contains(&number) => {
                System::named(&format!("EPSG:{}", 26700 + number))
            }
            _ => {
                if datum != "WGS 1984" {
                    self.remark(format!("the datum \"{datum}\" is taken for WGS 1984"));
                }
                System::named(&format!("UTM{number}{}", if north { 'N' } else { 'S' }))
            }
        }
    }
}
