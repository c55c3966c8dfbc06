//! Headers: the first 8 bytes of every packet, in clear. They name the sender and carry the number
//! that is never used twice.

use units::{Instant, NODES, NodeId};

use super::{Error, exactly, steps};

/// Bytes of a header.
pub const HEADER: usize = 8;

/// The kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// [`Beacon`](super::Beacon).
    Beacon,
    /// [`Report`](super::Report).
    Report,
    /// A [`Capsule`](super::Capsule) with an [`Order`](units::Order) in it.
    Command,
    /// A [`Capsule`](super::Capsule) with [`Telemetry`](super::Telemetry) in it.
    Telemetry,
    /// [`Membership`](super::Membership).
    Membership,
    /// [`MissionMessage`](super::MissionMessage).
    Mission,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Beacon,
        Self::Report,
        Self::Command,
        Self::Telemetry,
        Self::Membership,
        Self::Mission,
    ];

    const fn code(self) -> u8 {
        match self {
            Self::Beacon => 1,
            Self::Report => 2,
            Self::Command => 3,
            Self::Telemetry => 4,
            Self::Membership => 5,
            Self::Mission => 6,
        }
    }

    const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Beacon),
            2 => Some(Self::Report),
            3 => Some(Self::Command),
            4 => Some(Self::Telemetry),
            5 => Some(Self::Membership),
            6 => Some(Self::Mission),
            _ => None,
        }
    }
}

/// The turn of a frame in which a packet was sent: each node has two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Wave {
    /// The turns run from the base to the head.
    Outward,
    /// The turns run from the head to the base.
    Inward,
}

/// The number of a node's boot: 24 bits, never the same twice, never zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Epoch(u32);

impl Epoch {
    /// The epoch of a node that is switched on for the first time.
    pub const FIRST: Self = Self(1);

    /// Epoch `number`, if there is one: 1 to 2²⁴ − 1.
    #[must_use]
    pub const fn new(number: u32) -> Option<Self> {
        if number != 0 && number <= LOW { Some(Self(number)) } else { None }
    }

    /// The epoch's number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }

    /// The epoch after this one; `None` after 16 million.
    #[must_use]
    pub const fn next(self) -> Option<Self> {
        Self::new(self.0 + 1)
    }

    /// The epoch's three bytes, the lowest first.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 3] {
        let [e0, e1, e2, _] = self.0.to_le_bytes();
        [e0, e1, e2]
    }

    /// The epoch with these bytes; `None` where they are zero.
    #[must_use]
    pub const fn from_bytes([e0, e1, e2]: [u8; 3]) -> Option<Self> {
        Self::new(u32::from_le_bytes([e0, e1, e2, 0]))
    }
}

/// The number of a packet: 24 bits of [`Epoch`] above 24 bits that count within it. A later packet
/// of the same node has the larger one.
///
/// The count is also the packet's time stamp: the time since the sender's boot in steps of
/// [`STAMP_US`], or one more than the count of the packet before, whichever is later. A burst runs
/// ahead of the time by a few steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counter(u64);

/// A step of a packet's time stamp in µs. 24 bits of it are 38 hours, and a node sends fewer than
/// the 122 packets a second that would make its count run ahead of the time for good.
pub const STAMP_US: u64 = 1 << STAMP_BITS;

const STAMP_BITS: u32 = 13;

/// The largest number of 24 bits.
const LOW: u32 = (1 << 24) - 1;

impl Counter {
    /// The packet `count` of `epoch`, if it has one: 0 to 2²⁴ − 1.
    #[must_use]
    pub const fn new(epoch: Epoch, count: u32) -> Option<Self> {
        if count <= LOW { Some(Self((epoch.0 as u64) << 24 | count as u64)) } else { None }
    }

    /// This counter, or the one of the same epoch that stamps the time `now` since the sender's boot,
    /// whichever is later; `None` where a count has no room for that time.
    #[must_use]
    pub const fn stamped(self, now: Instant) -> Option<Self> {
        let stamp = now.as_micros() >> STAMP_BITS;
        if stamp <= self.count() as u64 {
            return Some(self);
        }
        if stamp <= LOW as u64 { Self::new(self.epoch(), stamp as u32) } else { None }
    }

    /// Steps of [`STAMP_US`] by which `now` on the receiver's clock is later than the stamp. The two
    /// clocks began at different times, so only differences of such delays have a meaning.
    #[must_use]
    pub const fn delay(self, now: Instant) -> i32 {
        ((now.as_micros() >> STAMP_BITS) as u32).wrapping_sub(self.count()) as i32
    }

    /// The sender's epoch.
    #[must_use]
    pub const fn epoch(self) -> Epoch {
        Epoch((self.0 >> 24) as u32)
    }

