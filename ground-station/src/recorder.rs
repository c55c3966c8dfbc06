//! Records what the station hears and orders, in two files that are written by a thread of their
//! own: a slow disk delays no order.
//!
//! `packets.csv` has a row for each report of a drone that has a link towards the base; `uchain
//! replay` reads it. `station.mcap` has everything, as JSON messages. Each range survey has a table of
//! its own, `survey-1.csv` and so on. The first two are flushed twice a second, and the system is
//! asked to put them onto the disk (`fsync`): they are readable up to there when the station is
//! killed, and also when the machine loses its power.

mod durable;
mod mcap;
mod packets;
mod survey;

use std::io::{self, BufWriter};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use units::NodeId;

use self::durable::{DiskFolder, DurableFile, DurableFolder};
use crate::message::{Event, Record};
use crate::range_survey::Sample;

/// The time between two flushes, half of the second that a recording may lose.
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
        let mut files = Files::begin(DiskFolder::make(folder)?)?;
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
struct Files<F: DurableFolder> {
    packets: packets::Packets<BufWriter<F::File>>,
    mcap: mcap::Recording<BufWriter<F::File>>,
    /// The two files once more, to have them put onto the disk.
    files: [F::File; 2],
    folder: F,
    /// The number of range surveys that were written.
    surveys: usize,
}

impl<F: DurableFolder> Files<F> {
    fn begin(folder: F) -> io::Result<Self> {
        let (packets, mcap) = (folder.create("packets.csv")?, folder.create("station.mcap")?);
        let files = [packets.again()?, mcap.again()?];
        let packets = packets::Packets::new(BufWriter::new(packets))?;
        let mcap = mcap::Recording::new(BufWriter::new(mcap))?;
        folder.sync()?;
        Ok(Self { packets, mcap, files, folder, surveys: 0 })
    }

    fn write(&mut self, record: Record) -> io::Result<()> {
        self.packets.write(&record)?;
        self.mcap.write(record);
        Ok(())
    }

    /// Writes what was recorded so far, and returns when a power cut would leave it.
    fn flush(&mut self) -> io::Result<()> {
        self.packets.flush()?;
        self.mcap.flush()?;
        self.files.iter().try_for_each(DurableFile::sync)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.packets.flush()?;
        self.mcap.finish()?;
        self.files.iter().try_for_each(DurableFile::sync)
    }

    fn write_survey(&mut self, node: NodeId, samples: &[Sample]) -> io::Result<()> {
        self.surveys += 1;
        let file = self.folder.create(&format!("survey-{}.csv", self.surveys))?;
        survey::write(file, node, samples)?;
        self.folder.sync()
    }

    fn write_all(&mut self, records: &Receiver<Record>) -> io::Result<()> {
        let mut flushed = Instant::now();
        loop {
            match records.recv_timeout(FLUSH.saturating_sub(flushed.elapsed())) {
                Ok(record) => {
                    if let Event::Survey(node, samples) = &record.event {
                        self.write_survey(*node, samples)?;
                    }
                    self.write(record)?;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.finish(),
            }
            if flushed.elapsed() >= FLUSH {
                flushed = Instant::now();
                self.flush()?;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ::mcap::MessageStream;
    use ::mcap::read::Options;

    use super::durable::tests::PowerCutFolder;
    use super::*;
    use crate::blocks::DroneReport;

    fn notice(n: u64) -> Record {
        Record { at: Duration::from_millis(n), event: Event::Notice(format!("line {n}")) }
    }

    fn report(n: u64) -> Record {
        let report = DroneReport {
            state: 4,
            fault: 0,
            age: units::Duration::ZERO,
            battery: None,
            endurance: None,
            back: Some((NodeId(3), units::Dbm(-61.5))),
            odometer: units::Metres(12.5),
        };
        Record { at: Duration::from_millis(n), event: Event::Drone(NodeId(1), report) }
    }

    fn messages(bytes: &[u8]) -> usize {
        let options = Options::IgnoreEndMagic;
        let stream = MessageStream::new_with_options(bytes, options.into()).unwrap();
        stream.map_while(Result::ok).count()
    }

    #[test]
    fn a_power_cut_leaves_what_was_flushed() {
        let folder = PowerCutFolder::default();
        let rows = || folder.after_power_cut("packets.csv").unwrap();
        let messages = || messages(&folder.after_power_cut("station.mcap").unwrap());
        let mut files = Files::begin(folder.clone()).unwrap();
        for n in 0..1_000 {
            files.write(report(n)).unwrap();
            files.write(notice(n)).unwrap();
        }
        files.flush().unwrap();
        files.write(report(1_000)).unwrap();
        assert_eq!(String::from_utf8(rows()).unwrap().lines().count(), 1 + 1_000);
        assert_eq!(messages(), 2_000);
        files.finish().unwrap();
        assert_eq!(messages(), 2_001);
        assert_eq!(String::from_utf8(rows()).unwrap().lines().count(), 1 + 1_001);
    }

    #[test]
    fn a_power_cut_leaves_a_range_survey() {
        let folder = PowerCutFolder::default();
        let mut files = Files::begin(folder.clone()).unwrap();
        let at = units::Instant::from_millis(1_500);
        let sample = Sample { at, place_m: 4.0, rssi: units::Dbm(-61.5) };
        files.write_survey(NodeId(2), &[sample; 3]).unwrap();
        let rows = String::from_utf8(folder.after_power_cut("survey-1.csv").unwrap()).unwrap();
        assert_eq!(rows.lines().count(), 1 + 3, "{rows}");
        assert!(rows.contains("1.500,"), "{rows}");
    }

    /// The recorder's own thread flushes without being told to.
    #[test]
    fn a_recording_that_goes_on_reaches_the_disk() {
        let folder = PowerCutFolder::default();
        let mut files = Files::begin(folder.clone()).unwrap();
        let (records, received) = mpsc::channel();
        let writer = thread::spawn(move || files.write_all(&received));
        records.send(notice(1)).unwrap();
        while messages(&folder.after_power_cut("station.mcap").unwrap()) < 1 {
            thread::sleep(Duration::from_millis(10));
        }
        drop(records);
        writer.join().unwrap().unwrap();
    }
}
