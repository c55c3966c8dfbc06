//! The numbers of a mission that matter first, in words, and what is to be said beside a success.

use serde_json::Value;
use units::MissionKind;

use crate::pictures::escaped;

/// From this part of the time on, weak links are told beside a success.
const WEAK: f64 = 0.01;

/// The numbers, each with what it is; nothing where the summary has none of them.
pub(super) fn html(mission: MissionKind, summary: &Value) -> String {
    let numbers = match mission {
        MissionKind::Chain => chain(summary),
        MissionKind::Swarm => swarm(summary),
        MissionKind::Explore => explore(summary),
    };
    let items = numbers.into_iter().flatten().map(|(value, words)| {
        format!("<div><dt>{}</dt><dd>{}</dd></div>", escaped(&value), escaped(&words))
    });
    let items: String = items.collect();
    if items.is_empty() { items } else { format!("<dl class=\"headline\">{items}</dl>") }
}

/// What a reader of "Success" must know as well, each a clause.
pub(super) fn reservations(summary: &Value) -> Vec<String> {
    let mut but = Vec::new();
    let part = |path: &str| number(summary, path);
    if let Some(weak) = part("/metrics/violation").filter(|weak| *weak >= WEAK) {
        but.push(format!(
            "a link was weaker than the launch limit for {} of the time under way",
            percent(weak)
        ));
    }
    // Where no chain was needed, none is too long.
    let surplus = part("/verdict/surplus_at_rest").filter(|_| part("/metrics/needed").is_some());
    if let Some(surplus) = surplus.filter(|surplus| *surplus > 0.0) {
        but.push(format!("relays more than were needed at the end: {surplus:.0}"));
    }
    let counted = [
        ("/metrics/wall_contacts", "contacts with walls"),
        ("/metrics/drone_contacts", "contacts between drones"),
        ("/swarm/lost", "drones lost"),
    ];
    for (path, words) in counted {
        if let Some(count) = part(path).filter(|count| *count > 0.0) {
            but.push(format!("{words}: {count:.0}"));
        }
    }
    but
}

/// A number with the words that say what it is.
type Told = Option<(String, String)>;

fn chain(summary: &Value) -> [Told; 5] {
    let of = |path: &str| number(summary, path);
    let relays = of("/metrics/launched").zip(of("/metrics/needed"));
    let relays = relays.map(|(launched, needed)| {
        (format!("{launched:.0}"), format!("relays flew; the best chain needs {needed:.0}"))
    });
    // A mission that begins with its chain in the air launches none.
    let repaired = of("/metrics/t_repair_s").map(|after| {
        (format!("{after:.0} s"), "after the loss the rest was near its best chain".to_owned())
    });
    let weak = of("/metrics/violation")
        .map(|weak| (percent(weak), "of the time under way a link was too weak".to_owned()));
    let gap = of("/metrics/gap_db").map(|gap| {
        let words = "below the best chain's is the weakest link, at the end of the hold";
        (format!("{gap:.1} dB").replace('-', "\u{2212}"), words.to_owned())
    });
    [
        of("/metrics/farthest_m").filter(|farthest| *farthest > 0.0).map(|farthest| {
            (format!("{farthest:.1} m"), "was the farthest that the head came".to_owned())
        }),
        relays.or(repaired),
        weak.or(gap),
        of("/radio/pilot_delay_p95_s").map(|delay| {
            let words = "at most until an order is at the head, 19 times of 20";
            (format!("{delay:.2} s"), words.to_owned())
        }),
        contacts(summary),
    ]
}

fn swarm(summary: &Value) -> [Told; 5] {
    let of = |path: &str| number(summary, path);
    let has_two = summary.pointer("/swarm/both_areas").and_then(Value::as_bool).unwrap_or(false);
    let (area, first) = if has_two { ("both areas", "first ") } else { ("the area", "") };
    [
        of("/swarm/covered").map(|part| (percent(part), format!("of {area} was surveyed"))),
        of("/swarm/surveyed_s")
            .map(|at| (clock(at), format!("had passed when the {first}survey was done"))),
        of("/swarm/across_s").map(|at| {
            (clock(at), "had passed when all began to land, across the passage".to_owned())
        }),
        closest(of("/swarm/closest_drones_m")),
        contacts(summary),
    ]
}

fn explore(summary: &Value) -> [Told; 5] {
    let of = |path: &str| number(summary, path);
    [
        of("/explore/explored")
            .map(|part| (percent(part), "of what a drone can reach is known".to_owned())),
        of("/explore/t99_s").map(|at| (clock(at), "had passed when 99 % was known".to_owned())),
        of("/explore/ended_s")
            .map(|at| (clock(at), "had passed when the last drone finished exploring".to_owned())),
        closest(of("/explore/closest_drones_m")),
        contacts(summary),
    ]
}

fn closest(metres: Option<f64>) -> Told {
    metres
        .map(|metres| (format!("{metres:.2} m"), "was the least distance of two drones".to_owned()))
}

fn contacts(summary: &Value) -> Told {
    let walls = number(summary, "/metrics/wall_contacts")?;
    let drones = number(summary, "/metrics/drone_contacts")?;
    Some((format!("{:.0}", walls + drones), "contacts with walls or between drones".to_owned()))
}

fn number(summary: &Value, path: &str) -> Option<f64> {
    summary.pointer(path).and_then(Value::as_f64)
}

/// A part of one in per cent; a small one has a decimal.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    if percent > 0.0 && percent < 10.0 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

/// Seconds as minutes and seconds.
fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    format!("{}:{:02} min", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_success_with_weak_links_says_so() {
        let with = |weak: f64| {
            reservations(&json!({ "metrics": { "violation": weak, "wall_contacts": 0 } }))
        };
        assert_eq!(
            with(0.234),
            ["a link was weaker than the launch limit for 23 % of the time under way"]
        );
        assert!(with(0.0).is_empty() && reservations(&json!({})).is_empty());
    }

    #[test]
    fn each_mission_has_its_own_numbers_and_a_recording_none() {
        let summary = json!({
            "metrics": { "farthest_m": 26.5, "launched": 3, "needed": 3, "wall_contacts": 0,
                "drone_contacts": 1 },
            "swarm": { "covered": 1.0, "surveyed_s": 147.6 },
            "explore": { "explored": 0.995, "t99_s": null },
        });
        let chain = html(MissionKind::Chain, &summary);
        assert!(chain.contains("26.5 m") && chain.contains("best chain needs 3"), "{chain}");
        let swarm = html(MissionKind::Swarm, &summary);
        assert!(swarm.contains("100 %") && swarm.contains("2:28 min"), "{swarm}");
        let both = json!({ "swarm": { "both_areas": true, "covered": 1.0, "surveyed_s": 99.0 } });
        let both = html(MissionKind::Swarm, &both);
        assert!(both.contains("both areas") && both.contains("first survey"), "{both}");
        let explore = html(MissionKind::Explore, &summary);
        assert!(explore.contains("<dt>100 %</dt>") && !explore.contains("99 % was"), "{explore}");
        assert_eq!(html(MissionKind::Chain, &json!({})), "");
    }
}
