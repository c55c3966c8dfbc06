//! Reads the fields of a line, by classes of characters that `*set` can change.

/// The classes of characters; a character can be in several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Blank = 1,
    Comment = 2,
    Decimal = 4,
    Eol = 8,
    Keyword = 16,
    Minus = 32,
    Names = 64,
    Omit = 128,
    Plus = 256,
    Root = 512,
    Separator = 1024,
}

impl Class {
    /// The class of that name in `*set`.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "blank" => Self::Blank,
            "comment" => Self::Comment,
            "decimal" => Self::Decimal,
            "eol" => Self::Eol,
            "keyword" => Self::Keyword,
            "minus" => Self::Minus,
            "names" => Self::Names,
            "omit" => Self::Omit,
            "plus" => Self::Plus,
            "root" => Self::Root,
            "separator" => Self::Separator,
            _ => return None,
        })
    }
}

/// The classes of each character.
#[derive(Clone, Debug)]
pub(crate) struct Characters([u16; 256]);

impl Default for Characters {
    /// The classes that Survex's manual gives under `*set`, and Ctrl-Z as the end of DOS's files.
    fn default() -> Self {
        let mut characters = Self([0; 256]);
        for (class, members) in [
            (Class::Blank, &b"\t ,"[..]),
            (Class::Comment, b";"),
            (Class::Decimal, b"."),
            (Class::Eol, b"\n\r\x1a"),
            (Class::Keyword, b"*"),
            (Class::Minus, b"-"),
            (Class::Names, b"_-"),
            (Class::Omit, b"-"),
            (Class::Plus, b"+"),
            (Class::Root, b"\\"),
            (Class::Separator, b"."),
        ] {
            characters.set(class, members);
        }
        characters
    }
}

impl Characters {
    /// The classes for Compass's files, in whose names nearly every character may be.
    pub(crate) fn compass() -> Self {
        let mut characters = Self::default();
        characters.set(Class::Blank, b"\t ");
        for class in [Class::Comment, Class::Keyword, Class::Root, Class::Separator] {
            characters.set(class, b"");
        }
        let names: Vec<u8> = (0x21..=0xff).collect();
        characters.set(Class::Names, &names);
        characters
    }

    /// Puts exactly these characters into the class.
    pub(super) fn set(&mut self, class: Class, members: &[u8]) {
        for classes in &mut self.0 {
            *classes &= !(class as u16);
        }
        for &member in members {
            self.0[usize::from(member)] |= class as u16;
        }
    }

    /// Adds a character to the class.
    pub(super) fn add(&mut self, class: Class, member: u8) {
        self.0[usize::from(member)] |= class as u16;
    }

    /// Adds every character to the classes that it has in another table.
    pub(super) fn merge(&mut self, other: &Self) {
        for (classes, others) in self.0.iter_mut().zip(&other.0) {
            *classes |= others;
        }
    }

    /// Notes the characters that names of Walls may have.
    pub(super) fn note_walls(&mut self) {
        for byte in (0x21..=0xff).filter(|byte| !b":;,\x7f".contains(byte)) {
            self.add(Class::Names, byte);
        }
        self.add(Class::Separator, b':');
    }

    pub(crate) fn is(&self, byte: u8, class: Class) -> bool {
        self.0[usize::from(byte)] & class as u16 != 0
    }

    pub(crate) fn is_name(&self, byte: u8) -> bool {
        byte.is_ascii_alphanumeric() || self.is(byte, Class::Names)
    }
}

/// A position in a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cursor<'a> {
    line: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) const fn new(line: &'a [u8]) -> Self {
        Self { line, at: 0 }
    }

    /// The column, the first being 1.
    pub(crate) const fn column(&self) -> u32 {
        self.at as u32 + 1
    }

    /// How many bytes are read.
    pub(super) const fn offset(&self) -> usize {
        self.at
    }

    pub(crate) fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    pub(crate) fn next(&mut self) {
        self.at += 1;
    }

    /// What is left of the line.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.line.get(self.at..).unwrap_or_default()
    }

    /// Whether the next character is of the class.
    pub(crate) fn sees(&self, class: Class, characters: &Characters) -> bool {
        self.peek().is_some_and(|byte| characters.is(byte, class))
    }

    pub(crate) fn skip_blanks(&mut self, characters: &Characters) {
        while self.sees(Class::Blank, characters) {
            self.next();
        }
    }

    /// Whether nothing but blanks and a comment is left.
    pub(crate) fn is_done(&mut self, characters: &Characters) -> bool {
        self.skip_blanks(characters);
        self.peek().is_none() || self.sees(Class::Comment, characters)
    }

    /// The next field, up to a blank or a comment; empty at the end.
    pub(crate) fn word(&mut self, characters: &Characters) -> &'a [u8] {
        self.skip_blanks(characters);
        let begin = self.at;
        while self.peek().is_some()
            && !self.sees(Class::Blank, characters)
            && !self.sees(Class::Comment, characters)
        {
            self.next();
        }
        &self.line[begin.min(self.line.len())..self.at.min(self.line.len())]
    }

    /// The next letters, in lower case; empty where there are none.
    pub(crate) fn keyword(&mut self, characters: &Characters) -> String {
        self.skip_blanks(characters);
        let letters: String = self
            .rest()
            .iter()
            .map(|&byte| char::from(byte))
            .take_while(char::is_ascii_alphabetic)
            .collect();
        self.at += letters.len();
        letters.to_ascii_lowercase()
    }

    /// The next number: digits with at most one decimal point and a sign before them. `None`, and
    /// nothing read, where there is none.
    pub(crate) fn number(&mut self, characters: &Characters) -> Option<f64> {
        self.skip_blanks(characters);
        let begin = self.at;
        let mut text = String::new();
        if self.sees(Class::Minus, characters) {
            text.push('-');
            self.next();
        } else if self.sees(Class::Plus, characters) {
            self.next();
        }
        let (mut digits, mut point) = (0, false);
        while let Some(byte) = self.peek() {
            if byte.is_ascii_digit() {
                text.push(char::from(byte));
                digits += 1;
            } else if !point && characters.is(byte, Class::Decimal) {
                text.push('.');
                point = true;
            } else {
                break;
            }
            self.next();
        }
        let number = text.parse().ok().filter(|number: &f64| digits > 0 && number.is_finite());
        if number.is_none() {
            self.at = begin;
        }
        number
    }

    /// A text in quotes, or a word; `None` where the closing quote is missing.
    pub(crate) fn quoted(&mut self, characters: &Characters) -> Option<String> {
        self.skip_blanks(characters);
        if self.peek() != Some(b'"') {
            return Some(String::from_utf8_lossy(self.word(characters)).into_owned());
        }
        self.next();
        let length = self.rest().iter().position(|&byte| byte == b'"')?;
        let text = String::from_utf8_lossy(&self.rest()[..length]).into_owned();
        self.at += length + 1;
        Some(text)
    }
}
