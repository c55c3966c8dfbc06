//! Parses the `trace.csv` of a run: one row for each drone and 0.2 s.
//!
//! A row has up to two packets, one from the neighbour in front and one from the neighbour behind.
//! A link is named after the drone that received and the drone that sent: `1 from 0`. How fast the
//! two separate follows from the true places of both. The record holds the last packet of each
//! neighbour: a packet that was lost on the way repeats the one before it.

use std::path::Path;

use input::InputError;
use units::Instant;

use super::table::{Header, Row, Table};
use super::{Position, distance, instant, received};
use crate::recording::{Anomaly, Clock, Ends, RadialSpeed, Recorder, Recording, Wrong};

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

pub(super) fn is_header(header: &Header) -> bool {
    header.named(&NAMES) == NAMES.len()
}

/// A row of the table.
type TraceRow = Row<{ NAMES.len() }>;
type TraceTable<'a> = Table<'a, { NAMES.len() }>;

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
    let mut table = Table::open(bytes, file, NAMES, NAMES.len())?;
    table.remark(&mut recorder);
    while let Some(row) = table.next() {
        recorder.row();
        match read(&row, &table) {
            Ok(drone) => drones.push(drone),
            Err((anomaly, wrong)) => recorder.wrong(anomaly, row.line, wrong),
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

fn read(row: &TraceRow, table: &TraceTable<'_>) -> Result<DroneRow, (Anomaly, Wrong)> {
    if !row.is_whole {
        return Err((Anomaly::RowLength, table.incomplete(row)));
    }
    let text = |field: usize| row.fields[field].as_deref().unwrap_or_default();
    let wrong = |field, should| (Anomaly::NotANumber, table.wrong(field, text(field), should));
    let figure = |field| table.number(text(field)).ok_or_else(|| wrong(field, "number"));
    let node = |field| text(field).parse().map_err(|_| wrong(field, "number of a drone"));
    // There is no packet where both fields are empty.
    let packet = |peer: usize| -> Result<Option<(u8, f64)>, (Anomaly, Wrong)> {
        if text(peer).is_empty() && text(peer + 1).is_empty() {
            return Ok(None);
        }
        Ok(Some((node(peer)?, figure(peer + 1)?)))
    };
    Ok(DroneRow {
        line: row.line,
        time: instant(figure(0)?).ok_or_else(|| wrong(0, "number of seconds"))?,
        node: node(1)?,
        position: [figure(2)?, figure(3)?, figure(4)?],
        heard: [packet(5)?, packet(7)?].into_iter().flatten().collect(),
    })
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
