//! The radio chip of a board: a model of what the vendor's firmware does, or that firmware itself.

mod boot;
mod firmware;

pub use boot::{RadioFirmware, Unbootable};
pub use firmware::FirmwareChip;

use super::deck_memory::DeckMemory;
use super::noise::Shares;
use super::nrf51::{Answer, Nrf51, Power, Sent, Tuning};
use crate::soc::{Level, Nanos, UartByte};

/// A packet that comes off the air at a moment.
pub(super) struct Heard<'a> {
    pub(super) at: Nanos,
    /// −dBm.
    pub(super) rssi: u8,
    pub(super) what: What<'a>,
}

/// The content of a packet that comes off the air.
pub(super) enum What<'a> {
    /// A packet of another drone's to this port, to all drones or to this one alone.
    P2p { port: u8, data: &'a [u8], broadcast: bool },
    /// A packet of the ground's, header first.
    Crtp(&'a [u8]),
}

/// The radio chip.
pub enum RadioChip {
    /// The model, which is quick.
    Model(Box<Nrf51>),
    /// The vendor's firmware on an emulated chip.
    Firmware(Box<FirmwareChip>),
}

/// Calls a method that both kinds of chip have.
macro_rules! either {
    ($chip:expr, $it:ident => $call:expr) => {
        match $chip {
            Self::Model($it) => $call,
            Self::Firmware($it) => $call,
        }
    };
}

impl RadioChip {
    pub(super) fn new(
        firmware: Option<&RadioFirmware>,
        version: &str,
        memories: Vec<DeckMemory>,
    ) -> Self {
        match firmware {
            None => Self::Model(Box::new(Nrf51::new(version, memories))),
            Some(firmware) => Self::Firmware(Box::new(FirmwareChip::new(firmware))),
        }
    }

    /// The model, if it is one.
    #[must_use]
    pub const fn model(&self) -> Option<&Nrf51> {
        match self {
            Self::Model(model) => Some(model),
            Self::Firmware(_) => None,
        }
    }

    /// The emulated chip, if it runs the vendor's firmware.
    #[must_use]
    pub const fn firmware(&self) -> Option<&FirmwareChip> {
        match self {
            Self::Model(_) => None,
            Self::Firmware(chip) => Some(chip),
        }
    }

    /// The settings of the radio.
    #[must_use]
    pub const fn tuning(&self) -> Tuning {
        either!(self, it => it.tuning())
    }

    /// Whether the flight processor has power.
    #[must_use]
    pub const fn power(&self) -> Power {
        either!(self, it => it.power())
    }

    pub(super) fn due(&self) -> Nanos {
        either!(self, it => it.due())
    }

    pub(super) fn advance(&mut self, now: Nanos) {
        either!(self, it => it.advance(now));
    }

    pub(super) fn led(&self) -> bool {
        either!(self, it => it.led())
    }

    pub(super) fn wait(&self) -> Level {
        either!(self, it => it.wait())
    }

    /// A byte from the flight processor, whose stop bit passes now.
    pub(super) fn take(&mut self, now: Nanos, byte: u8, bit: u32) {
        either!(self, it => it.take(now, byte, bit));
    }

    /// The byte for the flight processor that has begun by now.
    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        either!(self, it => it.give(now))
    }

    pub(super) fn hear(&mut self, now: Nanos, heard: &Heard<'_>) {
        let Heard { at, rssi, .. } = *heard;
        match (self, &heard.what) {
            (Self::Model(model), What::P2p { port, data, broadcast }) => {
                model.hear_p2p(now, at, *broadcast, *port, data, rssi);
            }
            (Self::Model(model), What::Crtp(data)) => model.hear_crtp(now, at, data, rssi),
            (Self::Firmware(chip), _) => chip.hear(heard),
        }
    }

    pub(super) fn take_sent(&mut self) -> Vec<Sent> {
        either!(self, it => it.take_sent())
    }

    pub(super) fn take_answers(&mut self) -> Vec<Answer> {
        either!(self, it => it.take_answers())
    }

    pub(super) fn set_battery(&mut self, now: Nanos, volts: f32, charging: bool, usb: bool) {
        either!(self, it => it.set_battery(now, volts, charging, usb));
    }

    pub(super) fn press(&mut self, now: Nanos) {
        either!(self, it => it.press(now));
    }

    pub(super) fn disturb(&mut self, shares: Shares, seed: u64) {
        either!(self, it => it.disturb(shares, seed));
    }

    pub(super) fn set_stuck_full(&mut self, is: bool) {
        either!(self, it => it.stuck_full = is);
    }

    pub(super) fn reset(&mut self, now: Nanos) {
        either!(self, it => it.reset(now));
    }

    /// Sets the radio to another channel from the air.
    pub(super) fn retune(&mut self, now: Nanos, channel: u8) {
        match self {
            Self::Model(model) => model.retune(channel),
            Self::Firmware(chip) => chip.retune(now, channel),
        }
    }

    /// Keeps the core of a model busy; a chip that runs the firmware is as busy as that makes it.
    pub(super) fn keep_busy(&mut self, now: Nanos, every: Nanos, busy: Nanos) {
        if let Self::Model(model) = self {
            model.keep_busy(now, every, busy);
        }
    }

    /// Lets a model send old packets in place of its own; a chip that runs the firmware does so where
    /// that does.
    pub(super) fn set_ghosts(&mut self, is: bool) {
        if let Self::Model(model) = self {
            model.ghosts = is;
        }
    }
}
