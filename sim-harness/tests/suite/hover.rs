//! A drone that is told to hover stays where it is. The velocity that the estimator gives is wrong
//! by some millimetres a second for as long as the gyroscope's bias has changed, and the drone flew
//! along with it: these three went by 0.4 to 0.7 m in a minute, though their own estimates of their
//! positions had seen nearly all of it.

use flight::FlightConfig;
use random::{Purpose, Stream};
use sim_harness::bodies::craft::{Craft, Surroundings};
use sim_harness::bodies::others::Others;
use sim_harness::scenario::Ground;
use sim_harness::scenario::Scenario;
use sim_harness::scenario::VehicleSpec;
use units::{Metres, Point2, Setpoint};

/// The way of a drone that is to hover for a minute: the true one and the one that its estimator
/// has seen, m.
fn drifted(seed: u64) -> [f32; 2] {
    let scenario = Scenario::open("zigzag-5").unwrap();
    let around = Surroundings {
        tunnel: &scenario.tunnel,
        ground: Ground::GOOD,
        vehicle: &scenario.vehicle,
        others: Others::NONE,
    };
    let (config, height) = (FlightConfig::CRAZYFLIE_2_1, Metres(0.3));
    let random = Stream::new(seed, Purpose::Craft(1));
    let at = Point2::new(3.0, 0.0);
    let vehicle = VehicleSpec { flow_scale_error: 0.0, ..scenario.vehicle };
    let mut craft =
        Craft::standing(config, at, [1.0, 0.0], &vehicle, random).hovering(height, around);
    let places = |craft: &Craft| {
        let seen = craft.flight().unwrap().estimator().position();
        [craft.body().position(), seen].map(|[x, y, _]| Point2::new(x, y))
    };
    let before = places(&craft);
    for ms in 0..60_000 {
        if ms % 200 == 0 {
            craft.command(Setpoint::hover(height));
        }
        craft.advance(around);
    }
    let after = places(&craft);
    [0, 1].map(|n| before[n].distance(after[n]).0)
}

#[test]
fn a_hovering_drone_stays_where_it_is() {
    for seed in [8, 9, 11] {
        let [truly, seen] = drifted(seed);
        assert!(seen < 0.05, "seed {seed}: {seen} m that it has seen");
        // The noise of the flow walks by 5.4 mm in a second and axis, which is 6 cm in a minute.
        assert!(truly < 0.18, "seed {seed}: {truly} m");
    }
}
