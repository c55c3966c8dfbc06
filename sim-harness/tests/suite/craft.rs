//! The physics and the sensors of the flight level, by laws that hold whatever flies in them.

use flight::{Airframe, Duties, GRAVITY};
use proptest::prelude::*;
use random::{Purpose, Stream};
use sensors::vl53l1x::RangeStatus;
use sim_harness::bodies::craft::Surroundings;
use sim_harness::bodies::craft::battery::Battery;
use sim_harness::bodies::craft::body::{
    BodySpec, Drive, PROPELLER_RADIUS, RigidBody, STANDING, turned, turned_back,
};
use sim_harness::bodies::craft::flow::Flow;
use sim_harness::bodies::craft::imu::Imu;
use sim_harness::bodies::craft::motors::{LAG, Motors};
use sim_harness::bodies::craft::rangers::{Ranger, deviation};
use sim_harness::bodies::others::{Obstacle, Others};
use sim_harness::scenario::Ground;
use sim_harness::scenario::VehicleSpec;
use units::Point2;
use world::Tunnel;
use world::layout::Layout;

const AIRFRAME: Airframe = Airframe::CRAZYFLIE_2_1;

fn spec() -> BodySpec {
    BodySpec::of(&AIRFRAME)
}

fn in_the_air(height: f32) -> RigidBody {
    let mut body = RigidBody::standing([0.0, 0.0], [1.0, 0.0]);
    body.launch([0.0, 0.0, height], [0.0; 3], [0.0; 3]);
    body
}

/// No vibration of body rates and of specific force.
const STILL: ([f32; 3], [f32; 3]) = ([0.0; 3], [0.0; 3]);

fn random() -> Stream {
    Stream::new(1, Purpose::Craft(0))
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    (mean, variance.sqrt())
}

/// A corridor of this width along x.
fn corridor(width: f32) -> Tunnel {
    Tunnel::dig(&Layout::corridor(&[[0.0, 0.0], [20.0, 0.0]], width)).unwrap()
}

#[test]
fn a_body_without_motors_falls_as_galileo_says() {
    let mut body = in_the_air(5.0);
    for _ in 0..900 {
        body.advance(&spec(), &Drive::default());
    }
    let (fallen, speed) = (5.0 - body.position()[2], -body.velocity()[2]);
    assert!((speed - GRAVITY * 0.9).abs() < 1e-3, "{speed}");
    assert!((fallen - 0.5 * GRAVITY * 0.81).abs() < 6e-3, "{fallen}");
    assert!(body.specific_force().iter().all(|f| f.abs() < 1e-6), "weightless");
}

#[test]
fn thrust_equal_to_its_weight_keeps_a_body_where_it_is() {
    let mut body = in_the_air(3.0);
    let drive = Drive { thrust: [AIRFRAME.hover_thrust(); 4], spin: 7_700.0, wind: [0.0; 3] };
    for _ in 0..2_000 {
        body.advance(&spec(), &drive);
    }
    // At 3 m the ground effect is 4e-6 of the thrust.
    assert!((body.position()[2] - 3.0).abs() < 5e-4, "{:?}", body.position());
    assert!((body.specific_force()[2] - GRAVITY).abs() < 1e-3);
}

#[test]
fn a_propeller_lifts_more_near_the_floor_and_never_by_much() {
    let lift = |height: f32| {
        let mut body = in_the_air(height);
        body.advance(&spec(), &Drive { thrust: [0.08; 4], spin: 0.0, wind: [0.0; 3] });
        body.specific_force()[2] * AIRFRAME.mass / 0.32
    };
    let near = lift(STANDING + 0.001);
    assert!(near > 1.02 && near < 1.10, "{near}");
    assert!(lift(0.05) < near && lift(0.05) > lift(0.3));
    // Cheeseman and Bennett at 0.1 m above the propellers.
    let law = 1.0 / (1.0 - (PROPELLER_RADIUS / 0.4).powi(2));
    assert!((lift(0.092) - law).abs() < 1e-4, "{} {law}", lift(0.092));
    assert!((lift(5.0) - 1.0).abs() < 1e-5);
}

