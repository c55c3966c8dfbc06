//! Reports: each node tells five times a second how it flies and how well it hears the others.

use heapless::Vec;
use units::{
    Dbm, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond, NodeId, Phase, Signpost,
};

use super::signpost::{SIGNPOST, decode_signpost, encode_signpost};
use super::{Epoch, Error, MAX_BODY, fill, steps};

/// The most other nodes that one report lists.
pub const HEARD: usize = 4;

/// Bytes of a report that lists no node.
const ALONE: usize = 20;
/// Bytes of a [`Heard`].
const ONE: usize = 5;

const _: () = assert!(ALONE + SIGNPOST + HEARD * ONE <= MAX_BODY, "a report is one packet");

/// A report, in 20 bytes, 4 for a [`Signpost`] and 5 for each node that it lists.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | bits 0–2 | `phase` | 0 waiting, 1 transit, 2 linked, 3 base, 4 out, 5 searching, 6 perched, 7 linked and `is_uneven` | |
/// | 0 | bit 3 | `recall` | 1 the chain is called home | |
/// | 0 | bit 4 | `calls` | 1 the head calls for a relay | |
/// | 0 | bits 5–6 | `waiting` | relays that wait on the ground or climb, 3 for more | |
/// | 0 | bit 7 | `has_signpost` | 1 bytes 20 to 23 are a signpost | |
/// | 1 | `i16` | `velocity` | along the tunnel, towards the head | 1 mm/s |
/// | 3 | `i24` | `odometer` | way along the tunnel since take-off | 1/512 m |
/// | 6 | `i16` | `weakest` | weakest link between the head and the sender; both 0 for none | 1/4 dBm |
/// | 8 | `i16` | `strongest` | strongest link between the head and the sender; both 0 for none | 1/4 dBm |
/// | 10 | `i16` | `front_surplus` | surplus of the links towards the head; of a head, the way by which the chain is too short | 1/16 m |
/// | 12 | `u16` | `front_compliance` | compliance of the links towards the head, or 0 | 1/1024 m/dB |
/// | 14 | `i16` | `back_surplus` | surplus of the links towards the base, or 0 | 1/16 m |
/// | 16 | `u16` | `back_compliance` | compliance of the links towards the base, or 0 | 1/1024 m/dB |
/// | 18 | bits 0–3 | `front_links` | number of the links in the sum towards the head | |
/// | 18 | bits 4–7 | `back_links` | number of the links in the sum towards the base | |
/// | 19 | `i8` | `head_velocity` | of the head along the tunnel, away from the base | 4 mm/s |
/// | 20 | 0 to 24 bytes | `entries` | a signpost where there is one, then the nodes that the sender hears | |
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// The stage of the sender's mission.
    pub phase: Phase,
    /// Whether the whole chain must come home, because one of its drones must.
    pub recall: bool,
    /// Whether the head calls for a relay: its links leave it less speed than the pilot asks for.
    pub calls: bool,
    /// Whether the signal does not fall evenly along the tunnel, by what the drones from the head to
    /// the sender have measured. Only a sender that is a link of the chain says so on the air.
    pub is_uneven: bool,
    /// The sender's velocity along the tunnel, positive towards the head.
    pub velocity: MetresPerSecond,
    /// The sender's way along the tunnel since take-off, positive towards the head.
    pub odometer: Metres,
    /// The links from the head down to the sender, if it knows of any. A single link of 0 dBm, to a
    /// quarter, counts as none on the air.
    pub links: Option<LinkSpan>,
    /// The sums over all links between the sender and the head, and between the sender and the
    /// base.
    pub sums: [LinkSum; 2],
    /// The number of relays that wait on the ground or climb, as far as the sender knows; 3 stands for more
    /// as well.
    pub waiting: u8,
    /// The head's velocity along the tunnel, positive away from the base, as the head reported it.
    pub head_velocity: MetresPerSecond,
    /// One entry of the list of the pilot's choices, another in each report; `None` where the sender
    /// knows of no choice. An entry that contradicts itself is left out on the air.
    pub signpost: Option<Signpost>,
    /// The nodes that the sender hears, each once.
    pub heard: Vec<Heard, HEARD>,
}

