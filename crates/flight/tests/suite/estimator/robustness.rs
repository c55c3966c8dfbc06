//! Property tests: for any input the state stays finite, the attitude a unit quaternion, and the
//! covariance symmetric and positive.

use flight::{Estimator, EstimatorConfig};
use nalgebra::SMatrix;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sensors::pmw3901::Motion;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::Metres;

const CONFIG: EstimatorConfig = EstimatorConfig::DEFAULT;

fn seeded(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..Default::default()
    }
}

#[derive(Clone, Copy, Debug)]
enum Event {
    Predict(f32, [f32; 3], [f32; 3]),
    /// A number of equal predictions.
    Fly(u16, f32, [f32; 3], [f32; 3]),
    Flow(Motion),
    Down(Reading),
    Rest([f32; 3]),
    Settle([f32; 3]),
}

/// Events as they occur in a flight, in any order.
fn usual() -> impl Strategy<Value = Event> {
    let rates = [-6.0f32..6.0, -6.0f32..6.0, -3.0f32..3.0];
    let force = [-3.0f32..3.0, -3.0f32..3.0, 0.0f32..25.0];
    let flow =
        (-99i16..100, -99i16..100, any::<u8>(), 0u16..0x2000).prop_map(|(x, y, squal, shutter)| {
            Motion { x, y, moved: true, squal, shutter, ..Motion::default() }
        });
    let down = (0.0f32..4.0, 0.0f32..0.1).prop_map(|(distance, sigma)| range(distance, sigma));
    prop_oneof![
        8 => (1u16..60, 0.2e-3f32..20e-3, rates, force)
            .prop_map(|(n, dt, gyro, accel)| Event::Fly(n, dt, gyro, accel)),
        6 => flow.prop_map(Event::Flow),
        3 => down.prop_map(Event::Down),
        1 => [-3.0f32..3.0, -3.0f32..3.0, 8.0f32..11.0].prop_map(Event::Rest),
    ]
}

/// Events with any bits.
fn absurd() -> impl Strategy<Value = Event> {
    let three = any::<[f32; 3]>();
    let flow = (any::<i16>(), any::<i16>(), any::<bool>(), any::<u8>(), any::<u16>()).prop_map(
        |(x, y, moved, squal, shutter)| Motion { x, y, moved, squal, shutter, ..Motion::default() },
    );
    prop_oneof![
        4 => (any::<f32>(), three, three).prop_map(|(dt, g, a)| Event::Predict(dt, g, a)),
        2 => flow.prop_map(Event::Flow),
        2 => (any::<f32>(), any::<f32>()).prop_map(|(d, s)| Event::Down(range(d, s))),
        1 => three.prop_map(Event::Rest),
        1 => three.prop_map(Event::Settle),
    ]
}

fn range(distance: f32, sigma: f32) -> Reading {
    Reading {
        distance: Metres(distance),
        sigma: Metres(sigma),
        status: RangeStatus::Valid,
        signal: CountRate(1.0),
        ambient: CountRate(1.0),
        stream: 1,
    }
}

fn apply(drone: &mut Estimator, event: &Event) {
    match event {
        Event::Predict(dt, gyro, accel) => drone.predict(&CONFIG, *dt, *gyro, *accel),
        Event::Fly(n, dt, gyro, accel) => {
            for _ in 0..*n {
                drone.predict(&CONFIG, *dt, *gyro, *accel);
            }
        }
        Event::Flow(motion) => {
            drone.flow(&CONFIG, motion);
        }
        Event::Down(reading) => {
            drone.down(&CONFIG, reading);
        }
        Event::Rest(accel) => drone.rest(&CONFIG, *accel),
        Event::Settle(accel) => drone.settle(&CONFIG, *accel),
    }
}

/// Checks that the state is finite, the quaternion a unit, and the covariance symmetric and
/// positive up to the rounding of single precision: the smallest eigenvalue of the correlation
/// matrix is at least −10⁻⁴.
fn check(drone: &Estimator) -> Result<(), TestCaseError> {
    let numbers = drone.position().into_iter().chain(drone.velocity()).chain(drone.up());
    for number in numbers.chain([drone.velocity_sd(), drone.height_sd(), drone.tilt_sd()]) {
        prop_assert!(number.is_finite(), "{drone:?}");
    }
    let norm: f32 = drone.quaternion().iter().map(|part| part * part).sum();
    prop_assert!((norm - 1.0).abs() < 1e-5, "{norm}");
    let p = SMatrix::<f32, 9, 9>::from(drone.covariance()).cast::<f64>();
    prop_assert_eq!(p, p.transpose());
    let variances = p.diagonal();
    prop_assert!(variances.min() > 0.0 && variances.max() < 1.1e4, "{variances}");
    let scale = SMatrix::from_diagonal(&variances.map(|variance| 1.0 / variance.sqrt()));
    let correlation = scale * p * scale;
    let least = correlation.symmetric_eigenvalues().min();
    prop_assert!(least > -1e-4, "{least} of {correlation:.5}");
    Ok(())
}

proptest! {
    #![proptest_config(seeded(48))]

    #[test]
    fn any_flight_keeps_the_state_valid(
        events in prop::collection::vec(usual(), 1..400),
    ) {
        let mut drone = Estimator::new();
        drone.settle(&CONFIG, [0.0, 0.0, 9.81]);
        for event in &events {
            apply(&mut drone, event);
            check(&drone)?;
        }
    }

    #[test]
    fn any_bits_keep_the_state_valid(
        events in prop::collection::vec(prop_oneof![absurd(), usual()], 1..100),
    ) {
        let mut drone = Estimator::new();
        for event in &events {
            apply(&mut drone, event);
            check(&drone)?;
        }
    }
}
