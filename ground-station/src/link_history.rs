//! Keeps the strengths of each drone's link over the last minutes, so that a page that is opened in
//! mid-flight shows them from the beginning.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use units::{Dbm, Duration, Instant, NodeId};

use crate::freshness;

/// The time that is kept, which is what the page's strip charts show.
const KEPT: Duration = Duration::from_secs(300);

/// The strengths of one drone's link, each with the time when the drone reported it.
type Strengths = VecDeque<(Instant, Dbm)>;

/// The strengths of all drones' links towards the base.
#[derive(Debug, Default)]
pub struct LinkHistory(Mutex<BTreeMap<NodeId, Strengths>>);

impl LinkHistory {
    /// Notes the strength that a drone reported, and forgets what is older than five minutes.
    pub fn note(&self, node: NodeId, said: Instant, rssi: Dbm) {
        let mut links = self.lock();
        let strengths = links.entry(node).or_default();
        strengths.push_back((said, rssi));
        strengths.retain(|(at, _)| said.since(*at) <= KEPT);
    }

    /// The strengths as JSON: for each drone its number and a list of times in ms and strengths in dBm,
    /// the oldest first. The times are those of the [stamps](freshness::stamp) of the station's states.
    #[must_use]
    pub fn json(&self) -> String {
        let links = self.lock();
        let all: Vec<(u8, Vec<(u64, f32)>)> = links
            .iter()
            .map(|(node, strengths)| {
                let points =
                    strengths.iter().map(|(at, rssi)| (freshness::stamp(*at), rssi.0)).collect();
                (node.0, points)
            })
            .collect();
        serde_json::to_string(&all).unwrap_or_else(|_| "[]".to_owned())
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<NodeId, Strengths>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_minutes_of_each_link_are_kept() {
        let history = LinkHistory::default();
        for second in [0, 1, 2, 301] {
            history.note(
                NodeId(2),
                Instant::from_millis(1_000 * second),
                Dbm(-60.0 - second as f32),
            );
        }
        history.note(NodeId(1), Instant::from_millis(4_000), Dbm(-50.5));
        assert_eq!(
            history.json(),
            "[[1,[[4000,-50.5]]],[2,[[1000,-61.0],[2000,-62.0],[301000,-361.0]]]]"
        );
    }
}
