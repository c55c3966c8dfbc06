//! Tests of the estimator through its public API: how good the estimate is, how well it knows its
//! own error, and which faulty readings it must reject.

mod consistency;
mod faults;
mod gravity;
mod robustness;
mod world;
