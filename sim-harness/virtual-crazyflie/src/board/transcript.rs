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
pub(super) struct Transcript {
    transfers: Option<Vec<Transfer>>,
}

impl Transcript {
    pub(super) fn begin(&mut self) {
        self.transfers.get_or_insert_default();
    }

    pub(super) fn take(&mut self) -> Vec<Transfer> {
        self.transfers.as_mut().map(std::mem::take).unwrap_or_default()
    }

    pub(super) fn start(&mut self, at: Nanos, peer: Peer, read: bool, acknowledged: bool) {
        if let Some(transfers) = &mut self.transfers {
            let (written, answered) = (Vec::new(), Vec::new());
            transfers.push(Transfer { at, peer, acknowledged, read, written, answered });
        }
    }

    /// Adds bytes to the latest transfer with a peer of the same bus.
    pub(super) fn add(&mut self, bus: Bus, written: Option<u8>, answered: Option<u8>) {
        let of_bus = |transfer: &&mut Transfer| Bus::of(transfer.peer) == bus;
        let latest = self.transfers.as_mut().and_then(|all| all.iter_mut().rev().find(of_bus));
        if let Some(transfer) = latest {
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
