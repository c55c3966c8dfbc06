//! The link as a pilot has it: chains that stand still, through the door of `uchain bench link`.

use sim_harness::bench::link::measure as link;

#[test]
fn the_aims_of_the_link_are_met() {
    let rows = link::run(1, 1, || {});
    assert_eq!(link::missed(&rows), Vec::<String>::new());
    assert_eq!(rows.len(), link::count());
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
