//! Reads Survex's own files, `.svx`.
//!
//! The grammar is that of the manual of Survex 1.4, chapter "Survex data files", and where the
//! manual is silent, what `cavern` 1.4.22 does. What `cavern` refuses is refused; commands that
//! concern neither stations nor legs are passed over.

pub(crate) mod characters;
mod commands;
mod data;
pub(crate) mod date;
pub(crate) mod measure;
mod names;
pub(crate) mod settings;

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use crate::draft::Draft;
use crate::earth::System;
use crate::error::Refusal;
use crate::files::{self, FileError, Files, Opened};
use crate::formats::Format;
use crate::survey::Source;
use crate::{compass, walls};
use characters::{Characters, Class, Cursor};
use data::Traverse;
use names::Exports;
use settings::Settings;

/// The deepest that files include each other.
const DEEPEST: usize = 32;
/// The most blocks that are open at once.
const MOST_BLOCKS: usize = 1000;
/// The most bytes of a survey, each file counted as often as it is included. One of as many legs as
/// are read has some 15 MB.
pub(crate) const MOST_BYTES: usize = 64 << 20;
/// The most often that files are included.
pub(crate) const MOST_FILES: usize = 20_000;

/// A block that `*begin` has opened.
struct Block {
    /// The survey's full name, where the command names one.
    survey: Option<Rc<str>>,
    saved: Settings,
    source: Source,
}

/// What is read of a set of `.svx` files so far.
pub(crate) struct Reader<'a> {
    files: &'a dyn Files,
    pub(crate) draft: Draft,
    settings: Settings,
    blocks: Vec<Block>,
    /// The paths of the files that are being read, each included by the one before.
    open: Vec<String>,
    source: Source,
    bytes: usize,
    included: usize,
    traverse: Traverse,
    /// The surveys by name, with the first `*begin` of each.
    surveys: HashMap<Box<str>, Option<Source>>,
    exports: Exports,
    /// Whether `*export` may come next.
    may_export: bool,
    output: Option<Rc<System>>,
    /// The station that is fixed without coordinates.
    origin: Option<usize>,
    /// The stations that entrances and exports name, which no leg may use.
    hints: Vec<(usize, Source, &'static str)>,
    warned_of_date: bool,
    /// The declination of the line before, by place, height and day.
    last_declination: Option<(data::Occasion, f64)>,
    /// The convergence of the grid at the place of the line before.
    last_convergence: Option<([f64; 2], f64)>,
    /// The classes that characters are or were in.
    ever: Characters,
    /// Whether a file of another format has positions on the earth.
    is_on_earth: bool,
    /// The offset in the present line from which `*set eol` holds.
    resume: Option<usize>,
}

/// Reads the file `entry` of `files` and all that it includes.
pub(crate) fn read(files: &dyn Files, entry: &str, opened: &Opened) -> Result<Draft, Refusal> {
    let mut reader = Reader {
        files,
        draft: Draft::default(),
        settings: Settings::default(),
        blocks: Vec::new(),
        open: Vec::new(),
        source: Source::default(),
        bytes: 0,
        included: 0,
        traverse: Traverse::default(),
        surveys: HashMap::new(),
        exports: Exports::default(),
        may_export: false,
        output: None,
        origin: None,
        hints: Vec::new(),
        warned_of_date: false,
        last_declination: None,
        last_convergence: None,
        ever: Characters::default(),
        is_on_earth: false,
        resume: None,
    };
    reader.whole(entry, opened).map_err(|refusal| Refusal {
        wrong: names::shown(&refusal.wrong),
        remedy: names::shown(&refusal.remedy),
        ..refusal
    })?;
    reader.draft.is_on_earth =
        reader.is_on_earth || reader.output.is_some() || reader.settings.system.is_some();
    reader.separate_levels();
    Ok(reader.draft)
}

/// The length of the first line, without its end.
fn end_of_line(bytes: &[u8], characters: &Characters) -> usize {
    bytes.iter().position(|byte| characters.is(*byte, Class::Eol)).unwrap_or(bytes.len())
}

