//! Files and pictures made from a [`mission::trace::Trace`].
//!
//! [`TraceFiles`] writes all files of the option `--out`. All output is a pure function of the
//! trace: the same mission gives the same bytes, on any machine and at any time.

pub mod bag;
pub mod csv;
pub mod figure_page;
mod folder;
pub mod mcap;
pub mod memory;
mod origin;
pub mod pictures;
pub mod report;
mod runs_parquet;
pub mod subt;
mod summary;
pub mod survey;
#[cfg(test)]
pub(crate) mod synthetic;
mod write;

pub use folder::{Folder, Staging, Streamed};
pub use origin::{CampaignOrigin, Origin, REVISION};
pub use runs_parquet::RunsParquet;
pub use summary::summary;
pub use summary::{last_states, metrics_json, route_json};
pub use write::{OutputError, TraceFiles, put_picture, write_report};
