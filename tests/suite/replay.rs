//! Recorded RSSI through the on-board code: every log format with everything that can be wrong
//! with it, the scores on links whose law is known, and the recordings themselves where they are.

use std::fs;
use std::path::{Path, PathBuf};

use chain::policy::Policy;
use proptest::prelude::*;
use serde_json::{Value, json};
use sim_harness::replay::{Format, ReplayOptions, ReplaySummary, replay};

/// A folder of this test's own, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("replay").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let file = folder.join(name);
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(&file, content).unwrap();
    file
}

fn replayed(file: PathBuf) -> ReplaySummary {
    replay(&[file], &ReplayOptions::default()).unwrap()
}

/// The report of the only file.
fn report(file: PathBuf) -> Value {
    serde_json::to_value(replayed(file)).unwrap()["files"][0].clone()
}

fn rmse(prediction: &Value, predictor: &str) -> f64 {
    prediction[predictor]["rmse_db"].as_f64().unwrap()
}

/// Every anomaly that a table of ours can have, each with its line.
const SPOILT_CSV: &str = "\
rssi_dbm,link,time_s,velocity_mps,remark
-50,a,10.0,0,first of a
-52,a,10.2,0.5,
102,a,10.4,0.5,impossible
-54,a,10.1,0.5,late
-54,a,10.6,99,too fast
-54,a,10.8,,speed not measured
-54,a,11.0
-54,a,x,0.5,no number
-60,a,17.0,0,after a gap of 6.2 s
-61,b,17.2,0,first of b
-62,a,3.0,0,a new clock
-63,a,3.2,0,

-64,,3.4,0,no name
";

#[test]
fn a_csv_of_ours_is_replayed_and_its_anomalies_are_told_by_line() {
    let report = report(write(&folder("csv"), "log.csv", SPOILT_CSV));
    assert_eq!(report["format"], "csv");
    assert_eq!((&report["rows"], &report["used"]), (&json!(13), &json!(8)));
    assert_eq!(
        report["anomalies"],
        json!({
            "row-length": { "count": 2, "lines": [8, 15] },
            "not-a-number": { "count": 1, "lines": [9] },
            "impossible-rssi": { "count": 1, "lines": [4] },
            "impossible-motion": { "count": 1, "lines": [6] },
            "clock-backwards": { "count": 1, "lines": [5] },
            "clock-restart": { "count": 1, "lines": [12] },
            "gap": { "count": 1, "lines": [10] },
        })
    );
    // −50 for −52, −52 for −54, −54 for −54; −62 for −63 by the new clock. A filter that starts
    // anew predicts nothing.
    let prediction = &report["prediction"];
    assert_eq!(prediction["samples"], 4);
    assert!((rmse(prediction, "last") - f64::sqrt(9.0 / 4.0)).abs() < 1e-6);
    assert_eq!(report["links"][0]["link"], "a");
    assert_eq!(report["links"][0]["packets"], 7);
    assert_eq!(report["links"][1]["prediction"], Value::Null);
    assert_eq!(report["policy"], Value::Null);
}

#[test]
fn the_table_names_the_first_lines_of_each_anomaly() {
    let file = write(&folder("table"), "log.csv", SPOILT_CSV);
    let table = replayed(file.clone()).to_string();
    let expected = format!(
        "\
{}
  csv: 8 of 13 rows used, 8 packets on 2 links
  row-length             2  (lines 8, 15)
  not-a-number           1  (line 9)
  impossible-rssi        1  (line 4)
  impossible-motion      1  (line 6)
  clock-backwards        1  (line 5)
  clock-restart          1  (line 12)
  gap                    1  (line 10)

  next packet (4 predicted)   RMSE dB   log-likelihood   same variance
  last sample                   1.500          -2.4561         -2.4561
",
        file.display()
    );
    assert!(table.starts_with(&expected), "{table}");
}

