//! The world the drones fly in when there are none, and the `uchain` command.
//!
//! The on-board code of `crates/` flies here unchanged: [`mission`] moves time, bodies and packets
//! around the very [`onboard::Drone`] that the firmware runs.
//!
//! | module | what it holds |
//! |---|---|
//! | [`scenario`] | what a mission is: the TOML files, checked |
//! | [`world`] | floor plan, skeleton, beams, radio, and the best chain that could be |
//! | [`bodies`] | the bodies of drones: a point, a rigid body, or one whose firmware runs in an emulator |
//! | [`mission`] | one mission, step by step: on-board code, bodies, and the medium between the radios |
//! | [`measure`] | the record of a mission, its figures, campaigns, the paper's figure 3, and the benchmarks |
//! | [`replay`] | recorded RSSI through the on-board code |
//! | [`output`] | files and pictures |
//! | [`serve`] | drones that cflib and cfclient connect to |
//! | `stock` | a drone that runs the vendor's firmware, with the feature `virtual` |
//! | [`keys`] | the keys of a fleet, and the pages that bring them to its drones |
//! | [`cli`] | the command line |

pub mod bodies;
pub mod cli;
pub mod input_error;
pub mod keys;
pub mod measure;
pub mod mission;
pub mod output;
pub mod random;
pub mod replay;
pub mod scenario;
pub mod serve;
#[cfg(feature = "virtual")]
pub mod stock;
pub mod suggest;
pub mod world;
