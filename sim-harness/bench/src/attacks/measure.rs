//! Whole missions at flight level beside which an attacker sends. The attacker has radios with the
//! vendor's firmware and has recorded every packet from the beginning, but has no key. The mission
//! is `relay-pair`, flown longer: a head that explores, its relay, and the base.

use agent::{ChainDuty, Duty, State};
use input::InputError;
use random::{Purpose, Stream};
use rayon::prelude::*;
use serde_json::{Value, json};
use wire::p2p::{HEADER, MAX_BODY, TAG, VERSION};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;
use world::{SkeletonPlace, World};

use medium::timing;
use mission::{Mission, ROUND_US};
use scenario::{Fidelity, Scenario};

/// The scenario's name.
pub const SCENARIO: &str = "relay-pair";
/// The length of a mission, µs.
const SPAN_US: u64 = 20_000_000;
/// Packets a second of an attack that is no flood: as many as a chain of three sends.
const RATE: u64 = 50;
/// A flood sends this many times the capacity of the channel.
const FLOOD: usize = 10;
/// From this moment on an attacker jams and holds packets back, µs: the chain has formed.
const HOLD_FROM_US: u64 = 10_000_000;
/// The time for which packets are held back that are still taken, µs.
const SHORT_HOLD_US: u64 = 1_000_000;
/// The time for which packets are held back that are refused, µs.
const LONG_HOLD_US: u64 = 5_000_000;
/// The least age of a recording, µs.
const OLD_US: u64 = 2_000_000;
/// The attacker's place halfway between base and relay at the beginning, m.
const NEAR: f32 = 1.0;
/// The attacker's place far beyond the end of the tunnel, m: its packets arrive more than 12 dB
/// weaker than the links of the chain.
const FAR: f32 = 200.0;

/// The number of attacks.
pub const COUNT: usize = Attack::ALL.len();

/// An attack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Attack {
    /// No attack, for comparison.
    None,
    /// Packets of every kind, from every number, with counters to come and random bytes.
    Forged,
    /// Packets that were recorded at least [`OLD_US`] before.
    Replayed,
    /// The last packet, repeated at a random moment after it, before or after the next. A drone that has
    /// missed the original cannot distinguish the copy from it.
    Repeated,
    /// Recorded packets with bytes missing at the end.
    Truncated,
    /// Recorded packets with one to three bits changed.
    BitFlipped,
    /// Recorded packets in another drone's name, with that drone's next numbers.
    WrongSender,
    /// Every packet is jammed at its receivers, and played in its order [`SHORT_HOLD_US`] later.
    HeldShortly,
    /// The same [`LONG_HOLD_US`] later.
    HeldLong,
    /// Forged packets of ten radios in the middle of the chain that send without a pause.
    Flood,
    /// The same from a place where they are much weaker than the links of the chain.
    FloodFromAfar,
}

impl Attack {
    const ALL: [Self; 11] = [
        Self::None,
        Self::Forged,
        Self::Replayed,
        Self::Repeated,
        Self::Truncated,
        Self::BitFlipped,
        Self::WrongSender,
        Self::HeldShortly,
        Self::HeldLong,
        Self::Flood,
        Self::FloodFromAfar,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Forged => "forged",
            Self::Replayed => "replayed",
            Self::Repeated => "repeated a while later",
            Self::Truncated => "truncated",
            Self::BitFlipped => "bit-flipped",
            Self::WrongSender => "wrong sender",
            Self::HeldShortly => "jam and hold, 1 s",
            Self::HeldLong => "jam and hold, 5 s",
            Self::Flood => "flood, 10 times the air, in the middle",
            Self::FloodFromAfar => "flood, 10 times the air, from afar",
        }
    }

    /// Whether no packet of the attack may be accepted. A lost packet that is repeated in order
    /// cannot be distinguished from the original, and one that was held back for a while still says
    /// what it said.
    const fn is_refused(self) -> bool {
        !matches!(self, Self::Repeated | Self::HeldShortly)
    }

    /// How long packets are held back, µs.
    const fn hold_us(self) -> Option<u64> {
        match self {
            Self::HeldShortly => Some(SHORT_HOLD_US),
            Self::HeldLong => Some(LONG_HOLD_US),
            _ => None,
        }
    }

    const fn radios(self) -> usize {
        match self {
            Self::Flood | Self::FloodFromAfar => FLOOD,
            _ => 1,
        }
    }

    const fn place(self) -> f32 {
        match self {
            Self::FloodFromAfar => FAR,
            _ => NEAR,
        }
    }
}

