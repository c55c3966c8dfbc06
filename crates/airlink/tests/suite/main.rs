//! The link through its public door: turns, delays and sealed packets.

mod common;
mod delay;
mod secure;
mod stop;
mod turns;
