//! The summary of a mission as a table for people.

use std::fmt::Write;

use maps::Route;

use measure::metrics::{ExploreMetrics, RunMetrics, SwarmMetrics};
use measure::verdict::Judgement;
use mission::trace::Trace;
use report::last_states;
use scenario::Scenario;
use units::MissionKind;

/// The most hindrances that are listed.
const MOST_LISTED: usize = 5;

/// The route, and why it leads no farther.
fn route_lines(text: &mut String, route: &Route, reach_m: f32) {
    let Route { from, to, length_m, stations, assumed_widths, .. } = route;
    let _ = writeln!(text, "  route                 {from} to {to}, {length_m:.1} m");
    let _ = writeln!(
        text,
        "  passage widths        {} measured, {assumed_widths} assumed",
        stations.saturating_sub(*assumed_widths)
    );
    if route.long_reach_m.is_some() {
        let width = route.median_width_m;
        let _ = match reach_m >= 0.5 * width * core::f32::consts::SQRT_2 {
            true => writeln!(
                text,
                "  side rangers          reach {reach_m} m, for a passage {width:.1} m wide"
            ),
            false => writeln!(
                text,
                "  side rangers          reach {reach_m} m, and see no wall from the middle of a passage {width:.1} m wide"
            ),
        };
    }
    let (sides, others) = (route.side_galleries, route.above_or_below);
    if sides + others > 0 {
        let hidden = match others {
            0 => String::new(),
            others => format!("; {others} on other levels left out"),
        };
        let _ = writeln!(text, "  side galleries        {sides}{hidden}");
    }
    let _ = writeln!(text, "  route ends            {}", route.ended);
    let aside: Vec<_> = route.hindrances_aside().collect();
    for hindrance in aside.iter().take(MOST_LISTED) {
        let _ = writeln!(text, "  not flown             {hindrance}");
    }
    match aside.len().saturating_sub(MOST_LISTED) {
        0 => {}
        more => {
            let _ = writeln!(text, "  not flown             {more} legs more");
        }
    }
}

/// The table of one mission.
pub(super) fn table(
    scenario: &Scenario,
    seed: u64,
    trace: &Trace,
    m: &RunMetrics,
    judgement: &Judgement,
    failures: &[String],
) -> String {
    let mut text = match failures {
        [] => "success\n".to_owned(),
        failures => failures.iter().map(|failure| format!("failure: {failure}\n")).collect(),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}: {}", scenario.name, scenario.title);
    let duration = scenario.duration_s();
    let _ = match scenario.mission {
        MissionKind::Chain => writeln!(
            text,
            "  {duration:.0} s, seed {seed}, policy {}, head reached {:.1} m\n",
            scenario.policy, m.farthest_m
        ),
        mission => writeln!(text, "  {duration:.0} s, seed {seed}, mission {}\n", mission.name()),
    };
    verdict_lines(&mut text, judgement);
    if let Some(route) = &scenario.route {
        route_lines(&mut text, route, scenario.vehicle.reach);
    }
    if m.launched.is_finite() {
        let _ = writeln!(
            text,
            "  relays flown          {} ({} in an optimal chain)",
            m.launched, m.needed
        );
    }
    match (&m.swarm, &m.explore) {
        (Some(swarm), _) => swarm_lines(&mut text, swarm),
        (_, Some(explore)) => explore_lines(&mut text, explore),
        (None, None) => hold_lines(&mut text, m),
    }
    if let Ok(hold) = m.hold.as_ref()
        && !hold.t_repair_s.is_nan()
    {
        let _ = match hold.t_repair_s.is_finite() {
            true => {
                writeln!(text, "  repaired              {:.1} s after the loss", hold.t_repair_s)
            }
            false => writeln!(text, "  repaired              never"),
        };
    }
    if m.violation.is_finite() {
        let _ = writeln!(text, "  link below limit      {:.1} % of the time", 100.0 * m.violation);
    }
    let standing = match m.ground_contacts {
        0 => String::new(),
        n => format!(", {n} of drones on the ground"),
    };
    let _ = writeln!(
        text,
        "  touches               {} of walls, {} of drones{standing}",
        m.wall_contacts, m.drone_contacts
    );
    if let Some(flight) = &m.flight {
        let _ = writeln!(
            text,
            "  flight                {} take-offs, {} landings; tilt to {:.0}°, velocity known to \
             {:.3} m/s, battery down to {:.2} V",
            flight.take_offs,
            flight.landings,
            flight.max_tilt_deg,
            flight.velocity_error_mps,
            flight.min_battery_v
        );
    }
    let states: Vec<_> =
        last_states(trace).map(|(node, state)| format!("{node} {}", state.name())).collect();
    let _ = writeln!(text, "  at the end            {}", states.join(", "));
    text
}

