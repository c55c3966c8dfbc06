//! Tests of the flight code and of its estimator through their public APIs.

mod estimator;
mod public_api;
