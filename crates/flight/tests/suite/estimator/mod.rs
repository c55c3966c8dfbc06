//! The estimator through its public door: what it knows in flight, how well it knows how well it
//! knows, and what no sensor can make it believe.

mod anything;
mod consistency;
mod faults;
mod world;
