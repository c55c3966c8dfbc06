//! What the figures of a summary mean, in the words of the book's chapter on metrics.

/// What a figure means; `None` for a name that no summary has.
pub(super) fn meaning(key: &str) -> Option<&'static str> {
    let mut all = ALL.iter().flat_map(|group| group.iter());
    all.find(|(known, _)| *known == key).map(|(_, words)| *words)
}

/// The names with their meanings, by the parts of a summary.
const ALL: [&[(&str, &str)]; 11] = [
    &MISSION,
    &VERDICT,
    &CRITERIA,
    &HOLD,
    &CHAIN,
    &CONTACTS,
    &RADIO,
    &SWARM,
    &EXPLORATION,
    &FLIGHTS,
    &ROUTE,
];

/// The figures of the mission.
const MISSION: [(&str, &str); 8] = [
    ("scenario", "the name of the scenario that was flown"),
    (
        "seed",
        "the number that all chance of the mission comes from; the same seed flies the same mission",
    ),
    ("version", "the version of the program"),
    (
        "fidelity",
        "how closely drones are simulated: as points, rigid bodies, or with the firmware's file",
    ),
    ("link", "every packet (exact), or reports with a loss and a delay (ideal)"),
    ("policy", "the rule by which relays move"),
    ("duration_s", "how long the mission is"),
    ("drones", "how many drones ended in each state, the base included"),
];

/// The figures of the verdict.
const VERDICT: [(&str, &str); 5] = [
    ("ended", "why the exploration ended"),
    ("came_m", "how far the head came"),
    ("could_m", "how far it could have come with a perfect chain"),
    ("stood_s", "how long the head stood although it could have flown on"),
    ("surplus_at_rest", "relays more than were needed at the end"),
];

/// The entries of a criterion.
const CRITERIA: [(&str, &str); 4] = [
    ("least", "the bound: no less than this"),
    ("most", "the bound: no more than this"),
    ("value", "what was reached"),
    ("met", "whether the bound was kept"),
];

/// The figures of the hold.
const HOLD: [(&str, &str); 16] = [
    ("hold_from_s", "the longest hover of the head in one place begins"),
    ("hold_until_s", "the longest hover of the head in one place ends"),
    ("no_hold", "why there was no hold"),
    ("t3_s", "time in the hold until the strengths of all links were equal to 3 dB, and stayed so"),
    ("t1_s", "time in the hold until the strengths of all links were equal to 1 dB, and stayed so"),
    (
        "t_gap1_s",
        "time in the hold until the weakest link was within 1 dB of that of the best chain",
    ),
    (
        "t_repair_s",
        "time from the last loss of a drone until the rest was within 1 dB of its best chain",
    ),
    (
        "gap_db",
        "how much weaker the weakest link is than that of the best chain, at the end of the hold",
    ),
    ("difference_db", "how much neighbouring links differ, at the end of the hold"),
    ("hold_spread_db", "the largest difference between two links, at the end of the hold"),
    ("swing_p95_db", "how much a link still swings at the end of the hold, 19 times of 20"),
    ("position_sd_m", "how much relays still move at the end of the hold, standard deviation"),
    ("path_m", "distance flown by a relay in the hold"),
    (
        "hold_violation",
        "part of the hold in which a link was more than 0.5 dB weaker than the limit",
    ),
    (
        "relays_beyond_need",
        "relays in the hold beyond those that the best chain needs, in the mean over the hold",
    ),
    ("bound_s", "the shortest time in which relays can come to the best places"),
];

/// The figures of the exploration of a chain.
const CHAIN: [(&str, &str); 10] = [
    ("launched", "the most relays that were in the chain at the same time"),
    ("needed", "relays that the best chain needs so that no link is weaker than the limit"),
    (
        "violation",
        "part of the time under way in which a link was more than 0.5 dB weaker than the limit",
    ),
    ("peak_excess_db", "by how much the weakest link was weaker than the limit at most"),
    (
        "cruise_gap_db",
        "how much weaker the weakest link is than that of the best chain while the head flies in",
    ),
    ("farthest_m", "the head's greatest distance from the base, along the way"),
    ("t_farthest_s", "when the head first was within 0.5 m of its farthest place"),
    ("head_heard_until_s", "the last time that the head was heard at the base"),
    ("still_flying", "drones in the air at the end"),
    ("order_lost", "how often a drone was on the wrong side of its neighbour"),
];

/// The figures of contacts.
const CONTACTS: [(&str, &str); 3] = [
    ("wall_contacts", "how often any drone began to touch a wall"),
    ("drone_contacts", "how often two flying drones began to touch, as seen from above"),
    ("ground_contacts", "how often a drone began to touch one that stood on the ground"),
];

/// The figures of the radio.
const RADIO: [(&str, &str); 12] = [
    ("sealed", "whether packets are encrypted and authenticated"),
    ("air_time", "part of the time in which a drone sends"),
    ("packets_sent", "packets that were transmitted"),
    ("packets_heard", "packets that were received, counted at each receiver"),
    ("weak", "packets that were too weak to be heard"),
    ("chance", "packets lost by chance, as the scenario says"),
    ("collision", "packets lost because two were sent at once"),
    ("deaf", "packets that came while the receiver itself was sending, or off"),
    ("cut", "packets that the scenario cut off"),
    ("orders_heard", "orders that reached the head"),
    ("pilot_delay_p50_s", "time from the pilot's stick to the head's radio link, median"),
    (
        "pilot_delay_p95_s",
        "time from the pilot's stick to the head's radio link, which one order in twenty exceeds",
    ),
];

