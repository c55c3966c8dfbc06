//! The chain through its public door: neighbours, filters, policies and launches.

mod filter;
mod launch;
mod neighbours;
mod policy;
mod registry;