/// The result of one attack.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the attack.
    pub attack: &'static str,
    /// The number of packets that were sent at the chain, in all missions.
    pub packets: u64,
    /// How often a drone accepted one of them.
    pub accepted: u64,
    /// The mean error of the drones' filtered links from the tenth second on, dB.
    pub link_error_db: f32,
    /// How far a relay was from its place in the same mission without an attack, m: the greatest,
    /// from the tenth second on.
    pub displaced_m: f32,
    /// The effect on the chain, and in how many of the missions.
    pub effect: String,
}

impl Row {
    /// The result as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let round = |value: f32| (f64::from(value) * 1e2).round() / 1e2;
        json!({
            "attack": self.attack,
            "packets": self.packets,
            "accepted": self.accepted,
            "link_error_db": round(self.link_error_db),
            "displaced_m": round(self.displaced_m),
            "effect": self.effect,
        })
    }
}

/// Flies every attack on `runs` missions, with seeds from `seed` on.
///
/// # Errors
/// [`InputError`] if the built-in scenario cannot be read.
pub fn run(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Result<Vec<Row>, InputError> {
    let mut scenario = Scenario::open(SCENARIO)?.at(Fidelity::Flight);
    scenario.duration_us = SPAN_US;
    let world = scenario.world();
    let fly_all = |attack| -> Vec<End> {
        (0..runs as u64)
            .map(|n| {
                let end = fly(&scenario, &world, attack, seed.wrapping_add(n));
                after_each();
                end
            })
            .collect()
    };
    let all: Vec<_> = Attack::ALL.into_par_iter().map(|attack| (attack, fly_all(attack))).collect();
    let undisturbed = all.iter().find(|(attack, _)| *attack == Attack::None);
    let undisturbed = undisturbed.map_or(&[][..], |(_, ends)| ends);
    Ok(all.iter().map(|(attack, ends)| row(*attack, ends, undisturbed)).collect())
}

/// The attacks of which packets were accepted that should not have been.
#[must_use]
pub fn missed(rows: &[Row]) -> Vec<String> {
    let taken = |row: &&Row| row.accepted > 0;
    let refused = |row: &&Row| {
        Attack::ALL.iter().any(|attack| attack.name() == row.attack && attack.is_refused())
    };
    rows.iter()
        .filter(taken)
        .filter(refused)
        .map(|row| format!("{}: {} packets were taken for the chain's", row.attack, row.accepted))
        .collect()
}

/// How one mission ended.
struct End {
    packets: u64,
    accepted: u64,
    /// Whether head and relay fly their duties, and hear each other and the base.
    holds: bool,
    /// Orders that reached the head.
    orders: u32,
    /// How long each drone was without the neighbours that it had, s.
    deaf_s: f32,
    states: Vec<&'static str>,
    /// The mean error of the filtered links, dB.
    link_error_db: f32,
    /// The ways of the relays in each round from [`HOLD_FROM_US`] on.
    ways: Vec<f32>,
}

fn row(attack: Attack, ends: &[End], undisturbed: &[End]) -> Row {
    let holds = ends.iter().filter(|end| end.holds).count();
    let orders: u32 = ends.iter().map(|end| end.orders).sum();
    let mean_orders = f64::from(orders) / ends.len().max(1) as f64;
    let deaf_s = ends.iter().map(|end| end.deaf_s).fold(0.0, f32::max);
    let mut effect = format!(
        "chain holds in {holds} of {}; {mean_orders:.0} orders reach the head; a link missed for \
         {deaf_s:.1} s at most",
        ends.len()
    );
    if let Some(end) = ends.iter().find(|end| !end.holds) {
        effect += &format!("; else it ends {}", end.states.join(", "));
    }
    let pairs = ends.iter().zip(undisturbed);
    let ways = pairs.flat_map(|(end, calm)| end.ways.iter().zip(&calm.ways));
    Row {
        attack: attack.name(),
        link_error_db: mean(ends.iter().map(|end| end.link_error_db)),
        displaced_m: ways.map(|(is, was)| (is - was).abs()).fold(0.0, f32::max),
        packets: ends.iter().map(|end| end.packets).sum(),
        accepted: ends.iter().map(|end| end.accepted).sum(),
        effect,
    }
}

fn fly(scenario: &Scenario, world: &World, attack: Attack, seed: u64) -> End {
    let places = vec![SkeletonPlace::main(attack.place()); attack.radios()];
    let mut mission = Mission::besieged(scenario, world, seed, &places);
    let mut random = Stream::new(seed, Purpose::Intruder);
    let mut missed = vec![0_u32; mission.count()];
    let (mut errors, mut ways) = (Vec::new(), Vec::new());
    while !mission.is_over() {
        attack_for_a_round(&mut mission, attack, &mut random);
        mission.round();
        for (n, missed) in missed.iter_mut().enumerate() {
            *missed += u32::from(!has_neighbours(&mission, n));
        }
        if mission.time_us() > HOLD_FROM_US {
            errors.extend(link_errors(&mut mission));
            ways.extend(mission.ways().skip(1).take(mission.count() - 2));
        }
    }
    let states: Vec<_> = mission.states().collect();
    let flies = |n: usize, state: &State| match state {
        State::OnMission(Duty::Chain(ChainDuty::Leading { .. })) => n == 0,
        State::OnMission(Duty::Chain(ChainDuty::Relaying { .. })) => n > 0,
        _ => false,
    };
    let drones = states.len() - 1;
    let at_work = states.iter().enumerate().take(drones).all(|(n, state)| flies(n, state));
    let hear = (0..mission.count()).all(|n| has_neighbours(&mission, n));
    End {
        packets: mission.intruded(),
        accepted: mission.accepted(),
        holds: at_work && hear,
        orders: mission.radio().orders,
        deaf_s: missed.iter().max().map_or(0.0, |&n| n as f32 * ROUND_US as f32 * 1e-6),
        states: states.iter().map(|state| state.name()).collect(),
        link_error_db: mean(errors.into_iter()),
        ways,
    }
}

/// The mean of these values, or 0 where there are none.
pub(super) fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { 0.0 } else { sum / count as f32 }
}

