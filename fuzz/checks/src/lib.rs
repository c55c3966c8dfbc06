//! Properties that must hold for any bytes that a drone or the simulator receives or reads. Each module has one
//! function `check`, which panics where its property does not hold: the fuzz targets call it with
//! the bytes of libFuzzer, and `tests/corpus.rs` with those that it has found so far.
//!
//! | module | the bytes are |
//! |---|---|
//! | [`syslink`] | what the radio chip sends over the serial line |
//! | [`p2p`] | packets from the air |
//! | [`capsule`] | the sealed part of a packet, once it is open |
//! | [`storage`] | the contents of the EEPROM |
//! | [`airlink`] | a script of what happens to two nodes that talk by radio |
//! | [`crtp`] | packets of ground stations |
//! | [`frontier`] | packets of robots that explore together |
//! | [`replay`] | requests of a replay, from a debug probe |
//! | [`maps`] | files of robots' maps and SubT worlds; it has a function for each format |
//! | [`surveys`] | files of cave surveys; it has a function for each format |

pub mod airlink;
pub mod capsule;
pub mod crtp;
pub mod frontier;
pub mod maps;
pub mod p2p;
pub mod replay;
pub mod storage;
pub mod surveys;
pub mod syslink;