/// The strength with which one other node is heard, in 5 bytes.
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | bits 0–3 | `node` | the node that is heard, 0 to 15 | |
/// | 0 | bits 4–6 | zero | | |
/// | 0 | bit 7 | `is_new` | 1 a packet of the node has come since the sender's last report | |
/// | 1 | `u8` | `rssi` | strength of its last packet | −1 dBm |
/// | 2 | `u24` | `epoch` | its epoch | |
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heard {
    /// The node that is heard.
    pub node: NodeId,
    /// The strength of its last packet, unfiltered.
    pub rssi: Dbm,
    /// Whether a packet of it has come since the sender's last report.
    pub is_new: bool,
    /// Its epoch.
    pub epoch: Epoch,
}

/// Steps of each quantity in one of its unit.
mod per {
    pub(super) const VELOCITY: f32 = 1000.0;
    /// A power of two, so that an f32 has every step of the three bytes: 16 km, to 2 mm.
    pub(super) const WAY: f32 = 512.0;
    pub(super) const SURPLUS: f32 = 16.0;
    pub(super) const COMPLIANCE: f32 = 1024.0;
    pub(super) const HEAD_VELOCITY: f32 = 250.0;
}

/// The smallest number of three bytes with a sign.
const LEAST: i32 = -(1 << 23);
const MOST: i32 = (1 << 23) - 1;

/// The most links of a sum.
const LINKS: u8 = 15;

const PHASE: u8 = 0b111;
const LINKED_UNEVEN: u8 = 7;
const RECALL: u8 = 1 << 3;
const CALLS: u8 = 1 << 4;
const WAITING: u8 = 5;
const MOST_WAITING: u8 = 3;
const HAS_SIGNPOST: u8 = 1 << 7;

const NODE: u8 = 0b1111;
const IS_NEW: u8 = 1 << 7;

