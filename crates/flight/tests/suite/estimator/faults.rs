//! Tests sensors that see nothing, that give wrong readings, and that give right ones after the
//! world has changed.

use flight::{Estimator, EstimatorConfig, GRAVITY, Reseated, Unusable, Verdict};
use sensors::pmw3901::Motion;
use sensors::vl53l1x::RangeStatus;
use units::Metres;

use super::world::{Path, Rng, SensorErrors, SimulatedFlight, motion, reading};

const CONFIG: EstimatorConfig = EstimatorConfig::DEFAULT;

fn hovering() -> SimulatedFlight {
    let mut rng = Rng(3);
    let errors = SensorErrors::drawn(&CONFIG, &mut rng);
    let mut drone = SimulatedFlight::new(Path::HOVER, errors, rng);
    drone.fly(6.0);
    drone
}

/// Advances by 10 ms and applies this flow reading: returns its verdict, and whether velocity and
/// covariance stayed the same.
fn apply_flow(drone: &mut SimulatedFlight, motion: Motion) -> (Verdict, bool) {
    for _ in 0..10 {
        drone.advance(1e-3);
    }
    drone.read_flow();
    let before = drone.estimator;
    let verdict = drone.estimator.flow(&CONFIG, &motion);
    let same = before.velocity() == drone.estimator.velocity()
        && before.covariance() == drone.estimator.covariance();
    (verdict, same)
}

#[test]
fn a_flow_sensor_that_sees_nothing_changes_nothing() {
    let good = motion(2, -1);
    for (motion, why) in [
        (Motion { shutter: 0x1FFF, squal: 0x18, ..good }, Unusable::Dark),
        (Motion { squal: 9, ..good }, Unusable::Featureless),
        (Motion { x: 100, ..good }, Unusable::OutOfRange),
        (Motion { y: i16::MIN, ..good }, Unusable::OutOfRange),
        (Motion { moved: false, ..good }, Unusable::Invalid),
    ] {
        assert_eq!(apply_flow(&mut hovering(), motion), (Verdict::Unusable(why), true));
    }
    // The data sheet refuses what is dark and of little quality, neither alone.
    for motion in [
        good,
        Motion { shutter: 0x1FFF, squal: 0x19, ..good },
        Motion { shutter: 0x1EFF, squal: 0x18, ..good },
    ] {
        let (verdict, same) = apply_flow(&mut hovering(), motion);
        assert!(verdict.is_used() && !same, "{verdict:?}");
    }
}

#[test]
fn flow_is_not_used_near_the_floor_nor_after_a_gap() {
    let mut drone = hovering();
    for _ in 0..60 {
        drone.advance(1e-3);
    }
    let verdict = drone.estimator.flow(&CONFIG, &motion(0, 0));
    assert_eq!(verdict, Verdict::Unusable(Unusable::Stale));
    let twice = drone.estimator.flow(&CONFIG, &motion(0, 0));
    assert_eq!(twice, Verdict::Unusable(Unusable::Stale));

    let mut standing = Estimator::new();
    standing.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    standing.predict(&CONFIG, 0.01, [0.0; 3], [0.0, 0.0, GRAVITY]);
    let verdict = standing.flow(&CONFIG, &motion(0, 0));
    assert_eq!(verdict, Verdict::Unusable(Unusable::TooLow));
}

#[test]
fn a_single_wrong_flow_reading_is_rejected() {
    for (x, y) in [(60, 0), (0, -60), (-40, 40)] {
        let (verdict, same) = apply_flow(&mut hovering(), motion(x, y));
        assert!(matches!(verdict, Verdict::Rejected(nis) if nis.value > 25.0), "{verdict:?}");
        assert!(same);
    }
}

/// A push that the inertial sensors missed: the flow is rejected for half a second, then the
/// velocity is reset to it.
#[test]
fn flow_readings_that_persist_reset_the_velocity() {
    let mut drone = hovering();
    let mut pushed = None;
    for reading in 0..100 {
        // 0.8 m/s at 0.3 m over ground.
        let (verdict, _) = apply_flow(&mut drone, motion(13, 0));
        match verdict {
            Verdict::Rejected(_) => assert_eq!(pushed, None, "{reading}"),
            Verdict::Reseated(Reseated::Velocity) => pushed = Some(reading),
            Verdict::Used(_) => assert!(pushed.is_some(), "{reading}"),
            other => panic!("{other:?}"),
        }
    }
    assert!((45..60).contains(&pushed.unwrap()), "{pushed:?}");
    let [x, y, _] = drone.estimator.velocity();
    assert!((x - 0.8).abs() < 0.1 && y.abs() < 0.1, "{x}, {y} m/s");
}

