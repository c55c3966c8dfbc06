//! States, encodings and outcomes by which the core is compared with another.
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
//! | [`speed`] | how fast the core is executed |
//!
//! The other core is not here: it is under another licence, and asked by the workspace `oracle`.

pub mod forms;
pub mod outcome;
pub mod random;
pub mod rig;
pub mod speed;
pub mod state;
pub mod summary;
pub mod sweep;
pub mod vectors;

pub use outcome::{After, Outcome};
pub use rig::{Rig, run_one};
pub use state::{State, States};
