//! The checks of the flight code over small logs whose flights are known.

use flight::replay::End;
use flight::{Airframe, Cause, GRAVITY};
use proptest::prelude::*;
use replay::flights::{Ending, FlightSummary, LogReport, replay_flights};

use super::usd_log::{UsdLog, write};

const FRAME: Airframe = Airframe::CRAZYFLIE_2_1;
const CLOSED: f32 = 3.8;
const SLOW: [&str; 14] = [
    "motor.m1",
    "motor.m2",
    "motor.m3",
    "motor.m4",
    "pwm.m1_pwm",
    "pwm.m2_pwm",
    "pwm.m3_pwm",
    "pwm.m4_pwm",
    "pm.vbatMV",
    "stateEstimate.z",
    "stateEstimate.vz",
    "stateEstimate.ax",
    "stateEstimate.ay",
    "stateEstimate.az",
];
const FAST: [&str; 10] = [
    "acc.x", "acc.y", "acc.z", "gyro.x", "gyro.y", "gyro.z", "motor.m1", "motor.m2", "motor.m3",
    "motor.m4",
];

/// The voltage at which a motor gives this thrust.
fn volts_for(thrust: f32) -> f32 {
    let (mut low, mut high) = (1.0, 4.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if FRAME.thrust_at(middle) < thrust { low = middle } else { high = middle }
    }
    low
}

/// The vendor's command for a voltage of its parabola.
fn command_for(volts: f32) -> f32 {
    let (a, b): (f32, f32) = (0.000_623_9, 0.088);
    (b - (b * b - 4.0 * a * volts).sqrt()) / (2.0 * a) / 60.0 * 65_535.0
}

/// A hover of 6 s at 100 Hz, whose motors 1 and 3 give `yaw` more than the others so that the torque
/// is `yaw` N m, with `part` of the thrust that the constants say.
fn slow_hover(part: f32, yaw: f32) -> UsdLog {
    let mut log = UsdLog::new(&SLOW);
    let mean = FRAME.hover_thrust() / part;
    let more = 0.25 * yaw / FRAME.torque_per_thrust;
    let volts = [mean - more, mean + more, mean - more, mean + more].map(volts_for);
    for n in 0..1_000_u16 {
        let time = 0.01 * f64::from(n);
        let flies = (2.0..8.0).contains(&time);
        let battery = if flies { CLOSED - 0.3 } else { CLOSED };
        let commands = volts.map(|volts| if flies { command_for(volts) } else { 0.0 });
        let duties = volts.map(|volts| if flies { volts / battery * 65_535.0 } else { 0.0 });
        let since = time - 2.0;
        let height = if flies { (since.min(6.0 - since).clamp(0.0, 0.5)) as f32 } else { 0.0 };
        // A reading that never repeats itself.
        let noise = 1e-3 * (f32::from(n) * 0.7).sin();
        let mut row = [commands, duties].concat();
        row.extend([1e3 * battery, height, noise, noise, 2.0 * noise, noise]);
        log.row(time, &row);
    }
    log
}

/// A hover of 6 s at 1 kHz, with this added to accelerometer (m/s²) and gyroscope (rad/s).
fn fast_hover(add: impl Fn(f64) -> ([f32; 3], [f32; 3])) -> UsdLog {
    let mut log = UsdLog::new(&FAST);
    let command = command_for(volts_for(FRAME.hover_thrust()));
    for n in 0..10_000_u16 {
        let time = 1e-3 * f64::from(n);
        let flies = (2.0..8.0).contains(&time);
        let (force, rates) = add(time);
        let noise = 1e-3 * (f32::from(n) * 0.7).sin();
        let [x, y, z] = force.map(|force| force / GRAVITY + noise);
        let [p, q, r] = rates.map(|rate| rate.to_degrees() + noise);
        let motor = if flies { command } else { 0.0 };
        log.row(time, &[x, y, 1.0 + z, p, q, r, motor, motor, motor, motor]);
    }
    log
}

fn replayed(log: &UsdLog, name: &str) -> LogReport {
    let FlightSummary { mut logs, .. } = replay_flights(&[log.write(name)]).unwrap();
    logs.remove(0)
}

fn refused(bytes: &[u8], name: &str) -> String {
    let error = replay_flights(&[write(name, bytes)]).unwrap_err().to_string();
    assert!(error.contains(name) && error.lines().count() == 1, "{error}");
    error
}

#[test]
fn thrust_and_yaw_torque_of_a_hover_are_found() {
    for (part, yaw) in [(1.0, 0.0), (0.85, -3e-4), (1.1, 2e-4)] {
        let report = replayed(&slow_hover(part, yaw), "E1_log00");
        assert_eq!((report.flights, report.ended.as_slice()), (1, &[Ending::Landed][..]));
        assert!((report.airborne_s - 6.0).abs() < 0.1 && report.ends.is_empty(), "{report:?}");
        let [_, scale, _] = report.accel.as_ref().unwrap().thrust_scale;
        assert!((scale / part - 1.0).abs() < 0.01, "{scale} {part}");
        let [roll, pitch, found] = report.torque.as_ref().unwrap().mean_nm;
        assert!((found - yaw).abs() < 2e-6 && roll.abs() < 2e-6 && pitch.abs() < 2e-6);
        let battery = report.battery.as_ref().unwrap();
        assert_eq!((battery.may_fly, battery.critical_at_s), (Some(true), None));
        assert_eq!(report.drone, "flights/E1");
    }
}

