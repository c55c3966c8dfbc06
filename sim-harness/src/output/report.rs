//! `report.html`: the mission as one page that plays it.
//!
//! Style, script, pictures and data are all in the file, so it can be mailed, opened from a stick
//! and looked at in ten years. The page itself lies in `assets/report/`; here its gaps are filled.

mod data;
mod metrics;

use super::pictures::{self, PictureError, escaped};
use crate::trace::Trace;

const PAGE: &str = include_str!("../../assets/report/report.html");
const STYLE: &str = include_str!("../../assets/report/report.css");
const SCRIPT: &str = include_str!("../../assets/report/report.js");

/// The page for a mission and the summary of it: any JSON object, of which every number, text and
/// truth value is shown. Whatever stands in names and texts is shown as text.
///
/// # Errors
/// See [`PictureError`].
pub fn html(trace: &Trace, summary: &serde_json::Value) -> Result<String, PictureError> {
    let positions = pictures::positions(trace)?;
    let links = pictures::links(trace)?;
    let map = pictures::map(trace)?;
    let filled = |gap: &str| match gap {
        "title" => escaped(&trace.scenario),
        "subtitle" => subtitle(trace),
        "style" => STYLE.to_owned(),
        "script" => SCRIPT.to_owned(),
        "positions" => positions.svg().to_owned(),
        "links" => links.svg().to_owned(),
        "map" => map.svg().to_owned(),
        "summary" => metrics::html(summary),
        "data" => data::json(trace, positions.frames(), links.frames()),
        _ => String::new(),
    };
    Ok(fill(PAGE, filled))
}

fn subtitle(trace: &Trace) -> String {
    let seconds = trace.frames.last().map_or(0, |frame| frame.time_us / 1_000_000);
    let relays = trace.nodes.iter().filter(|node| node.role == units::Role::Relay).count();
    let (minutes, rest) = (seconds / 60, seconds % 60);
    let plural = if relays == 1 { "" } else { "s" };
    format!("{minutes} min {rest} s with {relays} relay{plural} \u{b7} seed {}", trace.seed)
}

/// Replaces every `{{gap}}` of the page, in one pass: what is filled in is never looked at again.
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
    use crate::output::synthetic;

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