#[test]
fn a_body_that_spins_freely_keeps_its_energy_and_its_momentum() {
    let mut body = in_the_air(50.0);
    body.launch([0.0, 0.0, 50.0], [0.0; 3], [3.0, -2.0, 4.0]);
    let inertia = AIRFRAME.inertia;
    let state = |body: &RigidBody| {
        let rates = body.rates();
        let energy: f32 = (0..3).map(|n| 0.5 * inertia[n] * rates[n] * rates[n]).sum();
        let momentum = std::array::from_fn(|n| inertia[n] * rates[n]);
        (energy, turned(body.rotation(), momentum))
    };
    let (energy, momentum) = state(&body);
    for _ in 0..2_000 {
        body.advance(&spec(), &Drive::default());
    }
    let (energy_now, momentum_now) = state(&body);
    assert!((energy_now / energy - 1.0).abs() < 1e-2, "{energy} {energy_now}");
    for axis in 0..3 {
        assert!((momentum_now[axis] - momentum[axis]).abs() < 0.02 * 1.5e-4, "axis {axis}");
    }
}

#[test]
fn a_differential_thrust_turns_the_body_as_the_airframe_says() {
    let more = 0.01;
    let push = |motor: usize| {
        let mut thrust = [0.05; 4];
        thrust[motor] += more;
        let mut body = in_the_air(2.0);
        body.advance(&spec(), &Drive { thrust, spin: 0.0, wind: [0.0; 3] });
        body.rates().map(|rate| rate * 1e3)
    };
    let roll = AIRFRAME.arm * more / AIRFRAME.inertia[0];
    let pitch = AIRFRAME.arm * more / AIRFRAME.inertia[1];
    let yaw = AIRFRAME.torque_per_thrust * more / AIRFRAME.inertia[2];
    // Front right, rear right, rear left, front left: positive roll lowers the right side,
    // positive pitch the nose; M1 and M3 turn counter-clockwise and twist the body the other way.
    for (motor, signs) in [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0]]
        .into_iter()
        .enumerate()
    {
        let is = push(motor);
        let wanted = [roll * signs[0], pitch * signs[1], yaw * signs[2]];
        for axis in 0..3 {
            assert!(
                (is[axis] - wanted[axis]).abs() < 0.01 * wanted[axis].abs(),
                "M{motor}: {is:?}"
            );
        }
    }
}

#[test]
fn a_tilted_body_settles_at_the_speed_where_drag_meets_lift() {
    let spin = 7_700.0;
    let mut body = in_the_air(10.0);
    // Wind from the west carries a body that hovers to the east until it moves with the air.
    let drive = Drive { thrust: [AIRFRAME.hover_thrust(); 4], spin, wind: [1.0, 0.0, 0.0] };
    let mut last = 0.0;
    for _ in 0..20_000 {
        body.advance(&spec(), &drive);
        assert!(body.velocity()[0] >= last - 1e-6);
        last = body.velocity()[0];
    }
    assert!((last - 1.0).abs() < 0.02, "{last}");
}

#[test]
fn the_motors_follow_with_the_time_constant_that_was_identified() {
    let mut motors = Motors::new();
    let duties = Duties([0.7; 4]);
    let end = AIRFRAME.thrust_at(0.7 * 3.8);
    let mut milliseconds = 0;
    while motors.thrust()[0] < end * (1.0 - 1.0 / core::f32::consts::E) {
        motors.advance(&AIRFRAME, duties, 3.8);
        milliseconds += 1;
    }
    assert!((milliseconds as f32 - LAG * 1e3).abs() <= 1.0, "{milliseconds}");
    for _ in 0..1_000 {
        motors.advance(&AIRFRAME, Duties::OFF, 3.8);
    }
    assert!(motors.lift() < 1e-6);
}

