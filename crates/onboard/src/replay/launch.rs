//! Watches recorded strengths by the launch rule, as a relay that waits beside the base does.

use chain::launch::{LaunchConfig, LaunchWatch};
use units::{Dbm, Duration, Instant, LinkSpan, NODES};

/// A strength holds until its link counts as lost.
#[derive(Clone, Copy, Debug)]
struct Held {
    rssi: Dbm,
    heard: Instant,
}

/// The launch rule over the links of a recording, head first.
///
/// The last link is the one with the largest number, from the first time that it is heard. A
/// recording cannot answer the call with one more drone, so a call that goes on counts once.
#[derive(Clone, Copy, Debug)]
pub struct LaunchRule {
    watch: LaunchWatch,
    held: [Option<Held>; NODES],
    links: usize,
    calling: bool,
}

impl LaunchRule {
    /// The rule for a recording of so many links, of which no more than [`NODES`] count.
    #[must_use]
    pub const fn new(links: usize) -> Self {
        Self { watch: LaunchWatch::new(), held: [None; NODES], links, calling: false }
    }

    /// Takes in the strengths of one moment, each with the number of its link; returns whether the
    /// rule begins to call for a relay. A link that was silent for longer than `lost_after` is lost.
    pub fn step(
        &mut self,
        now: Instant,
        config: &LaunchConfig,
        lost_after: Duration,
        strengths: impl Iterator<Item = (usize, Dbm)>,
    ) -> bool {
        // Only a clock that fell back makes a link of a later moment.
        if self.held.iter().flatten().any(|held| held.heard > now) {
            *self = Self::new(self.links);
        }
        for (link, rssi) in strengths {
            if let Some(held) = self.held.get_mut(link) {
                *held = Some(Held { rssi, heard: now });
            }
        }
        let links = self.held.get(..self.links.min(NODES)).unwrap_or_default();
        let Some((Some(last), ahead)) = links.split_last() else { return false };
        let fresh = |link: &Held| (now.since(link.heard) <= lost_after).then_some(link.rssi);
        let ahead = ahead
            .iter()
            .filter_map(|link| fresh(link.as_ref()?))
            .fold(None, |span, link| Some(LinkSpan::extended(span, link)));
        let calls = self.watch.step(now, config, fresh(last), ahead);
        let begins = calls && !self.calling;
        self.calling = calls;
        begins
    }
}
