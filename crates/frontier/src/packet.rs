//! The packets that robots exchange: at most 43 bytes each, which a drone's mission message has room
//! for, little-endian.
//!
//! | bytes | field |
//! |---|---|
//! | 0 | kind in bits 7 and 6; the number of the robot that made the packet in the others |
//! | 1 | the number of the robot that sends it, which differs where it forwards it |
//! | 2 | sequence number, which counts up with each packet that the maker makes |
//! | 3.. | the body |
//!
//! | kind | body |
//! |---|---|
//! | 0 status | x and y in centimetres (`i16` each), goal (3), version of its marks (`u16`), then 3 for each robot it knows: number, with bit 7 where it hears that robot itself, and the version that it has of that robot's marks (`u16`) |
//! | 1 changes | versions before and after (`u16` each), then 3 for each tile |
//! | 2 bids | 5 for each bid: tile (3) and distance in centimetres (`u16`) |
//! | 3 orders | 4 for each order: the robot's number and the tile (3) |
//!
//! A tile takes three bytes: the column in bits 0 to 9, the row in bits 10 to 19, and in bits 20 to
//! 23 what the packet says of it: the mark, the robot's activity, or what is ordered.

use heapless::Vec;
use units::{Metres, Payload, Point2};

use crate::cluster::MOST_ROBOTS;
use crate::tile::{Gain, Mark, Tile};

/// The most bytes of a packet.
pub const MOST_BYTES: usize = Payload::MOST;
/// The most tiles of a packet of changes.
pub const MOST_CHANGES: usize = 12;
/// The most bids of a packet.
pub const MOST_BIDS: usize = 8;
/// The most orders of a packet.
pub const MOST_ORDERS: usize = 10;
/// The most robots of which a status speaks.
pub const MOST_KNOWN: usize = 10;

const HEADER: usize = 3;
const KIND_SHIFT: u8 = 6;
const IS_DIRECT: u8 = 0x80;
const COORDINATE_BITS: u32 = 10;
const COORDINATE_MASK: u32 = (1 << COORDINATE_BITS) - 1;
const CENTIMETRES: f32 = 100.0;

/// A packet.
#[derive(Clone, Debug, PartialEq)]
pub struct Packet {
    /// The robot that made the packet.
    pub origin: u8,
    /// The robot that sends it.
    pub sender: u8,
    /// The sequence number.
    pub sequence: u8,
    /// What it says.
    pub body: Body,
}

/// What a packet says.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// Where the robot is and what it does.
    Status(Status),
    /// Marks that have changed.
    Changes(Changes),
    /// The candidates that the robot would go to, by its own map.
    Bids(Vec<Bid, MOST_BIDS>),
    /// The leader's orders.
    Orders(Vec<Order, MOST_ORDERS>),
}

/// What a robot does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Activity {
    /// It waits for a goal.
    #[default]
    Waiting,
    /// It is on its way.
    Going,
    /// It can reach none of the candidates that it knows.
    Idle,
    /// It has stopped for good.
    Stopped,
}

/// A robot's status.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// The robot's place, to the centimetre; what is beyond ±327 m is told as that.
    pub position: Point2,
    /// What it does.
    pub activity: Activity,
    /// Its goal, or its last one.
    pub goal: Tile,
    /// The version of its marks.
    pub version: u16,
    /// The robots that it knows.
    pub known: Vec<Known, MOST_KNOWN>,
}

/// What a robot has of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Known {
    /// The other's number.
    pub robot: u8,
    /// Whether it hears the other itself, and not through a third.
    pub is_direct: bool,
    /// The version that it has of the other's marks.
    pub version: u16,
}

/// Marks of one robot that have changed from one version to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Changes {
    /// The version before.
    pub base: u16,
    /// The version after.
    pub upto: u16,
    /// The marks that changed between.
    pub marks: Vec<(Tile, Mark), MOST_CHANGES>,
}

