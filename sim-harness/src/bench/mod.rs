//! The named benchmarks.
//!
//! | name | what it measures |
//! |---|---|
//! | [`chain`] | how well and how fast each movement policy makes links equal |
//! | [`throughput`] | drone-rounds per second on one core and on all |

pub mod chain;
pub mod throughput;
