//! Parses the `trace.csv` of a run: one row for each drone and 0.2 s.
//!
//! A row has up to two packets, one from the neighbour in front and one from the neighbour behind.
//! A link is named after the drone that received and the drone that sent: `1 from 0`. How fast the
//! two separate follows from the true places of both. The record holds the last packet of each
//! neighbour: a packet that was lost on the way repeats the one before it.

use std::path::Path;

use units::Instant;

use super::table::{Row, Table};
use super::{Position, distance, instant, number, received};
use crate::input_error::InputError;
use crate::replay::recording::{Anomaly, Clock, Ends, RadialSpeed, Recorder, Recording};

const NAMES: [&str; 9] = [
    "time_s",
    "node",
    "x_m",
    "y_m",
    "z_m",
    "front_peer",
    "front_raw_dbm",
    "back_peer",
    "back_raw_dbm",
];

pub(super) fn is_header(row: &str) -> bool {
    let row = row.trim_start_matches('\u{feff}');
    NAMES.iter().all(|name| row.split(',').any(|cell| cell.trim() == *name))
}

/// The contents of a row.
pub(super) struct DroneRow {
    pub(super) line: usize,
    pub(super) time: Instant,
    pub(super) node: u8,
    /// Not numbers where the place is not known.
    pub(super) position: Position,
    /// Each neighbour's number, and the strength of the packet from it.
    pub(super) heard: Vec<(u8, f64)>,
}

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut drones: Vec<DroneRow> = Vec::new();
    for row in Table::open(bytes, file, NAMES, NAMES.len())? {
        recorder.row();
        let line = row.line;
        match read(row) {
            Ok(drone) => drones.push(drone),
            Err(anomaly) => recorder.anomaly(anomaly, line),
        }
    }
    Ok(of_rows(recorder, &drones))
}

/// The recording of rows in order of time.
pub(super) fn of_rows(mut recorder: Recorder, drones: &[DroneRow]) -> Recording {
    let mut clock = Clock::default();
    let mut speeds: Vec<RadialSpeed> = Vec::new();
    for frame in drones.chunk_by(|one, other| one.time == other.time) {
        let Some(first) = frame.first() else { continue };
        if recorder.clock_is_sound(&mut clock, first.time, first.line) {
            record(&mut recorder, &mut speeds, frame);
        }
    }
    recorder.finish()
}

fn read(row: Row<{ NAMES.len() }>) -> Result<DroneRow, Anomaly> {
    let Row { line, fields: [time, node, x, y, z, front, front_raw, back, back_raw], whole } = row;
    if !whole {
        return Err(Anomaly::RowLength);
    }
    let time = instant(figure(time)?).ok_or(Anomaly::NotANumber)?;
    let heard = [packet(front, front_raw)?, packet(back, back_raw)?];
    Ok(DroneRow {
        line,
        time,
        node: node_of(&node.ok_or(Anomaly::RowLength)?)?,
        position: [figure(x)?, figure(y)?, figure(z)?],
        heard: heard.into_iter().flatten().collect(),
    })
}

fn figure(field: Option<String>) -> Result<f64, Anomaly> {
    number(&field.ok_or(Anomaly::RowLength)?).ok_or(Anomaly::NotANumber)
}

fn node_of(field: &str) -> Result<u8, Anomaly> {
    field.parse().map_err(|_| Anomaly::NotANumber)
}

/// The packet from a neighbour; none where both fields are empty.
fn packet(peer: Option<String>, raw: Option<String>) -> Result<Option<(u8, f64)>, Anomaly> {
    let (peer, raw) = (peer.unwrap_or_default(), raw.unwrap_or_default());
    if peer.is_empty() && raw.is_empty() {
        return Ok(None);
    }
    Ok(Some((node_of(&peer)?, figure(Some(raw))?)))
}

fn record(recorder: &mut Recorder, speeds: &mut Vec<RadialSpeed>, frame: &[DroneRow]) {
    for drone in frame {
        for &(peer, raw) in &drone.heard {
            let Some(rssi) = received(raw) else {
                recorder.anomaly(Anomaly::ImpossibleRssi, drone.line);
                continue;
            };
            let link = recorder.link(&format!("{} from {peer}", drone.node));
            if speeds.len() <= link {
                speeds.resize(link + 1, RadialSpeed::default());
            }
            let sender = frame.iter().find(|other| other.node == peer);
            let ends = sender
                .map(|sender| Ends {
                    distance: distance(&drone.position, &sender.position),
                    moving: drone.position,
                })
                .filter(|ends| ends.distance.0.is_finite());
            let separating = ends
                .zip(speeds.get_mut(link))
                .map(|(ends, speed)| speed.at(drone.time, ends.distance));
            recorder.sample(drone.line, drone.time, link, rssi, separating, ends);
        }
    }
}

#[cfg(test)]
mod tests {
    use units::MetresPerSecond;

    use super::*;

    const HEADER: &str =
        "time_s,node,role,x_m,y_m,z_m,front_peer,front_raw_dbm,back_peer,back_raw_dbm\n";

    fn parsed(rows: &str) -> Recording {
        parse(format!("{HEADER}{rows}").as_bytes(), Path::new("trace.csv")).unwrap()
    }

    #[test]
    fn each_drone_gives_a_packet_of_each_neighbour_and_the_speed_between_them() {
        let recording = parsed(
            "0.2,0,head,3.0,0.0,0.4,,,1,-50.0\n0.2,1,base,0.0,0.0,0.4,0,-51.0,,\n\
             0.4,0,head,3.1,0.0,0.4,,,1,-52.0\n0.4,1,base,0.0,0.0,0.4,0,-53.0,,\n",
        );
        assert_eq!(recording.links, ["0 from 1", "1 from 0"]);
        let samples: Vec<_> = recording.samples.iter().map(|s| (s.link, s.rssi.0)).collect();
        assert_eq!(samples, [(0, -50.0), (1, -51.0), (0, -52.0), (1, -53.0)]);
        let speed = recording.samples[3].separating.unwrap_or(MetresPerSecond::ZERO).0;
        assert!((speed - 0.5).abs() < 1e-4, "{speed}");
    }

    #[test]
    fn a_row_that_is_wrong_is_counted_and_no_other_is() {
        let recording =
            parsed("0.2,0,head,3.0\n0.2,0,head,3.0,0.0,0.4,1,,,\n0.4,1,base,0,0,0,0,-51.0,,\n");
        assert_eq!(recording.anomalies.of(Anomaly::RowLength), [2]);
        assert_eq!(recording.anomalies.of(Anomaly::NotANumber), [3]);
        assert_eq!(recording.samples.len(), 1);
        assert_eq!(recording.samples[0].separating, None, "the sender is not in the frame");
    }
}
