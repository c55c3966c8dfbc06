//! Recordings with bytes changed, left out and put in: each is read, or refused in one line.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

use random::{Purpose, Stream};
use sim_harness::mission::Mission;
use sim_harness::replay::{ReplayOptions, replay, station_record};
use sim_harness::report::{csv, mcap};
use sim_harness::scenario::Scenario;

/// A recording of the ground station: a plan, orders, and a head and a relay that report.
fn station() -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = ::mcap::WriteOptions::new().compression(None).chunk_size(Some(2_000));
    let mut writer = options.create(&mut out).unwrap();
    let mut messages = vec![
        (
            "/map",
            r#"{"outlines":[],"lines":[{"name":"main","points":[[0,0],[9,0]]}],"base_m":0.5}"#
                .into(),
        ),
        ("/limits", r#"{"base":2,"launch_limit_dbm":-60.0,"retreat_limit_dbm":-70.0}"#.into()),
        (
            "/order",
            r#"{"event":"ordered","order":{"order":"explore","speed":0.2,"way":null},"fate":null}"#
                .to_owned(),
        ),
    ];
    for n in 0..40 {
        let (node, topic) =
            if n % 2 == 0 { (0, "/drone/0/report") } else { (1, "/drone/1/report") };
        let report = format!(
            r#"{{"node":{node},"state":"leading","state_code":3,"fault":"","battery_v":3.9,"endurance_s":200.0,"odometer_m":{}.5,"back":{},"rssi_dbm":-5{}.5}}"#,
            n / 10,
            node + 1,
            n % 9
        );
        messages.push((topic, report));
    }
    let mut channels = BTreeMap::new();
    for (n, (topic, json)) in messages.iter().enumerate() {
        let channel_id = *channels
            .entry(*topic)
            .or_insert_with(|| writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap());
        let log_time = 1_700_000_000_000_000_000 + n as u64 * 100_000_000;
        let header = ::mcap::records::MessageHeader {
            channel_id,
            sequence: n as u32,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, json.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

/// A log of the vendor's SD-card deck: an event of a battery's voltage and a signal strength each 0.1 s.
fn of_the_card() -> Vec<u8> {
    let mut bytes = b"\xbc\x01\x00\x01\x00\x07\x00fixedFrequency\0\x02\x00".to_vec();
    bytes.extend(b"pm.vbatMV(H)\0radio.rssi(B)\0");
    for n in 0..40_u32 {
        bytes.extend(7_u16.to_le_bytes());
        bytes.extend((n * 100).to_le_bytes());
        bytes.extend([1, 2, 50 + n as u8 % 9]);
    }
    // A checksum of 4 bytes that does not match is told, and the rest is read.
    bytes.extend([0; 4]);
    bytes
}

/// What belongs to a robot's log and to a TETAM track, in the places where they look for it.
fn write_companions(folder: &Path) {
    let devices = folder.parent().unwrap().join("cnf/tetam.dev");
    fs::create_dir_all(devices.parent().unwrap()).unwrap();
    let dongles = r#"Dongles:{"aa": [[0, 0, -3], 1, "s1"], "bb": [[0, 0, 3], 2, "s2"] }"#;
    fs::write(devices, format!("{dongles}\nBeacons:{{\"cc\": [[], 3, \"b\"] }}")).unwrap();
    fs::write(folder.join("anchors.csv"), "id,x,y,z\n1,0,0,1.3\n2,10,0,1.3\n").unwrap();
    let poses = (0..20)
        .map(|n| format!("{n},{},{}.5,0,0,-50,\n", 1_000_000_000_000_u64 + n * 1_000, n / 2));
    let poses = format!(",ts,x,heading,y,rssi_7,rssi_9\n{}", poses.collect::<String>());
    fs::write(folder.join("run_df.csv"), poses).unwrap();
}

/// Recordings of each kind.
fn recordings() -> Vec<(&'static str, Vec<u8>)> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios/short.toml");
    let scenario = Scenario::read(&file).unwrap();
    let trace = Mission::record(&scenario, &scenario.world(), 1);
    let (mut table, mut file) = (Vec::new(), Cursor::new(Vec::new()));
    csv::write(&trace, &mut table).unwrap();
    mcap::write(&trace, &mut file).unwrap();
    let rows = |row: &dyn Fn(usize) -> String| (0..60).map(row).collect::<String>().into_bytes();
    let packets = [
        b"time_s,link,rssi_dbm,velocity_mps\n".to_vec(),
        rows(&|n| format!("{}.{},a,-5{},0.1\n", n / 5, n % 5, n % 7)),
    ];
    let dates = [
        b"time_s;link;rssi_dbm\n".to_vec(),
        rows(&|n| format!("2024-05-01T10:00:{:02}Z;\"a\";-5{},5\n", n, n % 7)),
    ];
    let still = [
        b"Frame,Time,Source,DeviceName,RSSI\n".to_vec(),
        rows(&|n| format!("{n},0.{n:03},aa,Phone,-4{}\n", n % 9)),
    ];
    vec![
        ("station.mcap", station()),
        ("log00", of_the_card()),
        (
            "track.mbd",
            rows(&|n| {
                format!(
                    "10{}.{},aa,cc,-6{},0,0,{}.5,1,0,0,0,1,0,0,0,1\n",
                    n / 5,
                    n % 5,
                    n % 9,
                    n / 5
                )
            }),
        ),
        (
            "run_ble.txt",
            rows(&|n| {
                format!(
                    "100{:02}00\t7\t1\t31\t100000\t1\t0\t1\t1\t{}\t-5{}\t1\t2\t3\t0\n",
                    n,
                    25_600 + n % 200,
                    n % 9
                )
            }),
        ),
        ("trace.csv", table),
        ("trace.mcap", file.into_inner()),
        ("packets.csv", packets.concat()),
        ("dates.csv", dates.concat()),
        ("flight.csv", rows(&|n| format!("{}.{},5{},4{},\n", n / 5, n % 5, n % 9, n % 8))),
        ("still.csv", still.concat()),
    ]
}

/// Reads so many files of each recording, each damaged at up to three places.
fn read(count: u64, folder: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("damaged-logs").join(folder);
    fs::create_dir_all(&folder).unwrap();
    write_companions(&folder);
    for (name, sound) in recordings() {
        let file = folder.join(name);
        fs::write(folder.join(name), &sound).unwrap();
        let done = replay(&[folder.join(name)], &ReplayOptions::default());
        assert!(done.is_ok(), "undamaged: {}", done.unwrap_err());
        let (mut read, mut refused) = (0, 0);
        // The longest that one took, with its number. It is printed, and no test depends on it.
        let mut slowest = (Duration::ZERO, 0);
        for number in 0..count {
            let mut random = Stream::new(number, Purpose::Drawn);
            let mut bytes = sound.clone();
            for _ in 0..=random.below(3) {
                damage(&mut bytes, &mut random);
            }
            fs::write(&file, &bytes).unwrap();
            let began = Instant::now();
            let done = replay(std::slice::from_ref(&file), &ReplayOptions::default())
                .and_then(|_| station_record(&file));
            slowest = slowest.max((began.elapsed(), number));
            match done {
                Ok(_) => read += 1,
                Err(error) => {
                    let line = error.to_string();
                    let is_clear = line.lines().count() == 1 && line.contains("; ");
                    assert!(is_clear && line.contains(name), "{number}: {line}");
                    refused += 1;
                }
            }
        }
        println!(
            "{name}: {read} read, {refused} refused; number {} took {:?}",
            slowest.1, slowest.0
        );
    }
}

/// Changes bytes at one place, puts one in, or takes some out.
pub(crate) fn damage(bytes: &mut Vec<u8>, random: &mut Stream) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len() as u32) as usize;
    match random.below(6) {
        0 | 1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.below(256) as u8,
        3 => drop(bytes.remove(at)),
        4 => bytes.insert(at, random.below(256) as u8),
        _ if random.below(4) == 0 => bytes.truncate(at),
        _ => {
            let end = (at + 8).min(bytes.len());
            bytes[at..end].fill(if random.below(2) == 0 { 0xff } else { 0 });
        }
    }
}

#[test]
fn a_damaged_recording_is_read_or_refused_in_one_line() {
    read(40, "some");
}

/// `DAMAGED_LOGS` says how many files of each recording.
#[test]
#[ignore = "takes an hour; UCHAIN_LONG=1 .ci/run test runs it"]
fn every_damaged_recording_is_read_or_refused_in_one_line() {
    let count = std::env::var("DAMAGED_LOGS").ok().and_then(|it| it.parse().ok());
    read(count.unwrap_or(20_000), "many");
}
