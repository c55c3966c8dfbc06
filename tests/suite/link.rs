//! The link as a pilot has it: chains that stand still, through the door of `uchain bench link`.

use sim_harness::bench::link::measure as link;

/// At 1000 polls a second the base is deaf for a third of the time, and an aim may be missed by as much as these few
/// chains scatter.
#[test]
fn the_aims_of_the_link_are_met_where_the_dongle_asks_as_often_as_is_advised() {
    let rows = link::run(1, 1, || {});
    let missed = link::missed(&rows);
    let at_100: Vec<_> = missed.iter().filter(|line| !line.contains("1000 polls")).collect();
    assert_eq!(at_100, Vec::<&String>::new());
    assert_eq!(rows.len(), link::count());
    let hurried = rows.iter().filter(|row| row.drones == 15 && row.loss <= 0.7 && !row.fades);
    for row in hurried {
        let delay_s = row.pilot_delay_p95_s.unwrap_or(f32::INFINITY);
        assert!(delay_s < 0.9, "orders take {delay_s} s at a loss of {}", row.loss);
    }
}

#[test]
fn no_chain_fills_a_third_of_the_air_and_none_is_cut_off() {
    // Fades that take most of the time do cut chains off: the book's chapter on the link has them.
    for row in link::run(1, 2, || {}).into_iter().filter(|row| !row.fades) {
        let chain = format!("{} drones, {} lost", row.drones, row.loss);
        assert!(row.air_time_fraction < 0.33, "{chain}: {}", row.air_time_fraction);
        assert!(row.pilot_delay_p95_s.is_some(), "{chain}: orders do not get through");
        assert!(row.telemetry_delay_p95_s.is_some(), "{chain}: nobody is heard at the base");
    }
}
