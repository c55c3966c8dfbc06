//! Defines the error for input that cannot be used. Its one line says where the mistake is, what is
//! wrong, and how to correct it.

use std::fmt;
use std::path::{Path, PathBuf};

/// The error for input of the user that cannot be used. It ends the command with exit status 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    place: Option<(PathBuf, Option<usize>)>,
    wrong: String,
    remedy: String,
}

impl InputError {
    /// Makes an error without a place: `wrong` says what is wrong, `remedy` how to correct it.
    pub fn new(wrong: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: None, wrong: wrong.into(), remedy: remedy.into() }
    }

    /// Adds the file in which the error is.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        Self { place: Some((file.to_owned(), None)), ..self }
    }

    /// Adds the file and the line in which the error is; the first line is 1.
    #[must_use]
    pub fn at_line(self, file: &Path, line: usize) -> Self {
        Self { place: Some((file.to_owned(), Some(line))), ..self }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some((file, Some(line))) => write!(f, "{}:{line}: ", file.display())?,
            Some((file, None)) => write!(f, "{}: ", file.display())?,
            None => {}
        }
        write!(f, "{}; {}", self.wrong, self.remedy)
    }
}

impl std::error::Error for InputError {}
