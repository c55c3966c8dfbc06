//! Filters with and without the motion of a link's ends (`uchain replay --predict`): on links whose
//! law is known, and on the recordings where they are.

use std::fs;
use std::path::{Path, PathBuf};

use sim_harness::mission::Mission;
use sim_harness::replay::{Horizon, Horizons, ReplayOptions, replay};
use sim_harness::scenario::Scenario;

fn write(name: &str, content: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("horizons");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    fs::write(&file, content).unwrap();
    file
}

fn compared(files: &[PathBuf]) -> Horizons {
    let options = ReplayOptions { predict: true, ..ReplayOptions::default() };
    replay(files, &options).unwrap().horizons.unwrap()
}

/// A walk to and fro between 1.5 and 5.5 m for five minutes, with an exponent of 3 and noise of 2.3
/// dB. The motion is written with this factor.
fn walk(factor: f64) -> String {
    let mut state = 2_463_534_242_u32;
    let mut log = String::from("time_s,link,rssi_dbm,velocity_mps\n");
    for step in 0..1_500_u32 {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        let noise = 8.0 * (f64::from(state) / f64::from(u32::MAX) - 0.5);
        let phase = step % 80;
        let (way, speed) = if phase < 40 { (phase, 0.5) } else { (80 - phase, -0.5) };
        // The speed is that on the way to here.
        let speed = if phase == 0 {
            -0.5
        } else if phase == 40 {
            0.5
        } else {
            speed
        };
        let rssi = -40.0 - 30.0 * (1.5 + 0.1 * f64::from(way)).log10() + noise;
        log += &format!("{:.1},a,{rssi:.2},{}\n", 0.2 * f64::from(step), factor * speed);
    }
    log
}

fn fitted(horizon: &Horizon) -> f64 {
    let gain = horizon.gains.iter().find(|gain| gain.filter == "fitted").unwrap();
    assert!(gain.rmse_percent.low <= gain.rmse_percent.value);
    assert!(gain.rmse_percent.value <= gain.rmse_percent.high);
    if gain.rmse_percent.excludes_zero() { gain.rmse_percent.value } else { 0.0 }
}

#[test]
fn motion_helps_where_the_law_holds_and_the_more_the_older_the_packet() {
    let compared = compared(&[write("walk.csv", &walk(1.0))]);
    let horizons = &compared.logs[0].horizons;
    assert_eq!(horizons.iter().map(|one| one.horizon_s).collect::<Vec<_>>(), [0.0, 1.0, 2.0]);
    let gains: Vec<f64> = horizons.iter().map(fitted).collect();
    assert!(0.0 < gains[0] && gains[0] < gains[1] && gains[1] < gains[2], "{gains:?}");
    let came = horizons[2].came;
    assert!(came.low > 0.7 && came.high < 1.6, "{came:?}");
    assert!(compared.all.is_empty() && compared.without_motion.is_empty());
}

#[test]
fn motion_of_the_wrong_sign_makes_the_prediction_worse_and_shows_in_what_came() {
    let compared = compared(&[write("backwards.csv", &walk(-1.0))]);
    for horizon in &compared.logs[0].horizons {
        assert!(fitted(horizon) < 0.0, "{horizon:?}");
        assert!(horizon.came.high < 0.0, "{horizon:?}");
    }
}

#[test]
fn a_log_without_motion_is_left_out_and_several_are_pooled() {
    let still = "time_s,link,rssi_dbm\n0,a,-50\n0.2,a,-51\n0.4,a,-50\n";
    let (still, walk) = (write("still.csv", still), write("one.csv", &walk(1.0)));
    let compared = compared(&[still.clone(), walk.clone(), walk]);
    assert_eq!(compared.without_motion, [still.display().to_string()]);
    assert_eq!(compared.logs.len(), 2);
    let [one, all] = [&compared.logs[0].horizons[0], &compared.all[0]];
    assert_eq!(all.samples, 2 * one.samples);
    assert!((all.predictors[5].rmse_db - one.predictors[5].rmse_db).abs() < 1e-9);
}

/// The recordings, which are no part of the repository.
fn recordings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/rssi")
}

/// The filter with the motion predicts every track better than without, at every horizon, and the
/// intervals exclude zero. On the robot, which is slow, none does.
#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_walks_are_predicted_better_with_their_motion() {
    let tracks = ["straight_01", "straight_03", "straight_04", "rectangular_with_rotation"];
    let track = |name| recordings().join(format!("tetam_ble/trk/{name}_all_sensors.mbd"));
    let walked = compared(&tracks.map(track));
    for log in &walked.logs {
        for horizon in &log.horizons {
            assert!(fitted(horizon) > 0.0, "{}: {horizon:?}", log.file);
        }
    }
    let driven = compared(&[recordings().join("ble_uwb_robot/calib3_ble.txt")]);
    for horizon in &driven.logs[0].horizons {
        assert_eq!(fitted(horizon), 0.0, "{horizon:?}");
    }
}

/// Every file beneath a folder.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path);
        }
    }
}

/// What belongs to a data set and is no log: licences, descriptions, maps, positions, and the merged
/// table of the robot, which has means in place of packets.
fn is_companion(file: &Path) -> bool {
    let name = file.file_name().unwrap().to_string_lossy().into_owned();
    let ends = [".md", ".dev", ".par", ".occ", "_df.csv", "_motion.txt"];
    ends.iter().any(|end| name.ends_with(end))
        || ["README.txt", "LICENSE.txt", "anchors.csv", "layout.csv"].contains(&name.as_str())
}

/// Every recording that is long enough is the channel of a mission, and both flights as well.
#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_logs_drive_missions() {
    let mut logs = Vec::new();
    files(&recordings(), &mut logs);
    logs.retain(|file| !is_companion(file));
    let plain = fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios/short.toml"),
    );
    let plain = plain.unwrap();
    for (n, log) in logs.iter().enumerate() {
        let log = fs::canonicalize(log).unwrap();
        let text = format!("{plain}\n[radio.trace]\nlog = {:?}\n", log.display().to_string());
        let scenario = Scenario::read(&write(&format!("drives-{n}.toml"), &text)).unwrap();
        let world = scenario.world();
        let trace = Mission::record(&scenario, &world, 1);
        let links = trace.frames.iter().flat_map(|frame| &frame.drones).filter_map(|one| one.back);
        let off = links.map(|link| (link.raw.0 - link.truth.0).abs()).fold(0.0, f32::max);
        // No packet scatters by more than the recorded ones; those of a parked drone scatter little.
        assert!(off < 60.0, "{}: {off} dB", log.display());
    }
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_logs_are_read_every_one_and_fitted_where_they_know_distances() {
    let mut logs = Vec::new();
    files(&recordings(), &mut logs);
    logs.retain(|file| !is_companion(file));
    logs.sort();
    assert_eq!(logs.len(), 9, "{logs:?}");
    let read = replay(&logs, &ReplayOptions { fit: true, ..ReplayOptions::default() }).unwrap();
    for report in &read.files {
        assert!(report.used * 10 > report.rows * 9, "{}: {} used", report.file, report.used);
    }
    let held_out = read.fit.unwrap().held_out;
    assert!(held_out.fitted_db < held_out.default_db, "{held_out:?}");
}
