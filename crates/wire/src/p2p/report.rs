//! Reports: each node tells five times a second how it flies and how well it hears the others.

use heapless::Vec;
use units::{Dbm, LinkSpan, Metres, MetresPerSecond, NodeId, Phase};

use super::{Error, MAX_BODY, steps};

/// The most other nodes that one report lists.
pub const HEARD: usize = 4;

/// Bytes of a report that lists no node.
const ALONE: usize = 20;
/// Bytes of a [`Heard`].
const ONE: usize = 4;

const _: () = assert!(ALONE + HEARD * ONE <= MAX_BODY, "a report is one packet");

/// A report, in 20 bytes and 4 for each node that it lists.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | bits 0–2 | `phase` | 0 waiting, 1 transit, 2 linked, 3 base, 4 out | |
/// | 0 | bit 3 | `recall` | 1 the chain is called home | |
/// | 0 | bit 4 | `has_links` | 1 bytes 6 to 9 hold links | |
/// | 0 | bit 5 | `has_front` | 1 bytes 10 and 11 hold a link | |
/// | 0 | bit 6 | `has_back` | 1 bytes 12 and 13 hold a link | |
/// | 0 | bit 7 | zero | | |
/// | 1 | `i16` | `velocity` | along the tunnel, towards the head | 1 mm/s |
/// | 3 | `i24` | `odometer` | way along the tunnel since take-off | 1/128 m |
/// | 6 | `i16` | `weakest` | weakest link between the head and the sender, or 0 | 1/4 dBm |
/// | 8 | `i16` | `strongest` | strongest link between the head and the sender, or 0 | 1/4 dBm |
/// | 10 | `i16` | `front` | the sender's link towards the head, or 0 | 1/4 dBm |
/// | 12 | `i16` | `back` | the sender's link towards the base, or 0 | 1/4 dBm |
/// | 14 | `u16` | `front_total` | sum over the links towards the head, or 0 | 1/64 |
/// | 16 | `u8` | `front_links` | number of these links, 1 to 15, 0 none | |
/// | 17 | `u16` | `back_total` | sum over the links towards the base, or 0 | 1/64 |
/// | 19 | `u8` | `back_links` | number of these links, 1 to 15, 0 none | |
/// | 20 | 0 to 4 × 4 bytes | `heard` | the nodes that the sender hears | |
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// The stage of the sender's mission.
    pub phase: Phase,
    /// Whether the whole chain must come home, because one of its drones must.
    pub recall: bool,
    /// The sender's velocity along the tunnel, positive towards the head.
    pub velocity: MetresPerSecond,
    /// The sender's way along the tunnel since take-off, positive towards the head.
    pub odometer: Metres,
    /// The links from the head down to the sender, if it knows of any.
    pub links: Option<LinkSpan>,
    /// The sender's link towards the head, filtered.
    pub front: Option<Dbm>,
    /// The sender's link towards the base, filtered.
    pub back: Option<Dbm>,
    /// Sums over all links on its side of the chain, towards the head and towards the base.
    pub sums: [Option<Sum>; 2],
    /// The nodes that the sender hears, each once.
    pub heard: Vec<Heard, HEARD>,
}

/// A sum over links.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sum {
    /// The sum of the quantity that the policy adds up, 0 to 1023, to 1/64.
    pub total: f32,
    /// The number of links in the sum, 1 to 15.
    pub links: u8,
}

/// The strength with which one other node is heard, in 4 bytes.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `node` | the node that is heard, 0 to 15 | |
/// | 1 | `u8` | `rssi` | strength of its last packet | −1 dBm |
/// | 2 | `u16` | `epoch` | low half of its epoch | |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heard {
    /// The node that is heard.
    pub node: NodeId,
    /// The strength of its last packet, unfiltered.
    pub rssi: Dbm,
    /// The last 16 bits of its epoch.
    pub epoch: u16,
}

/// Steps of each quantity in one of its unit.
mod per {
    pub(super) const VELOCITY: f32 = 1000.0;
    /// A power of two, so that an f32 has every step of the three bytes: 65 km, to 8 mm.
    pub(super) const WAY: f32 = 128.0;
    pub(super) const TOTAL: f32 = 64.0;
}

/// The smallest number of three bytes with a sign.
const LEAST: i32 = -(1 << 23);
const MOST: i32 = (1 << 23) - 1;

/// The most links of a [`Sum`].
const LINKS: u8 = 15;

const PHASE: u8 = 0b111;
const RECALL: u8 = 1 << 3;
const HAS_LINKS: u8 = 1 << 4;
const HAS_FRONT: u8 = 1 << 5;
const HAS_BACK: u8 = 1 << 6;
const ZERO: u8 = 1 << 7;

impl Report {
    pub(super) fn encode(&self) -> Vec<u8, MAX_BODY> {
        let links = self.links.and_then(span_in_steps);
        let front = self.front.and_then(steps::quarters);
        let back = self.back.and_then(steps::quarters);
        let [front_sum, back_sum] = self.sums.map(|sum| sum.map_or([0; 3], Sum::encode));

        let flag = |set, bit| if set { bit } else { 0 };
        let codes = phase_code(self.phase)
            | flag(self.recall, RECALL)
            | flag(links.is_some(), HAS_LINKS)
            | flag(front.is_some(), HAS_FRONT)
            | flag(back.is_some(), HAS_BACK);
        let (weakest, strongest) = links.unwrap_or_default();
        let way = steps::within(self.odometer.0 * per::WAY, LEAST, MOST);

        let [v0, v1] = steps::short(self.velocity.0 * per::VELOCITY).to_le_bytes();
        let [o0, o1, o2, _] = way.to_le_bytes();
        let powers = [weakest, strongest, front.unwrap_or_default(), back.unwrap_or_default()];
        [codes, v0, v1, o0, o1, o2]
            .into_iter()
            .chain(powers.into_iter().flat_map(i16::to_le_bytes))
            .chain(front_sum)
            .chain(back_sum)
            .chain(self.named().flatten())
            .take(MAX_BODY)
            .collect()
    }

