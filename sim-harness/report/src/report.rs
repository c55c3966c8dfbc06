//! Makes `report.html`, a page that replays the mission.
//!
//! Style, script, pictures and data are all in the one file, so that it can be mailed and needs no
//! network. `assets/report/` holds the page with `{{gaps}}`; this module fills them.

mod data;
mod headline;
mod meanings;
mod metrics;

use input::counted;
use serde_json::Value;

use super::pictures::{self, Picture, PictureError, escaped, palette};
use mission::trace::Trace;
use units::MissionKind;

const PAGE: &str = include_str!("../../assets/report/report.html");
const STYLE: &str = include_str!("../../assets/report/report.css");
const SCRIPT: &str = include_str!("../../assets/report/report.js");

/// Makes the page for a mission and its summary, a JSON object whose entries are all shown. Names
/// and texts are escaped, so that none of them becomes markup.
///
/// # Errors
/// See [`PictureError`].
pub fn html(trace: &Trace, summary: &Value) -> Result<String, PictureError> {
    let charts = pictures::over_time(trace)?;
    let map = pictures::map(trace)?;
    let filled = |gap: &str| match gap {
        "name" => escaped(&trace.scenario),
        "title" => escaped(title(trace, summary)),
        "verdict" => verdict(summary),
        "headline" => headline::html(trace.mission, summary),
        "charts" => section(&charts),
        "subtitle" => escaped(&subtitle(trace)),
        "style" => format!("{}{STYLE}", palette::style()),
        "script" => SCRIPT.to_owned(),
        "map" => map.svg().to_owned(),
        "summary" => metrics::html(trace.mission, summary),
        "data" => data::json(trace, summary, &charts),
        _ => String::new(),
    };
    Ok(fill(PAGE, filled))
}

/// The charts over time, if there are any.
fn section(charts: &[(&str, Picture)]) -> String {
    if charts.is_empty() {
        return String::new();
    }
    let figure = |(name, chart): &(&str, Picture)| {
        format!("<figure class=\"card picture\" id=\"{name}\">{}</figure>", chart.svg())
    };
    let figures: Vec<String> = charts.iter().map(figure).collect();
    format!(
        "<section aria-label=\"Charts over time\" id=\"charts\">\n    {}\n  </section>",
        figures.join("\n    ")
    )
}

/// The scenario's title, or its name where the summary has no title.
fn title<'a>(trace: &'a Trace, summary: &'a Value) -> &'a str {
    summary.get("title").and_then(Value::as_str).unwrap_or(&trace.scenario)
}

/// Whether the mission succeeded, and if not, why; nothing where the summary does not judge it.
fn verdict(summary: &Value) -> String {
    let Some(success) = summary.get("success").and_then(Value::as_bool) else {
        return String::new();
    };
    if success {
        let but = headline::reservations(summary);
        let words = if but.is_empty() { "Success" } else { "Success, but" };
        return format!("<p class=\"verdict good\">{words}</p>{}", list(&but));
    }
    let failures = summary.get("failures").and_then(Value::as_array);
    let items = failures.into_iter().flatten().filter_map(Value::as_str);
    let items: Vec<String> = items.map(str::to_owned).collect();
    format!("<p class=\"verdict bad\">Failure</p>\n  {}", list(&items))
}

fn list(items: &[String]) -> String {
    if items.is_empty() {
        return String::new();
    }
    let items: String = items.iter().map(|why| format!("<li>{}</li>", escaped(why))).collect();
    format!("<ul class=\"failures\">{items}</ul>")
}

fn subtitle(trace: &Trace) -> String {
    let seconds = trace.frames.last().map_or(0, |frame| frame.time_us / 1_000_000);
    let is_counted = |role| match trace.mission {
        MissionKind::Chain => role == units::Role::Relay,
        MissionKind::Swarm | MissionKind::Explore => role != units::Role::Base,
    };
    let drones = trace.nodes.iter().filter(|node| is_counted(node.role)).count();
    let name = match trace.mission {
        MissionKind::Chain => "relay",
        MissionKind::Swarm => "drone",
        MissionKind::Explore => "explorer",
    };
    let (minutes, rest) = (seconds / 60, seconds % 60);
    let scenario = &trace.scenario;
    let origin = match trace.seed {
        Some(seed) => format!("seed {seed}"),
        None => "recorded".to_owned(),
    };
    // A long mission is thinned.
    let step = trace.frames.get(1).zip(trace.frames.first());
    let step = step.map_or(0, |(second, first)| second.time_us.saturating_sub(first.time_us));
    let shown = match step / 100_000 {
        0..=2 => String::new(),
        tenths => format!(" \u{b7} shown every {}.{} s", tenths / 10, tenths % 10),
    };
    format!(
        "{scenario} \u{b7} {minutes} min {rest} s with {} \u{b7} {origin}{shown}",
        counted(drones, name)
    )
}

/// Replaces every `{{gap}}` of the page, in one pass: a gap within a filled-in text stays as it is.
fn fill(page: &str, filled: impl Fn(&str) -> String) -> String {
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some((before, after)) = rest.split_once("{{") {
        out.push_str(before);
        let Some((gap, after)) = after.split_once("}}") else {
            rest = after;
            break;
        };
        out.push_str(&filled(gap));
        rest = after;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::synthetic;

    #[test]
    fn no_text_of_the_scenario_becomes_markup() {
        let trace = synthetic::mission();
        let evil = "</script><script>alert(1)</script><!-- {{data}} ]]>";
        let trace = Trace { scenario: evil.to_owned(), ..trace };
        let page = html(&trace, &json!({ evil: evil, "nested": { "<b>": ["<i>", 1] } })).unwrap();
        assert!(!page.contains("<script>alert") && !page.contains("<b>") && !page.contains("<i>"));
        // The page's own two scripts, and no gap left open.
        assert_eq!(page.matches("</script>").count(), 2);
        assert_eq!(page.matches("{{data}}").count(), html_copies(&page));
    }

    /// How often the name is shown: as text, `{{data}}` within it must have stayed itself.
    fn html_copies(page: &str) -> usize {
        page.matches("{{data}} ]]").count()
    }

    #[test]
    fn the_verdict_and_its_reasons_come_before_all_else() {
        let failed = json!({ "title": "A cave", "success": false, "failures": ["fell & broke"] });
        let page = html(&synthetic::mission(), &failed).unwrap();
        let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
        let header = &page[at("<header>")..at("</header>")];
        for text in ["Failure", "A cave", "fell &amp; broke", "seed 42"] {
            assert!(header.contains(text), "{text}: {header}");
        }
        let page = html(&synthetic::mission(), &json!({ "success": true })).unwrap();
        assert!(page.contains("<p class=\"verdict good\">Success</p>"));
        assert!(!html(&synthetic::mission(), &json!({})).unwrap().contains("class=\"verdict"));
    }

    #[test]
    fn nothing_is_fetched() {
        let page = html(&synthetic::mission(), &json!({})).unwrap();
        for outside in ["src=", "href=", "url(", "@import", "fetch(", "XMLHttpRequest"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }

    #[test]
    fn a_mission_without_frames_is_still_a_page() {
        let mut trace = synthetic::mission();
        trace.frames.clear();
        assert!(html(&trace, &json!(null)).unwrap().contains("</html>"));
        let nothing = Trace { nodes: Vec::new(), floor_plan: Default::default(), ..trace };
        assert!(html(&nothing, &json!(null)).unwrap().contains("</html>"));
    }
}
