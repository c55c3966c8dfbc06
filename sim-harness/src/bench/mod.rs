//! The named benchmarks.
//!
//! | name | what it measures |
//! |---|---|
//! | [`chain`] | how well and how fast each movement policy makes links equal |
//! | [`throughput`] | how fast the simulation is, at both fidelities |
//! | [`faults`] | what becomes of a drone when something goes wrong |
//! | [`estimator`] | whether the state estimator knows itself |

pub mod chain;
pub mod estimator;
pub mod faults;
pub mod throughput;
