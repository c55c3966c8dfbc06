//! Bad input, told in one line: where it is, what is wrong, and how to mend it.

use std::fmt;
use std::path::{Path, PathBuf};

/// Something the user gave that cannot be used. Ends the command with exit status 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    place: Option<(PathBuf, Option<usize>)>,
    wrong: String,
    remedy: String,
}

impl InputError {
    /// An error that is in no file: `wrong` says what it is, `remedy` what to do about it.
    pub fn new(wrong: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: None, wrong: wrong.into(), remedy: remedy.into() }
    }

    /// The same, in this file.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        Self { place: Some((file.to_owned(), None)), ..self }
    }

    /// The same, in this line of this file; the first line is 1.
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
