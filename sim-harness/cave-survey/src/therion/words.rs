//! Cuts the files of Therion into lines and words.

/// The lines that say something, each with its number. A line that ends with `\` goes on in the next.
pub(super) fn lines(text: &str) -> Vec<(u32, String)> {
    let mut all = Vec::new();
    let mut begun: Option<(u32, String)> = None;
    for (number, line) in (1..).zip(crate::files::lines(text)) {
        let line = line.trim_end();
        let (first, mut whole) = begun.take().unwrap_or((number, String::new()));
        match line.strip_suffix('\\') {
            Some(part) => {
                whole += part;
                begun = Some((first, whole));
            }
            None => {
                whole += line;
                let said = whole.trim_start();
                if !said.is_empty() && !said.starts_with('#') {
                    all.push((first, whole));
                }
            }
        }
    }
    all.extend(begun);
    all
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
