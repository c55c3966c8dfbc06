//! Cuts lines of Walls into fields.

/// The part of a line that is not read yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a>(&'a str);

/// Walls takes a comma for a blank.
fn is_blank(character: char) -> bool {
    character == ',' || character.is_whitespace()
}

impl<'a> Fields<'a> {
    /// The fields of a line, without its comment.
    pub(super) fn new(line: &'a str) -> Self {
        Self(line.split(';').next().unwrap_or(line))
    }

    /// What is left, without blanks around it.
    pub(super) fn rest(&self) -> &'a str {
        self.0.trim_matches(is_blank)
    }

    /// The next character that is no blank.
    pub(super) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Whether passage dimensions follow.
    pub(super) fn sees_dimensions(&self) -> bool {
        matches!(self.peek(), Some('<' | '*'))
    }

    /// Whether passage dimensions follow, and are closed.
    pub(super) fn sees_closed_dimensions(&self) -> bool {
        let mut ahead = *self;
        self.sees_dimensions() && ahead.bracketed().is_some()
    }

    /// The next field, up to a blank or one of `ends`; `None` where there is none.
    fn until(&mut self, ends: &[char]) -> Option<&'a str> {
        let text = self.0.trim_start_matches(is_blank);
        let end = text.find(|it: char| is_blank(it) || ends.contains(&it)).unwrap_or(text.len());
        let (field, rest) = text.split_at(end);
        self.0 = rest;
        Some(field).filter(|field| !field.is_empty())
    }

    /// The name of a station, in which nearly every character may be.
    pub(super) fn name(&mut self) -> Option<&'a str> {
        self.until(&[])
    }

    /// A reading, which may touch what follows it.
    pub(super) fn reading(&mut self) -> Option<&'a str> {
        self.until(&['#', '<', '*', '(', '\\'])
    }

    /// What touches a closing bracket before the next blank, and is neither variances nor a
    /// directive.
    pub(super) fn junk(&mut self) -> Option<&'a str> {
        let end = self.0.find(|it: char| is_blank(it) || it == '#' || it == '(');
        let (junk, rest) = self.0.split_at(end.unwrap_or(self.0.len()));
        self.0 = rest;
        Some(junk).filter(|junk| !junk.is_empty())
    }

    /// The text between the next character, which is an opening bracket or an asterisk, and the one
    /// that closes it; `None` where that is missing.
    pub(super) fn bracketed(&mut self) -> Option<&'a str> {
        let text = self.rest();
        let close = match text.chars().next()? {
            '(' => ')',
            '<' => '>',
            _ => '*',
        };
        let (inside, rest) = text.get(1..)?.split_once(close)?;
        self.0 = rest;
        Some(inside)
    }
}

/// The words of `#Units`: keys in lower case, each with its value where it has one. A value may be in
/// quotation marks.
pub(super) fn options(line: &str) -> Vec<(String, Option<String>)> {
    let mut all = Vec::new();
    let mut rest = line.split(';').next().unwrap_or(line);
    loop {
        rest = rest.trim_start_matches(is_blank);
        let end = rest.find(|it: char| is_blank(it) || it == '=').unwrap_or(rest.len());
        let (key, behind) = rest.split_at(end);
        let Some(value) = behind.trim_start().strip_prefix('=') else {
            if key.is_empty() {
                return all;
            }
            all.push((key.to_ascii_lowercase(), None));
            rest = behind;
            continue;
        };
        let value = value.trim_start();
        let key = key.to_ascii_lowercase();
        let (value, behind) = match value.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => {
                // The values of `TypeAB` and `TypeVB` are lists.
                let is_list = key.starts_with("type");
                let ends = |it: char| it.is_whitespace() || (it == ',' && !is_list);
                value.split_at(value.find(ends).unwrap_or(value.len()))
            }
        };
        all.push((key, Some(value.to_owned())));
        rest = behind;
    }
}
