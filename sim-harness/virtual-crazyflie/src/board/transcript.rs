//! A record of the traffic on the board's sensor buses, transfer by transfer.

use crate::soc::{I2cBus, Nanos};

/// The bus of a transfer, and the device to which it is addressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Peer {
    /// A device on I2C1, by its address: decks and EEPROM.
    Deck(u8),
    /// A device on I2C3, by its address: the sensors of the board.
    Sensor(u8),
    /// The flow sensor on SPI1.
    Flow,
}

/// What went over a bus from a start, or a select, to the next one or to the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// When it began.
    pub at: Nanos,
    /// With whom.
    pub peer: Peer,
    /// The address was acknowledged; a select always is.
    pub acknowledged: bool,
    /// The address said that the device is to be read.
    pub read: bool,
    /// Bytes of the chip.
    pub written: Vec<u8>,
    /// Bytes of the device.
    pub answered: Vec<u8>,
}

/// The record, while it is kept.
#[derive(Debug, Default)]
pub(super) struct Transcript(Option<Box<Record>>);

#[derive(Debug, Default)]
struct Record {
    /// The transfer that goes on, of each bus.
    ongoing: [Option<Transfer>; 3],
    done: Vec<Transfer>,
}

impl Transcript {
    pub(super) fn begin(&mut self) {
        self.0.get_or_insert_default();
    }

    pub(super) fn take(&mut self) -> Vec<Transfer> {
        self.0.as_mut().map(|record| std::mem::take(&mut record.done)).unwrap_or_default()
    }

    pub(super) fn start(&mut self, at: Nanos, peer: Peer, read: bool, acknowledged: bool) {
        let bus = Bus::of(peer);
        self.stop(bus);
        if let Some(record) = &mut self.0 {
            let (written, answered) = (Vec::new(), Vec::new());
            let transfer = Transfer { at, peer, acknowledged, read, written, answered };
            record.ongoing[bus as usize] = Some(transfer);
        }
    }

    pub(super) fn stop(&mut self, bus: Bus) {
        if let Some(record) = &mut self.0 {
            record.done.extend(record.ongoing[bus as usize].take());
        }
    }

    /// Adds bytes to the transfer that goes on.
    pub(super) fn add(&mut self, bus: Bus, written: Option<u8>, answered: Option<u8>) {
        let Some(record) = &mut self.0 else { return };
        if let Some(transfer) = &mut record.ongoing[bus as usize] {
            transfer.written.extend(written);
            transfer.answered.extend(answered);
        }
    }
}

/// A bus that is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bus {
    Deck,
    Sensor,
    Flow,
}

impl Bus {
    const fn of(peer: Peer) -> Self {
        match peer {
            Peer::Deck(_) => Self::Deck,
            Peer::Sensor(_) => Self::Sensor,
            Peer::Flow => Self::Flow,
        }
    }

    pub(super) const fn i2c(bus: I2cBus) -> Option<Self> {
        match bus {
            I2cBus::I2c1 => Some(Self::Deck),
            I2cBus::I2c2 => None,
            I2cBus::I2c3 => Some(Self::Sensor),
        }
    }
}

impl Peer {
    pub(super) const fn i2c(bus: I2cBus, address: u8) -> Option<Self> {
        match bus {
            I2cBus::I2c1 => Some(Self::Deck(address)),
            I2cBus::I2c2 => None,
            I2cBus::I2c3 => Some(Self::Sensor(address)),
        }
    }
}