/// The lines about what the head did, and why its exploration ended.
fn verdict_lines(text: &mut String, judgement: &Judgement) {
    let Judgement { came_m, could_m, stood_s, surplus_at_rest, ended, .. } = judgement;
    if let Some(ended) = ended {
        let _ = writeln!(text, "  exploration ended     {}", ended.words());
        let _ = writeln!(
            text,
            "  head                  came to {came_m:.1} m, and could have come to {could_m:.1} m"
        );
    }
    if *stood_s > 0.0 {
        let _ = writeln!(
            text,
            "  head stood            {stood_s:.0} s while the pilot pushed and relays waited"
        );
    }
    if *surplus_at_rest > 0.0 {
        let _ = writeln!(text, "  relays beyond need    {surplus_at_rest:.1} at rest");
    }
}

/// The line about when something came to be.
fn when(text: &mut String, what: &str, at: f32) {
    let _ = match at.is_finite() {
        true => writeln!(text, "  {what:21} after {at:.0} s"),
        false => writeln!(text, "  {what:21} never"),
    };
}

/// The lines about an exploration.
fn explore_lines(text: &mut String, explore: &ExploreMetrics) {
    let percent = |part: f32| format!("{:.1} %", 100.0 * part);
    let ExploreMetrics { explored, walls_found, false_walls, false_free, .. } = *explore;
    let _ = writeln!(
        text,
        "  explored              {} of what the drones can come to",
        percent(explored)
    );
    if walls_found.is_finite() {
        let _ = writeln!(text, "  walls found           {}", percent(walls_found));
    }
    let _ = writeln!(
        text,
        "  wrong in the maps     {} of the walls, {} of what is free",
        percent(or_zero(false_walls)),
        percent(or_zero(false_free))
    );
    when(text, "half of it", explore.t50_s);
    when(text, "99 % of it", explore.t99_s);
    when(text, "nothing left for all", explore.ended_s);
    let _ = writeln!(text, "  closest drones        {:.2} m", explore.closest_drones_m);
}

/// The part, or 0 where there is nothing of which it could be a part.
fn or_zero(part: f32) -> f32 {
    if part.is_nan() { 0.0 } else { part }
}

/// The lines about a swarm.
fn swarm_lines(text: &mut String, swarm: &SwarmMetrics) {
    let lost = match swarm.lost {
        0 => String::new(),
        lost => format!(", drones lost: {lost}"),
    };
    let _ = writeln!(text, "  area flown over       {:.1} %{lost}", 100.0 * swarm.covered);
    when(text, "rows flown", swarm.surveyed_s);
    when(text, "into the passage", swarm.gathered_s);
    when(text, "all across", swarm.across_s);
    let _ = writeln!(text, "  closest drones        {:.2} m", swarm.closest_drones_m);
}

/// The lines about the hold.
fn hold_lines(text: &mut String, m: &RunMetrics) {
    let hold = match &m.hold {
        Ok(hold) => hold,
        Err(why) => {
            let _ = writeln!(text, "  hold                  n/a: {why}");
            return;
        }
    };
    let _ = writeln!(text, "  hold                  {:.0} s to {:.0} s", hold.from_s, hold.until_s);
    let _ = match hold.t3_s.is_finite() {
        true => writeln!(text, "  links within 3 dB     from {:.1} s of the hold on", hold.t3_s),
        false => writeln!(text, "  links                 never stayed within 3 dB"),
    };
    let _ = writeln!(text, "  end of the hold       links differ by {:.2} dB,", hold.difference_db);
    let _ = writeln!(
        text,
        "                        the weakest is {:.2} dB below the optimum,",
        hold.gap_db
    );
    let _ = writeln!(
        text,
        "                        95 % swing by less than {:.2} dB",
        hold.swing_p95_db
    );
}
