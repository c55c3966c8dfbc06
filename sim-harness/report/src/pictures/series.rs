//! Extracts the series of the charts over time from a trace.

use agent::{AgentConfig, State};
use units::{Db, NodeId};

use mission::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};

/// More points to a line than this no screen or paper shows.
const MOST_POINTS: usize = 2000;
/// More dots to a panel than this run into each other.
const MOST_DOTS: usize = 600;

/// The loss of an antenna on the ground by which drones there correct what they receive.
pub(crate) const GROUND_LOSS: Db = AgentConfig::DEFAULT.perch.ground_loss;

/// A drone below this height that is on its mission has been lost, m.
const DOWN: f32 = 0.05;

/// One link as the end nearer to the base knew it.
pub(super) struct LinkSeries {
    /// Both ends by name.
    pub(super) name: String,
    /// The neighbour and since when it was that, in s, where the neighbour changed at all.
    pub(super) peers: Vec<(f64, String)>,
    /// Time in s, and RSSI in dBm as received, filtered, true; NaN where there was no link, and
    /// between two different peers.
    pub(super) samples: Vec<Sample>,
}

/// A link at one moment.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub time: f64,
    pub(super) raw: f64,
    pub(super) filtered: f64,
    pub(super) truth: f64,
}

impl LinkSeries {
    /// Points of a line.
    pub(super) fn line(&self, value: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
        let step = self.samples.len().div_ceil(MOST_POINTS).max(1);
        // A break of the line is never thinned out.
        let kept = self.samples.iter().enumerate().filter(|(index, sample)| {
            index.is_multiple_of(step)
                || index + 1 == self.samples.len()
                || sample.filtered.is_nan()
        });
        kept.map(|(_, s)| (s.time, value(s))).collect()
    }

    /// Single packets.
    pub(super) fn dots(&self) -> Vec<(f64, f64)> {
        thinned(&self.samples, MOST_DOTS).map(|s| (s.time, s.raw)).collect()
    }

    /// Everything that must fit into the panel.
    pub(super) fn values(&self) -> impl Iterator<Item = f64> {
        self.samples.iter().flat_map(|s| [s.raw, s.filtered, s.truth])
    }
}

/// Every link that there ever was, from the head's end to the base's: one for each node that had
/// a drone in front of it.
pub(super) fn links(trace: &Trace) -> Vec<LinkSeries> {
    (1..trace.nodes.len()).filter_map(|receiver| link(trace, receiver)).collect()
}

fn link(trace: &Trace, receiver: usize) -> Option<LinkSeries> {
    let mut peers: Vec<(f64, NodeId)> = Vec::new();
    let mut samples = Vec::with_capacity(trace.frames.len());
    let mut before = None;
    for frame in &trace.frames {
        let time = seconds(frame.time_us);
        let seen = observed(trace, frame, receiver);
        let peer = seen.map(|(peer, _)| peer);
        if let Some(peer) = peer.filter(|peer| peers.last().is_none_or(|last| last.1 != *peer)) {
            peers.push((time, peer));
        }
        // A change of peer is a new link, not a jump of the old one.
        let same = peer == before;
        before = peer;
        let value = |v: Option<f32>| v.filter(|_| same).map_or(f64::NAN, f64::from);
        samples.push(Sample {
            time,
            raw: value(seen.map(|(_, link)| link.raw.0)),
            filtered: value(seen.map(|(_, link)| link.filtered.0)),
            truth: value(seen.map(|(_, link)| link.truth.0)),
        });
    }
    let name = |id: NodeId| {
        trace.nodes.iter().find(|n| n.id == id).map_or_else(|| id.to_string(), Node::to_string)
    };
    let own = trace.nodes.get(receiver)?.to_string();
    let (name, peers) = match peers.as_slice() {
        [] => return None,
        [(_, only)] => (format!("{} \u{2013} {own}", name(*only)), Vec::new()),
        many => (
            format!("next in front \u{2013} {own}"),
            many.iter().map(|(since, id)| (*since, name(*id))).collect(),
        ),
    };
    Some(LinkSeries { name, peers, samples })
}

/// Whether a drone is down without having landed: its agent's last word stands, and it says no more.
fn is_down(drone: &DroneFrame) -> bool {
    drone.height < DOWN && matches!(drone.state, State::OnMission(_))
}

/// The name of a drone's state, as an onlooker would say it: a drone that fell, or was taken out of the mission,
/// is `down`, whatever its agent said last.
pub(crate) fn state_name(drone: &DroneFrame) -> &'static str {
    if is_down(drone) { "down" } else { drone.state.name() }
}

