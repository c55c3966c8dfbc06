//! The link as a pilot has it: chains that stand still, through the door of `uchain bench link`.

use sim_harness::measure::bench::link;

#[test]
fn an_order_is_through_eight_hops_at_a_fifth_lost_within_half_a_second() {
    let rows = link::run(1, 1, || {});
    assert_eq!(link::missed(&rows), None);
    assert_eq!(rows.len(), link::DRONES.count() * link::LOSSES.len());
}

#[test]
fn no_chain_fills_a_quarter_of_the_air_and_none_is_cut_off() {
    for row in link::run(1, 2, || {}) {
        let chain = format!("{} drones, {} lost", row.drones, row.loss);
        assert!(row.air_time_fraction < 0.25, "{chain}: {}", row.air_time_fraction);
        assert!(row.pilot_delay_p95_s.is_some(), "{chain}: orders do not get through");
        assert!(row.telemetry_delay_p95_s.is_some(), "{chain}: nobody is heard at the base");
    }
}
