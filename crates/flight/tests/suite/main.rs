//! The flight code through its public door, and its estimator.

mod door;
mod estimator;
