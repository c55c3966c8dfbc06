//! The named benchmarks.
//!
//! | name | what it measures |
//! |---|---|
//! | [`chain`] | how well the chain holds, grows, heals and comes home under each movement policy |
//! | [`drawn`] | how the chain does in places that each seed draws, beside an oracle |
//! | [`throughput`] | how fast the simulation is, at both fidelities |
//! | [`faults`] | how flights end after faults of sensors and motors |
//! | [`estimator`] | whether the state estimator predicts its own errors |
//! | [`junctions`] | whether every relay takes the branch that the pilot chose |
//! | [`explore`] | how several robots explore a place together |
//! | [`link`] | how orders and telemetry get through a chain |
//! | [`attacks`] | how many packets a chain accepts from an attacker without a key |
//! | [`placement`] | how much relays cover that are put down by each rule |
//! | [`forces`] | whether swarms by virtual forces keep clear and connected, and how fast they are |
//! | `firmware` | load, step times and stack of the firmware, on the emulated core |
//! | `emulator` | how fast the emulator is, and the comparison of its core with another |
//! | `mishaps` | how flights end when the firmware's chip, buses or code fail |
//! | `stock` | how far the vendor's firmware flies the emulated drone |

pub mod attacks;
pub mod chain;
pub mod drawn;
#[cfg(feature = "virtual")]
pub mod emulator;
pub mod estimator;
pub mod explore;
pub mod faults;
#[cfg(feature = "virtual")]
pub mod firmware;
pub mod forces;
pub mod junctions;
pub mod link;
#[cfg(feature = "virtual")]
pub mod mishaps;
mod net;
pub mod placement;
#[cfg(feature = "virtual")]
pub mod stock;
pub mod throughput;
