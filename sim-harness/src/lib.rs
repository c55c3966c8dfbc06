//! The `uchain` command, and the simulator of U-Chain as one dependency.
//!
//! The on-board code of `crates/` runs here unchanged: a [`mission`] advances time, bodies and
//! packets, and calls the same `onboard::Drone` as the firmware.
//!
//! | package | what it holds |
//! |---|---|
//! | [`scenario`] | scenarios: the TOML files that describe missions, read and checked |
//! | [`bodies`] | the bodies of drones: a point, a rigid body, or one whose firmware runs in an emulator |
//! | [`medium`] | the air between radios, packet by packet |
//! | [`mission`] | one mission, step by step: on-board code, bodies and medium, and its trace |
//! | [`measure`] | the metrics of a mission, campaigns, and the paper's figure 3 |
//! | [`planning`] | plans on paper: relays, drops, places for explorers |
//! | [`report`] | files and pictures |
//! | [`replay`] | the replay of recorded RSSI through the on-board code |
//! | [`serve`] | simulated drones for cflib and cfclient |
//! | `stock` | a drone that runs the vendor's firmware, with the feature `virtual` |
//! | [`mod@bench`] | the benchmarks: one folder each, and their registry |
//!
//! [`cli`] is the command line.

pub mod cli;

#[cfg(feature = "virtual")]
pub use stock;
pub use {
    benchmarks as bench, bodies, measure, medium, mission, planning, replay, report, scenario,
    serve,
};