#[test]
fn the_series_has_every_packet_and_what_was_expected_of_it() {
    let file = write(
        &folder("series"),
        "log.csv",
        "time_s,link,rssi_dbm\n0.5,a,-50\n0.7,a,-60\n0.9,a,-50\n",
    );
    let mut series = Vec::new();
    replayed(file.clone()).write_series(&mut series).unwrap();
    let series = String::from_utf8(series).unwrap().replace(&*file.to_string_lossy(), "F");
    assert_eq!(
        series,
        "\
file,line,time_s,link,rssi_dbm,velocity_mps,\
last_dbm,average_dbm,kalman_still_dbm,kalman_dbm,k_tuned_dbm,chain_dbm,\
last_error_db,average_error_db,kalman_still_error_db,kalman_error_db,k_tuned_error_db,chain_error_db
F,2,0.500000,a,-50,,,,,,,,,,,,,
F,3,0.700000,a,-60,,-50.000,-50.000,-50.000,-50.000,-50.000,-50.000,-10.000,-10.000,-10.000,-10.000,-10.000,-10.000
F,4,0.900000,a,-50,,-60.000,-52.700,-55.082,-55.082,-55.003,-52.262,10.000,2.700,5.082,5.082,5.003,2.262
"
    );
}

#[test]
fn a_log_without_motion_has_no_score_for_the_filter_with_it() {
    let file =
        write(&folder("motionless"), "log.csv", "time_s,link,rssi_dbm\n0,a,-50\n0.2,a,-52\n");
    let report = report(file);
    assert_eq!(report["prediction"]["kalman"], Value::Null);
    assert!(report["prediction"]["kalman_still"]["rmse_db"].is_number());
}

/// Relay 1 between a weak front and a strong back link, dropouts, and all that can be wrong.
const SPOILT_FLIGHT: &str = "\
0.4,60,50,42,
0.8,60,50,42,
1.2,60,50,
1.1,60,50,42,
1.6,60,0,42,
2.0,160,50,42,
2.4,60,fifty,42,
6.0,50,60,70,
";

/// The whole drone of a relay over a flight: it relays while both links are there, backs up when
/// the base's side falls silent, and lands when that goes on for longer than its bound.
#[test]
fn a_flight_shows_what_the_whole_drone_would_have_done() {
    let mut log = String::new();
    for row in 0..100 {
        let time = f64::from(row) * 0.4;
        // Link 1 is heard for the first 2 s only.
        let back = if row < 5 { "55," } else { "" };
        log.push_str(&format!("{time:.2},55,{back}\n"));
    }
    let report = report(write(&folder("agents"), "flight.csv", &log));
    let agents = report["agents"].as_array().unwrap();
    assert_eq!(agents.len(), 1);
    let part = |name: &str| agents[0][name].as_f64().unwrap();
    assert!(part("relaying") > 0.05 && part("relaying") < 0.15, "{agents:?}");
    assert!(part("backing_up") > 0.7, "{agents:?}");
    assert_eq!(part("reconnecting"), 0.0);
    // Lost 2 s after the last packet, and 30 s of retreat.
    let landed = part("landed_s");
    assert!((33.0..35.0).contains(&landed), "{agents:?}");
}

#[test]
fn a_flight_shows_what_the_policies_would_have_done() {
    let report = report(write(&folder("flight"), "flight.csv", SPOILT_FLIGHT));
    assert_eq!(report["format"], "uchain-flight");
    assert_eq!((&report["rows"], &report["used"]), (&json!(8), &json!(6)));
    assert_eq!(
        report["anomalies"],
        json!({
            "not-a-number": { "count": 1, "lines": [7] },
            "impossible-rssi": { "count": 1, "lines": [6] },
            "missing-link": { "count": 1, "lines": [3] },
            "clock-backwards": { "count": 1, "lines": [4] },
            "gap": { "count": 1, "lines": [8] },
        })
    );
    assert_eq!(report["prediction"], Value::Null);
    let commands = report["policy"].as_array().unwrap();
    assert_eq!(commands.len(), 6 * 2);
    // Three rows forward, one back. Full speed either way, as T0 does.
    assert_eq!(commands[0]["policy"], "t0");
    assert_eq!(commands[0]["relay"], 1);
    assert_eq!(commands[0]["rows"], 4);
    assert_eq!(commands[0]["forward"], 0.75);
    assert_eq!(commands[0]["sign_changes"], 1);
    assert_eq!(commands[0]["agrees_with_authors"], 1.0);
    // The last link is at −70 dBm in the last row only: at once, but not for 2 s.
    assert_eq!(report["launches_at_once_s"], json!([6.0]));
    assert_eq!(report["launches_s"], json!([]));
    // Adjacent links differ by 10, 8; 10, 8; 10; 8; 10, 10.
    assert_eq!(report["equality"]["pairs"], 8);
    assert_eq!(report["equality"]["within_5_db"], 0.0);
    assert_eq!(report["equality"]["means_dbm"][2], -238.0 / 5.0);
}

