//! Simulates robots as points that explore a plan together by the rules of [`frontier`].
//!
//! A [`World`] is a plan with walls. A [`Setup`] names world, rule, number of robots, seed, and what
//! goes wrong; [`run()`] flies it and returns an [`Outcome`]. The same setup gives the same outcome.

mod robot;
mod run;
mod world;

pub use run::{Outcome, Setup, run};
pub use world::{WORLDS, World};
