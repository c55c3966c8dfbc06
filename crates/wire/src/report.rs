//! What every drone of a chain broadcasts 5 times a second: 19 bytes in one P2P packet.
//!
//! | byte | type | what | unit |
//! |---|---|---|---|
//! | 0 | `u8` | version, 1 | |
//! | 1 | `u8` | who speaks | |
//! | 2 | `u16` | sequence number of the report | |
//! | 4 | bits 0–2 | phase: 0 waiting, 1 transit, 2 linked, 3 base, 4 out | |
//! | | bit 3 | the links at 11 are there | |
//! | | bits 4–6 | order: 0 none, 1 wait, 2 explore, 3 return, 4 land, 5 stop | |
//! | | bit 7 | the chain is called home | |
//! | 5 | `i16` | velocity along the tunnel | mm/s |
//! | 7 | `i32` | way along the tunnel | cm |
//! | 11 | `i16` | weakest link, or zero | ¼ dBm |
//! | 13 | `i16` | strongest link, or zero | ¼ dBm |
//! | 15 | `u16` | sequence number of the order, or zero | |
//! | 17 | `i16` | speed of the order to explore, or zero | mm/s |
//!
//! A number is rounded to the nearest step, and what is beyond the type becomes its largest or
//! smallest value: 32 m/s, 21,000 km, ±8,192 dBm, none of which flies. What is not a number cannot
//! be said: a velocity, a way or a speed becomes zero, and links become none. The steps are a tenth
//! or less of what is measured: the optic flow's noise is centimetres per second and its drift
//! centimetres per metre, the radio chip's signal strength whole decibels.
//!
//! Each report has exactly one encoding; anything else is an error, so that a bit that a later
//! version gives a meaning is not taken for something else by this one.

use core::fmt;

use units::{Dbm, Metres, MetresPerSecond, NodeId};

/// Bytes of a report.
pub const LENGTH: usize = 19;

const VERSION: u8 = 1;

const _: () = assert!(LENGTH <= crate::syslink::MAX_P2P, "a report is one packet");

/// A report, as it is on the air.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Who speaks.
    pub from: NodeId,
    /// Counts the sender's reports, wrapping.
    pub sequence: u16,
    /// Where the sender is in its mission.
    pub phase: Phase,
    /// Its velocity along the tunnel, positive towards the head.
    pub velocity: MetresPerSecond,
    /// Its way along the tunnel since take-off, positive towards the head.
    pub odometer: Metres,
    /// The links from the head down to the sender, where it knows of any.
    pub links: Option<Links>,
    /// The latest order that has reached the sender.
    pub order: Option<Order>,
    /// Somebody in the chain must come home, and so everybody does.
    pub recall: bool,
}

/// Where a drone is in its mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// On the ground at the base, free to be launched.
    Waiting,
    /// In the air, not yet a link of the chain.
    Transit,
    /// A link of the chain.
    Linked,
    /// The operator's end of the chain.
    Base,
    /// On the ground and out of the mission.
    Out,
}

/// The weakest and the strongest of a run of links; the weakest is not the stronger one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Links {
    /// The weakest.
    pub weakest: Dbm,
    /// The strongest.
    pub strongest: Dbm,
}

/// What the operator wants.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Order {
    /// Counts the operator's orders, wrapping.
    pub sequence: u16,
    /// The order.
    pub task: Task,
}

/// What a mission can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Task {
    /// Stay on the ground.
    Wait,
    /// Fly, the head at this speed along the tunnel.
    Explore(MetresPerSecond),
    /// Come home.
    Return,
    /// Land where you are.
    Land,
    /// Stop the motors now.
    Stop,
}

/// Why bytes are no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// Of this version nothing is known.
    Version(u8),
    /// There are this many bytes, not [`LENGTH`].
    Length(usize),
    /// There is no such phase or order.
    Code(u8),
    /// Bits are set that have no meaning here: of a number that is not there.
    Reserved,
    /// The weakest link is stronger than the strongest.
    Links,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version(version) => write!(f, "a report of the unknown version {version}"),
            Self::Length(bytes) => write!(f, "a report of {bytes} bytes, not {LENGTH}"),
            Self::Code(code) => write!(f, "a report with the unknown code {code:#04x}"),
            Self::Reserved => f.write_str("a report with bits set that have no meaning"),
            Self::Links => f.write_str("a report whose weakest link is its strongest"),
        }
    }
}

impl core::error::Error for Error {}

/// Steps of a quantity in one of its unit.
mod steps {
    pub(super) const VELOCITY: f32 = 1000.0;
    pub(super) const WAY: f32 = 100.0;
    pub(super) const POWER: f32 = 4.0;
}

const HAS_LINKS: u8 = 1 << 3;
const ORDER_SHIFT: u8 = 4;
const ORDER_MASK: u8 = 0b111;
const RECALL: u8 = 1 << 7;

