//! The simulator of U-Chain, and the `uchain` command.
//!
//! The on-board code of `crates/` runs here unchanged: a [`mission`] advances time, bodies and
//! packets, and calls the same [`onboard::Drone`] as the firmware.
//!
//! | module | what it holds |
//! |---|---|
//! | [`scenario`] | scenarios: the TOML files that describe missions, read and checked |
//! | [`bodies`] | the bodies of drones: a point, a rigid body, or one whose firmware runs in an emulator |
//! | [`mission`] | one mission, step by step: on-board code, bodies, and the medium between the radios |
//! | [`measure`] | the trace of a mission, its metrics, campaigns, and the paper's figure 3 |
//! | [`mod@bench`] | the benchmarks: one folder each, and their registry |
//! | [`replay`] | the replay of recorded RSSI through the on-board code |
//! | [`output`] | files and pictures |
//! | [`serve`] | simulated drones for cflib and cfclient |
//! | `stock` | a drone that runs the vendor's firmware, with the feature `virtual` |
//! | [`cli`] | the command line |

pub mod cli;

#[cfg(feature = "virtual")]
pub use stock;
pub use {
    benchmarks as bench, bodies, measure, medium, mission, planning, replay, report, scenario,
    serve,
};
