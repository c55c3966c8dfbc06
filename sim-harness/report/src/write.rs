//! Writes the files of a run.

use std::fmt;

use input::InputError;

use super::bag::{BAG, BagFile, Place};
use super::folder::{Folder, Streamed};
use super::pictures::{self, Picture, PictureError};
use super::{csv, mcap, report};
use mission::trace::{Frame, Trace};
use scenario::Scenario;

/// A run's files could not be written.
#[derive(Debug)]
pub enum OutputError {
    /// The directory cannot be used, which the user can correct.
    Input(InputError),
    /// A step that cannot fail has failed, which is a defect of the program.
    Picture(PictureError),
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::Picture(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for OutputError {}

impl From<InputError> for OutputError {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<PictureError> for OutputError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}

/// `trace.csv` and `trace.mcap` of a mission that is still flown: each frame goes to the disk, so
/// that a mission takes no more memory the longer it is.
pub struct TraceFiles {
    csv: csv::Table<Streamed>,
    mcap: mcap::TraceFile<Streamed>,
    bag: Option<BagFile<Streamed>>,
}

impl TraceFiles {
    /// Begins the files of a mission of which `trace` is the empty record.
    ///
    /// # Errors
    /// [`OutputError::Input`] if a file cannot be written.
    pub fn begin(folder: &Folder, trace: &Trace) -> Result<Self, OutputError> {
        let csv = csv::Table::new(folder.stream(CSV)?);
        let mcap = mcap::TraceFile::new(trace, folder.stream(MCAP)?);
        Ok(Self {
            csv: csv.map_err(|error| folder.unwritten(CSV, &error))?,
            mcap: mcap.map_err(|error| folder.unwritten(MCAP, &error.into()))?,
            bag: None,
        })
    }

    /// Writes a bag of ROS 2 as well, `bag.mcap` and `metadata.yaml`.
    ///
    /// # Errors
    /// As [`TraceFiles::begin`].
    pub fn with_bag(
        self,
        folder: &Folder,
        trace: &Trace,
        scenario: &Scenario,
    ) -> Result<Self, OutputError> {
        let bag = BagFile::new(trace, Place::of(scenario), folder.stream(BAG)?);
        Ok(Self { bag: Some(bag.map_err(|error| folder.unwritten(BAG, &error))?), ..self })
    }

    /// Writes one frame.
    ///
    /// # Errors
    /// As [`TraceFiles::begin`].
    pub fn frame(
        &mut self,
        folder: &Folder,
        trace: &Trace,
        frame: &Frame,
    ) -> Result<(), InputError> {
        let written = self.csv.frame(trace, frame);
        written.map_err(|error| folder.unwritten(CSV, &error))?;
        let written = self.mcap.frame(trace, frame);
        written.map_err(|error| folder.unwritten(MCAP, &error.into()))?;
        let written = self.bag.as_mut().map_or(Ok(()), |bag| bag.frame(trace, frame));
        written.map_err(|error| folder.unwritten(BAG, &error))
    }

    /// Writes `summary.json`, ends the streamed files, the bag among them, and writes the report and the
    /// pictures.
    ///
    /// # Errors
    /// As [`TraceFiles::begin`].
    pub fn finish(
        self,
        folder: &mut Folder,
        trace: &Trace,
        summary: &serde_json::Value,
    ) -> Result<(), OutputError> {
        folder.put_json("summary.json", summary)?;
        let csv = self.csv.finish().map_err(|error| folder.unwritten(CSV, &error))?;
        folder.keep(csv)?;
        let mcap = self.mcap.finish(trace);
        let mcap = mcap.map_err(|error| folder.unwritten(MCAP, &error.into()))?;
        folder.keep(mcap)?;
        if let Some(bag) = self.bag {
            let ended = bag.finish(trace).map_err(|error| folder.unwritten(BAG, &error))?;
            let (bag, metadata) = ended;
            folder.keep(bag)?;
            folder.put_text("metadata.yaml", &metadata)?;
        }
        write_report(folder, trace, summary)
    }
}

/// The names of the files with every frame.
const CSV: &str = "trace.csv";
const MCAP: &str = "trace.mcap";

/// Writes `report.html`, `map-moving.svg`, and as SVG and PNG `map` and the charts over time that the mission
/// [has](pictures::over_time).
///
/// # Errors
/// As [`TraceFiles::begin`].
pub fn write_report(
    folder: &mut Folder,
    trace: &Trace,
    summary: &serde_json::Value,
) -> Result<(), OutputError> {
    folder.put_text("report.html", &report::html(trace, summary)?)?;
    folder.put_text("map-moving.svg", &pictures::moving(trace)?)?;
    put_picture(folder, "map", &pictures::map(trace)?)?;
    for (name, picture) in pictures::over_time(trace)? {
        put_picture(folder, name, &picture)?;
    }
    Ok(())
}

/// Writes a picture as `name.svg` and `name.png`.
///
/// # Errors
/// As [`TraceFiles::begin`].
pub fn put_picture(folder: &mut Folder, name: &str, picture: &Picture) -> Result<(), OutputError> {
    let png = picture.png()?;
    folder.put_text(&format!("{name}.svg"), picture.svg())?;
    folder.put(&format!("{name}.png"), |out| std::io::Write::write_all(out, &png))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use serde_json::json;

    use super::*;
    use crate::folder::tests::Scratch;
    use crate::synthetic;

    fn mission(frames: usize) -> Trace {
        let mut trace = synthetic::mission();
        trace.frames.truncate(frames);
        trace
    }

    fn written(scratch: &Scratch, frames: usize) -> Vec<PathBuf> {
        let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
        let trace = mission(frames);
        let mut files = TraceFiles::begin(&folder, &trace).unwrap();
        trace.frames.iter().for_each(|frame| files.frame(&folder, &trace, frame).unwrap());
        files.finish(&mut folder, &trace, &json!({ "success": true })).unwrap();
        folder.finish().unwrap()
    }

    #[test]
    fn everything_is_written_and_nothing_else_is_left() {
        let scratch = Scratch::new("all");
        let mut written = written(&scratch, 400);
        let out = scratch.path().join("out");
        let mut found: Vec<_> =
            fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()).collect();
        written.sort();
        found.sort();
        assert_eq!(written, found);
        assert_eq!(written.len(), 12);
        assert!(fs::read(out.join("map.png")).unwrap().starts_with(b"\x89PNG"));
        let read: serde_json::Value =
            serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
        assert_eq!(read, json!({ "success": true }));
    }

    /// A swarm has neither a chain's links nor ways along a tunnel, and no picture of none.
    #[test]
    fn only_the_charts_that_a_mission_has_are_written() {
        let names = |trace: &Trace| -> Vec<&str> {
            pictures::over_time(trace).unwrap().iter().map(|(name, _)| *name).collect()
        };
        let mut trace = mission(400);
        assert_eq!(names(&trace), ["positions", "links"]);
        let scratch = Scratch::new("swarm");
        let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
        trace.mission = units::MissionKind::Swarm;
        write_report(&mut folder, &trace, &json!({})).unwrap();
        let written = folder.finish().unwrap();
        let mut files: Vec<_> = written.iter().filter_map(|path| path.file_name()).collect();
        files.sort();
        assert_eq!(files, ["files.txt", "map-moving.svg", "map.png", "map.svg", "report.html"]);
        trace.mission = units::MissionKind::Chain;
        for drone in trace.frames.iter_mut().flat_map(|frame| &mut frame.drones) {
            (drone.front, drone.back) = (None, None);
        }
        assert_eq!(names(&trace), ["positions"], "no drone ever heard another one");
    }

    /// What is not on the disk is in memory: no more than a buffer of each file waits there, however long
    /// the mission is.
    #[test]
    fn frames_go_to_the_disk_while_the_mission_is_flown() {
        const MOST_WAITING: u64 = 1 << 20;
        let scratch = Scratch::new("streamed");
        let out = scratch.path().join("out");
        let mut folder = Folder::open(&out).unwrap();
        let trace = mission(usize::MAX);
        let mut files = TraceFiles::begin(&folder, &trace).unwrap();
        // Several missions' frames are those of a long one.
        for frame in (0..8).flat_map(|_| &trace.frames) {
            files.frame(&folder, &trace, frame).unwrap();
        }
        let size = |path: PathBuf| fs::metadata(path).unwrap().len();
        let staging = scratch.path().join(".out.unfinished-results");
        let written = [CSV, MCAP].map(|name| size(staging.join(name)));
        files.finish(&mut folder, &trace, &json!({})).unwrap();
        folder.finish().unwrap();
        for (name, written) in [CSV, MCAP].into_iter().zip(written) {
            let whole = size(out.join(name));
            assert!(whole > 3 * MOST_WAITING, "{name}: {whole} bytes say nothing");
            assert!(written + MOST_WAITING > whole, "{name}: {written} of {whole} bytes");
        }
    }

    #[test]
    fn one_mission_makes_the_same_bytes_every_time() {
        let scratches = [Scratch::new("once"), Scratch::new("twice")];
        let all = scratches.each_ref().map(|scratch| written(scratch, 50));
        for (one, other) in all[0].iter().zip(&all[1]) {
            assert!(fs::read(one).unwrap() == fs::read(other).unwrap(), "{}", one.display());
        }
    }
}
