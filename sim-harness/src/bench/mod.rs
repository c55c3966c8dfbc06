//! The named benchmarks.
//!
//! | name | what it measures |
//! |---|---|
//! | [`chain`] | how well and how fast each movement policy makes links equal |
//! | [`throughput`] | how fast the simulation is, at both fidelities |
//! | [`faults`] | what becomes of a drone when something goes wrong |
//! | [`estimator`] | whether the state estimator knows itself |
//! | [`link`] | how orders and telemetry get through a chain |
//! | [`attacks`] | what a chain takes from somebody who has no key |
//! | `firmware` | what the firmware takes of its processor, on the emulated core |
//! | `emulator` | how fast that is, and how far it was compared with another |
//! | `mishaps` | what becomes of the firmware when its chip, buses or code go wrong |

pub mod attacks;
pub mod chain;
#[cfg(feature = "virtual")]
pub mod emulator;
pub mod estimator;
pub mod faults;
#[cfg(feature = "virtual")]
pub mod firmware;
pub mod link;
#[cfg(feature = "virtual")]
pub mod mishaps;
mod net;
pub mod throughput;