#[test]
fn a_duty_that_no_bridge_can_give_is_the_nearest_that_it_can() {
    let mut motors = Motors::new();
    for _ in 0..500 {
        motors.advance(&AIRFRAME, Duties([f32::NAN, f32::INFINITY, -1.0, 2.0]), 3.8);
    }
    let full = AIRFRAME.thrust_at(3.8);
    let [none, most, off, over] = motors.thrust();
    assert!(none == 0.0 && off == 0.0);
    assert!((most / full - 1.0).abs() < 1e-3 && (over / full - 1.0).abs() < 1e-3);
}

#[test]
fn a_full_battery_hovers_for_about_six_minutes_and_sags_under_load() {
    let mut battery = Battery::with_charge(1.0);
    assert!((battery.volts() - 4.157).abs() < 0.01, "{}", battery.volts());
    let hover = 4.0 * AIRFRAME.hover_thrust();
    battery.advance(hover);
    assert!((battery.volts() - 3.77).abs() < 0.02, "{}", battery.volts());
    let mut seconds = 0;
    let mut before = battery.volts();
    while battery.volts() > 3.0 {
        (0..1_000).for_each(|_| battery.advance(hover));
        seconds += 1;
        assert!(battery.volts() <= before);
        before = battery.volts();
    }
    assert!((300..420).contains(&seconds), "{seconds} s");
    let empty = Battery::with_charge(0.0).volts();
    assert!((empty - 2.957).abs() < 0.01, "{empty}");
}

#[test]
fn a_body_stands_on_its_feet_and_its_accelerometer_feels_gravity() {
    let mut body = RigidBody::standing([1.0, 2.0], [0.0, 1.0]);
    for _ in 0..1_000 {
        body.advance(&spec(), &Drive::default());
    }
    assert!(body.is_on_floor() && body.uprightness() > 0.999_99);
    assert!(body.height().abs() < 2e-3, "{}", body.height());
    assert!((body.specific_force()[2] - GRAVITY).abs() < 1e-2, "{:?}", body.specific_force());
    assert!((body.position()[0] - 1.0).abs() < 1e-4 && (body.position()[1] - 2.0).abs() < 1e-4);
}

#[test]
fn what_falls_from_half_a_metre_comes_to_rest_on_the_floor() {
    for rates in [[0.0; 3], [4.0, 1.0, 0.0], [0.0, -9.0, 3.0], [10.0, 0.0, 0.0]] {
        let mut body = in_the_air(0.5);
        body.launch([0.0, 0.0, 0.5], [0.3, -0.2, 0.0], rates);
        let mut highest_after_touch = 0.0_f32;
        let mut touched = false;
        for _ in 0..4_000 {
            body.advance(&spec(), &Drive::default());
            touched |= body.is_on_floor();
            if touched {
                highest_after_touch = highest_after_touch.max(body.position()[2]);
            }
        }
        assert!(body.is_on_floor(), "{rates:?}");
        assert!(highest_after_touch < 0.3, "{rates:?}: bounced to {highest_after_touch}");
        let speed = body.velocity().map(f32::abs).into_iter().fold(0.0, f32::max);
        assert!(speed < 0.02, "{rates:?}: {:?} {:?}", body.velocity(), body.rates());
    }
}

