//! Recordings with bytes changed, left out and put in: each is read, or refused in one line.

use std::fs;
use std::path::Path;

use random::{Purpose, Stream};
use sim_harness::mission::Mission;
use sim_harness::replay::{ReplayOptions, replay, station_record};
use sim_harness::report::{csv, mcap};
use sim_harness::scenario::Scenario;

/// Recordings of each kind that no other file belongs to.
fn recordings() -> Vec<(&'static str, Vec<u8>)> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios/short.toml");
    let scenario = Scenario::read(&file).unwrap();
    let trace = Mission::record(&scenario, &scenario.world(), 1);
    let (mut table, mut file) = (Vec::new(), std::io::Cursor::new(Vec::new()));
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
    for (name, sound) in recordings() {
        let file = folder.join(name);
        let (mut read, mut refused) = (0, 0);
        for number in 0..count {
            let mut random = Stream::new(number, Purpose::Drawn);
            let mut bytes = sound.clone();
            for _ in 0..=random.below(3) {
                damage(&mut bytes, &mut random);
            }
            fs::write(&file, &bytes).unwrap();
            let done = replay(std::slice::from_ref(&file), &ReplayOptions::default())
                .and_then(|_| station_record(&file));
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
        println!("{name}: {read} read, {refused} refused");
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
