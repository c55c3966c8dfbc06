//! Parses a table of packets: a header, then one row per packet.
//!
//! `time_s`, `link` and `rssi_dbm` must be there; `velocity_mps` may be: the rate at which the two
//! ends separated since the link's previous row; so may `distance_m`, the distance between them. Other columns are ignored. The book's chapter
//! "Replay" defines all columns.

use std::path::Path;

use units::{Metres, MetresPerSecond};

use super::table::{Row, Table};
use super::{instant, number, received};
use crate::input_error::InputError;
use crate::replay::recording::{Anomaly, Clock, Ends, Recorder, Recording};

const NAMES: [&str; 5] = ["time_s", "link", "rssi_dbm", "velocity_mps", "distance_m"];
const REQUIRED: usize = 3;

/// Faster than any multirotor; a value beyond it is in another unit.
const FASTEST: f64 = 50.0;

pub(super) fn is_header(row: &str) -> bool {
    NAMES.iter().take(REQUIRED).all(|name| {
        row.split(',').any(|cell| {
            cell.trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\u{feff}')
                .eq_ignore_ascii_case(name)
        })
    })
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut clock = Clock::default();
    let rows: Vec<_> = Table::open(bytes, file, NAMES, REQUIRED)?.collect();
    let sign = if lacks_the_sign(&rows) {
        recorder.note("no RSSI in it is negative: 52 is taken for -52 dBm");
        -1.0
    } else {
        1.0
    };
    for row in rows {
        recorder.row();
        record(&mut recorder, &mut clock, row, sign);
    }
    Ok(recorder.finish())
}

/// Whether all strengths are written without their minus sign, as the vendor's client and the
/// authors' logs have them. A value that no link has, such as 0 or 127 for "none", says nothing.
fn lacks_the_sign(rows: &[Row<{ NAMES.len() }>]) -> bool {
    let strengths =
        rows.iter().filter_map(|Row { fields: [_, _, rssi, ..], .. }| number(rssi.as_deref()?));
    let (mut positive, mut negative) = (false, false);
    for strength in strengths {
        positive |= strength >= 1.0 && received(-strength).is_some();
        negative |= strength < 0.0;
    }
    positive && !negative
}

fn record(recorder: &mut Recorder, clock: &mut Clock, row: Row<{ NAMES.len() }>, sign: f64) {
    let Row { line, fields: [time, link, rssi, velocity, distance], whole } = row;
    let link = link.filter(|link| !link.is_empty());
    let (Some(time), Some(link), Some(rssi), true) = (time, link, rssi, whole) else {
        return recorder.anomaly(Anomaly::RowLength, line);
    };
    // A cell left empty is a speed that was not measured, not a wrong one.
    let optional = |cell: Option<String>| {
        cell.filter(|cell| !cell.is_empty()).map_or(Some(None), |cell| number(&cell).map(Some))
    };
    let (Some(time), Some(rssi), Some(speed), Some(distance)) =
        (number(&time).and_then(instant), number(&rssi), optional(velocity), optional(distance))
    else {
        return recorder.anomaly(Anomaly::NotANumber, line);
    };
    let Some(rssi) = received(sign * rssi) else {
        return recorder.anomaly(Anomaly::ImpossibleRssi, line);
    };
    if !recorder.clock_is_sound(clock, time, line) {
        return;
    }
    let separating = speed.filter(|speed| speed.abs() <= FASTEST);
    if separating != speed {
        recorder.anomaly(Anomaly::ImpossibleMotion, line);
    }
    let link = recorder.link(&link);
    let separating = separating.map(|v| MetresPerSecond(v as f32));
    let ends = distance.filter(|m| *m > 0.0).map(|m| Ends::apart(Metres(m as f32)));
    recorder.sample(line, time, link, rssi, separating, ends);
}