#[test]
fn a_wall_takes_what_leads_into_it_and_no_more() {
    let mut body = in_the_air(1.0);
    body.launch([0.5, 0.55, 1.0], [0.3, 0.4, 0.0], [0.0; 3]);
    body.stop_at([0.5, 0.5]);
    let [along, into, _] = body.velocity();
    assert!(along == 0.3 && into.abs() < 1e-6);
    // What flies away from it already goes on.
    body.launch([0.5, 0.55, 1.0], [0.3, -0.4, 0.0], [0.0; 3]);
    body.stop_at([0.5, 0.5]);
    assert_eq!(body.velocity()[1], -0.4);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_attitude_stays_a_unit_quaternion_and_the_rotation_a_rotation(
        rates in prop::array::uniform3(-35.0f32..35.0),
        thrust in prop::array::uniform4(0.0f32..0.15),
    ) {
        let mut body = in_the_air(30.0);
        body.launch([0.0, 0.0, 30.0], [0.0; 3], rates);
        let spec = spec();
        for _ in 0..300 {
            body.advance(&spec, &Drive { thrust, spin: 7_000.0, wind: [0.0; 3] });
            let length2: f32 = body.attitude().iter().map(|part| part * part).sum();
            prop_assert!((length2 - 1.0).abs() < 1e-5, "{length2}");
        }
        let there = turned(body.rotation(), [0.3, -0.2, 0.9]);
        let back = turned_back(body.rotation(), there);
        for (is, wanted) in back.into_iter().zip([0.3, -0.2, 0.9]) {
            prop_assert!((is - wanted).abs() < 1e-4);
        }
    }

    #[test]
    fn a_body_stands_with_its_nose_where_it_was_put(angle in -3.1f32..3.1) {
        let heading = [libm::cosf(angle), libm::sinf(angle)];
        let body = RigidBody::standing([0.0, 0.0], heading);
        let nose = turned(body.rotation(), [1.0, 0.0, 0.0]);
        prop_assert!((nose[0] - heading[0]).abs() < 1e-3 && (nose[1] - heading[1]).abs() < 1e-3);
    }
}

#[test]
fn the_imu_at_rest_has_the_data_sheets_noise() {
    let mut random = random();
    let mut imu = Imu::new(&mut random);
    let (mut gyro, mut accel) = (Vec::new(), Vec::new());
    for _ in 0..20_000 {
        let (rates, force) = imu.sample([0.0; 3], [0.0, 0.0, GRAVITY], 0.0, STILL, &mut random);
        gyro.push(f64::from(rates[1]));
        accel.push(f64::from(force[1]));
    }
    // 0.014 °/s/√Hz over the noise bandwidth of a first-order low-pass at 116 Hz, which passes
    // pass / (2 - pass) of the variance at 500 Hz.
    let density = 0.014_f64.to_radians();
    let wanted = density * 500.0_f64.sqrt() * (0.5176_f64 / (2.0 - 0.5176)).sqrt();
    // The walk of the bias adds a little.
    let (mean, deviation) = moments(&gyro[100..]);
    assert!((deviation / wanted - 1.0).abs() < 0.1, "{deviation} {wanted}");
    assert!(mean.abs() < 4.0 * 0.5_f64.to_radians(), "{mean}");
    let wanted = 160e-6 * 9.80665 * 500.0_f64.sqrt() * (0.5979_f64 / (2.0 - 0.5979)).sqrt();
    let (_, deviation) = moments(&accel[100..]);
    assert!((deviation / wanted - 1.0).abs() < 0.15, "{deviation} {wanted}");
}

#[test]
fn vibration_shakes_the_sensors_and_turns_nothing() {
    let mut random = random();
    let mut imu = Imu::new(&mut random);
    let (mut sum, mut values) = (0.0_f64, Vec::new());
    let mut bias = 0.0_f64;
    for n in 0..40_000 {
        let shaking = if n < 20_000 { 0.0 } else { 1.0 };
        let (rates, _) = imu.sample([0.0; 3], [0.0, 0.0, GRAVITY], shaking, STILL, &mut random);
        if n < 20_000 {
            bias += f64::from(rates[0]) / 20_000.0;
        } else {
            sum += (f64::from(rates[0]) - bias) * 1e-3;
            values.push(f64::from(rates[0]));
        }
    }
    let (_, deviation) = moments(&values);
    assert!(deviation > 0.03 && deviation < 0.1, "{deviation}");
    // 20 s: what the noise and the bias's walk would turn it by, and no more.
    assert!(sum.abs() < 0.02, "turned by {sum} rad");
}

