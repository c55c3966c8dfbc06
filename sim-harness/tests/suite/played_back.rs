//! Logs as the channel of a mission (`[radio.trace]`): the packets of the mission scatter as those of
//! the log did.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use radio_model::Reception;
use sim_harness::medium::{Arrives, Medium, MediumConfig};
use sim_harness::mission::{Mission, RecordedChannel, Residual};
use sim_harness::scenario::Scenario;
use units::{Db, Dbm, Metres};

/// A receiver that adds nothing to what was recorded.
const EXACT: Reception = Reception {
    noise_variance: 0.0,
    resolution: Db(0.0),
    loss_rate: 0.0,
    sensitivity: Dbm(f32::NEG_INFINITY),
};

const PACKETS: usize = 400;
const EVERY_US: u64 = 200_000;

/// Residuals that scatter by 4 dB and depend on the one before: with each packet half of it is left.
fn residuals(seed: u32) -> Vec<f32> {
    let mut state = seed.wrapping_mul(2_654_435_761) | 1;
    let mut uniform = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 8) as f32 / (1_u32 << 24) as f32
    };
    let mut value = 0.0;
    (0..PACKETS)
        .map(|_| {
            value = 0.5 * value + 12.0 * (uniform() - 0.5);
            value
        })
        .collect()
}

