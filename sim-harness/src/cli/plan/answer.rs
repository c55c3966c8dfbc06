//! The answer of `uchain plan relays`: where relays would stand, how strong their links would be, and
//! what ends the flight.

use std::fmt::Write;

use input::counted;
use serde_json::{Value, json};

use planning::plan::{Limit, MOST_RELAYS, RelayPlan, Stand};
use scenario::Scenario;

/// A place of the way by station, where the way is a route of a survey.
fn by_station(scenario: &Scenario, stand: &Stand) -> Option<String> {
    scenario.route.as_ref()?.by_station(stand.along_m)
}

/// What ends the route of a map, where the way leads to its end.
fn end_of_route(scenario: &Scenario, plan: &RelayPlan) -> Option<String> {
    let route = scenario.route.as_ref()?;
    let last = route.marks.last()?;
    (plan.way_m + 0.5 >= last.along_m).then(|| format!("{}: {}", route.to, route.ended))
}

/// The answer as JSON.
#[must_use]
pub fn json(scenario: &Scenario, plan: &RelayPlan) -> Value {
    let stands = plan.stands.iter().map(|stand| {
        let station = by_station(scenario, stand);
        json!({ "along_m": stand.along_m, "x_m": stand.at.x, "y_m": stand.at.y, "station": station })
    });
    let links = plan.links.iter().map(|link| {
        json!({
            "length_m": link.length_m,
            "strength_dbm": link.strength.0,
            "over_launch_db": link.over_launch.0,
            "over_retreat_db": link.over_retreat.0,
        })
    });
    let needed = plan.needed.iter().map(|it| json!({ "depth_m": it.depth_m, "relays": it.relays }));
    json!({
        "scenario": scenario.name,
        "relays": plan.links.len() - 1,
        "way_m": plan.way_m,
        "reached_m": plan.reached_m,
        "least_dbm": plan.least.0,
        "stands": stands.collect::<Vec<_>>(),
        "links": links.collect::<Vec<_>>(),
        "needed": needed.collect::<Vec<_>>(),
        "limit": plan.limit().name(),
        "limit_fetched": plan.limit_fetched().name(),
        "route_ends": end_of_route(scenario, plan),
        "battery": {
            "endurance_s": plan.reach.endurance_s,
            "stay_s": plan.reach.stay_s,
            "farthest_m": plan.reach.farthest_m,
            "relays": plan.relays_by_battery(),
        },
    })
}

/// The answer for people.
#[must_use]
pub fn table(scenario: &Scenario, plan: &RelayPlan) -> String {
    let relays = plan.links.len() - 1;
    let mut text = format!(
        "{}: {} for {:.1} m, no link weaker than {:.1}\n\n\
         {:10} {:>8} {:>8} {:>8}   {:>8} {:>10} {:>12} {:>13}\n",
        scenario.name,
        counted(relays, "relay"),
        plan.reached_m,
        plan.least,
        "",
        "way, m",
        "x, m",
        "y, m",
        "link, m",
        "dBm",
        "over launch",
        "over retreat"
    );
    for (n, stand) in plan.stands.iter().enumerate() {
        let name = match n {
            0 => "base".to_owned(),
            n if n == relays + 1 => "head".to_owned(),
            // The relay next to the head flies first.
            n => format!("relay {}", relays + 1 - n),
        };
        let _ =
            write!(text, "{name:10} {:8.1} {:8.1} {:8.1}", stand.along_m, stand.at.x, stand.at.y);
        match n.checked_sub(1).and_then(|before| plan.links.get(before)) {
            Some(link) => {
                let _ = write!(
                    text,
                    "   {:8.1} {:10.1} {:9.1} dB {:10.1} dB",
                    link.length_m, link.strength.0, link.over_launch.0, link.over_retreat.0
                );
            }
            // So that stations stand below each other.
            None if by_station(scenario, stand).is_some() => text.push_str(&" ".repeat(49)),
            None => {}
        }
        if let Some(station) = by_station(scenario, stand) {
            let _ = write!(text, "   {station}");
        }
        text.push('\n');
    }
    text.push('\n');
    ends(&mut text, scenario, plan);
    text
}

/// The lines about what ends the flight.
fn ends(text: &mut String, scenario: &Scenario, plan: &RelayPlan) {
    let steps: Vec<_> =
        plan.needed.iter().map(|it| format!("{} to {:.0} m", it.relays, it.depth_m)).collect();
    let _ = writeln!(text, "relays needed: {}", steps.join(", "));
    let reach = plan.reach;
    let _ = writeln!(
        text,
        "a new, full battery hovers for {:.0} s; that of the head calls the chain home {}",
        reach.endurance_s,
        match plan.limit() {
            Limit::Battery => format!(
                "at {:.1} m, which takes {}",
                reach.farthest_m,
                counted(plan.relays_by_battery(), "relay")
            ),
            _ => format!("after {:.0} s at the end", reach.stay_s),
        }
    );
    let words = |limit: Limit| match limit {
        Limit::Battery => format!("the battery, at {:.1} m", reach.farthest_m),
        Limit::Radio => format!("the radio, at {:.1} m with {MOST_RELAYS} relays", plan.reached_m),
        Limit::Way => format!("the way, at {:.1} m", plan.way_m),
    };
    let [home, fetched] = [plan.limit(), plan.limit_fetched()].map(words);
    let _ = match home == fetched {
        true => writeln!(text, "limit: {home}"),
        false => writeln!(text, "limit: {home}; where drones land and are fetched, {fetched}"),
    };
    if let Some(end) = end_of_route(scenario, plan) {
        let _ = writeln!(text, "the route ends at {end}");
    }
}