    /// The nodes that the sender hears and that can be named on the air, each once.
    fn named(&self) -> impl Iterator<Item = [u8; ONE]> {
        let so_far = |count| self.heard.iter().take(count);
        self.heard.iter().enumerate().filter_map(move |(i, heard)| {
            let new = !so_far(i).any(|other| other.node == heard.node);
            new.then(|| heard.encode()).flatten()
        })
    }

    pub(super) fn decode(body: &[u8]) -> Result<Self, Error> {
        let length = Error::Length(body.len());
        let (alone, heard) = body.split_first_chunk::<ALONE>().ok_or(length)?;
        let (heard, []) = heard.as_chunks::<ONE>() else { return Err(length) };
        if heard.len() > HEARD {
            return Err(length);
        }
        let [codes, v0, v1, o0, o1, o2, w0, w1, s0, s1, f0, f1, b0, b1, sums @ ..] = *alone;
        let [front0, front1, front2, back0, back1, back2] = sums;
        if codes & ZERO != 0 {
            return Err(Error::Reserved);
        }
        let links = (i16::from_le_bytes([w0, w1]), i16::from_le_bytes([s0, s1]));
        Ok(Self {
            phase: phase_of_code(codes & PHASE)?,
            recall: codes & RECALL != 0,
            velocity: MetresPerSecond(f32::from(i16::from_le_bytes([v0, v1])) / per::VELOCITY),
            // The shift extends the sign.
            odometer: Metres((i32::from_le_bytes([0, o0, o1, o2]) >> 8) as f32 / per::WAY),
            links: span_of_steps(codes & HAS_LINKS != 0, links)?,
            front: power(codes & HAS_FRONT != 0, i16::from_le_bytes([f0, f1]))?,
            back: power(codes & HAS_BACK != 0, i16::from_le_bytes([b0, b1]))?,
            sums: [Sum::decode([front0, front1, front2])?, Sum::decode([back0, back1, back2])?],
            heard: all(heard)?,
        })
    }
}

/// The entries; an error where a node is listed twice.
fn all(entries: &[[u8; ONE]]) -> Result<Vec<Heard, HEARD>, Error> {
    let mut all = Vec::new();
    for entry in entries {
        let heard = Heard::decode(*entry)?;
        if all.iter().any(|other: &Heard| other.node == heard.node) {
            return Err(Error::Reserved);
        }
        all.push(heard).map_err(|_| Error::Length(entries.len()))?;
    }
    Ok(all)
}

fn power(there: bool, steps: i16) -> Result<Option<Dbm>, Error> {
    match (there, steps) {
        (true, steps) => Ok(Some(steps::of_quarters(steps))),
        (false, 0) => Ok(None),
        (false, _) => Err(Error::Reserved),
    }
}

const fn phase_code(phase: Phase) -> u8 {
    match phase {
        Phase::Waiting => 0,
        Phase::Transit => 1,
        Phase::Linked => 2,
        Phase::Base => 3,
        Phase::Out => 4,
    }
}

const fn phase_of_code(code: u8) -> Result<Phase, Error> {
    match code {
        0 => Ok(Phase::Waiting),
        1 => Ok(Phase::Transit),
        2 => Ok(Phase::Linked),
        3 => Ok(Phase::Base),
        4 => Ok(Phase::Out),
        _ => Err(Error::Code(code)),
    }
}

/// The span in steps, unless its ends contradict each other or are NaN.
fn span_in_steps(span: LinkSpan) -> Option<(i16, i16)> {
    if span.weakest > span.strongest {
        return None;
    }
    Some((steps::quarters(span.weakest)?, steps::quarters(span.strongest)?))
}

fn span_of_steps(there: bool, (weakest, strongest): (i16, i16)) -> Result<Option<LinkSpan>, Error> {
    match (there, weakest, strongest) {
        (false, 0, 0) => Ok(None),
        (true, ..) if weakest <= strongest => Ok(Some(LinkSpan {
            weakest: steps::of_quarters(weakest),
            strongest: steps::of_quarters(strongest),
        })),
        _ => Err(Error::Reserved),
    }
}

impl Sum {
    /// The sum's bytes: zeros where the total is NaN or there are no links.
    fn encode(self) -> [u8; 3] {
        match (steps::number(self.total), self.links.min(LINKS)) {
            (None, _) | (_, 0) => [0; 3],
            (Some(total), links) => {
                let total = steps::within(total * per::TOTAL, 0, u16::MAX.into()) as u16;
                let [t0, t1] = total.to_le_bytes();
                [t0, t1, links]
            }
        }
    }

    fn decode([t0, t1, links]: [u8; 3]) -> Result<Option<Self>, Error> {
        match (u16::from_le_bytes([t0, t1]), links) {
            (0, 0) => Ok(None),
            (total, 1..=LINKS) => Ok(Some(Self { total: f32::from(total) / per::TOTAL, links })),
            _ => Err(Error::Reserved),
        }
    }
}

impl Heard {
    fn encode(&self) -> Option<[u8; ONE]> {
        let [e0, e1] = self.epoch.to_le_bytes();
        steps::name(self.node).map(|name| [name, steps::weakness(self.rssi), e0, e1])
    }

    fn decode([name, rssi, e0, e1]: [u8; ONE]) -> Result<Self, Error> {
        Ok(Self {
            node: steps::of_name(name)?,
            rssi: steps::of_weakness(rssi),
            epoch: u16::from_le_bytes([e0, e1]),
        })
    }
}