/// A candidate with the length of the robot's way there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bid {
    /// The tile.
    pub tile: Tile,
    /// Its gain.
    pub gain: Gain,
    /// The length, to the centimetre, at most 655 m.
    pub distance: Metres,
}

/// What the leader orders one robot to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// The robot's number.
    pub robot: u8,
    /// What it is to do.
    pub task: Task,
}

/// What a robot is ordered to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// It goes to a tile.
    Go(Tile),
    /// It stops for good.
    Stop,
}

/// Bytes that are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// The length is none that a packet of its kind can have.
    Length,
    /// The number of a robot is not below [`MOST_ROBOTS`], or has a bit set that must be clear.
    Robot,
    /// What the packet says of a tile has no meaning in a packet of its kind.
    Code,
    /// The version after changes is not above the one before.
    Version,
}

impl Packet {
    /// The packet's bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8, MOST_BYTES> {
        let mut to = Writer(Vec::new());
        let kind: u8 = match &self.body {
            Body::Status(_) => 0,
            Body::Changes(_) => 1,
            Body::Bids(_) => 2,
            Body::Orders(_) => 3,
        };
        to.put(&[kind << KIND_SHIFT | self.origin, self.sender, self.sequence]);
        match &self.body {
            Body::Status(status) => to.status(status),
            Body::Changes(changes) => {
                to.put(&changes.base.to_le_bytes());
                to.put(&changes.upto.to_le_bytes());
                changes.marks.iter().for_each(|(tile, mark)| to.tile(*tile, mark.code()));
            }
            Body::Bids(bids) => {
                for bid in bids {
                    to.tile(bid.tile, Mark::Frontier(bid.gain).code());
                    to.put(&((bid.distance.0 * CENTIMETRES + 0.5) as u16).to_le_bytes());
                }
            }
            Body::Orders(orders) => {
                for order in orders {
                    to.put(&[order.robot]);
                    match order.task {
                        Task::Go(tile) => to.tile(tile, 0),
                        Task::Stop => to.tile(Tile::default(), 1),
                    }
                }
            }
        }
        to.0
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// [`PacketError`] says what is wrong with the bytes.
    pub fn decode(bytes: &[u8]) -> Result<Self, PacketError> {
        let (header, body) = bytes.split_first_chunk::<HEADER>().ok_or(PacketError::Length)?;
        if bytes.len() > MOST_BYTES {
            return Err(PacketError::Length);
        }
        let [first, sender, sequence] = *header;
        let body = match first >> KIND_SHIFT {
            0 => Body::Status(status(body)?),
            1 => Body::Changes(changes(body)?),
            2 => Body::Bids(each(body, bid)?),
            _ => Body::Orders(each(body, order)?),
        };
        let origin = first & !(0b11 << KIND_SHIFT);
        Ok(Self { origin, sender: robot(sender)?, sequence, body })
    }
}

/// Writes into a packet, which has room for the largest body of each kind.
struct Writer(Vec<u8, MOST_BYTES>);

impl Writer {
    fn put(&mut self, bytes: &[u8]) {
        let _ = self.0.extend_from_slice(bytes);
    }

    fn tile(&mut self, tile: Tile, code: u8) {
        let row = u32::from(tile.row()) << COORDINATE_BITS;
        let packed = u32::from(tile.column()) | row | u32::from(code) << (2 * COORDINATE_BITS);
        let [a, b, c, _] = packed.to_le_bytes();
        self.put(&[a, b, c]);
    }

    fn status(&mut self, status: &Status) {
        // The conversion clamps.
        let centimetres = |metres: f32| libm::roundf(metres * CENTIMETRES) as i16;
        self.put(&centimetres(status.position.x).to_le_bytes());
        self.put(&centimetres(status.position.y).to_le_bytes());
        let activity = match status.activity {
            Activity::Waiting => 0,
            Activity::Going => 1,
            Activity::Idle => 2,
            Activity::Stopped => 3,
        };
        self.tile(status.goal, activity);
        self.put(&status.version.to_le_bytes());
        for known in &status.known {
            let [low, high] = known.version.to_le_bytes();
            self.put(&[if known.is_direct { IS_DIRECT } else { 0 } | known.robot, low, high]);
        }
    }
}