/// How far each filtered link of the members is from the link's strength, dB.
pub(super) fn link_errors(mission: &mut Mission<'_>) -> Vec<f32> {
    let links: Vec<_> = (0..mission.count())
        .filter_map(|n| Some((n, mission.view(n)?.outputs?.status)))
        .flat_map(|(n, status)| [status.front, status.back].map(|link| (n, link)))
        .filter_map(|(n, link)| link.map(|link| (n, usize::from(link.peer.0), link.rssi)))
        .collect();
    let base = mission.count() - 1;
    let station = |node: usize| if node >= base { base } else { node };
    let error = |(n, peer, rssi): (usize, usize, units::Dbm)| {
        (rssi - mission.strength(station(peer), n)).0.abs()
    };
    links.into_iter().map(error).collect()
}

/// Whether a member hears its neighbours: the head the one behind, the base the one in front, a
/// relay both.
pub(super) fn has_neighbours(mission: &Mission<'_>, n: usize) -> bool {
    let Some(status) = mission.view(n).and_then(|view| view.outputs).map(|out| out.status) else {
        return false;
    };
    let front = n == 0 || status.front.is_some();
    let back = n + 1 == mission.count() || status.back.is_some();
    front && back
}

/// Sends the packets of the coming round.
fn attack_for_a_round(mission: &mut Mission<'_>, attack: Attack, random: &mut Stream) {
    match attack {
        Attack::None => {}
        Attack::HeldShortly | Attack::HeldLong => {
            mission.jam_and_listen(mission.time_us() >= HOLD_FROM_US);
            play_later(mission, attack.hold_us().unwrap_or_default(), HOLD_FROM_US);
        }
        Attack::Flood | Attack::FloodFromAfar => {
            let each_us = timing::air_us(Datarate::Mbit2, MAX_P2P);
            for radio in 0..FLOOD {
                // Out of step with each other, as ten real radios would be.
                let mut at_us = random.below(each_us as u32).into();
                while at_us < ROUND_US {
                    mission.intrude(radio, at_us, &forged(mission.count(), random));
                    at_us += each_us;
                }
            }
        }
        _ => {
            for _ in 0..RATE * ROUND_US / 1_000_000 {
                let Some(packet) = made(mission, attack, random) else { continue };
                mission.intrude(0, random.below(ROUND_US as u32).into(), &packet);
            }
        }
    }
}

