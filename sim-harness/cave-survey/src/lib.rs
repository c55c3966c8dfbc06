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
mod loops;
mod matrix;
mod parts;
mod sets;
mod survex;
mod survey;
mod three_d;
mod traverse;
mod walls;

pub use draft::MOST_LEGS;
pub use error::{Place, Refusal, Warning};
pub use files::{FileError, Files, Folder, Memory, Opened, read_whole};
pub use matrix::{Vector, norm};
pub use survey::{
    CrossSection, Leg, LegFlags, Misclosure, Source, Station, StationId, Summary, Survey,
};

/// Reads the survey `entry` of `files`; the name's ending tells the format.
///
/// # Errors
/// [`Refusal`] where the survey cannot be used.
pub fn read(files: &dyn Files, entry: &str) -> Result<Survey, Refusal> {
    let opened = files.open(entry).map_err(|error| {
        let (wrong, remedy) = survex::unopened(entry, &error);
        Refusal::new(wrong, remedy)
    })?;
    let (_, ending) = entry.rsplit_once('.').unwrap_or(("", "svx"));
    match &*ending.to_ascii_lowercase() {
        "3d" => three_d::read(opened),
        "dat" | "clp" => compass::survey(&opened)?.adjusted(),
        "mak" => compass::project(files, entry, &opened)?.adjusted(),
        "srv" => walls::survey(&opened)?.adjusted(),
        "wpj" => walls::project(files, entry, &opened)?.adjusted(),
        _ => survex::read(files, entry, opened)?.adjusted(),
    }
}
