//! Records what the station hears and orders, in two files that are written by a thread of their
//! own: a slow disk delays no order.
//!
//! `packets.csv` has a row for each report of a drone that has a link towards the base; `uchain
//! replay` reads it. `station.mcap` has everything, as JSON messages. Each range survey has a table of
//! its own, `survey-1.csv` and so on. The first two are flushed at least once
//! a second, and are readable up to there when the station is killed.

mod mcap;
mod packets;
mod survey;

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use units::NodeId;

use crate::message::{Event, Record};
use crate::range_survey::Sample;

/// The time between two flushes, half of the second that a killed station may lose.
const FLUSH: Duration = Duration::from_millis(500);

/// A recorder; its thread ends when the recorder is dropped.
#[derive(Debug)]
pub struct Recorder {
    records: Option<Sender<Record>>,
    writer: Option<JoinHandle<io::Result<()>>>,
}

impl Recorder {
    /// Creates the folder and its two files.
    ///
    /// # Errors
    /// If they cannot be created.
    pub fn create(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let create = |name: &str| File::create_new(folder.join(name)).map(BufWriter::new);
        let mut files = Files {
            packets: packets::Packets::new(create("packets.csv")?)?,
            mcap: mcap::Recording::new(create("station.mcap")?)?,
            folder: folder.to_owned(),
            surveys: 0,
        };
        let (records, received) = mpsc::channel();
        let writer = thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || files.write_all(&received))?;
        Ok(Self { records: Some(records), writer: Some(writer) })
    }

    /// Records an event. Returns whether the recorder still runs: its disk may be full.
    pub fn record(&self, record: Record) -> bool {
        self.records.as_ref().is_some_and(|records| records.send(record).is_ok())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.records = None;
        if let Some(Ok(Err(error))) = self.writer.take().map(JoinHandle::join) {
            eprintln!("uchain-ground: the recording is not complete: {error}");
        }
    }
}

/// The two files, and the folder for those of range surveys.
struct Files {
    packets: packets::Packets<BufWriter<File>>,
    mcap: mcap::Recording<BufWriter<File>>,
    folder: PathBuf,
    /// The number of range surveys that were written.
    surveys: usize,
}

impl Files {
    fn write_survey(&mut self, node: NodeId, samples: &[Sample]) -> io::Result<()> {
        self.surveys += 1;
        let name = format!("survey-{}.csv", self.surveys);
        survey::write(File::create_new(self.folder.join(name))?, node, samples)
    }

    fn write_all(&mut self, records: &Receiver<Record>) -> io::Result<()> {
        let mut flushed = Instant::now();
        loop {
            match records.recv_timeout(FLUSH.saturating_sub(flushed.elapsed())) {
                Ok(record) => {
                    if let Event::Survey(node, samples) = &record.event {
                        self.write_survey(*node, samples)?;
                    }
                    self.packets.write(&record)?;
                    self.mcap.write(record);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    self.packets.flush()?;
                    return self.mcap.finish();
                }
            }
            if flushed.elapsed() >= FLUSH {
                self.packets.flush()?;
                self.mcap.flush()?;
                flushed = Instant::now();
            }
        }
    }
}
