//! The still links of the MITLL set: what an nRF52 received from telephones 6 feet away.
//!
//! A header, then `Frame,Time,Source,DeviceName,RSSI,…`. A link is a source address. Both ends
//! stood still, so the speed is known: it is zero. Names are as they came over the air, damaged
//! packets included.

use std::path::Path;

use input::InputError;
use units::MetresPerSecond;

use super::table::Table;
use super::{instant, number, received};
use crate::recording::{Anomaly, Clock, Recorder, Recording};

const NAMES: [&str; 3] = ["Time", "Source", "RSSI"];

pub(super) fn is_header(row: &str) -> bool {
    row.trim_start_matches('\u{feff}').starts_with("Frame,Time,Source,") && row.contains(",RSSI")
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut clock = Clock::default();
    let mut table = Table::open(bytes, file, NAMES, NAMES.len())?;
    while let Some(row) = table.next() {
        recorder.row();
        let line = row.line;
        let [time, source, rssi] =
            row.fields.each_ref().map(|field| field.as_deref().unwrap_or_default());
        if !row.is_whole || source.is_empty() {
            recorder.wrong(Anomaly::RowLength, line, table.incomplete(&row));
            continue;
        }
        let Some(when) = number(time).and_then(instant) else {
            recorder.wrong(Anomaly::NotANumber, line, table.wrong(0, time, "number of seconds"));
            continue;
        };
        let Some(strength) = number(rssi) else {
            recorder.wrong(Anomaly::NotANumber, line, table.wrong(2, rssi, "number"));
            continue;
        };
        let Some(rssi) = received(strength) else {
            recorder.anomaly(Anomaly::ImpossibleRssi, line);
            continue;
        };
        if recorder.clock_is_sound(&mut clock, when, line) {
            let link = recorder.link(source);
            recorder.sample(line, when, link, rssi, Some(MetresPerSecond::ZERO), None);
        }
    }
    Ok(recorder.finish())
}
