//! Tests of the flight code through its public API: for any inputs, the outputs are safe to give to
//! motors.

use flight::{
    Cause, Command, Duties, Flight, FlightConfig, Mode, NotReady, Outputs, Sensed, StopCause,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sensors::pmw3901::Motion;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::{
    Acceleration, AngularVelocity, Instant, Metres, MetresPerSecond, RadiansPerSecond, Setpoint,
    Volts,
};

const CONFIG: FlightConfig = FlightConfig::CRAZYFLIE_2_1;

fn hover() -> Setpoint {
    Setpoint::Fly {
        forward: MetresPerSecond(0.0),
        lateral: MetresPerSecond(0.0),
        yaw_rate: RadiansPerSecond(0.0),
        height: Metres(0.3),
    }
}

/// A reading of the ranger that looks down.
fn down(distance: f32, stream: u8) -> Reading {
    Reading {
        distance: Metres(distance),
        sigma: Metres(0.003),
        status: RangeStatus::Valid,
        signal: CountRate(20.0),
        ambient: CountRate(0.1),
        stream,
    }
}

/// A drone on a desk that has been switched on.
struct Bench {
    flight: Flight,
    ms: u64,
    sensed: fn(u64) -> Sensed,
}

/// A little noise, different in every millisecond.
fn noise(ms: u64, size: f32) -> f32 {
    size * libm::sinf(1.7 * ms as f32)
}

fn at_rest(ms: u64) -> Sensed {
    Sensed {
        gyro: Some(AngularVelocity([0.01 + noise(ms, 1e-3); 3])),
        accel: Some(Acceleration([noise(ms, 0.02), 0.0, 9.81])),
        flow: ms.is_multiple_of(10).then_some(Motion { squal: ms as u8, ..Motion::default() }),
        down: ms.is_multiple_of(25).then(|| down(0.02 + noise(ms, 1e-3), ms as u8)),
        battery: ms.is_multiple_of(10).then_some(Volts(4.0)),
    }
}

impl Bench {
    fn new(sensed: fn(u64) -> Sensed) -> Self {
        Self { flight: Flight::new(), ms: 0, sensed }
    }

    fn step(&mut self, setpoint: Setpoint) -> Outputs {
        self.ms += 1;
        let now = Instant::from_millis(self.ms);
        let command = Command { setpoint, given: now };
        self.flight.step(&CONFIG, now, &(self.sensed)(self.ms), &command)
    }

    fn during(&mut self, ms: u64, setpoint: Setpoint) -> Outputs {
        let mut last = self.step(setpoint);
        for _ in 1..ms {
            last = self.step(setpoint);
        }
        last
    }
}

#[test]
fn a_drone_that_lies_still_becomes_ready_and_takes_off_when_ordered() {
    let mut bench = Bench::new(at_rest);
    let early = bench.during(100, hover());
    let calibrating = Mode::Grounded { waits_for: Some(NotReady::Calibrating) };
    assert_eq!((early.status.mode, early.duties), (calibrating, Duties::OFF));
    let ready = bench.during(1_000, Setpoint::Off);
    assert_eq!(ready.status.mode, Mode::Grounded { waits_for: None });
    let flying = bench.during(50, hover());
    assert!(matches!(flying.status.mode, Mode::Flying { .. }), "{:?}", flying.status);
    assert!(flying.duties.0.iter().all(|&duty| duty > 0.2), "{:?}", flying.duties);
}

#[test]
fn a_drone_on_the_ground_says_what_is_missing() {
    type Senses = fn(u64) -> Sensed;
    let missing: [(NotReady, Senses); 7] = [
        (NotReady::NoImu, |ms| Sensed { gyro: None, ..at_rest(ms) }),
        (NotReady::Calibrating, |ms| Sensed {
            gyro: Some(AngularVelocity([noise(ms, 0.1); 3])),
            ..at_rest(ms)
        }),
        (NotReady::Tilted, |ms| Sensed {
            accel: Some(Acceleration([3.4, 0.0, 9.2])),
            ..at_rest(ms)
        }),
        (NotReady::NoFlow, |ms| Sensed { flow: None, ..at_rest(ms) }),
        (NotReady::NoHeight, |ms| Sensed { down: None, ..at_rest(ms) }),
        (NotReady::NoBattery, |ms| Sensed { battery: None, ..at_rest(ms) }),
        (NotReady::BatteryLow, |ms| Sensed { battery: Some(Volts(3.5)), ..at_rest(ms) }),
    ];
    for (why, sensed) in missing {
        let outputs = Bench::new(sensed).during(3_000, hover());
        let grounded = Mode::Grounded { waits_for: Some(why) };
        assert_eq!((outputs.status.mode, outputs.duties), (grounded, Duties::OFF));
    }
}

#[test]
fn a_stop_is_obeyed_at_once_and_for_good() {
    let mut bench = Bench::new(at_rest);
    bench.during(1_000, Setpoint::Off);
    bench.during(50, hover());
    let outputs = bench.step(Setpoint::Stop);
    let stopped = Mode::Stopped { why: StopCause::Ordered };
    assert_eq!((outputs.status.mode, outputs.duties), (stopped, Duties::OFF));
    for setpoint in [hover(), Setpoint::Off, hover()] {
        let outputs = bench.during(1_000, setpoint);
        assert_eq!((outputs.status.mode, outputs.duties), (stopped, Duties::OFF));
    }
}

/// A pilot ordered a flight while the drone was not ready, and left: the drone must not take off
/// once it is ready.
#[test]
fn an_old_order_to_fly_is_not_obeyed() {
    let mut bench = Bench::new(at_rest);
    bench.during(1_000, Setpoint::Off);
    for _ in 0..1_000 {
        bench.ms += 1;
        let now = Instant::from_millis(bench.ms);
        let command = Command { setpoint: hover(), given: Instant::from_millis(1) };
        let outputs = bench.flight.step(&CONFIG, now, &at_rest(bench.ms), &command);
        assert_eq!(outputs.duties, Duties::OFF);
    }
}

#[test]
fn after_its_own_landing_the_drone_flies_again_only_after_off() {
    let mut bench = Bench::new(at_rest);
    bench.during(1_000, Setpoint::Off);
    bench.during(20, hover());
    bench.sensed = |ms| Sensed { gyro: None, ..at_rest(ms) };
    let outputs = bench.during(3_000, hover());
    assert_eq!(outputs.status.mode, Mode::Landed { why: Cause::NoImu });
    bench.sensed = at_rest;
    let outputs = bench.during(2_000, hover());
    assert_eq!(outputs.status.mode, Mode::Landed { why: Cause::NoImu });
    bench.during(10, Setpoint::Off);
    let outputs = bench.during(10, hover());
    assert!(matches!(outputs.status.mode, Mode::Flying { .. }));
}

/// Any number that a sensor or a broken bus could deliver.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -12.0f32..12.0,
        1 => prop::sample::select(&[
            f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 0.0, -0.0, 1e-40,
        ]),
        1 => any::<f32>(),
    ]
}

