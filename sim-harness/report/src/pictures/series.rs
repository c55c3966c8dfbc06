//! Extracts the series of the charts over time from a trace.

use units::NodeId;

use mission::trace::{Frame, LinkFrame, Trace};

/// More points to a line than this no screen or paper shows.
const MOST_POINTS: usize = 2000;
/// More dots to a panel than this run into each other.
const MOST_DOTS: usize = 600;

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
        trace
            .nodes
            .iter()
            .find(|n| n.id == id)
            .map_or_else(|| id.to_string(), |node| trace.name(node))
    };
    let own = trace.name(trace.nodes.get(receiver)?);
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

/// The link of a node towards the head: as it knew it itself, or as the node at the other end
/// did.
fn observed<'a>(
    trace: &Trace,
    frame: &'a Frame,
    receiver: usize,
) -> Option<(NodeId, &'a LinkFrame)> {
    if let Some(front) = &frame.drones.get(receiver)?.front {
        return Some((front.peer, front));
    }
    let own = trace.nodes.get(receiver)?.id;
    let ahead = trace.nodes.iter().zip(&frame.drones).take(receiver);
    ahead
        .filter_map(|(node, drone)| drone.back.as_ref().map(|link| (node.id, link)))
        .rfind(|(_, link)| link.peer == own)
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
    fn thinning_keeps_the_ends() {
        let all: Vec<u32> = (0..=1000).collect();
        let some: Vec<u32> = thinned(&all, 300).copied().collect();
        assert!(some.len() <= 301);
        assert_eq!((some.first(), some.last()), (Some(&0), Some(&1000)));
    }
}
