//! Resolves the names of stations and surveys, such as `1@inner.outer`.

use std::collections::{HashMap, HashSet};

use super::Reader;
use crate::error::Refusal;
use crate::survey::{Source, StationId};

/// The character that separates the levels of a name until all is read. Dots may be in names.
const LEVEL: &str = "\u{e001}";

/// The longest name with all its surveys, in bytes.
const LONGEST: usize = 4096;

/// A text about names as it is shown while they are read.
pub(super) fn shown(text: &str) -> String {
    text.replace(LEVEL, ".")
}

/// The surveys and stations that are named.
#[derive(Default)]
pub(super) struct Names {
    /// The names of the surveys that are open, the outermost first.
    pub(super) path: Vec<String>,
    /// All surveys, with their levels.
    pub(super) surveys: HashSet<String>,
    /// The surveys that references name, each with the first line that does.
    references: HashMap<String, Source>,
}

/// A station at an end of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct End {
    pub(super) id: StationId,
    /// Whether it is a point without a name, so that the leg is a splay.
    pub(super) is_splay: bool,
}

impl Reader<'_> {
    /// The station of a name, which is new where there was none.
    pub(super) fn station(&mut self, name: &str) -> Result<StationId, Refusal> {
        let (station, survey) = name.split_once('@').unwrap_or((name, ""));
        let allowed =
            |it: char| it.is_ascii_alphanumeric() || "_-/+*.,'".contains(it) || !it.is_ascii();
        if let Some(bad) = name.chars().find(|it| !allowed(*it) && *it != '@') {
            let wrong = format!("{bad:?} is not allowed in the name \"{name}\"");
            return Err(self.wrong(wrong, "give letters, digits, _ and -"));
        }
        if station.is_empty() || survey.contains('@') || super::words::is_omitted(station) {
            return Err(self.wrong(format!("\"{name}\" is no name of a station"), "give one"));
        }
        let (prefix, suffix) = match &self.centreline {
            Some(centreline) => (&*centreline.prefix, &*centreline.suffix),
            None => ("", ""),
        };
        let mut levels: Vec<&str> = self.names.path.iter().map(String::as_str).collect();
        levels.extend(survey.split('.').rev().filter(|level| !level.is_empty()));
        if !survey.is_empty() {
            let survey = levels.join(LEVEL);
            self.draft.count_item();
            self.names.references.entry(survey).or_insert(self.source);
        }
        let own = format!("{prefix}{station}{suffix}");
        levels.push(&own);
        let full = levels.join(LEVEL);
        if full.len() > LONGEST {
            return Err(self.wrong("the name of a station is too long", "shorten it"));
        }
        Ok(self.draft.station(&full, self.source).0)
    }

    /// The station at an end of a leg: `-` is on the wall, `.` in the passage.
    pub(super) fn end(&mut self, name: &str) -> Result<End, Refusal> {
        match name {
            "-" | "." => {
                let id = self.draft.anonymous(name == "-", self.source);
                Ok(End { id, is_splay: true })
            }
            _ => self.station(name).map(|id| End { id, is_splay: false }),
        }
    }

    /// Opens the survey of that name.
    pub(super) fn enter(&mut self, name: &str) -> Result<(), Refusal> {
        self.draft.count_item();
        self.names.path.push(name.to_owned());
        let full = self.names.path.join(LEVEL);
        if full.len() > LONGEST {
            return Err(self.wrong("the name of a survey is too long", "shorten it"));
        }
        if !self.names.surveys.insert(full) {
            let wrong = format!("there are two surveys \"{name}\"");
            return Err(self.wrong(wrong, "rename one of them"));
        }
        Ok(())
    }

    /// Refuses a reference to a survey that is nowhere.
    pub(super) fn check_references(&self) -> Result<(), Refusal> {
        let lost = self.names.references.iter().filter(|it| !self.names.surveys.contains(it.0));
        let first = lost.min_by_key(|(_, source)| (source.file, source.line));
        let Some((survey, source)) = first else { return Ok(()) };
        let wrong = format!("there is no survey \"{survey}\"");
        Err(self.draft.wrong(*source, wrong, "correct the name behind @"))
    }

    /// Separates the levels of all names by dots.
    pub(super) fn separate_levels(&mut self) {
        for station in &mut self.draft.stations {
            station.name = shown(&station.name).into();
        }
        for warning in &mut self.draft.warnings {
            warning.text = shown(&warning.text);
        }
    }
}
