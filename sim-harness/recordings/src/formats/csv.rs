//! Parses a table of packets: a header, then one row per packet.
//!
//! `time_s`, `link` and `rssi_dbm` must be there; `velocity_mps` may be: the rate at which the two
//! ends separated since the link's previous row; so may `distance_m`, the distance between them.
//! Other columns are ignored. The book's chapter "Replay" defines all columns.

mod times;

use std::path::Path;

use input::InputError;
use units::{Metres, MetresPerSecond};

use super::received;
use super::table::{Header, Row, Table};
use crate::recording::{Anomaly, Clock, Ends, Recorder, Recording};
use times::Times;

const NAMES: [&str; 5] = ["time_s", "link", "rssi_dbm", "velocity_mps", "distance_m"];
const REQUIRED: usize = 3;

/// Faster than any multirotor; a value beyond it is in another unit.
const FASTEST: f64 = 50.0;

/// A row of the table.
type PacketRow = Row<{ NAMES.len() }>;

/// Whether the first row of a table names the columns that must be there.
pub(super) fn is_header(header: &Header) -> bool {
    header.named(&NAMES[..REQUIRED]) == REQUIRED
}

/// Whether the first row of a table names a column that no other format has: a table of packets that
/// lacks another one.
pub(super) fn is_incomplete_header(header: &Header) -> bool {
    header.named(&["time_s", "rssi_dbm"]) > 0
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut table = Table::open(bytes, file, NAMES, REQUIRED)?;
    let rows: Vec<PacketRow> = table.by_ref().collect();
    table.remark(&mut recorder);
    let times = Times::of(rows.iter().filter_map(|row| row.fields[0].as_deref()), &table);
    if let Some(remark) = times.remark() {
        recorder.note(remark);
    }
    let sign = if lacks_the_sign(&rows, &table) {
        recorder.note("no RSSI in it is negative: 52 is taken for -52 dBm");
        -1.0
    } else {
        1.0
    };
    let mut reader = Reader { table, times, sign, recorder, clock: Clock::default() };
    for row in rows {
        reader.recorder.row();
        reader.row(row);
    }
    Ok(reader.recorder.finish())
}

/// Whether all strengths are written without their minus sign, as the vendor's client and the
/// authors' logs have them. A value that no link has, such as 0 or 127 for "none", says nothing.
fn lacks_the_sign(rows: &[PacketRow], table: &Table<'_, { NAMES.len() }>) -> bool {
    let strengths = rows
        .iter()
        .filter_map(|Row { fields: [_, _, rssi, ..], .. }| table.number(rssi.as_deref()?));
    let (mut positive, mut negative) = (false, false);
    for strength in strengths {
        positive |= strength >= 1.0 && received(-strength).is_some();
        negative |= strength < 0.0;
    }
    positive && !negative
}

/// Reads the rows, one after the other.
struct Reader<'a> {
    table: Table<'a, { NAMES.len() }>,
    times: Times,
    sign: f64,
    recorder: Recorder,
    clock: Clock,
}

impl Reader<'_> {
    fn row(&mut self, row: PacketRow) {
        let line = row.line;
        let [time, link, rssi, velocity, distance] = &row.fields;
        let required = [time, link, rssi].map(|field| field.as_deref().unwrap_or_default());
        if !row.is_whole || required.contains(&"") {
            let wrong = self.table.incomplete(&row);
            return self.recorder.wrong(Anomaly::RowLength, line, wrong);
        }
        let [time_text, link, rssi] = required;
        let Some(time) = self.times.instant(time_text, &self.table) else {
            let wrong = self.table.wrong(0, time_text, self.times.wanted());
            return self.recorder.wrong(Anomaly::NotANumber, line, wrong);
        };
        // A cell left empty is a speed that was not measured, not a wrong one.
        let read = |text: &Option<String>| {
            let text = text.as_deref().unwrap_or_default();
            if text.is_empty() { Some(None) } else { self.table.number(text).map(Some) }
        };
        let (Some(Some(rssi)), Some(speed), Some(distance)) =
            (read(&row.fields[2]), read(velocity), read(distance))
        else {
            let field = (2..NAMES.len()).find(|&n| read(&row.fields[n]).is_none()).unwrap_or(2);
            let text = row.fields[field].as_deref().unwrap_or(rssi);
            let wrong = self.table.wrong(field, text, "number");
            return self.recorder.wrong(Anomaly::NotANumber, line, wrong);
        };
        let Some(rssi) = received(self.sign * rssi) else {
            return self.recorder.anomaly(Anomaly::ImpossibleRssi, line);
        };
        if !self.recorder.clock_is_sound(&mut self.clock, time, line) {
            return;
        }
        let separating = speed.filter(|speed| speed.abs() <= FASTEST);
        if separating != speed {
            self.recorder.anomaly(Anomaly::ImpossibleMotion, line);
        }
        let link = self.recorder.link(link);
        let separating = separating.map(|v| MetresPerSecond(v as f32));
        let ends = distance.filter(|m| *m > 0.0).map(|m| Ends::apart(Metres(m as f32)));
        self.recorder.sample(line, time, link, rssi, separating, ends);
    }
}

#[cfg(test)]
mod tests;
