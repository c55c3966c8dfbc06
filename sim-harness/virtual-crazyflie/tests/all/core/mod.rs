//! The core by itself, with memory and a bus on which there is almost nothing: what no comparison of
//! single instructions shows. What each instruction computes is compared elsewhere.

mod blocks;
mod faults;
mod kernel;
mod memory;
pub(crate) mod rig;
mod time;
