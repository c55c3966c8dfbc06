//! Flies swarms of points by the virtual forces of [`virtual_forces`].
//!
//! The world is that of Falomir et al. (ICINCO 2017, section 6.2): at each round every drone goes a
//! random way between 5 and 10 cm in the direction that it chose. Drones move one after another, and
//! see the others where they are at that moment, as in JBotSim, the paper's simulator. A packet may
//! be lost, a position may be wrong, and a drone may fail: [`Trouble`].

pub mod bench;
mod flight;
mod leg;
mod place;
mod swarm;
mod trouble;

pub use flight::{Flight, Mission, TooMany, fly};
pub use leg::{Leg, Phase};
pub use place::{AREA_WIDTH, Place};
pub use swarm::MOST_DRONES;
pub use trouble::{Failure, Trouble};
