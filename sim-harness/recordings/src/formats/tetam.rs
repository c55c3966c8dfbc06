//! The position-annotated BLE tracks of the TETAM set: a beacon is carried past twelve receivers,
//! and every packet tells where the beacon was.
//!
//! `unix_s,receiver,beacon,rssi,x,y,z,` and nine elements of a rotation, no header. The receivers'
//! positions are in `../cnf/tetam.dev`, as the data set lays its folders out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use input::InputError;
use units::{Instant, MetresPerSecond};

use super::{Position, distance, instant, lines, number, read_companion, received};
use crate::recording::{Anomaly, Clock, Ends, RadialSpeed, Recorder, Recording};

const FIELDS: usize = 16;

/// The beacon is carried by a walker; nothing in the set reaches half of this.
const FASTEST: MetresPerSecond = MetresPerSecond(5.0);

/// The position of each receiver, by its address.
pub(super) type Receivers = BTreeMap<String, Position>;

pub(super) fn is_row(row: &str) -> bool {
    Row::read(row).is_ok()
}

struct Row<'a> {
    time: Instant,
    receiver: &'a str,
    rssi: f64,
    beacon: Position,
}

impl<'a> Row<'a> {
    fn read(row: &'a str) -> Result<Self, Anomaly> {
        let fields: Vec<&str> = row.split(',').map(str::trim).take(FIELDS + 1).collect();
        let [time, receiver, _, rssi, x, y, z, ..] = fields.as_slice() else {
            return Err(Anomaly::RowLength);
        };
        if fields.len() != FIELDS {
            return Err(Anomaly::RowLength);
        }
        let read = || {
            Some(Self {
                time: instant(number(time)?)?,
                receiver: *receiver,
                rssi: number(rssi)?,
                beacon: [number(x)?, number(y)?, number(z)?],
            })
        };
        read().ok_or(Anomaly::NotANumber)
    }
}

pub(super) fn parse(bytes: &[u8], receivers: &Receivers) -> Recording {
    let mut recorder = Recorder::default();
    let mut clock = Clock::default();
    let mut speeds: BTreeMap<usize, RadialSpeed> = BTreeMap::new();
    for (line, row) in lines(bytes) {
        recorder.row();
        let row = match Row::read(&row) {
            Ok(row) => row,
            Err(anomaly) => {
                recorder.anomaly(anomaly, line);
                continue;
            }
        };
        let Some(rssi) = received(row.rssi) else {
            recorder.anomaly(Anomaly::ImpossibleRssi, line);
            continue;
        };
        if !recorder.clock_is_sound(&mut clock, row.time, line) {
            continue;
        }
        let link = recorder.link(row.receiver);
        let position = receivers.get(row.receiver);
        if position.is_none() {
            recorder.anomaly(Anomaly::UnknownReceiver, line);
        }
        let ends = position
            .map(|position| Ends { distance: distance(position, &row.beacon), moving: row.beacon });
        let speed = ends.map(|ends| speeds.entry(link).or_default().at(row.time, ends.distance));
        let separating = speed.filter(|speed| speed.abs() <= FASTEST);
        if separating != speed {
            recorder.anomaly(Anomaly::ImpossibleMotion, line);
        }
        recorder.sample(line, row.time, link, rssi, separating, ends);
    }
    recorder.finish()
}

/// Reads the file of receivers that belongs to a track.
pub(super) fn receivers_of(track: &Path) -> Result<Receivers, InputError> {
    let devices = devices_of(track);
    let bytes = read_companion(&devices, "the data set keeps it there, beside the tracks' folder")?;
    let receivers = receivers(&bytes);
    if receivers.is_empty() {
        return Err(InputError::new(
            "has no receiver with a position",
            "give the data set's cnf/tetam.dev, with its line of \"Dongles\"",
        )
        .in_file(&devices));
    }
    Ok(receivers)
}

fn devices_of(track: &Path) -> PathBuf {
    let folder = track.parent().unwrap_or_else(|| Path::new(""));
    folder.join("..").join("cnf").join("tetam.dev")
}

/// The `Dongles:` line is a JSON object of `address: [[x, y, z], colour, alias]`. Entries without
/// a position are left out.
fn receivers(bytes: &[u8]) -> Receivers {
    type Device = (Vec<f64>, serde_json::Value, serde_json::Value);
    let dongles = lines(bytes).find_map(|(_, line)| {
        serde_json::from_str::<BTreeMap<String, Device>>(line.strip_prefix("Dongles:")?).ok()
    });
    dongles
        .unwrap_or_default()
        .into_iter()
        .filter_map(|(address, (position, _, _))| Some((address, position.try_into().ok()?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn receivers_are_read_and_those_without_a_position_left_out() {
        let text = br#"Dongles:{"aa": [[7.00, 7.09, 1.22], 16711680, "s1"], "bb": [[], 1, "s2"] }
Beacons:{"cc": [[], 1328790, "beacon1"] }"#;
        let read = receivers(text);
        assert_eq!(read.keys().collect::<Vec<_>>(), ["aa"]);
        assert_eq!(read["aa"], [7.0, 7.09, 1.22]);
        assert!(receivers(b"Dongles:{").is_empty());
    }
}