#[test]
fn one_policy_can_be_asked_for() {
    let file = write(&folder("policy"), "flight.csv", SPOILT_FLIGHT);
    let options = ReplayOptions { policy: Policy::named("t5"), ..ReplayOptions::default() };
    let summary = serde_json::to_value(replay(&[file], &options).unwrap()).unwrap();
    let commands = summary["files"][0]["policy"].as_array().unwrap();
    assert!(commands.len() == 2 && commands.iter().all(|told| told["policy"] == "t5"));
    assert_eq!(summary["all"], Value::Null);
}

/// Two receivers, 3 m below and above the start of a beacon's way.
const DEVICES: &str = r#"Dongles:{"aa": [[0, 0, -3], 1, "s1"], "bb": [[0, 0, 3], 2, "s2"] }
Beacons:{"cc": [[], 3, "b"] }"#;

const SPOILT_TRACK: &str = "\
100.0,aa,cc,-60,0,0,0,1,0,0,0,1,0,0,0,1
100.5,aa,cc,-61,0,0,1,1,0,0,0,1,0,0,0,1
100.5,bb,cc,-62,0,0,1,1,0,0,0,1,0,0,0,1
100.4,bb,cc,-62,0,0,1,1,0,0,0,1,0,0,0,1
101.0,bb,cc,-59,0,0,1.5,1,0,0,0,1,0,0,0,1
101.0,bb,cc,102,0,0,1.5,1,0,0,0,1,0,0,0,1
101.5,aa,cc,-60,0,0
101.5,aa,cc,-60,0,nought,0,1,0,0,0,1,0,0,0,1
101.5,dd,cc,-60,0,0,1,1,0,0,0,1,0,0,0,1
101.5,aa,cc,-60,0,0,31,1,0,0,0,1,0,0,0,1
7.0,aa,cc,-60,0,0,1,1,0,0,0,1,0,0,0,1
";

#[test]
fn a_tetam_track_knows_how_fast_the_beacon_leaves_each_receiver() {
    let folder = folder("tetam");
    write(&folder, "cnf/tetam.dev", DEVICES);
    let file = write(&folder, "trk/track.mbd", SPOILT_TRACK);
    let summary = replayed(file.clone());
    let report = serde_json::to_value(&summary).unwrap()["files"][0].clone();
    assert_eq!(report["format"], "tetam");
    assert_eq!(
        report["anomalies"],
        json!({
            "row-length": { "count": 1, "lines": [7] },
            "not-a-number": { "count": 1, "lines": [8] },
            "impossible-rssi": { "count": 1, "lines": [6] },
            "impossible-motion": { "count": 1, "lines": [10] },
            "unknown-receiver": { "count": 1, "lines": [9] },
            "clock-backwards": { "count": 1, "lines": [4] },
            "clock-restart": { "count": 1, "lines": [11] },
        })
    );
    let mut series = Vec::new();
    summary.write_series(&mut series).unwrap();
    let series = String::from_utf8(series).unwrap();
    let velocities: Vec<&str> =
        series.lines().skip(1).filter_map(|row| row.split(',').nth(5)).collect();
    // Away from the lower receiver at 1 m in 0.5 s, towards the upper one at 0.5 m in 0.5 s.
    assert_eq!(velocities, ["0.000", "2.000", "0.000", "-1.000", "", "", "0.000"]);
}

const ANCHORS: &str = "id,x,y,z\n1,0,0,1.3\n2,10,0,1.3\n";

