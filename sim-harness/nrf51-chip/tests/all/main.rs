//! The chip's core against outcomes that are known, and against the manual.

mod cycles;
mod exceptions;
mod flat;
mod outcomes;
