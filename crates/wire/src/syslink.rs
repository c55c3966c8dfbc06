//! Syslink: the serial line between the flight processor (STM32) and the radio chip (nRF51).
//!
//! From crazyflie2-nrf-firmware, `docs/protocols/syslink.md`, `src/main.c` and `src/esb.c`:
//!
//! | bytes | |
//! |---|---|
//! | 2 | start, `BC CF` |
//! | 1 | type |
//! | 1 | length of the data, at most 64 |
//! | 0–64 | data |
//! | 2 | Fletcher-8 checksum of type, length and data |
//!
//! [`Decoder`] finds [`Frame`]s in the bytes of the line, [`Incoming::parse`] returns the packet in
//! a frame, and [`Outgoing::encode`] writes one:
//!
//! ```
//! use wire::syslink::{Decoder, Incoming, Outgoing};
//! use units::Dbm;
//!
//! let mut decoder = Decoder::new();
//! // Noise, a false start, and a signal strength of -57 dBm.
//! let mut line: &[u8] = &[0x00, 0xBC, 0xCF, 0xBC, 0xCF, 0x04, 0x01, 0x39, 0x3E, 0x47];
//! while let Some(frame) = decoder.next(&mut line) {
//!     assert_eq!(Incoming::parse(&frame), Ok(Incoming::Rssi(Some(Dbm(-57.0)))));
//! }
//! assert_eq!(decoder.counters().good, 1);
//!
//! let mut out = [0; wire::syslink::MAX_FRAME];
//! let length = Outgoing::RadioReady.encode(&mut out).unwrap();
//! assert_eq!(&out[..length], [0xBC, 0xCF, 0x0B, 0x00, 0x0B, 0x16]);
//! ```
//!
//! The radio chip sends nothing until it has received one good frame, does not listen to the air
//! before [`Outgoing::RadioReady`], and reports battery and signal strength, each 100 times a
//! second, after [`Outgoing::BatteryAutoupdate`]. It confirms channel, data rate, address and power
//! by sending them back. One [`Outgoing::Raw`] may be sent for each [`Incoming::Raw`].

mod frame;
mod packet;
mod release;

pub use frame::{Counters, Decoder, Frame, MAX_DATA, MAX_FRAME};
pub use packet::{Battery, EncodeError, Incoming, MAX_P2P, MAX_RAW, Malformed, Outgoing, Port};
pub use release::Release;