    /// The packet's number within its epoch.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0 as u32 & LOW
    }

    /// The counter after this one in the same epoch; `None` when the epoch is used up.
    #[must_use]
    pub const fn next(self) -> Option<Self> {
        Self::new(self.epoch(), self.count() + 1)
    }

    /// The last 16 bits of the count, by which telemetry names the command that was obeyed.
    #[must_use]
    pub const fn low16(self) -> u16 {
        self.0 as u16
    }

    /// The counter's bytes: the count and then the epoch, each in three, the lowest first.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 6] {
        let [b0, b1, b2, b3, b4, b5, ..] = self.0.to_le_bytes();
        [b0, b1, b2, b3, b4, b5]
    }

    /// The counter with these bytes; `None` where their epoch is zero.
    #[must_use]
    pub const fn from_bytes([b0, b1, b2, b3, b4, b5]: [u8; 6]) -> Option<Self> {
        let counter = Self(u64::from_le_bytes([b0, b1, b2, b3, b4, b5, 0, 0]));
        if counter.epoch().0 != 0 { Some(counter) } else { None }
    }
}

/// The first bytes of a packet.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | bits 0–3 | `kind` | 1 beacon, 2 report, 3 command, 4 telemetry, 5 membership, 6 mission | |
/// | 0 | bits 4–7 | `version` | 6 | |
/// | 1 | bits 0–3 | `from` | the sender, 0 the head to 15 | |
/// | 1 | bit 4 | `wave` | 0 outward, 1 inward | |
/// | 1 | bit 5 | `place` | the packet's place in the turn, 0 or 1 | |
/// | 1 | bits 6–7 | `turn` | the sixth part, rounded down, of the number whose turn it is, 0 to 2 | |
/// | 2 | `u24` | `count` | time since the sender's boot in steps of 8.192 ms, or one more than in its last packet | |
/// | 5 | `u24` | `epoch` | number of the sender's boots, from 1 | |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// The kind of message in the body.
    pub kind: Kind,
    /// The sender of this packet, which may pass on a message that another node wrote.
    pub from: NodeId,
    /// The turn in which the packet was sent.
    pub wave: Wave,
    /// The packet's place among those of the turn, 0 or 1.
    pub place: u8,
    /// The node whose turn it is: the sender, or a node whose number is [`REUSE`] or twice as many
    /// from the sender's.
    pub owner: NodeId,
    /// The packet's number.
    pub counter: Counter,
}

/// A node may use the turns of the nodes whose numbers are a multiple of this from its own.
pub const REUSE: u8 = 6;

/// The version of all messages.
pub const VERSION: u8 = 6;
const INWARD: u8 = 1 << 4;
const PLACE_SHIFT: u8 = 5;
const LAST_PLACE: u8 = 1;
const TURN_SHIFT: u8 = 6;

impl Header {
    /// The header's bytes. A place above 1 becomes 1.
    #[must_use]
    pub fn encode(&self) -> [u8; HEADER] {
        let wave = match self.wave {
            Wave::Outward => 0,
            Wave::Inward => INWARD,
        };
        let place = self.place.min(LAST_PLACE) << PLACE_SHIFT;
        let [c0, c1, c2, c3, c4, c5] = self.counter.to_bytes();
        let turn = (steps::nearest_name(self.owner) / REUSE) << TURN_SHIFT;
        let sender = steps::nearest_name(self.from) | wave | place | turn;
        [VERSION << 4 | self.kind.code(), sender, c0, c1, c2, c3, c4, c5]
    }

    /// The header of a packet, and the rest of the packet: body and tag.
    ///
    /// # Errors
    /// [`Error`].
    pub fn decode(packet: &[u8]) -> Result<(Self, &[u8]), Error> {
        let &first = packet.first().ok_or(Error::Length(0))?;
        // Before anything else, which a later version may have elsewhere.
        if first >> 4 != VERSION {
            return Err(Error::Version(first >> 4));
        }
        let kind = Kind::from_code(first & 0xF).ok_or(Error::Kind(first & 0xF))?;
        let (header, rest) = packet.split_at_checked(HEADER).ok_or(Error::Length(packet.len()))?;
        let [_, sender, c0, c1, c2, c3, c4, c5] = exactly(header)?;
        let from = sender & 0xF;
        let owner = from % REUSE + REUSE * (sender >> TURN_SHIFT);
        if usize::from(owner) >= NODES {
            return Err(Error::Reserved);
        }
        let header = Self {
            kind,
            from: NodeId(from),
            owner: NodeId(owner),
            wave: if sender & INWARD != 0 { Wave::Inward } else { Wave::Outward },
            place: sender >> PLACE_SHIFT & LAST_PLACE,
            counter: Counter::from_bytes([c0, c1, c2, c3, c4, c5]).ok_or(Error::Reserved)?,
        };
        Ok((header, rest))
    }
}
