//! The core by itself, with memory and a bus on which there is almost nothing: what no comparison of
//! single instructions shows. What each instruction computes is compared elsewhere.

mod blocks;
mod faults;
#[path = "../firmware_elf/mod.rs"]
mod firmware_elf;
mod kernel;
mod memory;
mod rig;
mod time;
