//! Simulates robots as points that explore a place together with the code of [`frontier`].
//!
//! A [`World`] is a plan with walls. A [`Setup`] names world, rule, number of robots, radio and
//! seed, and what goes wrong; [`run()`] flies it and returns an [`Outcome`] and the map that the
//! robots have drawn. The same setup gives the same outcome.

mod air;
mod robot;
mod run;
mod world;

pub use air::Air;
pub use run::{LIMITS, Outcome, ROBOTS, Setup, run};
pub use world::{PLANS, World};
