//! Where the drones fly: a tunnel on a floor plan, and the radio that it lets through.
//!
//! The floor plan is a union of corridors and rooms ([`layout`]). Positions along it are measured
//! as the paper does, by the abscissa on the centre-line of the main corridor, from the base's end.

mod centre_line;
pub mod layout;
mod optimum;
mod radio;
mod tunnel;

pub use centre_line::CentreLine;
pub use optimum::{Optimum, best_chain, best_chains};
pub use radio::{Radio, Walls};
pub use tunnel::Tunnel;