/// A flow sensor that is wrong together with the height: no push makes 2.5 m/s, and no later
/// reading of that flight is believed, whether it fits or not.
#[test]
fn flow_readings_that_no_push_explains_are_not_believed_before_the_ground() {
    let mut drone = hovering();
    // 2.5 m/s at 0.3 m over ground.
    let verdicts: Vec<_> = (0..100).map(|_| apply_flow(&mut drone, motion(41, 0)).0).collect();
    assert!(verdicts[..45].iter().all(|verdict| matches!(verdict, Verdict::Rejected(_))));
    let implausible = Verdict::Unusable(Unusable::Implausible);
    assert!(verdicts[60..].iter().all(|verdict| *verdict == implausible), "{verdicts:?}");
    let [x, y, _] = drone.estimator.velocity();
    assert!(x.abs() < 0.05 && y.abs() < 0.05, "{x}, {y} m/s");
    for counts in [13, 0] {
        let (verdict, same) = apply_flow(&mut drone, motion(counts, 0));
        assert!(verdict == implausible && same, "{verdict:?}");
    }
    drone.estimator.rest(&CONFIG, [0.0, 0.0, GRAVITY]);
    assert_ne!(apply_flow(&mut drone, motion(0, 0)).0, implausible);
}

#[test]
fn a_ranger_that_sees_nothing_changes_nothing() {
    let good = reading(0.3);
    for (reading, why) in [
        (sensors::vl53l1x::Reading { status: RangeStatus::SignalFail, ..good }, Unusable::Invalid),
        (sensors::vl53l1x::Reading { status: RangeStatus::OutOfBounds, ..good }, Unusable::Invalid),
        (sensors::vl53l1x::Reading { status: RangeStatus::WrapTarget, ..good }, Unusable::Invalid),
        (sensors::vl53l1x::Reading { distance: Metres(5.0), ..good }, Unusable::OutOfRange),
        (sensors::vl53l1x::Reading { distance: Metres(f32::NAN), ..good }, Unusable::OutOfRange),
        (sensors::vl53l1x::Reading { distance: Metres(-0.1), ..good }, Unusable::OutOfRange),
    ] {
        let mut drone = hovering();
        let before = (drone.estimator.height(), drone.estimator.covariance());
        let verdict = drone.estimator.down(&CONFIG, &reading);
        assert_eq!(verdict, Verdict::Unusable(why));
        assert_eq!((drone.estimator.height(), drone.estimator.covariance()), before);
    }
}

/// Dark, wet or slanting floors: the sensor measures, and says that it does not measure well.
#[test]
fn a_range_of_which_the_sensor_is_not_sure_counts_but_little() {
    let moved_by = |status| {
        let mut drone = hovering();
        let reading = sensors::vl53l1x::Reading { status, ..reading(0.305) };
        let before = drone.estimator.height();
        assert!(drone.estimator.down(&CONFIG, &reading).is_used(), "{status:?}");
        drone.estimator.height() - before
    };
    let (sure, unsure) = (moved_by(RangeStatus::Valid), moved_by(RangeStatus::SigmaFail));
    assert!(unsure > 0.0 && unsure < 0.1 * sure, "{sure} {unsure}");
}

/// Boulders and pits: the height is reset after 0.3 s, and velocity and climb rate stay right.
#[test]
fn a_step_in_the_floor_resets_the_height_and_nothing_else() {
    for step in [0.15, 0.05, -0.4, -2.0] {
        let mut drone = hovering();
        drone.floor = step;
        let mut reseated = None;
        let start = drone.t;
        while drone.t < start + 1.0 {
            match drone.step().down {
                Some(Verdict::Rejected(_)) => assert_eq!(reseated, None),
                Some(Verdict::Reseated(Reseated::Height(Metres(by)))) => {
                    reseated = Some(drone.t - start);
                    assert!((f64::from(by) + step).abs() < 0.02, "{by} for {step}");
                    assert!(drone.height_error().abs() < 0.02);
                }
                Some(Verdict::Used(_)) => assert!(reseated.is_some(), "{step}"),
                _ => {}
            }
            let [x, y] = drone.velocity_error();
            // The flow is scaled by a height that is still wrong.
            assert!(x.abs() < 0.1 && y.abs() < 0.1, "{x}, {y} m/s over {step}");
            assert!(drone.climb_error().abs() < 0.1, "{} m/s", drone.climb_error());
        }
        assert!((0.3..0.4).contains(&reseated.unwrap()), "{reseated:?}");
        assert!(drone.height_error().abs() < 0.01, "{} m", drone.height_error());
    }
}