impl Report {
    pub(super) fn encode(&self, out: &mut [u8; MAX_BODY]) -> usize {
        let links = self.links.and_then(span_in_steps);
        let post = self.signpost.and_then(encode_signpost);
        let flag = |set, bit| if set { bit } else { 0 };
        let phase = match self.phase {
            Phase::Linked if self.is_uneven => LINKED_UNEVEN,
            phase => phase_code(phase),
        };
        let codes = phase
            | flag(self.recall, RECALL)
            | flag(self.calls, CALLS)
            | flag(post.is_some(), HAS_SIGNPOST)
            | self.waiting.min(MOST_WAITING) << WAITING;
        let (weakest, strongest) = links.unwrap_or_default();
        let way = steps::within(self.odometer.0 * per::WAY, LEAST, MOST);
        let head = steps::within(
            self.head_velocity.0 * per::HEAD_VELOCITY,
            i8::MIN.into(),
            i8::MAX.into(),
        ) as i8;

        let [v0, v1] = steps::short(self.velocity.0 * per::VELOCITY).to_le_bytes();
        let [o0, o1, o2, _] = way.to_le_bytes();
        let [(front, front_links), (back, back_links)] = self.sums.map(sum_in_bytes);
        let motion = [codes, v0, v1, o0, o1, o2];
        let span = [weakest, strongest].map(i16::to_le_bytes);
        let ends = [front_links | back_links << 4, head.to_le_bytes()[0]];
        let mut heard: Vec<_, HEARD> = Vec::new();
        // There are no more than fit; collecting them would link a panic.
        self.named().for_each(|one| _ = heard.push(one));
        let heard = heard.as_flattened();
        let post = post.as_ref().map_or(&[][..], |post| post);
        fill(out, [&motion, span.as_flattened(), &front, &back, &ends, post, heard])
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
        let [codes, v0, v1, o0, o1, o2, w0, w1, s0, s1, sums @ ..] = *alone;
        let [f0, f1, f2, f3, b0, b1, b2, b3, counts, head] = sums;
        let (signpost, heard) = if codes & HAS_SIGNPOST != 0 {
            let (post, heard) = heard.split_first_chunk::<SIGNPOST>().ok_or(length)?;
            (Some(decode_signpost(*post)?), heard)
        } else {
            (None, heard)
        };
        let (heard, []) = heard.as_chunks::<ONE>() else { return Err(length) };
        if heard.len() > HEARD {
            return Err(length);
        }
        let links = (i16::from_le_bytes([w0, w1]), i16::from_le_bytes([s0, s1]));
        let head = f32::from(i8::from_le_bytes([head]));
        Ok(Self {
            phase: phase_of_code(codes & PHASE)?,
            is_uneven: codes & PHASE == LINKED_UNEVEN,
            recall: codes & RECALL != 0,
            calls: codes & CALLS != 0,
            velocity: MetresPerSecond(f32::from(i16::from_le_bytes([v0, v1])) / per::VELOCITY),
            // The shift extends the sign.
            odometer: Metres((i32::from_le_bytes([0, o0, o1, o2]) >> 8) as f32 / per::WAY),
            links: span_of_steps(links)?,
            sums: [
                sum_of_bytes([f0, f1, f2, f3], counts & LINKS)?,
                sum_of_bytes([b0, b1, b2, b3], counts >> 4)?,
            ],
            waiting: codes >> WAITING & MOST_WAITING,
            head_velocity: MetresPerSecond(head / per::HEAD_VELOCITY),
            signpost,
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

const fn phase_code(phase: Phase) -> u8 {
    match phase {
        Phase::Waiting => 0,
        Phase::Transit => 1,
        Phase::Linked => 2,
        Phase::Base => 3,
        Phase::Out => 4,
        Phase::Searching => 5,
        Phase::Perched => 6,
    }
}

const fn phase_of_code(code: u8) -> Result<Phase, Error> {
    match code {
        0 => Ok(Phase::Waiting),
        1 => Ok(Phase::Transit),
        2 | LINKED_UNEVEN => Ok(Phase::Linked),
        3 => Ok(Phase::Base),
        4 => Ok(Phase::Out),
        5 => Ok(Phase::Searching),
        6 => Ok(Phase::Perched),
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

fn span_of_steps((weakest, strongest): (i16, i16)) -> Result<Option<LinkSpan>, Error> {
    match (weakest, strongest) {
        (0, 0) => Ok(None),
        _ if weakest <= strongest => Ok(Some(LinkSpan {
            weakest: steps::of_quarters(weakest),
            strongest: steps::of_quarters(strongest),
        })),
        _ => Err(Error::Reserved),
    }
}

/// A sum's bytes and its number of links: zeros where a number is NaN. A sum over no links has no
/// compliance.
fn sum_in_bytes(sum: LinkSum) -> ([u8; 4], u8) {
    let numbers = steps::number(sum.surplus.0).zip(steps::number(sum.compliance.0));
    match (numbers, sum.links.min(LINKS)) {
        (None, _) => ([0; 4], 0),
        (Some((surplus, _)), 0) => {
            let [s0, s1] = steps::short(surplus * per::SURPLUS).to_le_bytes();
            ([s0, s1, 0, 0], 0)
        }
        (Some((surplus, compliance)), links) => {
            let compliance = steps::within(compliance * per::COMPLIANCE, 0, u16::MAX.into());
            let [s0, s1] = steps::short(surplus * per::SURPLUS).to_le_bytes();
            let [c0, c1] = (compliance as u16).to_le_bytes();
            ([s0, s1, c0, c1], links)
        }
    }
}

fn sum_of_bytes([s0, s1, c0, c1]: [u8; 4], links: u8) -> Result<LinkSum, Error> {
    if links == 0 && [c0, c1] != [0; 2] {
        return Err(Error::Reserved);
    }
    Ok(LinkSum {
        surplus: Metres(f32::from(i16::from_le_bytes([s0, s1])) / per::SURPLUS),
        compliance: MetresPerDb(f32::from(u16::from_le_bytes([c0, c1])) / per::COMPLIANCE),
        links,
    })
}

impl Heard {
    fn encode(&self) -> Option<[u8; ONE]> {
        let [e0, e1, e2] = self.epoch.to_bytes();
        let is_new = if self.is_new { IS_NEW } else { 0 };
        steps::name(self.node).map(|name| [name | is_new, steps::weakness(self.rssi), e0, e1, e2])
    }

    fn decode([codes, rssi, e0, e1, e2]: [u8; ONE]) -> Result<Self, Error> {
        if codes & !(NODE | IS_NEW) != 0 {
            return Err(Error::Reserved);
        }
        Ok(Self {
            node: steps::of_name(codes & NODE)?,
            rssi: steps::of_weakness(rssi),
            is_new: codes & IS_NEW != 0,
            epoch: Epoch::from_bytes([e0, e1, e2]).ok_or(Error::Reserved)?,
        })
    }
}