/// The robot drives from the first anchor to the second at 0.5 m/s; the heading does not matter.
const POSES: &str = "\
,ts,x,heading,y,rssi_7,rssi_9
0,1000000000000,1.0,0,0,-50,
1,1001000000000,1.5,0,0,-50,
2,1002000000000,2.0,0,0,-50,
";

/// The ticks are milliseconds with their bytes the wrong way round: 25600 is
/// 100, 22530 is 600, 16390 is 1600.
const SPOILT_ROBOT: &str = "\
1000600\t7\t1\t43\t100000\t2\t0\t1\t1\t25600\t-50\t1\t2\t3\t0\t1\t1\t22530\t-51\t1\t2\t3\t0
1000600\t9\t1\t39\t100000\t1\t1\t2\t1\t25600\t-70\t1\t2\t3\t0\t0\t1\t5\t123456789
1000500\t9\t2\t31\t100000\t1\t0\t2\t1\t22530\t-70\t1\t2\t3\t0
1001600\t9\t3\t31\t100000\t1\t0\t2\t1\t22530\t0\t1\t2\t3\t0
1001600\t7\t2\t31\t100000\t1\t0\t1\t1\t22530\t-50
1001600\t7\t2\t31\tx\t0\t0
1001700\t7\t2\t19\t100000\t0\t0
1001700\t7\t3\t31\t100000\t1\t0\t1\t1\t16390\t-53\t1\t2\t3\t0
";

#[test]
fn a_robot_log_is_put_in_order_of_its_anchors_ticks() {
    let folder = folder("robot");
    write(&folder, "anchors.csv", ANCHORS);
    write(&folder, "run_df.csv", POSES);
    let summary = replayed(write(&folder, "run_ble.txt", SPOILT_ROBOT));
    let report = serde_json::to_value(&summary).unwrap()["files"][0].clone();
    assert_eq!(report["format"], "ble-robot");
    assert_eq!((&report["rows"], &report["used"]), (&json!(8), &json!(3)));
    assert_eq!(
        report["anomalies"],
        json!({
            "row-length": { "count": 1, "lines": [5] },
            "not-a-number": { "count": 1, "lines": [6] },
            "impossible-rssi": { "count": 1, "lines": [4] },
            "clock-backwards": { "count": 1, "lines": [3] },
        })
    );
    let mut series = Vec::new();
    summary.write_series(&mut series).unwrap();
    let series = String::from_utf8(series).unwrap();
    let cells: Vec<Vec<&str>> =
        series.lines().skip(1).map(|row| row.split(',').skip(2).take(4).collect()).collect();
    // A second after the anchor's last packet, though its row came later; 0.5 m farther away.
    assert_eq!(
        cells,
        [
            ["1000.100000", "7.1", "-50", "0.000"],
            ["1000.600000", "7.1", "-51", "0.000"],
            ["1000.600000", "9.2", "-70", "0.000"],
            ["1001.600000", "7.1", "-53", "0.500"],
        ]
    );
}

#[test]
fn a_still_link_is_read_although_its_packets_are_damaged() {
    let mut log = b"Frame,Time,Source,DeviceName,RSSI,Tx Power,PDU Type,Company\n\
        1,0.000,aa:bb,Phone,-45,8,0,76\n\
        2,0.005,aa:bb,P\xd1\xffne,-47,8,0,76\n\
        3,0.010,,Phone,-47,8,0,76\n\
        4,0.015,aa:bb,Pho,ne,-47,8,0,76\n\
        5,0.020,aa:bb,Phone,loud,8,0,76\n\
        6,0.001,aa:bb,Phone,-47,8,0,76\n"
        .to_vec();
    log.extend_from_slice(b"7,0.030,aa:bb,Phone,127,8,0,76\n");
    let report = report(write(&folder("mitll"), "still.csv", log));
    assert_eq!(report["format"], "mitll");
    assert_eq!(
        report["anomalies"],
        json!({
            "row-length": { "count": 2, "lines": [4, 5] },
            "not-a-number": { "count": 1, "lines": [6] },
            "impossible-rssi": { "count": 1, "lines": [8] },
            "clock-backwards": { "count": 1, "lines": [7] },
        })
    );
    // Nothing moves, and that is known: both filters are the same.
    assert_eq!(report["prediction"]["samples"], 1);
    assert_eq!(report["prediction"]["kalman"], report["prediction"]["kalman_still"]);
}