/// The link of a node towards the head: as it knew it itself, or as the node at the other end
/// did, with the strengths that were received. A drone that is down has none.
fn observed(trace: &Trace, frame: &Frame, receiver: usize) -> Option<(NodeId, LinkFrame)> {
    let own = frame.drones.get(receiver).filter(|drone| !is_down(drone))?;
    let link = match own.front {
        Some(front) => Some((front.peer, front)),
        None => {
            let id = trace.nodes.get(receiver)?.id;
            let ahead = trace.nodes.iter().zip(&frame.drones).take(receiver);
            ahead
                .filter_map(|(node, drone)| drone.back.map(|link| (node.id, link)))
                .rfind(|(_, link)| link.peer == id)
        }
    };
    let (peer, link) = link?;
    let other = trace.nodes.iter().position(|node| node.id == peer)?;
    let other = frame.drones.get(other).filter(|drone| !is_down(drone))?;
    let perched = [own, other].into_iter().filter(|drone| drone.state == State::Perched);
    let loss = perched.fold(Db(0.0), |loss, _| loss + GROUND_LOSS);
    Some((peer, LinkFrame { raw: link.raw - loss, filtered: link.filtered - loss, ..link }))
}

/// Time and way along the tunnel of one node.
pub(super) fn way(trace: &Trace, node: usize) -> Vec<(f64, f64)> {
    thinned(&trace.frames, MOST_POINTS)
        .filter_map(|frame| {
            let drone = frame.drones.get(node)?;
            Some((seconds(frame.time_us), f64::from(drone.way)))
        })
        .collect()
}

/// First and last moment of the mission, in s.
pub(super) fn time_span(trace: &Trace) -> (f64, f64) {
    let at = |frame: Option<&Frame>| frame.map_or(0.0, |frame| seconds(frame.time_us));
    let (from, to) = (at(trace.frames.first()), at(trace.frames.last()));
    // A first frame shortly after 0 is the beginning.
    (if from < 0.05 * to { 0.0 } else { from }, to)
}

/// The launch limit, unless it is a way of saying that there is none.
pub(crate) fn launch_limit(trace: &Trace) -> Option<f64> {
    /// Weaker than the most sensitive radio of this kind hears (−103 dBm at 125 kbit/s: nRF52840
    /// product specification, first page).
    const INAUDIBLE: f32 = -110.0;
    let limit = trace.launch_limit.0;
    (limit.is_finite() && limit > INAUDIBLE).then_some(f64::from(limit))
}

fn seconds(micros: u64) -> f64 {
    micros as f64 * 1e-6
}

/// Evenly fewer, so that about `most` are left; the last one always.
pub(super) fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let step = all.len().div_ceil(most.max(1)).max(1);
    let last = all.last().filter(|_| !(all.len().saturating_sub(1)).is_multiple_of(step));
    all.iter().step_by(step).chain(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn each_node_with_someone_in_front_is_a_link() {
        let names: Vec<String> =
            links(&synthetic::mission()).into_iter().map(|link| link.name).collect();
        assert_eq!(
            names,
            [
                "head \u{2013} relay 1",
                "relay 1 \u{2013} relay 2",
                "relay 2 \u{2013} relay 3",
                "next in front \u{2013} base",
            ]
        );
    }

    #[test]
    fn a_drone_that_is_down_has_no_link() {
        let mut trace = synthetic::mission();
        let before = links(&trace)[1].line(|sample| sample.truth);
        let last = before.iter().rfind(|(_, truth)| truth.is_finite()).unwrap().0;
        for frame in trace.frames.iter_mut().filter(|frame| seconds(frame.time_us) > 150.0) {
            frame.drones[1].height = 0.0;
        }
        let after = links(&trace)[1].line(|sample| sample.truth);
        let dies = after.iter().rfind(|(_, truth)| truth.is_finite()).unwrap().0;
        assert!(last > 200.0 && dies <= 150.2, "{last} {dies}");
    }

    #[test]
    fn links_on_the_ground_have_the_strength_that_is_received() {
        let mut trace = synthetic::mission();
        let received = |trace: &Trace| links(trace)[0].samples[1000].raw;
        let before = received(&trace);
        for frame in &mut trace.frames {
            frame.drones[0].state = State::Perched;
            frame.drones[1].state = State::Perched;
        }
        let lower = before - received(&trace);
        assert!((lower - 2.0 * f64::from(GROUND_LOSS.0)).abs() < 1e-3, "{lower}");
    }

    #[test]
    fn thinning_keeps_the_ends() {
        let all: Vec<u32> = (0..=1000).collect();
        let some: Vec<u32> = thinned(&all, 300).copied().collect();
        assert!(some.len() <= 301);
        assert_eq!((some.first(), some.last()), (Some(&0), Some(&1000)));
    }
}