impl Reader<'_> {
    /// Reads the survey and looks whether the names in it can be used.
    fn whole(&mut self, entry: &str, opened: &Opened) -> Result<(), Refusal> {
        self.file(entry, opened)?;
        self.check_exports()?;
        self.check_hints()
    }

    /// The column of the next field.
    fn column(&self, cursor: &Cursor<'_>) -> u32 {
        let mut field = *cursor;
        field.skip_blanks(&self.settings.characters);
        field.column()
    }

    /// A refusal at the next field.
    fn wrong(
        &self,
        cursor: &Cursor<'_>,
        wrong: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Refusal {
        let refusal = Refusal::new(wrong, remedy);
        match self.draft.place(self.source, self.column(cursor)) {
            Some(place) => refusal.at(place),
            None => refusal,
        }
    }

    fn warn(&mut self, cursor: &Cursor<'_>, text: impl Into<String>) {
        self.draft.warn(self.source, self.column(cursor), text);
    }

    /// Refuses what a command or a data line has too much of.
    fn require_end(&self, cursor: &mut Cursor<'_>) -> Result<(), Refusal> {
        if cursor.is_done(&self.settings.characters) {
            return Ok(());
        }
        let rest: String = String::from_utf8_lossy(cursor.rest()).chars().take(20).collect();
        let rest = rest.trim_end();
        Err(self.wrong(
            cursor,
            format!("\"{rest}\" is more than belongs here"),
            "remove it, or begin a comment with ;",
        ))
    }

    fn file(&mut self, path: &str, opened: &Opened) -> Result<(), Refusal> {
        let outer = self.source;
        let blocks = self.blocks.len();
        self.bytes = self.bytes.saturating_add(opened.bytes.len());
        self.included += 1;
        if self.bytes > MOST_BYTES || self.included > MOST_FILES {
            let wrong =
                format!("the survey has more than {} MB or {MOST_FILES} files", MOST_BYTES >> 20);
            return Err(self.draft.wrong(outer, wrong, "give a part of it"));
        }
        self.source = Source { file: self.draft.file(&opened.path), line: 0 };
        self.open.push(path.to_owned());
        let bytes = opened.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&opened.bytes);
        self.lines(bytes, blocks)?;
        self.complete_traverse(&Cursor::new(b""))?;
        self.draft.end_repeats();
        self.may_export = false;
        if let Some(block) = self.blocks.get(blocks) {
            let wrong = "this *begin has no *end in its file";
            return Err(self.draft.wrong(block.source, wrong, "add the *end"));
        }
        self.open.pop();
        self.source = outer;
        Ok(())
    }

    fn lines(&mut self, mut bytes: &[u8], blocks: usize) -> Result<(), Refusal> {
        while !bytes.is_empty() {
            let mut characters = Rc::clone(&self.settings.characters);
            let length = end_of_line(bytes, &characters);
            self.source.line = self.source.line.saturating_add(1);
            self.line(bytes.get(..length).unwrap_or_default(), blocks)?;
            let mut rest = bytes.get(length..).unwrap_or_default();
            // Where the line says what ends lines, that holds for the rest of it.
            if let Some(at) = self.resume.take() {
                characters = Rc::clone(&self.settings.characters);
                rest = bytes.get(at..).unwrap_or_default();
                rest = rest.get(end_of_line(rest, &characters)..).unwrap_or_default();
            }
            // The end of a line may be of two characters.
            bytes = match rest {
                [a, b, rest @ ..] if a != b && characters.is(*b, Class::Eol) => rest,
                [_, rest @ ..] => rest,
                [] => rest,
            };
        }
        Ok(())
    }

    fn line(&mut self, line: &[u8], blocks: usize) -> Result<(), Refusal> {
        let characters = Rc::clone(&self.settings.characters);
        let mut cursor = Cursor::new(line);
        cursor.skip_blanks(&characters);
        if cursor.sees(Class::Keyword, &characters) {
            self.complete_traverse(&cursor)?;
            cursor.next();
            return self.command(&mut cursor, blocks);
        }
        if cursor.peek().is_none() {
            return self.complete_traverse(&cursor);
        }
        if cursor.sees(Class::Comment, &characters) {
            return Ok(());
        }
        self.may_export = false;
        self.data(&mut cursor)
    }

    fn include(&mut self, name: &str, cursor: &Cursor<'_>) -> Result<(), Refusal> {
        let from = self.open.last().cloned().unwrap_or_default();
        let opened = files::open_named(self.files, &from, name, &[".svx"]);
        let (path, opened) = opened.map_err(|error| {
            let (wrong, remedy) = unopened(name, &error);
            self.wrong(cursor, wrong, remedy)
        })?;
        if self.open.contains(&path) {
            let wrong = format!("\"{name}\" includes itself");
            return Err(self.wrong(cursor, wrong, "remove this *include"));
        }
        if self.open.len() >= DEEPEST {
            let wrong = format!("files include each other {DEEPEST} deep");
            return Err(self.wrong(cursor, wrong, "include them from fewer levels"));
        }
        self.draft.end_repeats();
        match Format::named(&path) {
            None | Some(Format::Survex) => {
                let prefix = Rc::clone(&self.settings.prefix);
                self.file(&path, &opened)?;
                self.settings.prefix = prefix;
                Ok(())
            }
            Some(format) => self.foreign(format, &path, &opened, cursor),
        }
    }

    /// Includes a file of Compass or Walls, whose stations are in the present survey.
    fn foreign(
        &mut self,
        format: Format,
        path: &str,
        opened: &Opened,
        cursor: &Cursor<'_>,
    ) -> Result<(), Refusal> {
        let draft = match format {
            Format::CompassSurvey => compass::survey(opened),
            Format::CompassProject => compass::project(self.files, path, opened),
            Format::WallsSurvey => walls::survey(opened),
            Format::WallsProject => walls::project(self.files, path, opened),
            _ => {
                let wrong = "*include takes surveys of Survex, Compass and Walls";
                return Err(self.wrong(cursor, wrong, "give the other file itself"));
            }
        }?;
        let is_walls = matches!(format, Format::WallsSurvey | Format::WallsProject);
        self.included += draft.files.len();
        if self.included > MOST_FILES {
            let wrong = format!("the survey has more than {MOST_FILES} files");
            return Err(self.wrong(cursor, wrong, "give a part of it"));
        }
        if is_walls {
            self.ever.note_walls();
        }
        let prefix = Rc::clone(&self.settings.prefix);
        let is_on_earth = draft.is_on_earth;
        self.draft.merge(draft, |name| names::foreign(&prefix, name, is_walls))?;
        self.is_on_earth |= is_on_earth;
        Ok(())
    }

    /// Looks whether the stations that passages and commands name are there.
    fn check_hints(&mut self) -> Result<(), Refusal> {
        let fixed: HashSet<usize> = self.draft.fixes.iter().map(|fix| fix.station).collect();
        let lost =
            |station: usize| !self.draft.stations[station].is_used && !fixed.contains(&station);
        let sections = self.draft.passages.iter().flatten();
        if let Some((section, source)) = sections.clone().find(|it| lost(it.0.station)) {
            let name = &self.draft.stations[section.station].name;
            let wrong = format!("the passage is at station \"{name}\", which no leg joins");
            return Err(self.draft.wrong(*source, wrong, "correct the name, or add the leg"));
        }
        for (station, source, command) in std::mem::take(&mut self.hints) {
            if !self.draft.stations[station].is_used {
                let name = self.draft.stations[station].name.clone();
                self.draft.warn(
                    source,
                    0,
                    format!("*{command} names \"{name}\", which no leg uses"),
                );
            }
        }
        Ok(())
    }
}

/// What is wrong with a file that was not opened, and the remedy.
pub(crate) fn unopened(name: &str, error: &FileError) -> (String, String) {
    match error {
        FileError::Missing => {
            (format!("there is no file \"{name}\""), "put it there, or correct the name".into())
        }
        FileError::Outside => (
            format!("\"{name}\" lies outside the folder of the survey"),
            "name the folder that holds all of it with --within".into(),
        ),
        FileError::Utf16 => (format!("\"{name}\" is text in UTF-16"), "save it as UTF-8".into()),
        FileError::Unreadable(why) => {
            (format!("\"{name}\" cannot be read: {why}"), "give a readable file".into())
        }
    }
}
