//! The still links of the MITLL set: what an nRF52 received from telephones 6 feet away.
//!
//! A header, then `Frame,Time,Source,DeviceName,RSSI,…`. A link is a source address. Both ends
//! stood still, so the speed is known: it is zero. Names are as they came over the air, damaged
//! packets included.

use std::path::Path;

use units::MetresPerSecond;

use super::table::Table;
use super::{instant, number, received};
use crate::input_error::InputError;
use crate::replay::recording::{Anomaly, Clock, Recorder, Recording};

const NAMES: [&str; 3] = ["Time", "Source", "RSSI"];

pub(super) fn is_header(row: &str) -> bool {
    row.trim_start_matches('\u{feff}').starts_with("Frame,Time,Source,") && row.contains(",RSSI")
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut clock = Clock::default();
    for row in Table::open(bytes, file, NAMES, NAMES.len())? {
        recorder.row();
        let line = row.line;
        let ([Some(time), Some(source), Some(rssi)], true) = (row.fields, row.whole) else {
            recorder.anomaly(Anomaly::RowLength, line);
            continue;
        };
        if source.is_empty() {
            recorder.anomaly(Anomaly::RowLength, line);
            continue;
        }
        let (Some(time), Some(rssi)) = (number(&time).and_then(instant), number(&rssi)) else {
            recorder.anomaly(Anomaly::NotANumber, line);
            continue;
        };
        let Some(rssi) = received(rssi) else {
            recorder.anomaly(Anomaly::ImpossibleRssi, line);
            continue;
        };
        if recorder.clock_is_sound(&mut clock, time, line) {
            let link = recorder.link(&source);
            recorder.sample(line, time, link, rssi, Some(MetresPerSecond::ZERO), None);
        }
    }
    Ok(recorder.finish())
}