#[test]
fn readings_are_whole_digits_within_their_range() {
    let mut random = random();
    let mut imu = Imu::new(&mut random);
    let digit = 2000.0_f64.to_radians() / 32_768.0;
    let mut far = 0.0_f32;
    for n in 0..2_000 {
        let rate = 0.05 * n as f32;
        let (rates, force) =
            imu.sample([rate, 0.0, 0.0], [300.0, 0.0, 9.8], 1.0, STILL, &mut random);
        let digits = f64::from(rates[0]) / digit;
        assert!((digits - digits.round()).abs() < 2e-2, "{digits}");
        assert!(force[0] <= 24.0 * 9.806_65 && rates[0] <= 2000.0_f32.to_radians());
        far = far.max(rates[0]);
    }
    assert!((far - 2000.0_f32.to_radians()).abs() < 0.01, "saturates at its end: {far}");
}

/// Mean counts of a hundred readings at this velocity and this height.
fn counts(ground: Ground, speed: f32, rate: f32, height: f32) -> (f64, u8, u16, f64) {
    let mut random = random();
    let mut flow = Flow::new(1.0);
    let mut seen = Vec::new();
    let mut last = None;
    for n in 1..=2_000 {
        flow.watch([speed, 0.0, 0.0], [0.0, rate, 0.0], 1.0, height, 1e-3);
        if n % 10 == 0 {
            let motion = flow.read(ground, height, &mut random);
            seen.push(f64::from(motion.x));
            last = Some(motion);
        }
    }
    let (mean, deviation) = moments(&seen);
    let last = last.unwrap();
    (mean, last.squal, last.shutter, deviation)
}

#[test]
fn the_flow_counts_what_the_vendors_model_says() {
    let (mean, squal, shutter, deviation) = counts(Ground::GOOD, 0.3, 0.0, 0.3);
    let wanted = 0.01 * 35.0 / 0.71674 * 10.0;
    assert!((mean - wanted).abs() < 0.2, "{mean} {wanted}");
    // The noise of the exposure, and rounding.
    let noise = 0.4335 + 0.0007984 * f64::from(shutter);
    assert!((deviation - (noise * noise + 1.0 / 6.0).sqrt()).abs() < 0.15, "{deviation}");
    assert!(squal > 60);
    // Pitching down looks like flying back.
    let (mean, ..) = counts(Ground::GOOD, 0.0, 0.5, 0.3);
    assert!((mean + 0.5 * wanted).abs() < 0.2, "{mean}");
    // Twice as high, half as many.
    let (mean, ..) = counts(Ground::GOOD, 0.6, 0.0, 0.6);
    assert!((mean - wanted).abs() < 0.2, "{mean}");
}

#[test]
fn in_the_dark_over_paper_and_out_of_focus_the_counts_mean_nothing_and_the_sensor_says_so() {
    let plain = Ground { texture: 0.05, ..Ground::GOOD };
    for (ground, height) in [(Ground::DARK, 0.3), (plain, 0.3), (Ground::GOOD, 0.05)] {
        let (mean, squal, ..) = counts(ground, 0.3, 0.0, height);
        assert!(squal < 0x19, "{ground:?} at {height} m: squal {squal}");
        assert!(mean.abs() < 3.0, "{ground:?} at {height} m: {mean}");
    }
    let (_, _, shutter, _) = counts(Ground::DARK, 0.3, 0.0, 0.3);
    assert!(shutter >= 0x1F00);
    // Half the light costs noise, not sight.
    let dim = Ground { light: 0.2, ..Ground::GOOD };
    let (mean, squal, shutter, deviation) = counts(dim, 0.3, 0.0, 0.3);
    assert!((mean - 4.88).abs() < 0.5 && squal > 60 && shutter > 2_000 && deviation > 2.0);
}

