//! Plans the replay of a log by a whole `onboard::Drone`: which drone runs it, and what the drone is
//! told in each of its rounds.
//!
//! A log has no packets of the chain, so the drone's link stays shut, and the reports come to it as
//! they do from an ideal link: each neighbour is given the simplest report of a link of the chain,
//! and the base that of a base. The drone is in the air, and the order is to explore. The log knows no
//! walls, so the drone is given those of a straight tunnel, in whose middle it flies.
//!
//! **A flight** is run once for each relay, a round for each row. The strengths were filtered on board
//! when they were logged, so the drone does not filter them again.
//!
//! **A log of packets** is run by one relay, number 1, at 5 Hz. The log's first link leads to the head
//! in front of it, the others to the drones behind, the last of which is the base; a single link leads
//! to the base. The relay itself hovers: the rate of separation is that of the other end, which says
//! in its reports how fast and how far it flies.

use agent::{AgentConfig, BodyVelocity};
use chain::neighbours::Heard;
use chain::policy::Policy;
use chain::report::Report;
use onboard::replay::{Begin, HEARD, Step};
use tunnel_nav::{Diagonals, Range};
use units::{Dbm, Duration, Instant, Metres, MetresPerSecond, NODES, NodeId, Order, Phase, Role};

use recordings::recording::{LOST_AFTER, Recording, Sample};

/// One run of a drone: its beginning, and its rounds.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) begin: Begin,
    pub(super) steps: Vec<Step>,
}

/// The order of every round: to explore, with the head at rest.
const ORDER: Order = Order::explore(MetresPerSecond::ZERO);
/// The walls of a straight tunnel of 2 m, in whose middle the drone flies with its nose along it: the
/// beams meet them at 45°.
const WALLS: Diagonals = {
    let wall = Range::At(Metres(core::f32::consts::SQRT_2));
    Diagonals { nw: wall, ne: wall, sw: wall, se: wall }
};
/// The relay of a log of packets.
const RELAY: NodeId = NodeId(1);
/// The period of its rounds: 5 Hz, as in flight.
const ROUND: Duration = Duration::from_millis(200);

/// The runs of a flight, one for each relay.
pub(super) fn of_flight(recording: &Recording, policy: &Policy) -> Vec<Run> {
    (1..recording.links.len()).map(|relay| flight_of(recording, policy, relay)).collect()
}

fn flight_of(recording: &Recording, policy: &Policy, relay: usize) -> Run {
    let last = recording.links.len();
    let rows = recording.samples.chunk_by(|a, b| a.line == b.line);
    let steps = rows.enumerate().filter_map(|(n, row)| {
        let heard = row.iter().filter_map(|sample| flight_report(sample, relay, last, n as u16));
        Some(Step {
            heard: heard.take(HEARD).collect(),
            strengths: row.iter().filter_map(strength).take(NODES).collect(),
            ..idle_round(row.first()?.time, None)
        })
    });
    let begin = Begin {
        node: number(relay),
        role: Role::Relay,
        in_air: Some(Instant::ZERO),
        policy: policy.code,
        is_filtered: true,
        links: number(last).0,
    };
    Run { begin, steps: steps.collect() }
}

/// The report that a relay hears with one sample: link n joins drones n and n + 1.
fn flight_report(sample: &Sample, relay: usize, last: usize, sequence: u16) -> Option<Heard> {
    let from = match sample.link {
        link if link + 1 == relay => link,
        link if link == relay => link + 1,
        _ => return None,
    };
    let report = plain_report(number(from), sequence, from == last);
    Some(Heard { report, rssi: Some(sample.rssi), reverse: None })
}

fn strength(sample: &Sample) -> Option<(u8, Dbm)> {
    Some((u8::try_from(sample.link).ok()?, sample.rssi))
}

/// A round in which the drone hears nothing.
fn idle_round(now: Instant, velocity: Option<BodyVelocity>) -> Step {
    Step {
        now,
        velocity,
        ranges: WALLS,
        height: Some(AgentConfig::DEFAULT.flight.height),
        order: Some(ORDER),
        heard: heapless::Vec::new(),
        strengths: heapless::Vec::new(),
    }
}

/// The simplest report of a link of the chain, or of the base.
fn plain_report(from: NodeId, sequence: u16, is_base: bool) -> Report {
    Report::plain(from, sequence, if is_base { Phase::Base } else { Phase::Linked })
}

fn number(drone: usize) -> NodeId {
    NodeId(u8::try_from(drone).unwrap_or(u8::MAX))
}