/// Sends what was overheard `hold_us` before the coming round, but not before `from_us`.
fn play_later(mission: &mut Mission<'_>, hold_us: u64, from_us: u64) {
    let now_us = mission.time_us();
    let due_us = now_us.saturating_sub(hold_us).max(from_us);
    let until_us = (now_us + ROUND_US).saturating_sub(hold_us);
    let due = mission.overheard().filter(|heard| (due_us..until_us).contains(&heard.at_us));
    let due: Vec<_> = due.map(|heard| (heard.at_us, heard.data.clone())).collect();
    for (at_us, data) in due {
        mission.intrude(0, at_us + hold_us - now_us, &data);
    }
}

/// One packet of an attack; none while there is nothing to make it from.
fn made(mission: &Mission<'_>, attack: Attack, random: &mut Stream) -> Option<Vec<u8>> {
    if attack == Attack::Forged {
        return Some(forged(mission.count(), random));
    }
    let old_us = mission.time_us().saturating_sub(OLD_US);
    let known = match attack {
        Attack::Replayed => mission.overheard().take_while(|heard| heard.at_us < old_us).count(),
        _ => mission.overheard().len(),
    };
    // Half of the packets repeat the newest, half of them any.
    let which = match random.below(2) {
        _ if attack == Attack::Repeated => known.checked_sub(1)?,
        0 => known.checked_sub(1)?,
        _ => random.below(u32::try_from(known).ok().filter(|&n| n > 0)?) as usize,
    };
    let mut packet = mission.overheard().nth(which)?.data.clone();
    match attack {
        Attack::Truncated => packet.truncate(random.below(packet.len() as u32) as usize),
        Attack::BitFlipped => {
            // One to three, next to each other, so that none is changed back.
            let (first, count) = (random.below(8 * packet.len() as u32 - 2), 1 + random.below(3));
            for bit in first..first + count {
                packet[bit as usize / 8] ^= 1 << (bit % 8);
            }
        }
        Attack::WrongSender => {
            let from = random.below(mission.count() as u32) as u8;
            packet[1] = (packet[1] & 0xF0) | from;
            let count = u32::from_le_bytes([packet[2], packet[3], packet[4], 0]);
            let later = (count + 1 + random.below(100)).to_le_bytes();
            packet[2..5].copy_from_slice(&later[..3]);
        }
        _ => {}
    }
    Some(packet)
}

/// A packet with a valid header and random bytes after it.
fn forged(members: usize, random: &mut Stream) -> Vec<u8> {
    let kind = 1 + random.below(5) as u8;
    let from = random.below(members as u32) as u8;
    let length = HEADER + 1 + random.below(MAX_BODY as u32) as usize + TAG;
    let mut packet: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
    packet[0] = VERSION << 4 | kind;
    packet[1] = from | ((random.below(2) as u8) << 4);
    // An epoch that the node may well have.
    packet[6] &= 0x0F;
    packet[7] = 0;
    packet
}
