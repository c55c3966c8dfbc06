//! Where the operator is told that the drones are, and how far they may be from there.

use agent::odometer_deviation;
use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;
use units::Metres;

/// The errors of the ways that the base has been told of, in standard deviations, every 5 s of
/// missions of the scenario `demo`.
fn errors(seeds: std::ops::RangeInclusive<u64>) -> Vec<f32> {
    let scenario = Scenario::open("demo").unwrap();
    let world = scenario.world();
    let mut errors = Vec::new();
    for seed in seeds {
        let mut mission = Mission::new(&scenario, &world, seed);
        let home: Vec<f32> = mission.ways().collect();
        while !mission.is_over() {
            mission.round();
            if !mission.time_us().is_multiple_of(5_000_000) {
                continue;
            }
            let airborne: Vec<bool> = mission.states().map(|state| state.is_airborne()).collect();
            for (member, way) in mission.ways().enumerate() {
                let Some(told) = mission.told(member).filter(|_| airborne[member]) else {
                    continue;
                };
                let odometer = told.telemetry.odometer;
                let error = odometer - Metres(way - home[member]);
                // The drone has flown on since it told, at up to 0.4 m/s.
                let since_s = (mission.time_us() - told.at_us) as f32 * 1e-6;
                let flown = 0.4 * (since_s + 0.5);
                errors.push((error.0.abs() - flown).max(0.0) / odometer_deviation(odometer).0);
            }
        }
    }
    errors
}

#[test]
fn the_drones_are_where_the_operator_is_told() {
    let errors = errors(1..=3);
    assert!(errors.len() > 500);
    let beyond = |deviations: f32| {
        errors.iter().filter(|error| **error > deviations).count() as f32 / errors.len() as f32
    };
    assert!(beyond(3.0) < 0.003, "{}", beyond(3.0));
    assert!(beyond(1.0) < 0.32, "{}", beyond(1.0));
    assert!(beyond(0.3) > 0.1, "the deviation is not larger than it need be: {}", beyond(0.3));
}
