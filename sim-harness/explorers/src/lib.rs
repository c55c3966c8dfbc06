//! Simulates robots as points that explore a place together with the code of [`frontier`].
//!
//! A [`World`] is a plan with walls. A [`Setup`] names world, rule, number of robots, radio and
//! seed, and what goes wrong; [`run()`] flies it and returns an [`Outcome`] and the map that the
//! robots have drawn. The same setup gives the same outcome.

mod access_point;
mod air;
mod drawn;
mod drift;
mod robot;
mod run;
mod scale;
mod world;

pub use air::{Air, Network};
pub use drawn::merged;
pub use robot::{Senses, Sensor};
pub use run::{Glance, LIMITS, Outcome, ROBOTS, Setup, run, watch};
pub use scale::{SCALE_ROBOTS, SCALE_TILES, Scale, scale};
pub use world::{PLANS, World};