/// The runs of a log of packets: one, and one more for each restart of the log's clock.
pub(super) fn of_packets(recording: &Recording, policy: &Policy) -> Vec<Run> {
    let chosen = chosen_links(recording);
    segments(recording, &chosen).iter().map(|part| packets_of(part, policy, chosen.len())).collect()
}

/// The links that the relay can hear, in the log's order: all, or those with the most packets.
pub(super) fn chosen_links(recording: &Recording) -> Vec<usize> {
    let mut packets = vec![0_usize; recording.links.len()];
    for sample in &recording.samples {
        if let Some(count) = packets.get_mut(sample.link) {
            *count += 1;
        }
    }
    let mut links: Vec<usize> = (0..packets.len()).collect();
    links.sort_by_key(|link| std::cmp::Reverse(packets.get(*link).copied()));
    links.truncate(HEARD);
    links.sort_unstable();
    links
}

/// The samples of the chosen links, with each link's place among them, by recordings and by time.
fn segments(recording: &Recording, chosen: &[usize]) -> Vec<Vec<(usize, Sample)>> {
    let mut segments: Vec<Vec<(usize, Sample)>> = Vec::new();
    let mut latest = Instant::ZERO;
    for sample in &recording.samples {
        let Ok(place) = chosen.binary_search(&sample.link) else { continue };
        let fell_back = latest.since(sample.time) > LOST_AFTER;
        if fell_back || segments.is_empty() {
            segments.push(Vec::new());
            latest = Instant::ZERO;
        }
        latest = latest.max(sample.time);
        if let Some(segment) = segments.last_mut() {
            segment.push((place, *sample));
        }
    }
    for segment in &mut segments {
        // The rows of different receivers may be out of order by less than a link's silence.
        segment.sort_by_key(|(_, sample)| sample.time);
    }
    segments
}

/// The other end of a link, as its reports tell of it.
#[derive(Clone, Copy)]
struct OtherEnd {
    report: Report,
    heard: Option<Instant>,
}

impl OtherEnd {
    fn of(place: usize, links: usize) -> Self {
        let from = match (place, links) {
            (_, 1) => RELAY.0 + 1,
            (0, _) => RELAY.0 - 1,
            (place, _) => RELAY.0 + number(place).0,
        };
        let is_base = place + 1 == links;
        Self { report: plain_report(NodeId(from), 0, is_base), heard: None }
    }

    /// Moves it on to the next sample: away from the relay is forward for the end in front, and
    /// backward for the others.
    fn hear(&mut self, sample: &Sample) -> Heard {
        let away = if self.report.from < RELAY { 1.0 } else { -1.0 };
        let velocity = sample.separating.unwrap_or(MetresPerSecond::ZERO) * away;
        let before = self.heard.replace(sample.time).filter(|_| !sample.restarts);
        let dt = before.map_or(Duration::ZERO, |before| sample.time.since(before));
        self.report.sequence = self.report.sequence.wrapping_add(1);
        self.report.velocity = velocity;
        self.report.odometer += velocity * dt;
        Heard { report: self.report, rssi: Some(sample.rssi), reverse: None }
    }
}

fn packets_of(samples: &[(usize, Sample)], policy: &Policy, links: usize) -> Run {
    let still = BodyVelocity { forward: MetresPerSecond::ZERO, lateral: MetresPerSecond::ZERO };
    let mut ends: Vec<OtherEnd> = (0..links).map(|place| OtherEnd::of(place, links)).collect();
    let begins = samples.first().map_or(Instant::ZERO, |(_, sample)| sample.time);
    let mut steps = Vec::new();
    let mut rest = samples;
    let mut now = begins;
    while let Some((_, next)) = rest.first() {
        if next.time.since(now) > LOST_AFTER {
            now = next.time;
        }
        let count = rest.iter().take(HEARD).take_while(|(_, sample)| sample.time <= now).count();
        let (round, later) = rest.split_at(count);
        let mut step = idle_round(now, Some(still));
        for (place, sample) in round {
            // As many as there is room for were counted.
            let heard = ends.get_mut(*place).map(|end| end.hear(sample));
            step.heard.extend(heard);
            step.strengths.extend([(number(*place).0, sample.rssi)]);
        }
        steps.push(step);
        rest = later;
        // What there was no room for comes in a round of the same moment.
        if rest.first().is_none_or(|(_, sample)| sample.time > now) {
            now = now + ROUND;
        }
    }
    let begin = Begin {
        node: RELAY,
        role: Role::Relay,
        in_air: Some(begins),
        policy: policy.code,
        is_filtered: false,
        links: number(links).0,
    };
    Run { begin, steps }
}