#[test]
fn a_fast_hover_is_nothing_to_complain_about() {
    let report = replayed(&fast_hover(|_| ([0.0; 3], [0.0; 3])), "fast");
    assert!(report.ends.is_empty() && report.ended == [Ending::Landed], "{report:?}");
    let (accel, gyro) = (report.accel.unwrap(), report.gyro.unwrap());
    assert_eq!((gyro.suspicions, gyro.offsets, gyro.calibrated), (0, 0, true));
    assert_eq!((accel.impact_ms, accel.floor_ms, accel.set_aside), (0.0, 0.0, 0.0));
    assert!(accel.lateral_impact.unwrap().max < 0.1);
    let none = |what: &str| report.missing.iter().any(|missing| missing.starts_with(what));
    assert!(none("no battery") && none("no height") && !none("no gyroscope"));
}

#[test]
fn a_drone_that_scrapes_along_a_wall_is_blocked() {
    let scrape = |time: f64| {
        let hit = (5.0..5.3).contains(&time) && time * 100.0 % 3.0 < 0.6;
        (if hit { [0.0, 30.0, 0.0] } else { [0.0; 3] }, [0.0; 3])
    };
    let report = replayed(&fast_hover(scrape), "scrape");
    let end = report.ends_in_flight().unwrap();
    assert_eq!(end.end, End::Lands(Cause::Blocked));
    assert!((5.0..5.4).contains(&end.at_s));
    assert!(report.accel.unwrap().impact_ms > 12.0);
}

#[test]
fn an_offset_of_the_gyroscope_ends_the_flight() {
    let jump = |time: f64| ([0.0; 3], [0.0, if time > 5.0 { 1.0 } else { 0.0 }, 0.0]);
    let report = replayed(&fast_hover(jump), "offset");
    let gyro = report.gyro.as_ref().unwrap();
    assert!(gyro.suspicions >= 1 && gyro.offsets >= 1, "{gyro:?}");
    assert_eq!(report.ends_in_flight().unwrap().end, End::Lands(Cause::NoImu));
}

#[test]
fn a_drone_that_lies_on_its_back_has_crashed() {
    let over =
        |time: f64| (if time > 8.0 { [0.0, 0.0, -2.0 * GRAVITY] } else { [0.0; 3] }, [0.0; 3]);
    assert_eq!(replayed(&fast_hover(over), "over").ended, [Ending::Tumbled]);
}

#[test]
fn a_log_with_nothing_to_replay_is_refused_in_one_line() {
    let slow = slow_hover(1.0, 0.0);
    let none = slow.only(|name| name == "stateEstimate.vz");
    assert!(refused(&none.bytes(), "none").contains("log acc.*"));
    let still = slow.only(|name| name == "pm.vbatMV");
    assert!(refused(&still.bytes(), "still").contains("does not fly"));
    let empty = UsdLog::new(&SLOW);
    assert!(refused(&empty.bytes(), "empty").contains("no event"));
    assert!(refused(&[], "nothing").contains("no µSD log"));
    assert!(refused(b"time_s,link\n", "text").contains("no µSD log"));
}

#[test]
fn a_refused_log_does_not_hide_the_others() {
    let good = slow_hover(1.0, 0.0).write("good");
    let summary = replay_flights(&[write("bad", b"\xBC\x02"), good]).unwrap();
    assert_eq!((summary.logs.len(), summary.refused.len(), summary.all.logs), (1, 1, 1));
}

#[test]
fn a_log_that_ends_in_the_air_says_so() {
    let whole = slow_hover(1.0, 0.0).bytes();
    let cut = write("cut", &whole[..whole.len() * 6 / 10]);
    let summary = replay_flights(&[cut]).unwrap();
    assert_eq!(summary.logs[0].ended, [Ending::LogEnds]);
    assert!(summary.logs[0].note.as_ref().unwrap().contains("as far as it goes"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Whatever variables a log has, and wherever it was cut, it is replayed or refused.
    #[test]
    fn any_part_of_a_log_ends(kept in prop::collection::vec(any::<bool>(), 14), cut in 0..1_000_usize) {
        let log = slow_hover(0.9, 1e-4);
        let log = log.only(|name| SLOW.iter().zip(&kept).any(|(known, kept)| *known == name && *kept));
        let bytes = log.bytes();
        let file = write("part", &bytes[..bytes.len() * cut / 1_000]);
        if let Ok(summary) = replay_flights(&[file]) {
            prop_assert_eq!(summary.logs.len(), 1);
            prop_assert!(!summary.to_string().contains("NaN"));
        }
    }

    /// Values that no flight has end as well.
    #[test]
    fn any_values_end(values in prop::collection::vec(prop::num::f32::ANY, 14), from in 100..900_u16) {
        let mut log = slow_hover(1.0, 0.0);
        log.replace(usize::from(from), &values);
        let _ = replay_flights(&[log.write("values")]).map(|summary| summary.to_string());
    }
}
