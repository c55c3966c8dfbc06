//! Records that survive a power cut: each is kept in two slots, with a checksum and a sequence
//! number, so that a write that is cut short damages one slot and the other stays whole.
//!
//! | EEPROM address, slots A and B | record | module |
//! |---|---|---|
//! | 0 | the vendor's configuration block, read and never written | [`vendor`] |
//! | 0x200 and 0x300 | number, role, radio, trims, limits, policy, mission and its plan | [`settings`] |
//! | 0x240 and 0x340 | the keys that the drone was provisioned with | [`keys`] |
//! | 0x280 and 0x380 | the boot counter that makes nonces unique | [`epoch`] |
//! | 0x2C0 and 0x3C0 | the provisionings that the drone has used | [`ledger`] |
//! | 0x400 | the vendor's persistent parameters, neither read nor written | |
//!
//! Every slot begins a page of the EEPROM and no two slots share one, so no write touches another
//! slot, whatever the page being written turns into. All numbers are little-endian.
//!
//! # Reading and writing
//! This crate does no I/O. At boot the caller reads [`Record::LENGTH`] bytes from each of
//! [`Record::ADDRESSES`], each until two [`Readings`] agree, and passes them to [`Slots::read`]; [`Slots::newest`] is the record that
//! holds. To change it the caller asks [`Slots::write`] for a [`Write`], writes its bytes at its
//! address, reads them back and asks [`Write::is_kept`]: only then does the new record count.
//!
//! ```
//! use storage::{Record, Slots, settings::Settings};
//!
//! let blank = [0xFF; Settings::LENGTH];
//! let slots = Slots::<Settings>::read(&blank, &blank);
//! assert_eq!(slots.newest(), None);
//!
//! // The first record goes into slot A. Cut short, it is no record.
//! let write = slots.write(&Settings::DEFAULT).unwrap();
//! assert_eq!(write.address(), 0x200);
//! let mut cut = blank;
//! cut[..20].copy_from_slice(&write.bytes()[..20]);
//! assert!(!write.is_kept(&cut));
//! assert_eq!(Slots::<Settings>::read(&cut, &blank).newest(), None);
//!
//! // Whole, it holds.
//! assert!(write.is_kept(write.bytes()));
//! let slots = Slots::<Settings>::read(write.bytes(), &blank);
//! assert_eq!(slots.newest(), Some(&Settings::DEFAULT));
//! ```
#![no_std]

pub mod board_name;
mod bytes;
pub mod epoch;
mod error;
pub mod keys;
pub mod ledger;
pub mod settings;
mod slots;
mod swarm_plan;
pub mod vendor;

pub use bytes::crc32;
pub use error::Error;
pub use slots::{Readings, Record, Slot, Slots, Write};
