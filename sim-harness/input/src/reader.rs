//! Reads values from a scenario file for its sections: with their lines, with checks of their
//! ranges, and with error messages that say what is wrong, where, and how to correct it.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;
use units::{Duration, Point2};

use crate::InputError;
use crate::suggest;

/// A value with its place in the file.
pub type At<T> = Spanned<T>;

/// Two numbers, no more and no fewer.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "Vec<f32>")]
pub struct Pair(pub [f32; 2]);

impl TryFrom<Vec<f32>> for Pair {
    type Error = String;

    fn try_from(numbers: Vec<f32>) -> Result<Self, String> {
        <[f32; 2]>::try_from(numbers)
            .map(Self)
            .map_err(|numbers| format!("expected two numbers, found {}", numbers.len()))
    }
}

impl From<Pair> for Point2 {
    fn from(Pair([x, y]): Pair) -> Self {
        Self::new(x, y)
    }
}

/// Replaces terms of the parser by those of a person who does not write Rust.
const PLAIN: [(&str, &str); 6] = [
    ("unknown field", "unknown key"),
    ("missing field", "missing key"),
    ("unknown variant", "unknown value"),
    ("expected f32", "expected a number"),
    ("expected usize", "expected a whole number of 0 or more"),
    (" as i128", ""),
];

/// The text of a scenario file, to find the lines of its values in.
pub struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
}

impl<'a> Reader<'a> {
    /// Makes a reader of the text of the file at `path`, for the lines of its values.
    pub const fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, text }
    }

    /// The path that a file names, beside the scenario's own.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
    }

    /// An error at a byte of the file.
    pub fn at_byte(&self, byte: usize, error: InputError) -> InputError {
        error.at_line(self.path, self.line_at(byte))
    }

    fn line_at(&self, byte: usize) -> usize {
        1 + self.text.bytes().take(byte).filter(|&b| b == b'\n').count()
    }

    /// An error at a value of the file.
    pub fn wrong<T>(&self, at: &At<T>, wrong: String, remedy: impl Into<String>) -> InputError {
        InputError::new(wrong, remedy).at_line(self.path, self.line_at(at.span().start))
    }

    /// The error of the TOML parser, on one line.
    pub fn syntax(&self, error: &toml::de::Error) -> InputError {
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        let meant = suggest::question_about(&message);
        let wrong = PLAIN.iter().fold(message, |text, (theirs, ours)| text.replace(theirs, ours));
        let remedy =
            format!("{meant}see the book's chapter \"Scenarios\" for the keys and their types");
        let line = error.span().map_or(1, |span| self.line_at(span.start));
        InputError::new(wrong, remedy).at_line(self.path, line)
    }

    /// A number within `range`.
    pub fn number(
        &self,
        value: &At<f32>,
        key: &str,
        range: RangeInclusive<f32>,
    ) -> Result<f32, InputError> {
        let number = *value.as_ref();
        if range.contains(&number) {
            return Ok(number);
        }
        let remedy = format!("give a number from {} to {}", range.start(), range.end());
        Err(self.wrong(value, format!("{key} = {number} is out of range"), remedy))
    }

    /// Reads a key that may be left out.
    pub fn or(
        &self,
        value: Option<&At<f32>>,
        key: &str,
        range: RangeInclusive<f32>,
        default: f32,
    ) -> Result<f32, InputError> {
        value.map_or(Ok(default), |value| self.number(value, key, range))
    }

    /// A time within `range`, both in seconds; in microseconds.
    pub fn micros(
        &self,
        value: &At<f32>,
        key: &str,
        range: RangeInclusive<f32>,
    ) -> Result<u64, InputError> {
        Ok((f64::from(self.number(value, key, range)?) * 1e6).round() as u64)
    }

    /// A time span within `range`, in seconds, where the key may be left out.
    pub fn span_of(
        &self,
        value: Option<&At<f32>>,
        key: &str,
        range: RangeInclusive<f32>,
        default: Duration,
    ) -> Result<Duration, InputError> {
        value
            .map_or(Ok(default), |value| Ok(Duration::from_micros(self.micros(value, key, range)?)))
    }
}
