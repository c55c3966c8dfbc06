//! Remembers what each drone said last, and how its link to the base's side has changed.

use std::collections::{BTreeMap, VecDeque};

use units::{Dbm, Duration, Instant, NodeId};

use crate::blocks::{BaseReport, DroneReport};

/// The time over which the trend of a link is taken: ten telemetry packets of a relay.
const TREND_OVER: Duration = Duration::from_secs(10);
/// The least change of a link over that time that is a trend, in dB/s: what is less is within the
/// scatter of the filtered strengths of a chain that stands still in our own simulator.
const STEADY: f32 = 0.2;
/// Two reports whose times differ by less are the same report: the age in a log block is as old as
/// the block, which may be late by one period.
const SAME: Duration = Duration::from_millis(300);

/// How a link changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// There are too few reports yet.
    Unknown,
    /// The link grows stronger.
    Rising,
    /// The link does not change.
    Steady,
    /// The link grows weaker.
    Falling,
}

/// A drone as the station knows it.
#[derive(Clone, Debug)]
pub struct Drone {
    /// What the drone said last.
    pub report: DroneReport,
    /// When the drone said it.
    pub said: Instant,
    /// The strengths of its link towards the base, with their times.
    links: VecDeque<(Instant, Dbm)>,
}

impl Drone {
    /// How the link to the neighbour towards the base changes.
    #[must_use]
    pub fn trend(&self) -> Trend {
        match slope(&self.links) {
            None => Trend::Unknown,
            Some(slope) if slope > STEADY => Trend::Rising,
            Some(slope) if slope < -STEADY => Trend::Falling,
            Some(_) => Trend::Steady,
        }
    }

    /// The time since the drone spoke last.
    #[must_use]
    pub fn age(&self, now: Instant) -> Duration {
        now.since(self.said)
    }
}

/// The slope of the least-squares line in dB/s; `None` for fewer than five points, whose scatter
/// would pass for a slope.
fn slope(links: &VecDeque<(Instant, Dbm)>) -> Option<f32> {
    let (first, _) = links.front().filter(|_| links.len() >= 5)?;
    let points: Vec<(f32, f32)> =
        links.iter().map(|(at, rssi)| (at.since(*first).as_secs_f32(), rssi.0)).collect();
    let count = points.len() as f32;
    let mean_t = points.iter().map(|(t, _)| t).sum::<f32>() / count;
    let mean_r = points.iter().map(|(_, r)| r).sum::<f32>() / count;
    let product: f32 = points.iter().map(|(t, r)| (t - mean_t) * (r - mean_r)).sum();
    let square: f32 = points.iter().map(|(t, _)| (t - mean_t) * (t - mean_t)).sum();
    (square > 0.0).then(|| product / square)
}

/// The chain as the station knows it.
#[derive(Clone, Debug, Default)]
pub struct ChainView {
    /// The drones that the base has heard, head first: the numbers are in the order of the chain.
    pub drones: BTreeMap<NodeId, Drone>,
    /// What the base said last about itself.
    pub base: Option<BaseReport>,
    /// The order that the base gives, by its code.
    pub task: Option<u8>,
}

impl ChainView {
    /// Takes a drone's report that came in a log block. Returns whether it is a new one.
    pub fn hear(&mut self, now: Instant, node: NodeId, report: DroneReport) -> bool {
        let said = Instant::from_micros(now.as_micros().saturating_sub(report.age.as_micros()));
        let links = match self.drones.remove(&node) {
            Some(before) if said.since(before.said) < SAME => {
                self.drones.insert(node, before);
                return false;
            }
            Some(before) => before.links,
            None => VecDeque::new(),
        };
        let mut drone = Drone { report, said, links };
        drone.links.retain(|(at, _)| said.since(*at) <= TREND_OVER);
        drone.links.extend(report.back.map(|(_, rssi)| (said, rssi)));
        self.drones.insert(node, drone);
        true
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use units::Metres;

    use super::*;

    fn report(rssi: f32, age_ms: u64) -> DroneReport {
        DroneReport {
            state: 4,
            fault: 0,
            age: Duration::from_millis(age_ms),
            battery: None,
            endurance: None,
            back: Some((NodeId(3), Dbm(rssi))),
            odometer: Metres(1.0),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// A link that changes evenly has the trend of its slope, whenever its reports come.
        #[test]
        fn an_even_change_is_its_trend(slope in -3.0_f32..3.0, ages in prop::collection::vec(0_u64..250, 12)) {
            prop_assume!((slope.abs() - STEADY).abs() > 0.05);
            let mut chain = ChainView::default();
            for (second, age) in ages.iter().enumerate() {
                let said = 1_000 * second as u64 + 5_000;
                let rssi = -60.0 + slope * second as f32;
                chain.hear(Instant::from_millis(said + age), NodeId(1), report(rssi, *age));
            }
            let wanted = match slope {
                slope if slope > STEADY => Trend::Rising,
                slope if slope < -STEADY => Trend::Falling,
                _ => Trend::Steady,
            };
            prop_assert_eq!(chain.drones[&NodeId(1)].trend(), wanted);
        }
    }

    #[test]
    fn a_block_that_repeats_a_report_is_no_news() {
        let mut chain = ChainView::default();
        let at = Instant::from_millis;
        assert!(chain.hear(at(1_000), NodeId(1), report(-60.0, 100)));
        assert!(!chain.hear(at(1_250), NodeId(1), report(-60.0, 350)));
        assert!(chain.hear(at(2_000), NodeId(1), report(-61.0, 50)));
        assert_eq!(chain.drones[&NodeId(1)].trend(), Trend::Unknown);
    }
}
