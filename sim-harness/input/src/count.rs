//! Counts with their nouns.

/// A count and its noun, which takes an s but for one: "1 relay", "2 relays".
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}