#[test]
fn the_down_ranger_measures_along_its_tilt_with_the_vendors_deviation() {
    let mut random = random();
    let mut ranger = Ranger::new(&mut random);
    let mut look = |height: f32, upright: f32| -> Vec<f64> {
        (0..4_000)
            .map(|_| ranger.look_down(height, upright, &mut random))
            .filter(|reading| reading.status == RangeStatus::Valid)
            .map(|reading| f64::from(reading.distance.0))
            .collect()
    };
    let level = look(0.3, 1.0);
    let (mean, deviation_is) = moments(&level);
    let wanted = f64::from(deviation(0.3));
    assert!((mean - 0.3).abs() < 0.025);
    assert!((deviation_is / wanted - 1.0).abs() < 0.1, "{deviation_is} {wanted}");
    let (tilted, _) = moments(&look(0.3, 0.9));
    assert!((tilted - mean - 0.3 * (1.0 / 0.9 - 1.0)).abs() < 1e-3);
    assert!(look(3.5, 1.0).is_empty(), "out of reach");
}

#[test]
fn side_beams_see_the_walls_the_floor_when_they_look_down_and_nothing_far_off() {
    let tunnel = corridor(1.2);
    let mut random = random();
    let mut ranger = Ranger::new(&mut random);
    let mut look = |body: &RigidBody, beam: [f32; 2]| {
        let (ground, vehicle, others) = (Ground::GOOD, &VehicleSpec::DEFAULT, Others::NONE);
        let around = Surroundings { tunnel: &tunnel, ground, vehicle, others };
        ranger.look_along(around, body.position(), body.rotation(), beam, &mut random)
    };
    let mut body = in_the_air(1.0);
    body.launch([10.0, 0.0, 1.0], [0.0; 3], [0.0; 3]);
    let left = look(&body, [0.0, 1.0]);
    assert!(left.status == RangeStatus::Valid && (left.distance.0 - 0.6).abs() < 0.04);
    assert_eq!(look(&body, [1.0, 0.0]).status, RangeStatus::SignalFail, "10 m of nothing");
    let half = core::f32::consts::FRAC_1_SQRT_2;
    let slanting = look(&body, [half, half]);
    // The nearest edge of the cone counts.
    assert!((0.70..0.88).contains(&slanting.distance.0), "{slanting:?}");
    // Nose down by 45°, half a metre up: the front beam sees the floor.
    let mut steep = in_the_air(0.5);
    steep.launch([10.0, 0.0, 0.5], [0.0; 3], [0.0, core::f32::consts::FRAC_PI_4 / 0.2, 0.0]);
    (0..200).for_each(|_| steep.advance(&spec(), &Drive::default()));
    let [x, y, _] = steep.position();
    steep.launch([x, y, 0.5], [0.0; 3], [0.0; 3]);
    let floor = look(&steep, [1.0, 0.0]);
    assert!((0.5..0.75).contains(&floor.distance.0), "{floor:?}");
}
#[test]
fn side_beams_see_a_drone_that_is_near() {
    let tunnel = corridor(3.0);
    let mut random = random();
    let mut ranger = Ranger::new(&mut random);
    let mut body = in_the_air(0.3);
    body.launch([10.0, 0.0, 0.3], [0.0; 3], [0.0; 3]);
    let mut look = |ahead: f32, beside: f32| {
        let other = Obstacle { at: Point2::new(10.0 + ahead, beside), height: 0.3 };
        let drones = [Obstacle { at: Point2::new(10.0, 0.0), height: 0.3 }, other];
        let others = Others::of(&drones, 0);
        let (ground, vehicle) = (Ground::GOOD, &VehicleSpec::DEFAULT);
        let around = Surroundings { tunnel: &tunnel, ground, vehicle, others };
        let position = body.position();
        ranger.look_along(around, position, body.rotation(), [1.0, 0.0], &mut random)
    };
    let near = look(0.4, 0.05);
    assert!(near.status == RangeStatus::Valid && (near.distance.0 - 0.354).abs() < 0.04);
    assert_eq!(look(0.4, 0.3).status, RangeStatus::SignalFail, "beside the beam");
    assert_eq!(look(1.0, 0.0).status, RangeStatus::SignalFail, "too far away");
}
