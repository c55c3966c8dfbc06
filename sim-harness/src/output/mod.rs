//! Files and pictures made from a [`crate::measure::trace::Trace`].
//!
//! [`write_all`] is what `--out` does. Everything is a pure function of the trace: the same
//! mission gives the same bytes, wherever and whenever it is written.

pub mod csv;
mod folder;
pub mod mcap;
pub mod pictures;
pub mod report;
#[cfg(test)]
mod synthetic;
mod write;

pub use folder::{Folder, Staging};
pub use write::{OutputError, put_picture, write_all};
