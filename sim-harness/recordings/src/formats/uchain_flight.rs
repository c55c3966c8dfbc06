//! The U-Chain authors' own flights: `t,r0,r1,…,`, no header.
//!
//! A loss is a whole number of dB, the negative of the RSSI, already filtered on board; 0 means
//! that the link has never been heard. Link 0 joins the head and the first relay. A row ends where
//! the base had nothing fresh to write, so its length changes.

use units::Instant;

use super::{instant, lines, number, received};
use crate::recording::{Anomaly, Clock, Recorder, Recording};

/// The most links: those of a chain of the authors' 16 identities.
const MOST_LINKS: usize = 15;

pub(super) fn is_row(row: &str) -> bool {
    Row::read(row).is_ok()
}

struct Row {
    time: Instant,
    /// The losses, from the head on; 0 is a link that has never been heard.
    losses: Vec<i32>,
}

impl Row {
    fn read(row: &str) -> Result<Self, Anomaly> {
        // A row may end in the authors' trailing comma.
        let row = row.trim_end().strip_suffix(',').unwrap_or(row);
        let mut fields = row.split(',').take(MOST_LINKS + 2);
        let time = fields.next().and_then(number).and_then(instant);
        let time = time.ok_or(Anomaly::NotANumber)?;
        let losses: Vec<i32> = fields
            .map(|field| field.trim().parse().map_err(|_| Anomaly::NotANumber))
            .collect::<Result<_, _>>()?;
        match losses.len() {
            1..=MOST_LINKS => Ok(Self { time, losses }),
            _ => Err(Anomaly::RowLength),
        }
    }
}

pub(super) fn parse(bytes: &[u8]) -> Recording {
    let mut recorder = Recorder::default();
    let mut clock = Clock::default();
    // The chain is as long as the longest row: known only at the end.
    let mut lengths = Vec::new();
    for (line, row) in lines(bytes) {
        recorder.row();
        match Row::read(&row) {
            Ok(row) => {
                if recorder.clock_is_sound(&mut clock, row.time, line) {
                    lengths.push((line, row.losses.len()));
                    record(&mut recorder, line, &row);
                }
            }
            Err(anomaly) => recorder.anomaly(anomaly, line),
        }
    }
    let longest = lengths.iter().map(|(_, length)| *length).max().unwrap_or(0);
    for (line, _) in lengths.into_iter().filter(|(_, length)| *length < longest) {
        recorder.anomaly(Anomaly::MissingLink, line);
    }
    recorder.finish()
}

fn record(recorder: &mut Recorder, line: usize, row: &Row) {
    for (index, loss) in row.losses.iter().enumerate() {
        let link = recorder.link(&format!("r{index}"));
        if *loss == 0 {
            continue;
        }
        match received(-f64::from(*loss)) {
            Some(rssi) => recorder.sample(line, row.time, link, rssi, None, None),
            None => recorder.anomaly(Anomaly::ImpossibleRssi, line),
        }
    }
}
