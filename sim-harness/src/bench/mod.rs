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

pub mod attacks;
pub mod chain;
pub mod estimator;
pub mod faults;
pub mod link;
mod net;
pub mod throughput;
