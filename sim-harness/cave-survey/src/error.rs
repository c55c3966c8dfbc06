//! Defines what a reader says of a file: a [`Refusal`], which ends the reading, and a [`Warning`],
//! which does not. Both name the place, in words that fit on one line.

use std::fmt;
use std::sync::Arc;

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's path, as it was opened.
    pub file: Arc<str>,
    /// The line, the first being 1; 0 where the whole file is meant.
    pub line: u32,
    /// The column in bytes, the first being 1; 0 where the whole line is meant.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        match (self.line, self.column) {
            (0, _) => Ok(()),
            (line, 0) => write!(f, ":{line}"),
            (line, column) => write!(f, ":{line}:{column}"),
        }
    }
}

/// The reason why a survey cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The place of the mistake; `None` where it is in no single file.
    pub place: Option<Place>,
    /// Says what is wrong.
    pub wrong: String,
    /// Says how to correct it.
    pub remedy: String,
}

impl Refusal {
    /// Makes a refusal that has no place yet.
    pub fn new(wrong: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: None, wrong: printable(wrong), remedy: printable(remedy) }
    }

    /// Adds the place, where there is none yet.
    #[must_use]
    pub fn at(self, place: Place) -> Self {
        Self { place: self.place.or(Some(place)), ..self }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        write!(f, "{}; {}", self.wrong, self.remedy)
    }
}

impl std::error::Error for Refusal {}

/// The text without the control characters that a file may hold, which a terminal would obey.
pub(crate) fn printable(text: impl Into<String>) -> String {
    let text = text.into();
    match text.contains(char::is_control) {
        true => text.replace(char::is_control, "\u{fffd}"),
        false => text,
    }
}

/// A remark about something that was read in spite of a doubt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The place; `None` where the remark is about the whole survey.
    pub place: Option<Place>,
    /// The remark.
    pub text: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        f.write_str(&self.text)
    }
}