#[test]
fn a_file_that_is_not_what_it_claims_is_refused_in_one_line() {
    let folder = folder("refused");
    let image = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x04\0\0\0\x04\0".as_slice();
    let mostly_wrong = "0.4,52,47,\n".repeat(30) + &"what is this\n".repeat(40);
    let cases: [(&str, &[u8], Option<Format>, &str); 13] = [
        ("a.png", image, Some(Format::Tetam), "a.png:1: this is not a row of a TETAM track"),
        ("b.png", image, None, "b.png: this is in none of the known log formats"),
        (
            "a.gz",
            b"\x1f\x8b\x08\0",
            None,
            "a.gz: the file as a whole is compressed; unpack it with",
        ),
        (
            "a.zst",
            b"\x28\xb5\x2f\xfd\0",
            Some(Format::Mcap),
            "a.zst: the file as a whole is compre",
        ),
        ("a.txt", b"\xff\xfet\0i\0", None, "a.txt: this is text in UTF-16; save it as UTF-8"),
        ("empty", b"", None, "empty: the file is empty"),
        ("blank", b"\n \n\n", Some(Format::Csv), "blank: the file is empty"),
        ("c.csv", b"time,rssi\n0,-50\n", Some(Format::Csv), "c.csv:1: the first row does not name"),
        ("d.csv", b"Frame,Time\n", Some(Format::Mitll), "d.csv:1: the first row does not name"),
        ("e.csv", b"time_s,link,rssi_dbm\n", None, "e.csv: no row follows the header"),
        (
            "f.csv",
            b"time_s,link,rssi_dbm\n0,a,127\n",
            None,
            "f.csv: none of its 1 rows holds a usable sample",
        ),
        ("g.txt", mostly_wrong.as_bytes(), None, "g.txt:31: this is not a row of a U-Chain flight"),
        ("h_ble.txt", b"1\t2\t3\t19\t5\t0\t0\n", None, "anchors.csv: cannot be read"),
    ];
    for (name, content, format, wrong) in cases {
        let file = write(&folder, name, content);
        let options = ReplayOptions { format, ..ReplayOptions::default() };
        let error = replay(&[file], &options).unwrap_err().to_string();
        let start = format!("{}/{wrong}", folder.display());
        assert!(error.starts_with(&start) && error.contains("; "), "{name}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let missing = replay(&[folder.join("no such log")], &ReplayOptions::default()).unwrap_err();
    assert!(missing.to_string().contains("no such log: cannot be read"), "{missing}");
    assert!(replay(&[], &ReplayOptions::default()).is_err());
}

#[test]
fn files_are_pooled_by_packet() {
    let folder = folder("pooled");
    let a = write(&folder, "a.csv", "time_s,link,rssi_dbm\n0,a,-50\n0.2,a,-53\n");
    let b = write(&folder, "b.csv", "time_s,link,rssi_dbm\n0,a,-50\n0.2,a,-54\n0.4,a,-54\n");
    let summary = replay(&[a, b], &ReplayOptions::default()).unwrap();
    let all = serde_json::to_value(&summary).unwrap()["all"].clone();
    assert_eq!(all["samples"], 3);
    assert!((rmse(&all, "last") - f64::sqrt((9.0 + 16.0) / 3.0)).abs() < 1e-6);
    assert!(summary.to_string().contains("\nall files\n"));
}

/// A folder where every format finds what belongs to it, for logs in its `trk`.
fn furnished(name: &str) -> PathBuf {
    let folder = folder(name);
    write(&folder, "cnf/tetam.dev", DEVICES);
    write(&folder, "trk/anchors.csv", ANCHORS);
    write(&folder, "trk/log_df.csv", POSES);
    folder.join("trk")
}

const FORMATS: [Option<Format>; 6] = [
    None,
    Some(Format::UchainFlight),
    Some(Format::Tetam),
    Some(Format::BleRobot),
    Some(Format::Mitll),
    Some(Format::Csv),
];

/// Replays these bytes as every format. Whatever they are, the answer is a report whose numbers
/// are numbers, or an error in one line.
fn survive(folder: &Path, bytes: &[u8]) {
    let file = write(folder, "log_ble.txt", bytes);
    for format in FORMATS {
        let options = ReplayOptions { format, ..ReplayOptions::default() };
        match replay(std::slice::from_ref(&file), &options) {
            Ok(summary) => {
                assert!(!summary.to_string().contains("NaN"), "{summary}");
                serde_json::to_string(&summary).unwrap();
                summary.write_series(&mut Vec::new()).unwrap();
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_replayed_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        survive(&furnished("any"), &bytes);
    }

    #[test]
    fn a_log_with_any_damage_is_replayed_or_refused(
        log in prop::sample::select(vec![
            SPOILT_CSV,
            SPOILT_FLIGHT,
            SPOILT_TRACK,
            SPOILT_ROBOT,
            "Frame,Time,Source,DeviceName,RSSI\n1,0,aa,b,-45\n2,1,aa,b,-46\n",
        ]),
        damage in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::sample::select(b"0123456789-.,\t\n\"e\xffx".to_vec())),
            0..12,
        ),
    ) {
        let mut bytes = log.as_bytes().to_vec();
        for (place, byte) in damage {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        survive(&furnished("damaged"), &bytes);
    }

    /// The filter's claim: where strength follows distance as its law says, knowing the motion
    /// foresees it, and not knowing it does not.
    #[test]
    fn a_link_that_follows_the_law_is_foreseen_by_its_motion(
        start in 2.0..4.0_f64,
        speed in 0.3..0.8_f64,
        reversals in 1..4_u32,
    ) {
        let mut log = String::from("time_s,link,rssi_dbm,velocity_mps\n");
        let mut distance = start;
        for step in 0..120_u32 {
            let outward = (step * reversals / 60) % 2 == 0;
            let velocity = if step == 0 { 0.0 } else if outward { speed } else { -speed };
            distance = (distance + velocity * 0.2).max(1.0);
            let rssi = -40.0 - 30.0 * distance.log10();
            let time = 0.2 * f64::from(step);
            log += &format!("{time:.1},a,{rssi:.4},{velocity}\n");
            // The law is left as soon as the ends would pass each other.
            if distance <= 1.0 {
                break;
            }
        }
        let report = report(write(&folder("law"), "law.csv", log));
        let prediction = &report["prediction"];
        let (still, moving) = (rmse(prediction, "kalman_still"), rmse(prediction, "kalman"));
        prop_assert!(moving < 0.1 * still, "{moving} dB with the velocity, {still} dB without");
        let likelihood = |who: &str| prediction[who]["log_likelihood"].as_f64().unwrap();
        prop_assert!(likelihood("kalman") > likelihood("kalman_still"));
    }
}

/// Recordings, which are no part of the repository.
fn recorded(names: &[&str]) -> Vec<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/rssi");
    names.iter().map(|name| data.join(name)).collect()
}

/// The scores of each file, as a table: predicted packets, then RMSE and mean log-likelihood of
/// the last sample, the average, the filter without and with velocity, and the filters of the
/// policies `k-tuned` and `chain`.
fn scores(files: &[PathBuf]) -> String {
    let summary = replay(files, &ReplayOptions::default()).unwrap();
    let summary = serde_json::to_value(summary).unwrap();
    let row = |report: &Value| {
        let prediction = &report["prediction"];
        let score = |who: &str| {
            let likelihood = prediction[who]["log_likelihood"].as_f64().unwrap();
            format!("{:.3} {likelihood:.3}", rmse(prediction, who))
        };
        format!(
            "{} | {} | {} | {} | {} | {} | {}\n",
            prediction["samples"],
            score("last"),
            score("average"),
            score("kalman_still"),
            score("kalman"),
            score("k_tuned"),
            score("chain")
        )
    };
    summary["files"].as_array().unwrap().iter().map(row).collect()
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_tetam_tracks_are_foreseen_best_with_their_motion() {
    let files = recorded(&[
        "tetam_ble/trk/straight_01_all_sensors.mbd",
        "tetam_ble/trk/straight_03_all_sensors.mbd",
        "tetam_ble/trk/straight_04_all_sensors.mbd",
        "tetam_ble/trk/rectangular_with_rotation_all_sensors.mbd",
    ]);
    let summary = replay(&files, &ReplayOptions::default()).unwrap();
    let summary = serde_json::to_value(summary).unwrap();
    let backwards: Vec<&Value> = summary["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|report| &report["anomalies"]["clock-backwards"]["lines"])
        .collect();
    assert_eq!(backwards, [&Value::Null, &json!([1048]), &json!([238]), &json!([679])]);
    for report in summary["files"].as_array().unwrap() {
        let prediction = &report["prediction"];
        let rmse = |who| rmse(prediction, who);
        assert!(rmse("kalman") < rmse("kalman_still") && rmse("kalman_still") < rmse("average"));
        assert!(rmse("average") < rmse("last"));
    }
    assert_eq!(
        scores(&files),
        "\
1353 | 6.185 -3.264 | 5.025 -3.050 | 5.009 -3.030 | 4.988 -3.026 | 4.936 -5.247 | 5.054 -3.163
1048 | 6.047 -3.232 | 4.862 -3.007 | 4.860 -2.998 | 4.812 -2.988 | 5.017 -5.338 | 4.873 -3.111
544 | 6.257 -3.294 | 5.317 -3.114 | 5.275 -3.082 | 5.163 -3.058 | 5.320 -5.652 | 5.583 -3.519
1922 | 6.270 -3.267 | 5.178 -3.070 | 5.169 -3.064 | 5.113 -3.053 | 5.329 -5.887 | 5.234 -3.146
"
    );
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn a_recorded_robot_is_foreseen_no_better_with_its_slow_motion() {
    let files = recorded(&["ble_uwb_robot/calib3_ble.txt"]);
    let report = report(files[0].clone());
    assert_eq!((&report["rows"], &report["used"]), (&json!(1675), &json!(1611)));
    assert_eq!(report["packets"], 10_010);
    assert_eq!(report["anomalies"]["gap"]["count"], 6);
    assert_eq!(
        scores(&files),
        "\
9991 | 5.228 -3.076 | 4.611 -2.952 | 4.705 -2.968 | 4.697 -2.967 | 5.438 -6.143 | 4.756 -3.088
"
    );
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_still_links_are_foreseen_alike_by_both_filters() {
    let files =
        recorded(&["mitll_nrf52_static/anechoic_90.csv", "mitll_nrf52_static/screenroom_90.csv"]);
    assert_eq!(
        scores(&files),
        "\
7901 | 5.994 -3.024 | 4.245 -2.727 | 4.190 -2.855 | 4.190 -2.855 | 4.637 -5.016 | 4.221 -2.704
6658 | 10.658 -3.616 | 7.560 -3.271 | 6.983 -3.664 | 6.983 -3.664 | 6.971 -9.394 | 7.081 -3.364
"
    );
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn recorded_flights_are_told_from_their_content() {
    let files =
        recorded(&["uchain_flights/4drones_S_good_novideo.csv", "uchain_flights/ping_log.csv"]);
    let flown = report(files[0].clone());
    assert_eq!(flown["format"], "uchain-flight");
    assert_eq!((&flown["rows"], &flown["used"]), (&json!(141), &json!(141)));
    assert_eq!(flown["anomalies"]["missing-link"]["count"], 30);
    assert_eq!(flown["anomalies"]["gap"]["lines"], json!([64, 93, 97]));
    assert_eq!(flown["launches_s"], json!([37.8]));
    assert_eq!(flown["launches_at_once_s"], json!([28.61, 35.42, 45.39, 52.59]));
    // The head was off; relay 1 never had both of its links.
    let parked = report(files[1].clone());
    assert_eq!(parked["equality"]["means_dbm"][0], Value::Null);
    assert_eq!(parked["policy"][0]["rows"], 0);
}
