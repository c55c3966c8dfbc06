//! What the verbs and the benchmarks share of the command line: arguments, and a progress bar.

mod args;
mod progress;

pub use args::{FidelityArg, NetworkArg, SensorArg, counted, runs};
pub use progress::Progress;
