//! Resolves the names of stations and surveys, and checks which stations may be used from where.

use std::collections::HashMap;

use super::Reader;
use super::characters::{Class, Cursor};
use super::settings::Case;
use crate::error::Refusal;
use crate::survey::{Source, StationId};

/// A parsed name, and of how many levels it is below the current survey.
pub(super) struct Name {
    pub(super) full: String,
    pub(super) levels: u32,
}

/// A station of a data line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) id: StationId,
    pub(super) kind: NameKind,
}

/// The kind of a station's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NameKind {
    Plain,
    /// Anonymous, at the end of a splay.
    Splay,
    /// Anonymous, at the end of a leg.
    Point,
}

/// The levels to which stations are exported, and from which they are used.
#[derive(Debug, Default)]
pub(super) struct Exports {
    /// Whether the files use `*export` at all; where they do not, all may be used.
    pub(super) are_given: bool,
    pub(super) of: HashMap<StationId, Export>,
}

/// The exports of one station.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Export {
    /// One bit for each level above its own to which it is exported.
    pub(super) levels: u64,
    /// The most levels above its own from which it is used, and where.
    needed: u32,
    by: Source,
    is_inferred: bool,
}

/// The character that separates the levels of a name, until all is read.
const LEVEL: char = '.';

/// A dot within a level of a name, which `*set names` can allow, until all is read.
const DOT: char = '\u{e001}';

/// The characters that may separate levels instead, in the order in which `cavern` prefers them.
const SEPARATORS: &[u8] = b"./:;,!|\\ ~+*^='`\"#$%&?@<>()[]{}";

/// A text about names as it is shown while they are read.
pub(super) fn shown(text: &str) -> String {
    text.replace(DOT, ".")
}

/// The name of a station of another format in a survey. The levels of Walls's names are levels here;
/// those of Compass have none, and `cavern` separates them by dots even where dots are in them.
pub(super) fn foreign(prefix: &str, name: &str, is_walls: bool) -> String {
    let mut full = String::from(prefix);
    if !full.is_empty() {
        full.push(LEVEL);
    }
    full.extend(name.chars().map(|character| match character {
        '.' if is_walls => DOT,
        ':' if is_walls => LEVEL,
        other => other,
    }));
    full
}

/// The most levels of a name.
const DEEPEST: u32 = 60;