/// A second of readings that do not agree with each other must not reset the height.
#[test]
fn ranges_that_disagree_with_each_other_are_rejected() {
    let mut drone = hovering();
    let mut rng = Rng(9);
    for _ in 0..40 {
        for _ in 0..25 {
            drone.advance(1e-3);
        }
        let verdict = drone.estimator.down(&CONFIG, &reading(0.6 + 2.0 * rng.uniform()));
        assert!(matches!(verdict, Verdict::Rejected(_)), "{verdict:?}");
    }
    // A second of integrating the accelerometer alone, which is off by up to 0.1 m/s².
    assert!(drone.height_error().abs() < 0.1, "{} m", drone.height_error());
}

#[test]
fn at_rest_the_estimate_levels_itself_and_keeps_its_yaw() {
    let mut drone = hovering().estimator;
    for _ in 0..1_000 {
        drone.predict(&CONFIG, 1e-3, [0.0, 0.0, 0.7], [0.0, 0.0, GRAVITY]);
    }
    let yaw = drone.attitude().yaw.0;
    assert!((yaw - 0.7).abs() < 0.01, "{yaw}");
    // The drone landed on a slope: roll 0.1.
    let force = [0.0, 0.1f32.sin() * 9.9, 0.1f32.cos() * 9.9];
    for _ in 0..8_000 {
        drone.predict(&CONFIG, 1e-3, [0.0; 3], force);
        drone.rest(&CONFIG, force);
        assert_eq!((drone.velocity(), drone.height()), ([0.0; 3], 0.0));
    }
    let attitude = drone.attitude();
    assert!((attitude.roll.0 - 0.1).abs() < 1e-3 && attitude.pitch.0.abs() < 2e-3, "{attitude:?}");
    assert!((attitude.yaw.0 - yaw).abs() < 0.01);
    // By now the drone has also learnt how large its accelerometer measures gravity.
    let before = drone.climb();
    drone.predict(&CONFIG, 1e-3, [0.0; 3], force);
    assert!((drone.climb() - before).abs() < 1e-5);
}

#[test]
fn settling_takes_the_attitude_from_gravity_at_once() {
    let mut drone = Estimator::new();
    let (roll, pitch) = (0.2f32, -0.1f32);
    let up = [-pitch.sin(), roll.sin() * pitch.cos(), roll.cos() * pitch.cos()];
    drone.settle(&CONFIG, up.map(|part| part * GRAVITY));
    let attitude = drone.attitude();
    assert!((attitude.roll.0 - roll).abs() < 1e-5 && (attitude.pitch.0 - pitch).abs() < 1e-5);
    assert!(attitude.yaw.0.abs() < 1e-6);
    // An acceleration of zero has no direction and leaves the drone level.
    drone.settle(&CONFIG, [0.0; 3]);
    assert_eq!(drone.up(), [0.0, 0.0, 1.0]);
}

#[test]
fn a_drone_at_rest_stays_where_it_is_without_any_reading() {
    let mut drone = Estimator::new();
    drone.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    let before = drone.velocity_sd();
    for _ in 0..10_000 {
        drone.predict(&CONFIG, 1e-3, [0.0; 3], [0.0, 0.0, GRAVITY]);
    }
    for part in drone.velocity().into_iter().chain(drone.position()) {
        assert!(part.abs() < 1e-4, "{part}");
    }
    assert!(drone.velocity_sd() > 10.0 * before, "the uncertainty must grow");
}

#[test]
fn an_impossible_speed_is_unsound() {
    let mut drone = hovering().estimator;
    assert!(drone.is_sound());
    for _ in 0..1_000 {
        drone.predict(&CONFIG, 1e-3, [0.0; 3], [0.0, 0.0, 100.0]);
    }
    assert!(!drone.is_sound(), "{} m/s up", drone.climb());
    drone.settle(&CONFIG, [0.0, 0.0, GRAVITY]);
    assert!(drone.is_sound());
}
