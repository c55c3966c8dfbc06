//! The flight code's thresholds against recorded flights of real Crazyflies.
//!
//! The recordings are no part of the repository: they are read from `../shared/data/flights` beside
//! it.

use std::fs;
use std::path::{Path, PathBuf};

use flight::FlightConfig;
use replay::flights::{Ending, FlightSummary, replay_flights};

const CONFIG: FlightConfig = FlightConfig::CRAZYFLIE_2_1;

fn recordings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/flights")
}

/// The logs in these folders.
fn replayed(folders: &[&str]) -> FlightSummary {
    let mut files = Vec::new();
    for folder in folders {
        let entries = fs::read_dir(recordings().join(folder)).unwrap();
        let logs = entries.map(|entry| entry.unwrap().path()).filter(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().contains("log"))
        });
        files.extend(logs);
    }
    files.sort();
    replay_flights(&files).unwrap()
}

const CRAZYPAD: [&str; 5] = [
    "crazypad/normal",
    "crazypad/weight_W1_near_M3",
    "crazypad/tape_M1_M3",
    "crazypad/cut_least",
    "crazypad/cut_most",
];

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn no_recorded_flight_of_a_room_is_ended() {
    let summary = replayed(&CRAZYPAD);
    assert_eq!(summary.logs.len(), 14);
    for log in &summary.logs {
        assert!(log.ends.is_empty(), "{log:?}");
        // The pilot's script stops the motors at a height of 0.2 m, and the log ends before it does so
        // the second time.
        let [Ending::MotorsStopped(height), Ending::LogEnds] = log.ended.as_slice() else {
            panic!("{log:?}")
        };
        assert!(*height < 0.3, "{log:?}");
        let (accel, torque) = (log.accel.as_ref().unwrap(), log.torque.as_ref().unwrap());
        assert!(!accel.thrust_scale_at_limit && accel.set_aside == 0.0, "{log:?}");
        assert_eq!((accel.impact_ms, accel.held_s, accel.floor_ms), (0.0, 0.0, 0.0), "{log:?}");
        assert!(torque.yaw_part < 0.9 && torque.tilt_part < CONFIG.supervisor.most_trim, "{log:?}");
        let battery = log.battery.as_ref().unwrap();
        assert!(battery.lost_at_s.is_none() && battery.critical_at_s.is_none(), "{log:?}");
    }
    // The outside review found 1.8 to 3.5e-4 N m for undamaged drones.
    for log in replayed(&["crazypad/normal"]).logs {
        let [_, _, yaw] = log.torque.as_ref().unwrap().mean_nm;
        assert!((-3.6e-4..-1.75e-4).contains(&yaw), "{log:?}");
        let battery = log.battery.as_ref().unwrap();
        assert_eq!(battery.may_fly, Some(true), "{log:?}");
    }
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn a_lively_recorded_flight_is_not_ended() {
    let summary = replayed(&["arplaboratory"]);
    let log = summary.logs.iter().find(|log| log.file.ends_with("log15")).unwrap();
    assert!(log.ends.is_empty() && log.ended == [Ending::Landed], "{log:?}");
    let (accel, gyro) = (log.accel.as_ref().unwrap(), log.gyro.as_ref().unwrap());
    assert_eq!((gyro.suspicions, accel.impact_ms, accel.floor_ms), (0, 0.0, 0.0));
    assert!(accel.held_s < 0.5 * f64::from(CONFIG.supervisor.held_up_for.as_secs_f32()));
    let impact = accel.lateral_impact.unwrap();
    let near = |value: f32, to: f32| (value - to).abs() < 0.02;
    assert!(
        near(impact.p50, 0.17) && near(impact.p95, 0.42) && near(impact.max, 0.97),
        "{impact:?}"
    );
    // For a jump of 1 rad/s to pass for an impact takes more than the noise.
    let jump = 1.0;
    assert!(CONFIG.gyro.impact_per_jump * jump > impact.p999, "{impact:?}");
    let step = gyro.step.unwrap();
    assert!(near(step.p999, 0.21) && step.max < CONFIG.gyro.jump, "{step:?}");
}

/// The pilot of this flight lets the drone fall, and crashes it at the end.
#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn a_recorded_crash_is_one_and_the_fall_is_the_pilots() {
    let summary = replayed(&["arplaboratory"]);
    let log = summary.logs.iter().find(|log| log.file.ends_with("log10")).unwrap();
    assert_eq!(log.ended, [Ending::Tumbled]);
    let in_flight = log.ends.iter().filter(|end| end.phase == replay::flights::Phase::Flight);
    for end in in_flight {
        assert!(end.under_least_thrust, "{end:?}");
    }
    assert_eq!(log.accel.as_ref().unwrap().impact_ms, 0.0);
}
