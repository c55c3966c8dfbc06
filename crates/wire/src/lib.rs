//! Formats of every byte that leaves or enters a drone: each parser turns bytes into a checked
//! value, each encoder turns a value into bytes.
//!
//! | module | the bytes |
//! |---|---|
//! | [`syslink`] | the serial line between the flight processor and the radio chip |
//! | [`p2p`] | packets between drones, on the air |
//! | [`crtp`] | packets between a ground station and a drone |
//! | [`radio`] | channel, data rate, address and power, as `syslink` and a drone's settings have them |
//!
//! A parser accepts any bytes: it returns a value that has been checked, or an error. Every value
//! that an encoder accepts is accepted by the parser on the other side. All numbers are
//! little-endian.
#![no_std]

pub mod crtp;
pub mod p2p;
pub mod radio;
pub mod syslink;
