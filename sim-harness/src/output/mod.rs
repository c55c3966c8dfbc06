//! Files and pictures made from a [`crate::trace::Trace`].
//!
//! [`write_all`] is what `--out` does. Everything is a pure function of the trace: the same
//! mission gives the same bytes, wherever and whenever it is written.

pub mod csv;
pub mod mcap;
pub mod pictures;
pub mod report;
#[cfg(test)]
mod synthetic;
mod write;

pub use write::{OutputError, put, put_json, put_picture, put_text, write_all};
