//! A packet: a header and at most 30 bytes.

/// The most bytes after the header (crazyflie-firmware, `crtp.h`).
pub const MAX_DATA: usize = 30;

/// The most bytes of a packet.
pub const MAX_PACKET: usize = 1 + MAX_DATA;

/// Bits 2 and 3 of a header, which have no meaning and are set.
const IDLE_BITS: u8 = 0b0000_1100;

/// The service that a packet belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Port {
    /// Text for a console.
    Console = 0,
    /// Parameters.
    Param = 2,
    /// Set-points of roll, pitch, yaw rate and thrust.
    Commander = 3,
    /// Memories.
    Memory = 4,
    /// The log.
    Log = 5,
    /// Positions from an external positioning system.
    Localization = 6,
    /// Set-points.
    Setpoint = 7,
    /// High-level commands: take-off, landing, trajectories.
    HighLevel = 8,
    /// The supervisor, which decides whether the drone may fly.
    Supervisor = 9,
    /// Facts about the drone and its firmware.
    Platform = 13,
    /// The link itself.
    Link = 15,
}

impl Port {
    const fn from_header(header: u8) -> Result<Self, u8> {
        match header >> 4 {
            0 => Ok(Self::Console),
            2 => Ok(Self::Param),
            3 => Ok(Self::Commander),
            4 => Ok(Self::Memory),
            5 => Ok(Self::Log),
            6 => Ok(Self::Localization),
            7 => Ok(Self::Setpoint),
            8 => Ok(Self::HighLevel),
            9 => Ok(Self::Supervisor),
            13 => Ok(Self::Platform),
            15 => Ok(Self::Link),
            other => Err(other),
        }
    }
}

/// A packet: a header byte and up to [`MAX_DATA`] bytes of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Packet {
    /// The packet's bytes; those after `length` are zero.
    bytes: [u8; MAX_PACKET],
    /// The number of bytes, header included, 1 to 31.
    length: u8,
}

impl Packet {
    /// A packet without content, which is sent to let the other side send one in return.
    pub const NULL: Self = Self::empty(Port::Link, 3);

    pub(super) const fn empty(port: Port, channel: u8) -> Self {
        let mut bytes = [0; MAX_PACKET];
        bytes[0] = (port as u8) << 4 | IDLE_BITS | (channel & 0b11);
        Self { bytes, length: 1 }
    }

    /// A packet with this data.
    ///
    /// # Errors
    /// [`Error::Channel`](super::Error::Channel) above 3, [`Error::Length`](super::Error::Length)
    /// when there are more than [`MAX_DATA`] bytes.
    pub fn new(port: Port, channel: u8, data: &[u8]) -> Result<Self, super::Error> {
        if channel > 0b11 {
            return Err(super::Error::Channel(channel));
        }
        if data.len() > MAX_DATA {
            return Err(super::Error::Length(data.len()));
        }
        Ok(Self::empty(port, channel).with(data))
    }

    /// The packet with `more` at its end; bytes that do not fit are left out.
    pub(super) fn with(mut self, more: &[u8]) -> Self {
        let free = self.bytes.iter_mut().skip(usize::from(self.length));
        for (place, byte) in free.zip(more) {
            *place = *byte;
            self.length += 1;
        }
        self
    }

    /// The packet with these bytes, as they were received.
    ///
    /// # Errors
    /// [`Error::Length`](super::Error::Length) when there is no byte, or more than [`MAX_PACKET`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, super::Error> {
        let wrong = super::Error::Length(bytes.len());
        let (header, data) = bytes.split_first().ok_or(wrong)?;
        if data.len() > MAX_DATA {
            return Err(wrong);
        }
        let mut packet = Self { bytes: [0; MAX_PACKET], length: 0 };
        packet = packet.with(&[header | IDLE_BITS]);
        Ok(packet.with(data))
    }

    /// All bytes of the packet, 1 to [`MAX_PACKET`].
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }

    /// The bytes after the header.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.bytes.get(1..usize::from(self.length)).unwrap_or_default()
    }

    const fn header(&self) -> u8 {
        let [header, ..] = self.bytes;
        header
    }

    /// The service that the packet belongs to.
    ///
    /// # Errors
    /// [`Error::Port`](super::Error::Port) when no service has the packet's port.
    pub fn port(&self) -> Result<Port, super::Error> {
        Port::from_header(self.header()).map_err(super::Error::Port)
    }

    /// The packet's channel, 0 to 3.
    #[must_use]
    pub const fn channel(&self) -> u8 {
        self.header() & 0b11
    }

    /// Whether this is a packet without content.
    #[must_use]
    pub const fn is_null(&self) -> bool {
        self.header() == Self::NULL.header()
    }
}
