//! The summary as a table of names and values.

use std::fmt::Write;

use serde_json::{Map, Value};

use crate::pictures::escaped;

/// Objects within objects become sections, to this depth; deeper ones are shown as JSON.
const DEPTH: usize = 3;

/// Every entry of the summary.
pub(super) fn html(summary: &Value) -> String {
    let mut out = String::new();
    match summary {
        Value::Object(entries) => section(&mut out, "", entries, DEPTH),
        Value::Null => out.push_str("<p class=\"quiet\">There is no summary.</p>"),
        other => out.push_str(&escaped(&shown(other))),
    }
    out
}

fn section(out: &mut String, title: &str, entries: &Map<String, Value>, depth: usize) {
    if !title.is_empty() {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "<h3>{}</h3>", escaped(title));
    }
    let is_section = |value: &Value| value.is_object() && depth > 0;
    out.push_str("<dl class=\"metrics\">\n");
    for (key, value) in entries.iter().filter(|(_, value)| !is_section(value)) {
        let (name, unit) = named(key);
        let value = if unit.is_empty() || !value.is_number() {
            shown(value)
        } else {
            format!("{} {unit}", shown(value))
        };
        let _ = writeln!(out, "<div><dt>{}</dt><dd>{}</dd></div>", escaped(&name), escaped(&value));
    }
    out.push_str("</dl>\n");
    for (key, value) in entries {
        if let (Value::Object(inner), true) = (value, depth > 0) {
            let (name, _) = named(key);
            let title = if title.is_empty() { name } else { format!("{title} \u{203a} {name}") };
            section(out, &title, inner, depth - 1);
        }
    }
}

/// The endings of metric names, and the units that they stand for, longest first.
const UNITS: [(&str, &str); 10] = [
    ("_rad_s", "rad/s"),
    ("_percent", "%"),
    ("_m_s", "m/s"),
    ("_dbm", "dBm"),
    ("_rad", "rad"),
    ("_db", "dB"),
    ("_m2", "m\u{b2}"),
    ("_hz", "Hz"),
    ("_m", "m"),
    ("_s", "s"),
];

/// A metric's name in words, and its unit: `mean_gap_db` is the `Mean gap` in `dB`.
fn named(key: &str) -> (String, &'static str) {
    let unit = UNITS.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, *unit)));
    let (stem, unit) = unit.filter(|(stem, _)| !stem.is_empty()).unwrap_or((key, ""));
    let words = stem.replace('_', " ");
    let mut letters = words.chars();
    let name = letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect());
    (name, unit)
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "\u{2013}".to_owned(),
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        Value::Number(number) => match number.as_f64() {
            Some(real) if !number.is_i64() && !number.is_u64() => short(real),
            _ => number.to_string().replace('-', "\u{2212}"),
        },
        Value::String(text) => text.clone(),
        Value::Array(values) if values.len() <= 12 => {
            values.iter().map(shown).collect::<Vec<_>>().join(", ")
        }
        Value::Array(values) => format!("{} values", values.len()),
        Value::Object(_) => value.to_string(),
    }
}

/// Three decimals below ten, two below a hundred, one above; without zeros at the end.
fn short(real: f64) -> String {
    let decimals = match real.abs() {
        size if size < 1e-3 && size > 0.0 => return format!("{real:.2e}"),
        size if size < 10.0 => 3,
        size if size < 100.0 => 2,
        _ => 1,
    };
    let text = format!("{real:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_their_unit_and_values_gain_it() {
        assert_eq!(named("mean_link_gap_db"), ("Mean link gap".to_owned(), "dB"));
        assert_eq!(named("top_speed_m_s"), ("Top speed".to_owned(), "m/s"));
        assert_eq!(named("relays"), ("Relays".to_owned(), ""));
        let out = html(&serde_json::json!({ "gap_db": -1.25, "ok": true, "link": { "n": 2 } }));
        assert!(out.contains("<dt>Gap</dt><dd>\u{2212}1.25 dB</dd>"));
        assert!(out.contains("<dd>yes</dd>") && out.contains("<h3>Link</h3>"));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(short(0.12345), "0.123");
        assert_eq!(short(34.0), "34");
        assert_eq!(short(1234.56), "1234.6");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.000_012), "1.20e-5");
    }
}
