//! Panics, faults, resets and the watchdog, and the records of them that the next boot reads.
//!
//! | module | holds |
//! |---|---|
//! | [`mod@panic`], [`fault`] | panics and faults: motors off, a crash record, reset |
//! | [`reset`] | why the chip started, and the watchdog |
//! | [`restart_mark`] | whether the last run ended in the air, or while a stop stood |
//! | [`stack`] | where the stack lies and how deep it has been |

pub(crate) mod fault;
pub(crate) mod panic;
pub(crate) mod reset;
pub(crate) mod restart_mark;
pub(crate) mod stack;
