//! Compares the emulated core with another one, instruction by instruction: states to start from,
//! encodings to execute, and the outcomes on which both cores agreed.
//!
//! | module | what it holds |
//! |---|---|
//! | [`forms`] | every form of an instruction, as a pattern of bits |
//! | [`state`] | states that reach what is special in an instruction |
//! | [`sweep`] | the encodings that an ELF is made of |
//! | [`outcome`] | what one instruction leaves behind, and a hash of it |
//! | [`rig`] | one instruction on our core |
//! | [`vectors`] | outcomes that were found right, kept in a file |
//! | [`summary`] | these, replayed, in figures |
//!
//! The other core is Unicorn's. It is under another licence, so the workspace `oracle` asks it, and
//! this crate keeps what it answered.

pub mod forms;
pub mod outcome;
pub mod random;
pub mod rig;
pub mod state;
pub mod summary;
pub mod sweep;
pub mod vectors;

pub use outcome::{After, Outcome};
pub use rig::{Rig, run_one};
pub use state::{State, States};
