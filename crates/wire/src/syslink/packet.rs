//! The packets in the frames of the serial line: their types, and the data of each.

use core::fmt;

use units::{Dbm, Volts};

use super::frame::{self, Frame};
use crate::radio::{Address, Channel, Datarate, TxPower};

/// The most data of one P2P packet (`P2P_MAX_DATA_SIZE`).
pub const MAX_P2P: usize = 60;

/// The most bytes of a raw packet that the radio chip sends: its firmware accepts fewer than
/// `SYSLINK_MTU` (crazyflie2-nrf-firmware, `main.c`).
pub const MAX_RAW: usize = frame::MAX_DATA - 1;

/// Type bytes, from `interface/syslink.h` of crazyflie2-nrf-firmware.
mod kind {
    pub(super) const RAW: u8 = 0x00;
    pub(super) const CHANNEL: u8 = 0x01;
    pub(super) const DATARATE: u8 = 0x02;
    pub(super) const RSSI: u8 = 0x04;
    pub(super) const ADDRESS: u8 = 0x05;
    pub(super) const RAW_BROADCAST: u8 = 0x06;
    pub(super) const POWER: u8 = 0x07;
    pub(super) const P2P: u8 = 0x08;
    pub(super) const P2P_BROADCAST: u8 = 0x0A;
    pub(super) const RADIO_READY: u8 = 0x0B;
    pub(super) const BATTERY_STATE: u8 = 0x13;
    pub(super) const BATTERY_AUTOUPDATE: u8 = 0x14;
    pub(super) const SHUTDOWN_REQUEST: u8 = 0x15;
    pub(super) const SHUTDOWN_ACK: u8 = 0x16;
    pub(super) const NRF_VERSION: u8 = 0x30;
}

/// A P2P port, 0 to 15: it tells protocols between drones apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Port(u8);

impl Port {
    /// The port with this number, if there is one: a port has four bits on the air.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number < 16 { Some(Self(number)) } else { None }
    }

    /// The port's number.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }
}

/// The state of the battery, as the radio chip measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Battery {
    /// Whether the battery is being charged.
    pub charging: bool,
    /// Whether there is USB power.
    pub usb: bool,
    /// The battery's voltage.
    pub voltage: Volts,
}

/// A packet from the radio chip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Incoming<'a> {
    /// A packet of the ground station, as it was on the air; one may be sent in return.
    Raw(&'a [u8]),
    /// A packet of the ground station to all drones, as it was on the air. It is not answered.
    RawBroadcast(&'a [u8]),
    /// The channel has been set.
    Channel(Channel),
    /// The data rate has been set.
    Datarate(Datarate),
    /// The address has been set.
    Address(Address),
    /// The transmit power has been set.
    Power(TxPower),
    /// The strength of the last packet, whichever device sent it; `None` before the first.
    Rssi(Option<Dbm>),
    /// A packet of another drone.
    P2pBroadcast {
        /// The packet's port.
        port: Port,
        /// The strength with which it was received.
        rssi: Dbm,
        /// The packet's data, at most [`MAX_P2P`] bytes.
        data: &'a [u8],
    },
    /// A packet laid out like another drone's, for this drone alone: a ground station can send it.
    P2p {
        /// The packet's port.
        port: Port,
        /// The strength with which it was received.
        rssi: Dbm,
        /// The packet's data, at most [`MAX_P2P`] bytes.
        data: &'a [u8],
    },
    /// The state of the battery.
    Battery(Battery),
    /// The button was pressed: unless [`Outgoing::ShutdownAck`] comes, the supply ends in a second.
    ShutdownRequest,
    /// The version of the radio chip's firmware, as text without the zero at its end.
    NrfVersion(&'a [u8]),
    /// A packet of this type, which this code does not know.
    Unknown(u8),
}

/// A frame of this type had data that the type does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Malformed(pub u8);

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "malformed syslink frame of type {:#04x}", self.0)
    }
}

impl core::error::Error for Malformed {}

impl<'a> Incoming<'a> {
    /// The packet that a frame contains.
    ///
    /// # Errors
    /// [`Malformed`] when the data has not the length or the values of the frame's type.
    pub fn parse(frame: &Frame<'a>) -> Result<Self, Malformed> {
        let data = frame.data;
        match frame.kind {
            kind::RAW => Some(Self::Raw(data)),
            kind::RAW_BROADCAST => Some(Self::RawBroadcast(data)),
            kind::CHANNEL => one(data).and_then(Channel::new).map(Self::Channel),
            kind::DATARATE => one(data).and_then(Datarate::from_code).map(Self::Datarate),
            kind::ADDRESS => {
                data.try_into().ok().map(|bytes| Self::Address(Address::from_le_bytes(bytes)))
            }
            kind::POWER => {
                one(data).and_then(|byte| TxPower::from_code(byte as i8)).map(Self::Power)
            }
            kind::RSSI => {
                one(data).and_then(rssi).map(|is| Self::Rssi((is.0 != 0.0).then_some(is)))
            }
            kind::P2P => p2p(data).map(|(port, rssi, data)| Self::P2p { port, rssi, data }),
            kind::P2P_BROADCAST => {
                p2p(data).map(|(port, rssi, data)| Self::P2pBroadcast { port, rssi, data })
            }
            kind::BATTERY_STATE => battery(data).map(Self::Battery),
            kind::SHUTDOWN_REQUEST => Some(Self::ShutdownRequest),
            kind::NRF_VERSION => Some(Self::NrfVersion(until_zero(data))),
            other => Some(Self::Unknown(other)),
        }
        .ok_or(Malformed(frame.kind))
    }
}