impl Report {
    /// The report's bytes.
    #[must_use]
    pub fn encode(&self) -> [u8; LENGTH] {
        let links = self.links.and_then(steps_of_links);
        let (order, order_sequence, speed) = match self.order {
            None => (0, 0, 0),
            Some(order) => {
                let (code, speed) = code_of_task(order.task);
                (code, order.sequence, speed)
            }
        };
        let has_links = if links.is_some() { HAS_LINKS } else { 0 };
        let recall = if self.recall { RECALL } else { 0 };
        let codes = code_of_phase(self.phase) | has_links | (order << ORDER_SHIFT) | recall;
        let (weakest, strongest) = links.unwrap_or((0, 0));

        let [s0, s1] = self.sequence.to_le_bytes();
        let [v0, v1] = short(self.velocity.0 * steps::VELOCITY).to_le_bytes();
        let [o0, o1, o2, o3] = nearest(self.odometer.0 * steps::WAY).to_le_bytes();
        let [w0, w1] = weakest.to_le_bytes();
        let [t0, t1] = strongest.to_le_bytes();
        let [n0, n1] = order_sequence.to_le_bytes();
        let [e0, e1] = speed.to_le_bytes();
        [
            VERSION,
            self.from.0,
            s0,
            s1,
            codes,
            v0,
            v1,
            o0,
            o1,
            o2,
            o3,
            w0,
            w1,
            t0,
            t1,
            n0,
            n1,
            e0,
            e1,
        ]
    }

    /// The report that these bytes are.
    ///
    /// # Errors
    /// [`Error`].
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        match bytes.first() {
            None => return Err(Error::Length(0)),
            Some(&VERSION) => {}
            Some(&other) => return Err(Error::Version(other)),
        }
        let bytes: &[u8; LENGTH] = bytes.try_into().map_err(|_| Error::Length(bytes.len()))?;
        let [_, from, s0, s1, codes, v0, v1, o0, o1, o2, o3, w0, w1, t0, t1, n0, n1, e0, e1] =
            *bytes;
        let links = (i16::from_le_bytes([w0, w1]), i16::from_le_bytes([t0, t1]));
        let order = (u16::from_le_bytes([n0, n1]), i16::from_le_bytes([e0, e1]));
        Ok(Self {
            from: NodeId(from),
            sequence: u16::from_le_bytes([s0, s1]),
            phase: phase(codes)?,
            velocity: speed_of(i16::from_le_bytes([v0, v1])),
            odometer: Metres(i32::from_le_bytes([o0, o1, o2, o3]) as f32 / steps::WAY),
            links: links_of(codes & HAS_LINKS != 0, links)?,
            order: order_of((codes >> ORDER_SHIFT) & ORDER_MASK, order)?,
            recall: codes & RECALL != 0,
        })
    }
}

const fn code_of_phase(phase: Phase) -> u8 {
    match phase {
        Phase::Waiting => 0,
        Phase::Transit => 1,
        Phase::Linked => 2,
        Phase::Base => 3,
        Phase::Out => 4,
    }
}

fn phase(codes: u8) -> Result<Phase, Error> {
    match codes & 0b111 {
        0 => Ok(Phase::Waiting),
        1 => Ok(Phase::Transit),
        2 => Ok(Phase::Linked),
        3 => Ok(Phase::Base),
        4 => Ok(Phase::Out),
        _ => Err(Error::Code(codes)),
    }
}

/// The links in steps; nothing where they contradict each other or are no numbers.
fn steps_of_links(links: Links) -> Option<(i16, i16)> {
    (links.weakest <= links.strongest)
        .then(|| (short(links.weakest.0 * steps::POWER), short(links.strongest.0 * steps::POWER)))
}

fn links_of(there: bool, (weakest, strongest): (i16, i16)) -> Result<Option<Links>, Error> {
    match (there, weakest, strongest) {
        (false, 0, 0) => Ok(None),
        (false, ..) => Err(Error::Reserved),
        (true, ..) if weakest > strongest => Err(Error::Links),
        (true, ..) => Ok(Some(Links {
            weakest: Dbm(f32::from(weakest) / steps::POWER),
            strongest: Dbm(f32::from(strongest) / steps::POWER),
        })),
    }
}

/// A task's code, and the speed that goes with it.
fn code_of_task(task: Task) -> (u8, i16) {
    match task {
        Task::Wait => (1, 0),
        Task::Explore(speed) => (2, short(speed.0 * steps::VELOCITY)),
        Task::Return => (3, 0),
        Task::Land => (4, 0),
        Task::Stop => (5, 0),
    }
}

fn order_of(code: u8, (sequence, speed): (u16, i16)) -> Result<Option<Order>, Error> {
    let task = match code {
        0 if (sequence, speed) == (0, 0) => return Ok(None),
        2 => Task::Explore(speed_of(speed)),
        0..=5 if speed != 0 => return Err(Error::Reserved),
        1 => Task::Wait,
        3 => Task::Return,
        4 => Task::Land,
        5 => Task::Stop,
        0 => return Err(Error::Reserved),
        6.. => return Err(Error::Code(code)),
    };
    Ok(Some(Order { sequence, task }))
}

fn speed_of(steps: i16) -> MetresPerSecond {
    MetresPerSecond(f32::from(steps) / steps::VELOCITY)
}

/// The nearest whole number, ties away from zero. A conversion by `as` saturates, and makes zero of
/// what is not a number.
fn nearest(number: f32) -> i32 {
    (number + if number < 0.0 { -0.5 } else { 0.5 }) as i32
}

fn short(number: f32) -> i16 {
    nearest(number).clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