fn robot(number: u8) -> Result<u8, PacketError> {
    if usize::from(number) < MOST_ROBOTS { Ok(number) } else { Err(PacketError::Robot) }
}

fn tile(&[a, b, c]: &[u8; 3]) -> Result<(Tile, u8), PacketError> {
    let packed = u32::from_le_bytes([a, b, c, 0]);
    let at = |shift: u32| (packed >> shift & COORDINATE_MASK) as u16;
    let tile = Tile::new(at(0), at(COORDINATE_BITS)).ok_or(PacketError::Code)?;
    Ok((tile, (packed >> (2 * COORDINATE_BITS)) as u8))
}

/// Reads a body of items of `LENGTH` bytes each.
fn each<T, const LENGTH: usize, const MOST: usize>(
    bytes: &[u8],
    item: impl Fn(&[u8; LENGTH]) -> Result<T, PacketError>,
) -> Result<Vec<T, MOST>, PacketError> {
    let (items, []) = bytes.as_chunks::<LENGTH>() else { return Err(PacketError::Length) };
    let mut all = Vec::new();
    for bytes in items {
        all.push(item(bytes)?).map_err(|_| PacketError::Length)?;
    }
    Ok(all)
}

fn status(bytes: &[u8]) -> Result<Status, PacketError> {
    let (&[a, b, c, d, t, u, v, low, high], rest) =
        bytes.split_first_chunk::<9>().ok_or(PacketError::Length)?;
    let metres = |low, high| f32::from(i16::from_le_bytes([low, high])) / CENTIMETRES;
    let (goal, activity) = tile(&[t, u, v])?;
    let activity = match activity {
        0 => Activity::Waiting,
        1 => Activity::Going,
        2 => Activity::Idle,
        3 => Activity::Stopped,
        _ => return Err(PacketError::Code),
    };
    let known = each(rest, |&[first, low, high]: &[u8; 3]| {
        let version = u16::from_le_bytes([low, high]);
        let is_direct = first & IS_DIRECT != 0;
        Ok(Known { robot: robot(first & !IS_DIRECT)?, is_direct, version })
    })?;
    let position = Point2::new(metres(a, b), metres(c, d));
    Ok(Status { position, activity, goal, version: u16::from_le_bytes([low, high]), known })
}

fn changes(bytes: &[u8]) -> Result<Changes, PacketError> {
    let (&[a, b, c, d], rest) = bytes.split_first_chunk::<4>().ok_or(PacketError::Length)?;
    let (base, upto) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    if upto <= base {
        return Err(PacketError::Version);
    }
    let mark = |bytes: &[u8; 3]| {
        let (tile, code) = tile(bytes)?;
        Ok((tile, Mark::of_code(code).ok_or(PacketError::Code)?))
    };
    Ok(Changes { base, upto, marks: each(rest, mark)? })
}

fn bid(&[a, b, c, low, high]: &[u8; 5]) -> Result<Bid, PacketError> {
    let (tile, code) = tile(&[a, b, c])?;
    let Some(Mark::Frontier(gain)) = Mark::of_code(code) else { return Err(PacketError::Code) };
    let distance = Metres(f32::from(u16::from_le_bytes([low, high])) / CENTIMETRES);
    Ok(Bid { tile, gain, distance })
}

fn order(&[number, a, b, c]: &[u8; 4]) -> Result<Order, PacketError> {
    let (tile, code) = tile(&[a, b, c])?;
    let task = match code {
        0 => Task::Go(tile),
        1 if tile == Tile::default() => Task::Stop,
        _ => return Err(PacketError::Code),
    };
    Ok(Order { robot: robot(number)?, task })
}