fn one(data: &[u8]) -> Option<u8> {
    match data {
        [byte] => Some(*byte),
        _ => None,
    }
}

/// The strength that a sample stands for: it has seven bits and no sign (nRF51 reference manual,
/// RSSISAMPLE).
fn rssi(sample: u8) -> Option<Dbm> {
    (sample < 128).then_some(Dbm(-f32::from(sample)))
}

fn p2p(data: &[u8]) -> Option<(Port, Dbm, &[u8])> {
    let [port, sample, data @ ..] = data else { return None };
    if data.len() > MAX_P2P {
        return None;
    }
    Some((Port::new(*port)?, rssi(*sample)?, data))
}

fn battery(data: &[u8]) -> Option<Battery> {
    let (flags, numbers) = data.split_first()?;
    let (voltage, numbers) = float(numbers)?;
    let (_charge_milliamperes, numbers) = float(numbers)?;
    // Some builds of the radio chip's firmware add its temperature.
    if !numbers.is_empty() {
        let (_celsius, []) = float(numbers)? else { return None };
    }
    Some(Battery { charging: flags & 1 != 0, usb: flags & 2 != 0, voltage: Volts(voltage) })
}

/// The finite number at the beginning of `bytes`, and the bytes after it.
fn float(bytes: &[u8]) -> Option<(f32, &[u8])> {
    let (number, rest) = bytes.split_first_chunk()?;
    let number = f32::from_le_bytes(*number);
    number.is_finite().then_some((number, rest))
}

fn until_zero(text: &[u8]) -> &[u8] {
    text.split(|byte| *byte == 0).next().unwrap_or_default()
}

/// A packet to the radio chip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outgoing<'a> {
    /// A packet for the ground station, 1 to [`MAX_RAW`] bytes: one for each that came from there.
    Raw(&'a [u8]),
    /// The channel is to be set.
    Channel(Channel),
    /// The data rate is to be set.
    Datarate(Datarate),
    /// The address is to be set.
    Address(Address),
    /// The transmit power is to be set.
    Power(TxPower),
    /// The data is to be sent now, to every drone in range.
    P2pBroadcast {
        /// The packet's port.
        port: Port,
        /// The packet's data, at most [`MAX_P2P`] bytes.
        data: &'a [u8],
    },
    /// The radio is configured: the chip is to begin to listen.
    RadioReady,
    /// Battery and signal strength are to be reported from now on.
    BatteryAutoupdate,
    /// All data is saved: the supply may end.
    ShutdownAck,
    /// The chip is to send the version of its firmware.
    NrfVersion,
}

/// Why a packet could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncodeError {
    /// The packet has no data, or more than its type can carry.
    Length,
    /// The buffer has less room than the frame needs; [`MAX_FRAME`](frame::MAX_FRAME) bytes are
    /// enough for every frame.
    NoRoom,
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Length => "no data, or more than the packet carries",
            Self::NoRoom => "the frame does not fit the buffer",
        })
    }
}

impl core::error::Error for EncodeError {}

impl Outgoing<'_> {
    /// Writes the frame to the beginning of `out` and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`]; `out` is then unchanged.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let carried = match self {
            Self::Raw(data) => (1..=MAX_RAW).contains(&data.len()),
            Self::P2pBroadcast { data, .. } => data.len() <= MAX_P2P,
            _ => true,
        };
        if !carried {
            return Err(EncodeError::Length);
        }
        match self {
            Self::Raw(data) => frame::write(kind::RAW, data, &[], out),
            Self::Channel(channel) => frame::write(kind::CHANNEL, &[channel.number()], &[], out),
            Self::Datarate(rate) => frame::write(kind::DATARATE, &[rate.code()], &[], out),
            Self::Address(address) => frame::write(kind::ADDRESS, &address.to_le_bytes(), &[], out),
            Self::Power(power) => frame::write(kind::POWER, &power.code().to_le_bytes(), &[], out),
            Self::P2pBroadcast { port, data } => {
                frame::write(kind::P2P_BROADCAST, &[port.number()], data, out)
            }
            Self::RadioReady => frame::write(kind::RADIO_READY, &[], &[], out),
            Self::BatteryAutoupdate => frame::write(kind::BATTERY_AUTOUPDATE, &[], &[], out),
            Self::ShutdownAck => frame::write(kind::SHUTDOWN_ACK, &[], &[], out),
            Self::NrfVersion => frame::write(kind::NRF_VERSION, &[], &[], out),
        }
        .ok_or(EncodeError::NoRoom)
    }
}
