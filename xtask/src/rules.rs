//! The two tables of exceptions, `panics.toml` and `stack.toml`, and the names with wildcards in
//! them.

use std::cell::Cell;
use std::fmt;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::Result;

/// A function's name; `*` stands for any run of characters. Remembers whether it ever matched.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "String")]
pub(crate) struct Pattern {
    text: String,
    used: Cell<bool>,
}

impl From<String> for Pattern {
    fn from(text: String) -> Self {
        Self { text, used: Cell::new(false) }
    }
}

impl Pattern {
    pub(crate) fn matches(&self, name: &str) -> bool {
        let matches = fits(&self.text, name);
        self.used.set(self.used.get() || matches);
        matches
    }

    pub(crate) fn was_used(&self) -> bool {
        self.used.get()
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn fits(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// Which panics are left, and why.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Panics {
    /// Crates that must not have any.
    pub(crate) ours: Vec<String>,
    /// Panic functions whose calls the compiler makes up, in anyone's code.
    #[serde(default)]
    pub(crate) generated: Vec<Because>,
    /// Functions of others that may call a panic.
    #[serde(default)]
    pub(crate) allowed: Vec<Allowed>,
}

/// A function of others, and why it does not panic here.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Allowed {
    pub(crate) function: Pattern,
    /// Only where it was inlined into this one.
    pub(crate) within: Option<Pattern>,
    pub(crate) why: String,
}

/// A function, and why it is listed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Because {
    pub(crate) function: Pattern,
    pub(crate) why: String,
}

/// The facts about the stack that the disassembly does not show.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stack {
    /// The targets of calls through pointers; the first rule that fits a call counts.
    #[serde(default)]
    pub(crate) indirect: Vec<Indirect>,
    /// Functions that call themselves, by whatever way.
    #[serde(default)]
    pub(crate) recursion: Vec<Recursion>,
    /// Functions that are linked and never called.
    #[serde(default)]
    pub(crate) unreached: Vec<Because>,
    /// The interrupts' priorities.
    #[serde(default)]
    pub(crate) level: Vec<Level>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Indirect {
    /// A function that the call is in, inlined or not.
    pub(crate) at: Pattern,
    /// Another that it must be in as well.
    pub(crate) within: Option<Pattern>,
    pub(crate) calls: Vec<Pattern>,
    #[serde(rename = "why")]
    pub(crate) _why: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Recursion {
    pub(crate) function: Pattern,
    /// The most times that it is active at once.
    pub(crate) times: u32,
    #[serde(rename = "why")]
    pub(crate) _why: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Level {
    /// The priority as the NVIC counts: 0 is the most urgent.
    pub(crate) priority: u8,
    pub(crate) handlers: Vec<Pattern>,
    #[serde(rename = "why")]
    pub(crate) _why: String,
}

/// Reads a table that was compiled in.
pub(crate) fn read<T: DeserializeOwned>(name: &str, text: &str) -> Result<T> {
    toml::from_str(text).map_err(|why| format!("{name}: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, name, matches) in [
            ("main", "main", true),
            ("main", "mains", false),
            ("a*", "a", true),
            ("a*", "abc", true),
            ("*c", "abc", true),
            ("a*b*c", "a-b-b-c", true),
            ("a*b*c", "a-c", false),
            ("*poll*", "<embassy_executor::raw::TaskStorage<f>>::poll", true),
            ("", "", true),
            ("", "x", false),
            ("ab*ba", "aba", false),
        ] {
            assert_eq!(fits(pattern, name), matches, "{pattern} {name}");
        }
    }

    #[test]
    fn a_pattern_remembers_that_it_was_of_use() {
        let pattern = Pattern::from("a*".to_owned());
        assert!(!pattern.matches("b") && !pattern.was_used());
        assert!(pattern.matches("ab") && pattern.was_used());
    }

    #[test]
    fn the_tables_that_are_checked_in_can_be_read() {
        read::<Panics>("panics.toml", include_str!("../panics.toml")).unwrap();
        read::<Stack>("stack.toml", include_str!("../stack.toml")).unwrap();
    }

    #[test]
    fn a_misspelt_key_is_an_error() {
        assert!(read::<Panics>("p", "ours = []\n[[alowed]]\nfunction = \"\"\nwhy = \"\"").is_err());
    }
}