fn sensed() -> impl Strategy<Value = Sensed> {
    let triad = || prop::option::weighted(0.9, [number(), number(), number()]);
    let flow = prop::option::weighted(
        0.3,
        (any::<i16>(), any::<i16>(), any::<u8>(), any::<u16>(), any::<bool>()),
    );
    let height = prop::option::weighted(0.3, (number(), any::<u8>(), any::<bool>()));
    let battery = prop::option::weighted(0.3, number());
    (triad(), triad(), flow, height, battery).prop_map(|(gyro, accel, flow, height, battery)| {
        Sensed {
            gyro: gyro.map(AngularVelocity),
            accel: accel.map(Acceleration),
            flow: flow.map(|(x, y, squal, shutter, moved)| Motion {
                x,
                y,
                squal,
                shutter,
                moved,
                ..Motion::default()
            }),
            down: height.map(|(distance, stream, valid)| {
                let mut reading = down(distance, stream);
                if !valid {
                    reading.status = RangeStatus::SignalFail;
                }
                reading
            }),
            battery: battery.map(Volts),
        }
    })
}

fn setpoint() -> impl Strategy<Value = Setpoint> {
    prop_oneof![
        1 => Just(Setpoint::Off),
        9 => (number(), number(), number(), number()).prop_map(|(x, y, yaw, z)| Setpoint::Fly {
            forward: MetresPerSecond(x),
            lateral: MetresPerSecond(y),
            yaw_rate: RadiansPerSecond(yaw),
            height: Metres(z),
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, cases: 128, ..Default::default()
    })]

    /// Starts after a calibration and a take-off, so that all of the code is reached.
    #[test]
    fn duties_are_always_from_0_to_1(
        steps in prop::collection::vec((sensed(), setpoint(), 0u64..30_000), 1..200),
    ) {
        let mut bench = Bench::new(at_rest);
        bench.during(1_000, Setpoint::Off);
        bench.during(30, hover());
        let mut now = Instant::from_millis(bench.ms);
        for (sensed, setpoint, gap) in steps {
            now = now + units::Duration::from_micros(gap);
            let command = Command { setpoint, given: now };
            let outputs = bench.flight.step(&CONFIG, now, &sensed, &command);
            for duty in outputs.duties.0 {
                prop_assert!((0.0..=1.0).contains(&duty), "{outputs:?}");
            }
            if !outputs.status.mode.is_airborne() {
                prop_assert_eq!(outputs.duties, Duties::OFF);
            }
        }
    }

    #[test]
    fn the_same_inputs_give_the_same_outputs(steps in prop::collection::vec((sensed(), setpoint()), 1..100)) {
        let fly = || {
            let mut bench = Bench::new(at_rest);
            bench.during(600, Setpoint::Off);
            for (sensed, setpoint) in &steps {
                bench.ms += 1;
                let now = Instant::from_millis(bench.ms);
                let command = Command { setpoint: *setpoint, given: now };
                bench.flight.step(&CONFIG, now, sensed, &command);
            }
            format!("{:?}", bench.flight)
        };
        prop_assert_eq!(fly(), fly());
    }
}