/// The figures of a swarm.
const SWARM: [(&str, &str); 8] = [
    ("both_areas", "whether the swarm surveys the area behind the passage as well"),
    ("covered", "part of the area that the swarm has flown over, at most 0.5 m beside it"),
    ("lost", "drones that the scenario has taken away"),
    ("surveyed_s", "when the last drone had flown its rows"),
    ("gathered_s", "when the first drone set out into the passage"),
    ("across_s", "when the last drone had flown the whole plan, and began to land"),
    ("closest_drones_m", "the least distance of two drones in the air, five times a second"),
    ("unfinished", "drones that had not finished at the end"),
];

/// The figures of an exploration.
const EXPLORATION: [(&str, &str); 7] = [
    ("explored", "part of what a drone can reach that is known at the end"),
    ("walls_found", "part of the rock about the place for which a map has a wall"),
    ("false_walls", "part of the walls of the maps that are none"),
    ("false_free", "part of the true walls that the maps show as free"),
    ("t50_s", "when half of what a drone can reach was known"),
    ("t99_s", "when 99 % of what a drone can reach was known"),
    ("ended_s", "when the last drone finished exploring"),
];

/// The figures of flights.
const FLIGHTS: [(&str, &str); 18] = [
    ("max_tilt_deg", "the largest tilt in the air"),
    ("max_rate_dps", "the largest angular velocity in the air"),
    ("velocity_error_mps", "error of the estimated velocity over ground, root mean square"),
    ("min_battery_v", "the lowest voltage of any battery, under load"),
    ("take_offs", "how often a drone took off"),
    ("landings", "how often a drone landed upright, by an order or by its own decision"),
    ("told", "flights that ended with a landing by an order"),
    ("no-setpoint", "flights that ended with a landing because no command came"),
    ("no-imu", "flights that ended with a landing because the gyroscope failed"),
    ("no-flow", "flights that ended with a landing because no sensor measured the velocity"),
    ("no-height", "flights that ended with a landing because no sensor measured the height"),
    ("battery", "flights that ended with a landing because the battery was empty"),
    ("overload", "flights that ended with a landing because a motor could not keep up"),
    ("blocked", "flights that ended with a landing because the drone kept hitting an obstacle"),
    ("ordered", "flights that ended because the motors were stopped by an order"),
    ("tumbled", "flights that ended because the drone lay on its side or its back"),
    ("free-fall", "flights that ended because the drone was in free fall"),
    ("propeller-stuck", "flights that ended because the drone tipped over at take-off"),
];

/// The figures of the route of a map.
const ROUTE: [(&str, &str); 13] = [
    ("from", "where the route begins"),
    ("to", "where the route ends"),
    ("length_m", "the length of the route"),
    (
        "height_range_m",
        "how much the route rises and falls between its lowest and its highest point",
    ),
    ("stations", "stations of the survey along the route"),
    ("assumed_widths", "stations of the route whose widths the survey does not tell"),
    ("is_cut", "whether the route ends before the survey does"),
    ("why", "why the route ends there, by name"),
    ("words", "why the route ends there"),
    ("side_galleries", "galleries that branch off the route"),
    ("above_or_below", "places where another gallery lies above or below the route"),
    ("median_width_m", "the width of the route at half of its places or less"),
    ("hindrances", "what may stop a drone on the route"),
];

#[cfg(test)]
mod tests {
    use measure::metrics::{Reference, Watch};
    use mission::Mission;
    use scenario::{Fidelity, Scenario};
    use serde_json::Value;

    use super::*;

    /// The summary of the first round of a mission: it has every figure, most of them without a value.
    fn summary(name: &str, fidelity: Fidelity) -> Value {
        let scenario = Scenario { fidelity, ..Scenario::open(name).unwrap() };
        let world = scenario.world();
        let reference = Reference::of(&scenario, &world);
        let mut mission = Mission::new(&scenario, &world, 1);
        let mut watch = Watch::new(&scenario, &world, &reference);
        let mut trace = mission.begin_trace(1);
        mission.round();
        watch.look(&mission);
        trace.frames.push(mission.frame());
        let metrics = watch.verdict(&mission);
        let judgement = watch.judgement(&mission, &metrics);
        crate::summary(&scenario, 1, &trace, &metrics, &judgement, &[])
    }

    /// Adds the names of all figures that the page shows.
    fn figures(value: &Value, into: &mut Vec<String>) {
        for (key, value) in value.as_object().into_iter().flatten() {
            if value.is_object() {
                figures(value, into);
            } else if !["title", "success", "failures"].contains(&key.as_str()) {
                into.push(key.clone());
            }
        }
    }

    #[test]
    fn every_figure_of_every_kind_of_mission_has_a_meaning() {
        let mut all = Vec::new();
        for (name, fidelity) in [
            ("demo", Fidelity::Point),
            ("swarm-c", Fidelity::Point),
            ("explore-room", Fidelity::Point),
            ("straight", Fidelity::Flight),
        ] {
            figures(&summary(name, fidelity), &mut all);
        }
        for wanted in ["gap_db", "surveyed_s", "walls_found", "max_tilt_deg", "deaf", "met"] {
            assert!(all.iter().any(|key| key == wanted), "no {wanted}: {all:?}");
        }
        all.sort();
        all.dedup();
        all.retain(|key| meaning(key).is_none());
        assert!(all.is_empty(), "without a meaning: {all:?}");
    }

    #[test]
    fn every_way_in_which_a_flight_ends_has_a_meaning() {
        for end in bodies::craft::record::End::ALL {
            assert!(meaning(end.name()).is_some(), "{}", end.name());
        }
    }

    #[test]
    fn no_name_has_two_meanings() {
        let mut names: Vec<&str> =
            ALL.iter().flat_map(|group| group.iter().map(|it| it.0)).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
