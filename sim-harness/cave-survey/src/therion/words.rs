//! Cuts the files of Therion into lines and words.

use std::borrow::Cow;

use crate::files;

/// The lines of a file that say something, each with its number. A line that ends with `\` goes on in
/// the next.
#[derive(Clone)]
pub(super) struct Lines<I> {
    lines: I,
    number: u32,
}

/// The lines of a text.
pub(super) fn lines(text: &str) -> Lines<impl Iterator<Item = &str> + Clone> {
    Lines { lines: files::lines(text), number: 0 }
}

impl<'t, I: Iterator<Item = &'t str>> Iterator for Lines<I> {
    type Item = (u32, Cow<'t, str>);

    fn next(&mut self) -> Option<Self::Item> {
        let mut begun: Option<(u32, String)> = None;
        loop {
            let Some(line) = self.lines.next() else {
                return begun.map(|(number, whole)| (number, Cow::Owned(whole)));
            };
            self.number = self.number.saturating_add(1);
            let line = line.trim_end();
            if let Some(part) = line.strip_suffix('\\') {
                let (_, whole) = begun.get_or_insert_with(|| (self.number, String::new()));
                // What is too long is refused when it is read.
                if whole.len() <= files::LONGEST_LINE {
                    whole.push_str(part);
                }
                continue;
            }
            let (number, whole) = match begun.take() {
                Some((number, whole)) => (number, Cow::Owned(whole + line)),
                None => (self.number, Cow::Borrowed(line)),
            };
            let said = whole.trim_start();
            if !said.is_empty() && !said.starts_with('#') {
                return Some((number, whole));
            }
        }
    }
}

/// The words of a line. Words in quotation marks or brackets are one; a comment begins with `#` where
/// a word might begin.
pub(super) fn split(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next().filter(|first| *first != '#') {
        let (word, after) = match first {
            '"' => quoted(rest.get(1..).unwrap_or_default()),
            '[' => bracketed(rest.get(1..).unwrap_or_default()),
            _ => {
                let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
                let (word, after) = rest.split_at(end);
                (word.to_owned(), after)
            }
        };
        words.push(word);
        rest = after.trim_start();
    }
    words
}

/// The text up to the closing quotation mark, of which two stand for one, and what follows it.
fn quoted(text: &str) -> (String, &str) {
    let mut word = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('"') {
        word += before;
        match after.strip_prefix('"') {
            Some(after) => {
                word.push('"');
                rest = after;
            }
            None => return (word, after),
        }
    }
    word += rest;
    (word, "")
}

/// The text up to the bracket that closes, and what follows it.
fn bracketed(text: &str) -> (String, &str) {
    let mut depth = 1usize;
    for (at, character) in text.char_indices() {
        depth = match character {
            '[' => depth + 1,
            ']' => depth - 1,
            _ => depth,
        };
        if depth == 0 {
            let (word, rest) = text.split_at(at);
            return (word.to_owned(), rest.get(1..).unwrap_or_default());
        }
    }
    (text.to_owned(), "")
}

/// A number as Therion reads it: digits with at most one point, sign and exponent.
pub(super) fn number(text: &str) -> Option<f64> {
    let sound = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    text.bytes().all(sound).then(|| text.parse().ok()).flatten().filter(|it: &f64| it.is_finite())
}

/// Degrees, or degrees, minutes and seconds such as `45:30:12.5`.
pub(super) fn degrees(text: &str) -> Option<f64> {
    let (sign, size) = text.strip_prefix('-').map_or((1.0, text), |size| (-1.0, size));
    let last = size.split(':').count() - 1;
    let mut degrees = 0.0;
    for (place, part) in size.split(':').enumerate() {
        let share = [1.0, 60.0, 3600.0].get(place)?;
        if place > 0 && part.starts_with(['-', '+']) || place < last && part.contains('.') {
            return None;
        }
        degrees += number(part)? / share;
    }
    Some(sign * degrees)
}

/// Whether a reading is left out.
pub(super) fn is_omitted(text: &str) -> bool {
    matches!(text, "-" | "." | "nan" | "NaN" | "NAN")
}
