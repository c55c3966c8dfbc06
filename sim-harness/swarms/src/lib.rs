//! Flies swarms of points by the virtual forces of [`virtual_forces`].
//!
//! The world is that of Falomir et al. (ICINCO 2017, section 6.2): at each round every drone goes a
//! random way between 5 and 10 cm in the direction that it chose. Drones move one after another, and
//! see the others where they are at that moment, as in JBotSim, the paper's simulator.

mod survey;

pub use survey::{Outcome, survey};