/// Mean, variance, and autocorrelation from one packet to the next.
fn statistics(values: &[f32]) -> [f32; 3] {
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    let moment = |lag: usize| {
        let pairs = values.iter().zip(&values[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f32>() / (values.len() - lag) as f32
    };
    [mean, moment(0), moment(1) / moment(0)]
}

fn channel(residuals: &[f32], distance: impl Fn(usize) -> Option<Metres>) -> Arc<RecordedChannel> {
    let packet = |(n, residual): (usize, &f32)| Residual {
        at_us: n as u64 * EVERY_US,
        distance: distance(n),
        residual: Db(*residual),
    };
    let link = residuals.iter().enumerate().map(packet).collect();
    Arc::new(RecordedChannel::of([link].into_iter()).unwrap())
}

/// The strengths over −60 dBm with which one station hears another, twice as long as the log.
fn heard(channel: &Arc<RecordedChannel>, seed: u64) -> Vec<f32> {
    let config = MediumConfig { arrives: Arrives::AtAntenna, ..MediumConfig::of(EXACT) };
    let mut medium = Medium::new(config, 2, seed).through(Some(channel), seed);
    let mut heard = Vec::new();
    for n in 0..2 * PACKETS as u64 {
        medium.inject(0, (n + 1) * EVERY_US, &[0; 20]);
        while medium.next().is_some() {
            let arrival = medium.advance(&mut |_, _| Some(Dbm(-60.0)));
            heard.extend(arrival.iter().flat_map(|one| one.heard).map(|one| one.rssi.0 + 60.0));
        }
    }
    heard
}

/// Over the time there and back each packet is played twice, so that mean and variance are the log's,
/// and all but the two turns follow each other as in the log.
#[test]
fn packets_scatter_as_those_of_the_log() {
    for seed in 1..6 {
        let log = residuals(seed);
        let [mean, variance, correlation] = statistics(&log);
        for of_time in [true, false] {
            // At one distance the level is the mean, which belongs to the link's strength.
            let distance = |_| (!of_time).then_some(Metres(3.0));
            let played = heard(&channel(&log, distance), u64::from(seed));
            assert_eq!(played.len(), 2 * PACKETS);
            let found = statistics(&played);
            let level = if of_time { 0.0 } else { mean };
            assert!((found[0] - mean + level).abs() < 0.1, "{found:?}, {mean}");
            assert!((found[1] / variance - 1.0).abs() < 0.03, "{found:?}, {variance}");
            assert!((found[2] - correlation).abs() < 0.03, "{found:?}, {correlation}");
        }
    }
}

#[test]
fn a_seed_plays_the_same_packets_and_another_seed_others() {
    let channel = channel(&residuals(7), |_| None);
    assert_eq!(heard(&channel, 1), heard(&channel, 1));
    assert_ne!(heard(&channel, 1), heard(&channel, 2));
}

#[test]
fn a_link_of_few_packets_is_no_channel() {
    let link = vec![Residual { at_us: 0, distance: None, residual: Db(1.0) }; 19];
    assert_eq!(RecordedChannel::of([link].into_iter()), None);
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("played_back").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A scenario beside a log of 10 m of walk, in which a relay hovers between base and head.
fn scenario(name: &str, log: &str, link: &str) -> PathBuf {
    let folder = folder(name);
    fs::write(folder.join("log.csv"), log).unwrap();
    let text = format!(
        "\
title = \"A relay hovers in a recorded channel\"
duration_s = 80.0
link = \"{link}\"
[tunnel]
width_m = 1.5
centre_line_m = [[0.0, 0.0], [16.0, 0.0]]
[drones]
relays = 1
start = \"placed\"
at_m = [10.0, 5.0]
[radio]
packet_loss = 0.0
[radio.trace]
log = \"log.csv\"
[[pilot]]
at_s = 0.0
order = \"explore\"
speed_mps = 0.0
"
    );
    let file = folder.join("mission.toml");
    fs::write(&file, text).unwrap();
    file
}

/// A log of free space with a shadow of 6 dB beyond 5 m.
fn walk() -> String {
    let rows = residuals(3).into_iter().enumerate().map(|(n, residual)| {
        let distance = 1.0 + 9.0 * n as f32 / PACKETS as f32;
        let shadow = if distance > 5.0 { 6.0 } else { 0.0 };
        let rssi = -40.0 - 20.0 * distance.log10() - shadow + residual;
        format!("{:.1},a,{rssi:.1},{distance:.3}\n", 0.2 * n as f32)
    });
    format!("time_s,link,rssi_dbm,distance_m\n{}", rows.collect::<String>())
}

#[test]
fn a_mission_hears_the_scatter_of_its_log() {
    let deviations = |link: &str| -> Vec<f32> {
        let file = scenario(&format!("hears-{link}"), &walk(), link);
        let scenario = Scenario::read(&file).unwrap();
        let world = scenario.world();
        let trace = Mission::record(&scenario, &world, 1);
        let fronts = trace.frames.iter().filter_map(|frame| frame.drones.get(1)?.front);
        fronts.map(|front| front.raw.0 - front.truth.0).collect()
    };
    let [log_mean, log_variance, _] = statistics(&residuals(3));
    for link in ["exact", "ideal"] {
        let [mean, variance, _] = statistics(&deviations(link));
        // The level takes a part of the scatter, the law another; the mission plays the whole log.
        assert!((mean - log_mean).abs() < 1.5, "{link}: {mean} for {log_mean}");
        assert!(
            (0.6..1.2).contains(&(variance / log_variance)),
            "{link}: {variance}, {log_variance}"
        );
    }
}

#[test]
fn a_log_without_distances_drives_a_mission_by_its_time() {
    let rows = residuals(3).into_iter().enumerate();
    let rows =
        rows.map(|(n, residual)| format!("{:.1},a,{:.1}\n", 0.2 * n as f32, residual - 70.0));
    let log = format!("time_s,link,rssi_dbm\n{}", rows.collect::<String>());
    let scenario = Scenario::read(&scenario("times", &log, "ideal")).unwrap();
    let world = scenario.world();
    let trace = Mission::record(&scenario, &world, 1);
    let fronts = trace.frames.iter().filter_map(|frame| frame.drones.get(1)?.front);
    let played: Vec<f32> = fronts.map(|front| front.raw.0 - front.truth.0).collect();
    // The mission is as long as the log, which is played there and back: some parts of it twice.
    let [[mean, variance, correlation], log] = [statistics(&played), statistics(&residuals(3))];
    assert!(mean.abs() < 1.5, "{mean}");
    assert!((0.6..1.5).contains(&(variance / log[1])), "{variance} for {}", log[1]);
    assert!((correlation - log[2]).abs() < 0.15, "{correlation} for {}", log[2]);
}

#[test]
fn a_mission_through_a_log_repeats_itself() {
    let file = scenario("repeats", &walk(), "exact");
    let scenario = Scenario::read(&file).unwrap();
    let world = scenario.world();
    let flown = |seed| {
        let trace = Mission::record(&scenario, &world, seed);
        trace.frames.iter().map(|frame| format!("{frame:?}")).collect::<Vec<_>>()
    };
    assert_eq!(flown(1), flown(1));
    assert_ne!(flown(1), flown(2));
}

#[test]
fn a_bad_log_is_refused_in_one_line() {
    for (name, log) in [
        ("empty", ""),
        ("nothing", "time_s,link,rssi_dbm\n"),
        ("short", "time_s,link,rssi_dbm\n0,a,-50\n"),
    ] {
        let error = Scenario::read(&scenario(name, log, "exact")).unwrap_err().to_string();
        assert!(error.contains("log.csv") && !error.contains('\n'), "{error}");
    }
}
