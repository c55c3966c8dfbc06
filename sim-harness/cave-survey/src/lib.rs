//! Reads surveys of caves, and gives their stations positions.
//!
//! A cave is surveyed in *legs*, from one *station* to the next, each with a length, a bearing and a
//! slope. A *splay* is a leg to the wall. *Passage dimensions* are the distances from a station to
//! the walls left and right, the ceiling and the floor. Where legs form a *loop*, their errors show
//! as its *misclosure*, which is distributed over them by least squares.
//!
//! | files | are read by |
//! |---|---|
//! | Survex's `.svx` | `survex` |
//! | Survex's processed `.3d` | `three_d` |
//! | Compass's `.dat` and `.mak` | `compass` |
//! | Walls's `.srv` and `.wpj` | `walls` |
//! | Therion's `.th` and `thconfig` | `therion` |
//! | VisualTopo's `.tro` | `visual_topo` |
//! | PocketTopo's text | `pocket_topo` |
//!
//! [`read`] opens a file of a [`Files`] and all that it includes, and returns a [`Survey`], or a
//! [`Refusal`] that names file, line and remedy. No bytes make it panic, and what it takes is bounded.
//!
//! ```
//! use cave_survey::{Memory, read};
//!
//! let cave = "1 2 10 0 0\n2 3 10 120 0\n3 1 10.3 240 0\n";
//! let survey = read(&Memory::default().with("cave.svx", cave), "cave.svx")?;
//! let summary = survey.summary();
//! assert_eq!((summary.legs, summary.stations, summary.loops), (3, 3, 1));
//! assert!((summary.misclosure_m - 0.3).abs() < 1e-9);
//! # Ok::<(), cave_survey::Refusal>(())
//! ```

mod adjust;
mod compass;
mod draft;
mod earth;
mod elimination;
mod error;
mod files;
mod formats;
mod loops;
mod matrix;
mod merge;
mod parts;
mod pocket_topo;
mod sets;
mod survex;
mod survey;
mod therion;
mod three_d;
mod traverse;
mod visual_topo;
mod walls;

use formats::Format;

pub use draft::MOST_LEGS;
pub use error::{Place, Refusal, Warning};
pub use files::{FileError, Files, Folder, Memory, Opened, read_whole};
pub use matrix::{Vector, norm};
pub use survey::{
    CrossSection, Leg, LegFlags, Misclosure, Source, Station, StationId, Summary, Survey,
};

/// Reads the survey `entry` of `files`. The name's ending tells the format, or else the contents do.
///
/// # Errors
/// [`Refusal`] where the survey cannot be used.
pub fn read(files: &dyn Files, entry: &str) -> Result<Survey, Refusal> {
    let opened = files.open(entry).map_err(|error| {
        let (wrong, remedy) = survex::unopened(entry, &error);
        Refusal::new(wrong, remedy)
    })?;
    let place = || Place { file: opened.path.as_str().into(), line: 0, column: 0 };
    if opened.bytes.len() > survex::MOST_BYTES {
        let wrong = format!("the survey has more than {} MB", survex::MOST_BYTES >> 20);
        return Err(Refusal::new(wrong, "give a part of it").at(place()));
    }
    let format = formats::format(entry, &opened.bytes).map_err(|told| told.at(place()))?;
    let read = match format {
        Format::Processed => return three_d::read(opened),
        Format::Survex => survex::read(files, entry, &opened),
        Format::CompassSurvey => compass::survey(&opened),
        Format::CompassProject => compass::project(files, entry, &opened),
        Format::WallsSurvey => walls::survey(&opened),
        Format::WallsProject => walls::project(files, entry, &opened),
        Format::Therion => therion::read(files, entry, &opened),
        Format::VisualTopo => visual_topo::read(&opened),
        Format::PocketTopo => pocket_topo::read(&opened),
    };
    let mistaken = |refusal: Refusal| match formats::mistaken(format, &opened.bytes) {
        Some(other) => other.at(place()),
        None => refusal,
    };
    read.map_err(mistaken)?.adjusted()
}
