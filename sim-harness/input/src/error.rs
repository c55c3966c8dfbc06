//! Defines the error for input that cannot be used. Its one line says where the mistake is, what is
//! wrong, and how to correct it.

use std::fmt;
use std::path::{Path, PathBuf};

/// The error for input of the user that cannot be used. It ends the command with exit status 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    place: Option<Place>,
    wrong: String,
    remedy: String,
}

/// The place of an error in a file; lines and columns begin at 1.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Place {
    file: PathBuf,
    line: Option<usize>,
    column: Option<usize>,
}

impl InputError {
    /// Makes an error without a place: `wrong` says what is wrong, `remedy` how to correct it.
    pub fn new(wrong: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { place: None, wrong: wrong.into(), remedy: remedy.into() }
    }

    /// Adds the file in which the error is.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        self.at(file, None, None)
    }

    /// Adds the file and the line in which the error is; the first line is 1.
    #[must_use]
    pub fn at_line(self, file: &Path, line: usize) -> Self {
        self.at(file, Some(line), None)
    }

    /// Adds the file, the line and the column in which the error is; the first of each is 1.
    #[must_use]
    pub fn at_column(self, file: &Path, line: usize, column: usize) -> Self {
        self.at(file, Some(line), Some(column))
    }

    /// Puts a key with its value in the place of the file, for a key that was given by itself.
    #[must_use]
    pub fn at_key(self, key: &str) -> Self {
        self.at(Path::new(key), None, None)
    }

    /// Takes the place away, for input of which the user sees no file.
    #[must_use]
    pub fn without_place(self) -> Self {
        Self { place: None, ..self }
    }

    fn at(self, file: &Path, line: Option<usize>, column: Option<usize>) -> Self {
        Self { place: Some(Place { file: file.to_owned(), line, column }), ..self }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Place { file, line, column }) = &self.place {
            write!(f, "{}", file.display())?;
            for number in [line, column].into_iter().flatten() {
                write!(f, ":{number}")?;
            }
            f.write_str(": ")?;
        }
        write!(f, "{}; {}", self.wrong, self.remedy)
    }
}

impl std::error::Error for InputError {}
