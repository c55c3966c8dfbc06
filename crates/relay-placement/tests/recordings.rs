//! The refined map of signal strength on recordings, each reading predicted from others.
//!
//! The recordings are no part of the repository: they are read from `../shared/data/rssi` beside it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use relay_placement::{Readings, RefineConfig};
use units::{Db, Point2};

/// A reading of one reference, and what the model without an offset says of its strength, dB.
struct Sample {
    reference: String,
    at: Point2,
    rssi: f32,
    model: f32,
}

/// The readings of one fold follow each other, 20 at a time, as on a stretch of the way.
const FOLDS: usize = 5;
const STRETCH: usize = 20;
/// The half width of an interval that holds 90 % of a normal distribution, in standard deviations.
const INTERVAL_90: f32 = 1.645;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/rssi")
}

/// The result of a cross-validation.
#[derive(Debug)]
struct Score {
    readings: usize,
    rmse_before: f32,
    rmse_after: f32,
    within: f32,
}

fn is_in(fold: usize, n: usize) -> bool {
    n / STRETCH % FOLDS == fold
}

fn validate(samples: &[Sample]) -> Score {
    let (mut before, mut after, mut within) = (0.0, 0.0, 0.0);
    for fold in 0..FOLDS {
        let learnt = || samples.iter().enumerate().filter(|(n, _)| !is_in(fold, *n));
        let level =
            learnt().map(|(_, it)| it.rssi - it.model).sum::<f32>() / learnt().count() as f32;
        let mut readings: BTreeMap<&str, Readings<64>> = BTreeMap::new();
        for (_, it) in learnt() {
            let own = readings.entry(&it.reference);
            let own = own.or_insert_with(|| Readings::new(RefineConfig::DEFAULT));
            own.add(it.at, Db(it.rssi - it.model - level)).unwrap();
        }
        let fitted: BTreeMap<&str, _> =
            readings.iter().map(|(name, it)| (*name, it.fit())).collect();
        for (_, it) in samples.iter().enumerate().filter(|(n, _)| is_in(fold, *n)) {
            let over = it.rssi - it.model - level;
            let Some(refined) = fitted.get(it.reference.as_str()) else { continue };
            let correction = refined.at(it.at);
            let off = over - correction.over.0;
            before += over * over;
            after += off * off;
            within += f32::from(off.abs() <= INTERVAL_90 * correction.reading_deviation.0);
        }
    }
    let count = samples.len() as f32;
    Score {
        readings: samples.len(),
        rmse_before: (before / count).sqrt(),
        rmse_after: (after / count).sqrt(),
        within: within / count,
    }
}

fn numbers(row: &str) -> Vec<f32> {
    row.split(',').map(|field| field.trim().parse().unwrap_or(f32::NAN)).collect()
}

/// The positions of the receivers: the numbers of each `"address": [[x, y, z], …`.
fn receivers(text: &str) -> BTreeMap<String, Vec<f32>> {
    let text = text.split("Beacons").next().unwrap_or_default();
    let entries = text.split("\": [[").collect::<Vec<_>>();
    let names = entries.iter().filter_map(|part| part.rsplit('"').next());
    let places = entries.iter().skip(1).filter_map(|part| part.split(']').next());
    names.zip(places).map(|(name, place)| (name.to_owned(), numbers(place))).collect()
}

/// Free space from the receiver to the beacon: 20 log10 of the distance.
fn track(folder: &Path, name: &str) -> Vec<Sample> {
    let read = |path: &str| std::fs::read_to_string(folder.join(path)).unwrap();
    let receivers = receivers(&read("tetam_ble/cnf/tetam.dev"));
    let text = read(&format!("tetam_ble/trk/{name}_all_sensors.mbd"));
    let sample = |row: &str| {
        let fields = numbers(row);
        let reference = row.split(',').nth(1)?.to_owned();
        let place = receivers.get(&reference)?;
        let squares = (0..3).map(|axis| (fields[4 + axis] - place[axis]).powi(2));
        let model = -10.0 * squares.sum::<f32>().max(0.01).log10();
        Some(Sample { at: Point2::new(fields[4], fields[5]), rssi: fields[3], model, reference })
    };
    text.lines().filter_map(sample).collect()
}

/// The poses of the robot are in the frame of its own map, in which no anchor is given: the model is
/// a constant.
fn robot(folder: &Path) -> Vec<Sample> {
    let text = std::fs::read_to_string(folder.join("ble_uwb_robot/calib3_df.csv")).unwrap();
    let mut rows = text.lines();
    let heads: Vec<_> = rows.next().unwrap().split(',').collect();
    let rows = rows.map(numbers);
    rows.flat_map(|row| {
        let at = Point2::new(row[2], row[4]);
        let columns = heads.iter().zip(row).skip(5).filter(|(_, rssi)| rssi.is_finite());
        columns
            .map(|(head, rssi)| Sample { reference: (*head).to_owned(), at, rssi, model: 0.0 })
            .collect::<Vec<_>>()
    })
    .collect()
}

#[test]
#[ignore = "needs the recordings in ../shared/data"]
fn a_refined_map_is_nearer_to_the_recordings_and_knows_how_near() {
    let folder = folder();
    let tracks = ["straight_01", "straight_03", "straight_04", "rectangular_with_rotation"];
    let sets = tracks.map(|name| (name, track(&folder, name)));
    for (name, samples) in sets.into_iter().chain([("robot", robot(&folder))]) {
        let score = validate(&samples);
        println!(
            "{name}: {} readings, RMSE {:.2} dB before and {:.2} after, {:.1} % within",
            score.readings,
            score.rmse_before,
            score.rmse_after,
            100.0 * score.within
        );
        assert!(score.rmse_after < score.rmse_before, "{name}: {score:?}");
        assert!((0.85..=0.95).contains(&score.within), "{name}: {score:?}");
    }
}
