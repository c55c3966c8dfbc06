//! Every byte that leaves or enters a drone: parse → checked value → emit.
//!
//! | module | the bytes |
//! |---|---|
//! | [`syslink`] | the serial line between the flight processor and the radio chip |
//! | [`p2p`] | what drones say to each other, on the air |
//! | [`crtp`] | what a ground station and a drone say to each other |
//! | [`radio`] | channel, data rate, address and power, which the first and the last share |
//!
//! Any bytes may come in: a parser returns a value that has been checked, or an error. Any value
//! may go out: what an encoder accepts, the parser on the other side accepts too. All numbers are
//! little-endian.
#![no_std]

pub mod crtp;
pub mod p2p;
pub mod radio;
pub mod syslink;
