//! Reads the `trace.mcap` of a run, or the `station.mcap` of the ground station.
//!
//! In a trace, the topics `/drone/N/state` hold a drone's place, `/drone/N/link/front` and `…/back`
//! its last packets from its neighbours. A station's `/drone/N/report` holds the strength of a
//! drone's link towards the base. Messages of other topics and of other schemas are passed over. What
//! the table `trace.csv` calls a line is here the number of the message.

use std::collections::BTreeMap;
use std::path::Path;

use input::InputError;
use prost::Message;
use units::Instant;

use super::trace::{DroneRow, of_rows};
use crate::mcap_file;
use crate::messages::{DroneState, Link};
use crate::recording::{Anomaly, Recorder, Recording};
use station_log::DroneReport;

/// What a topic is about.
#[derive(Clone, Copy)]
enum About {
    State,
    Link,
    Report,
}

/// The drone and the kind of a topic's messages.
fn about(topic: &str) -> Option<(u8, About)> {
    let (node, rest) = topic.strip_prefix("/drone/")?.split_once('/')?;
    let about = match rest {
        "state" => About::State,
        "link/front" | "link/back" => About::Link,
        "report" => About::Report,
        _ => return None,
    };
    Some((node.parse().ok()?, about))
}

/// Reads the packets of a `trace.mcap` or a `station.mcap`.
///
/// # Errors
/// [`InputError`] where no message of it is of a drone.
pub fn parse(bytes: &[u8], file: &Path) -> Result<Recording, InputError> {
    let mut recorder = Recorder::default();
    let mut rows: BTreeMap<(u64, u8), DroneRow> = BTreeMap::new();
    let mut line = 0;
    let findings = mcap_file::read(bytes, &mut |message| {
        line += 1;
        let Some((node, about)) = about(message.topic) else { return };
        let micros = message.time_ns / 1000;
        let row = rows.entry((micros, node)).or_insert_with(|| DroneRow {
            line,
            time: Instant::from_micros(micros),
            node,
            position: [f64::NAN; 3],
            heard: Vec::new(),
        });
        if take(row, about, message.data).is_none() {
            recorder.anomaly(Anomaly::NotANumber, line);
        }
    });
    if rows.is_empty() {
        return Err(nothing_read(&findings).in_file(file));
    }
    for remark in findings.remarks() {
        recorder.note(remark);
    }
    for _ in 0..rows.len() {
        recorder.row();
    }
    // Rows without a place belong to a drone that was not simulated: their packets count.
    Ok(of_rows(recorder, &rows.into_values().collect::<Vec<_>>()))
}

/// The error for a file without any message that is read.
fn nothing_read(findings: &mcap_file::Findings) -> InputError {
    match &findings.damage {
        Some(damage) => {
            let wrong = format!("{damage}, and nothing before that is of a drone");
            InputError::new(wrong, "give another copy of it")
        }
        None => {
            let wrong = format!("none of its {} messages is of a drone", findings.messages);
            let remedy = "give the trace.mcap of a run, or the station.mcap of the ground station";
            InputError::new(wrong, remedy)
        }
    }
}

fn take(row: &mut DroneRow, about: About, data: &[u8]) -> Option<()> {
    match about {
        About::State => {
            let state = DroneState::decode(data).ok()?;
            let position = [state.x_m, state.y_m, state.z_m].map(f64::from);
            row.position = position.iter().all(|m| m.is_finite()).then_some(position)?;
        }
        About::Link => {
            let link = Link::decode(data).ok()?;
            row.heard.push((u8::try_from(link.peer).ok()?, f64::from(link.raw_dbm)));
        }
        About::Report => {
            let report: DroneReport = serde_json::from_slice(data).ok()?;
            row.heard.extend(report.back.zip(report.rssi_dbm.map(f64::from)));
        }
    }
    Some(())
}
