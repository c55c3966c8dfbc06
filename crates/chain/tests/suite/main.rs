//! The chain through its public door: neighbours, filters, policies and launches.

mod chain_wide;
mod edge;
mod filter;
mod governor;
mod launch;
mod neighbours;
mod noise;
mod policy;
mod registry;
mod route;
mod slopes;