impl Reader<'_> {
    /// The next name of a station or survey.
    pub(super) fn name(&self, cursor: &mut Cursor<'_>) -> Result<Name, Refusal> {
        let characters = self.settings.characters.clone();
        cursor.skip_blanks(&characters);
        let mut full = String::from(&*self.settings.prefix);
        if cursor.sees(Class::Root, &characters) {
            cursor.next();
            full.clear();
            if cursor.sees(Class::Separator, &characters) {
                cursor.next();
            }
        }
        let mut levels = 0;
        loop {
            let mut part = String::new();
            while let Some(byte) = cursor.peek().filter(|&byte| characters.is_name(byte)) {
                if part.len() < self.settings.truncate {
                    part.push(match (byte, self.settings.case) {
                        (b'.', _) => DOT,
                        (byte, Case::Preserve) => char::from(byte),
                        (byte, Case::Lower) => char::from(byte.to_ascii_lowercase()),
                        (byte, Case::Upper) => char::from(byte.to_ascii_uppercase()),
                    });
                }
                cursor.next();
            }
            if part.is_empty() {
                return Err(self.no_name(cursor, levels > 0));
            }
            if !full.is_empty() {
                full.push(LEVEL);
            }
            full += &part;
            levels += 1;
            if levels > DEEPEST {
                let wrong = format!("a name has more than {DEEPEST} levels");
                return Err(self.wrong(cursor, wrong, "shorten it"));
            }
            if !cursor.sees(Class::Separator, &characters) {
                break;
            }
            cursor.next();
        }
        let ends = cursor.peek().is_none()
            || cursor.sees(Class::Blank, &characters)
            || cursor.sees(Class::Comment, &characters);
        if !ends {
            return Err(self.no_name(cursor, true));
        }
        Ok(Name { full, levels })
    }

    /// The full name of the next survey; the root character alone stands for the root, whose name is
    /// empty.
    pub(super) fn survey_name(&mut self, cursor: &mut Cursor<'_>) -> Result<String, Refusal> {
        let characters = self.settings.characters.clone();
        let mut ahead = *cursor;
        ahead.skip_blanks(&characters);
        if ahead.sees(Class::Root, &characters) {
            ahead.next();
            if ahead.is_done(&characters) {
                self.warn(cursor, "the root is out of use as a survey");
                *cursor = ahead;
                return Ok(String::new());
            }
        }
        self.name(cursor).map(|name| name.full)
    }

    /// Separates the levels of names by a character that is in none of them, and lets dots be dots.
    pub(super) fn separate_levels(&mut self) {
        let is_name = |byte: u8| self.ever.is_name(byte);
        let is_separator = |byte: &u8| self.ever.is(*byte, Class::Separator);
        let mut free = SEPARATORS.iter().copied().filter(|byte| !is_name(*byte));
        let chosen = free.clone().find(is_separator).or_else(|| free.next()).unwrap_or(b'.');
        for station in &mut self.draft.stations {
            if chosen != b'.' && station.name.contains([LEVEL, DOT]) {
                let name = station.name.replace(LEVEL, &char::from(chosen).to_string());
                station.name = shown(&name).into();
            }
        }
        for warning in &mut self.draft.warnings {
            warning.text = shown(&warning.text);
        }
    }

    fn no_name(&self, cursor: &Cursor<'_>, is_inside: bool) -> Refusal {
        match cursor.peek() {
            Some(byte) if is_inside || !byte.is_ascii_whitespace() => {
                let wrong = format!("{:?} is not allowed in a name", char::from(byte));
                self.wrong(cursor, wrong, "allow it with *set names, or correct the name")
            }
            _ => self.wrong(cursor, "a station's name is missing", "give it"),
        }
    }

    /// The station of the next name, in a command.
    pub(super) fn station(&mut self, cursor: &mut Cursor<'_>) -> Result<StationId, Refusal> {
        let name = self.name(cursor)?;
        self.station_of(&name)
    }

    pub(super) fn station_of(&mut self, name: &Name) -> Result<StationId, Refusal> {
        let source = self.source;
        if self.surveys.contains_key(&*name.full) {
            let wrong = format!("\"{}\" is both a station and a survey", name.full);
            return Err(self.draft.wrong(source, wrong, "rename one of them"));
        }
        self.draft.require_room(source)?;
        let (id, is_new) = self.draft.station(&name.full, source);
        let is_inferred = self.settings.infer.exports;
        if is_new {
            self.note_surveys(&name.full)?;
        }
        if name.levels > 1 || is_inferred {
            let export = self.exports.of.entry(id).or_default();
            export.is_inferred |= is_inferred;
            if name.levels - 1 > export.needed {
                export.needed = name.levels - 1;
                export.by = source;
            }
        }
        Ok(id)
    }

    /// Notes the surveys above a name, which no station may be called like.
    pub(super) fn note_surveys(&mut self, full: &str) -> Result<(), Refusal> {
        let mut above = full;
        while let Some((survey, _)) = above.rsplit_once(LEVEL) {
            if self.surveys.contains_key(survey) {
                break;
            }
            if self.draft.known(survey).is_some() {
                let wrong = format!("\"{survey}\" is both a station and a survey");
                return Err(self.draft.wrong(self.source, wrong, "rename one of them"));
            }
            self.surveys.insert(survey.into(), None);
            self.draft.count_item();
            above = survey;
        }
        Ok(())
    }

    /// The next station of a data line, which may be anonymous.
    pub(super) fn named(&mut self, cursor: &mut Cursor<'_>) -> Result<Named, Refusal> {
        let characters = self.settings.characters.clone();
        cursor.skip_blanks(&characters);
        let ends = |cursor: &Cursor<'_>| {
            cursor.peek().is_none()
                || cursor.sees(Class::Blank, &characters)
                || cursor.sees(Class::Comment, &characters)
        };
        let mut ahead = *cursor;
        let mut separators = 0;
        while separators < 4 && ahead.sees(Class::Separator, &characters) {
            ahead.next();
            separators += 1;
        }
        if separators == 0 && self.settings.dash_is_wall && ahead.peek() == Some(b'-') {
            ahead.next();
            separators = if ends(&ahead) { 2 } else { 0 };
        }
        if !(1..=3).contains(&separators) || !ends(&ahead) {
            let id = self.station(cursor)?;
            return Ok(Named { id, kind: NameKind::Plain });
        }
        *cursor = ahead;
        let id = self.draft.anonymous(separators == 2, self.source);
        let kind = if separators == 3 { NameKind::Point } else { NameKind::Splay };
        Ok(Named { id, kind })
    }

    /// Refuses the use of a station from outside a survey that does not export it.
    pub(super) fn check_exports(&self) -> Result<(), Refusal> {
        if !self.exports.are_given {
            return Ok(());
        }
        let mut missing: Option<(&StationId, &Export, u32)> = None;
        for (id, export) in self.exports.of.iter().filter(|(_, export)| !export.is_inferred) {
            let level = (1..=export.needed).find(|level| export.levels & (1 << level) == 0);
            let first = |(other, _, _): &(&StationId, _, _)| id < *other;
            if let Some(level) = level.filter(|_| missing.as_ref().is_none_or(first)) {
                missing = Some((id, export, level));
            }
        }
        let Some((&id, export, level)) = missing else { return Ok(()) };
        let name = &self.draft.stations[id].name;
        let mut survey: &str = name;
        for _ in 0..level {
            survey = survey.rsplit_once(LEVEL).map_or("", |(above, _)| above);
        }
        let wrong =
            format!("station \"{name}\" is used here, but survey \"{survey}\" does not export it");
        Err(self.draft.wrong(export.by, wrong, "add *export behind the survey's *begin"))
    }
}
