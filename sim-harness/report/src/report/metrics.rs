//! The summary as a table of names and values. What a mission does not have is left out, and a name that is
//! no plain word says on hover what it means.

use std::fmt::Write;

use serde_json::{Map, Value};
use units::MissionKind;

use super::meanings::meaning;
use crate::pictures::escaped;

/// Objects within objects become sections, to this depth; deeper ones are shown as JSON.
const DEPTH: usize = 3;

/// Every entry of the summary that says something of this mission.
pub(super) fn html(mission: MissionKind, summary: &Value) -> String {
    let mut out = String::new();
    match summary {
        Value::Object(entries) => section(&mut out, mission, "", entries, DEPTH),
        Value::Null => out.push_str("<p class=\"quiet\">There is no summary.</p>"),
        other => out.push_str(&escaped(&shown(other))),
    }
    out
}

fn section(
    out: &mut String,
    mission: MissionKind,
    title: &str,
    entries: &Map<String, Value>,
    depth: usize,
) {
    let is_section = |value: &Value| value.is_object() && depth > 0;
    let is_other = |key: &str| mission != MissionKind::Chain && OF_CHAINS.contains(&key);
    let is_shown = |key: &str, value: &Value| {
        !is_section(value) && !is_empty(value) && !is_above(key) && !is_other(key)
    };
    let has_own = entries.iter().any(|(key, value)| is_shown(key, value));
    if !title.is_empty() && has_own {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "<h3>{}</h3>", escaped(title));
    }
    out.push_str(if has_own { "<dl class=\"metrics\">\n" } else { "" });
    for (key, value) in entries.iter().filter(|(key, value)| is_shown(key, value)) {
        let (name, unit) = named(key);
        let value = if unit.is_empty() || !value.is_number() {
            shown(value)
        } else {
            format!("{} {unit}", shown(value))
        };
        // A screen that is touched has no hover: there the words stand below.
        let (hint, below) = meaning(key).map_or_else(Default::default, |words| {
            let words = escaped(words);
            (format!(" title=\"{words}\""), format!("<small class=\"meaning\">{words}</small>"))
        });
        let (name, value) = (escaped(&name), escaped(&value));
        let _ = writeln!(out, "<div{hint}><dt>{name}</dt><dd>{value}{below}</dd></div>");
    }
    out.push_str(if has_own { "</dl>\n" } else { "" });
    for (key, value) in entries {
        if let (Value::Object(inner), true) = (value, depth > 0 && !is_empty(value)) {
            let (name, _) = named(key);
            let title = if title.is_empty() { name } else { format!("{title} \u{203a} {name}") };
            section(out, mission, &title, inner, depth - 1);
        }
    }
}

/// Whether a value says nothing.
fn is_empty(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(values) => values.is_empty(),
        Value::Object(entries) => entries.values().all(is_empty),
        Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}

/// What is said of chains alone: a swarm and explorers have no head, no hold and no movement policy.
const OF_CHAINS: [&str; 6] =
    ["policy", "no_hold", "farthest_m", "t_farthest_s", "head_heard_until_s", "order_lost"];

/// Whether the page's head says it already.
fn is_above(key: &str) -> bool {
    ["title", "success", "failures"].contains(&key)
}

/// The endings of metric names, and the units that they stand for, longest first.
const UNITS: [(&str, &str); 14] = [
    ("_mps", "m/s"),
    ("_dps", "\u{b0}/s"),
    ("_deg", "\u{b0}"),
    ("_v", "V"),
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
        Value::Array(values)
            if !values.is_empty() && values.iter().all(|it| state(it).is_some()) =>
        {
            counted_states(values.iter().filter_map(state))
        }
        Value::Array(values) if values.len() <= 12 => {
            values.iter().map(shown).collect::<Vec<_>>().join(", ")
        }
        Value::Array(values) => format!("{} values", values.len()),
        Value::Object(_) => value.to_string(),
    }
}

/// The state of a drone in the summary's list of drones.
fn state(value: &Value) -> Option<&str> {
    value.get("id").and(value.get("state")).and_then(Value::as_str)
}

/// How many drones are in each state, in the order in which states come: `3 landed, 1 idle`.
fn counted_states<'a>(states: impl Iterator<Item = &'a str>) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for state in states {
        match counts.iter_mut().find(|(known, _)| *known == state) {
            Some((_, count)) => *count += 1,
            None => counts.push((state, 1)),
        }
    }
    let words = counts.into_iter().map(|(state, count)| format!("{count} {state}"));
    words.collect::<Vec<_>>().join(", ")
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
        let out = html(
            MissionKind::Chain,
            &serde_json::json!({ "gap_db": -1.25, "ok": true, "link": { "n": 2 } }),
        );
        assert!(out.contains("<dt>Gap</dt><dd>\u{2212}1.25 dB<small"), "{out}");
        assert!(out.contains("<dd>yes</dd>") && out.contains("<h3>Link</h3>"));
    }

    #[test]
    fn what_says_nothing_is_left_out_and_hard_words_are_explained() {
        let out = html(
            MissionKind::Chain,
            &serde_json::json!({
                "metrics": { "t3_s": null, "violation": 0.1, "failures": [] },
                "empty": { "came_m": null },
                "drones": [{ "id": 0, "state": "landed" }, { "id": 1, "state": "idle" }],
            }),
        );
        assert!(
            !out.contains("T3") && !out.contains("Empty") && !out.contains("Failures"),
            "{out}"
        );
        assert!(out.contains("title=\"part of the time under way"), "{out}");
        assert!(out.contains("<dd>1 landed, 1 idle<small"), "{out}");
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
