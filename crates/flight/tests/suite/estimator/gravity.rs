//! Regression: an accelerometer that measures gravity by more than 3 % wrong was calibrated, and
//! then believed to measure 9.81 m/s². Such a drone took itself for one that sinks, rejected its
//! ranger and climbed to the ceiling.

use flight::{Estimator, EstimatorConfig, GRAVITY};

const CONFIG: EstimatorConfig = EstimatorConfig::DEFAULT;

/// The climb rate after a second at rest by this accelerometer, m/s.
fn climb_after_a_second(measured: f32) -> f32 {
    let mut drone = Estimator::new();
    drone.settle(&CONFIG, [0.0, 0.0, measured]);
    for _ in 0..1_000 {
        drone.predict(&CONFIG, 1e-3, [0.0; 3], [0.0, 0.0, measured]);
    }
    drone.climb()
}

#[test]
fn gravity_is_what_a_calibrated_accelerometer_measures_at_rest() {
    for error in [-0.09, -0.05, -0.035, 0.0, 0.035, 0.05, 0.09] {
        let climb = climb_after_a_second(GRAVITY * (1.0 + error));
        assert!(climb.abs() < 1e-3, "{error}: {climb} m/s");
    }
}

#[test]
fn gravity_learnt_in_the_air_never_jumps_back() {
    let mut drone = Estimator::new();
    let measured = [0.0, 0.0, 1.2 * GRAVITY];
    drone.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    let (mut climb, mut least) = (0.0, f32::MAX);
    for _ in 0..3_000 {
        drone.predict(&CONFIG, 1e-3, [0.0; 3], measured);
        drone.learn_gravity(&CONFIG, 1e-3, measured);
        let gained = drone.climb() - climb;
        assert!(gained < least + 1e-5, "{gained} m/s after {least} m/s");
        (climb, least) = (drone.climb(), gained.min(least));
    }
}
