//! Passing on: capsules on their way between the base and one node.
//!
//! Of each far end only the newest capsule is kept. Whoever hears it and stands further along says
//! it in its next turn, and again in later turns until somebody still further along has said it,
//! or a newer one comes, or it has been said often enough.
//! So the nearest hop passes it on at once, and who stands behind the nearest is the way round it.

use units::{Duration, Instant, NODES, NodeId};
use wire::p2p::{Capsule, Wave};

/// A capsule, and what is left to do for it.
#[derive(Clone, Copy, Debug)]
struct Entry<const N: usize> {
    capsule: Capsule<N>,
    /// When it was last said here, or, if never, when it was heard.
    at: Instant,
    /// How often it has been said here.
    said: u8,
    /// How often it may yet be said.
    left: u8,
    /// Time from one saying to the next.
    pause: Duration,
}

/// Where a capsule came from, as seen from here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// From nearer to where it began.
    Behind,
    /// From nearer to where it goes, or from there.
    Ahead,
}

/// What a capsule was, when it was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Heard {
    /// The newest of its far end.
    New,
    /// The newest, but not for the first time.
    Same,
    /// Older than the newest.
    Old,
}

/// The capsules of one kind, by far end.
#[derive(Clone, Debug)]
pub(crate) struct Passing<const N: usize> {
    entries: [Option<Entry<N>>; NODES],
    /// In whose wave they go.
    wave: Wave,
    /// Bit `n`: something is left to say of `n`.
    waiting: u16,
}

impl<const N: usize> Passing<N> {
    pub(crate) const fn new(wave: Wave) -> Self {
        Self { entries: [None; NODES], wave, waiting: 0 }
    }

    /// How `capsule` compares with what is known, of which nothing counts after `forget`: a number
    /// that a liar made up does not stand in the way for ever.
    pub(crate) fn compare(&self, now: Instant, capsule: &Capsule<N>, forget: Duration) -> Heard {
        match self.get(capsule.node) {
            Some(entry) if now.since(entry.at) > forget => Heard::New,
            Some(entry) if capsule.counter < entry.capsule.counter => Heard::Old,
            Some(entry) if capsule.counter == entry.capsule.counter => Heard::Same,
            _ => Heard::New,
        }
    }

    /// Keeps `capsule`, to be said `tries` times.
    pub(crate) fn keep(&mut self, now: Instant, capsule: Capsule<N>, tries: u8) {
        let number = capsule.node.0;
        let pause = self.pause(capsule.node);
        if let Some(place) = self.entries.get_mut(usize::from(number)) {
            *place = Some(Entry { capsule, at: now, said: 0, left: tries, pause });
            self.mark(number, tries > 0);
        }
    }

    /// Nothing more is to be said of `node`: it has got farther.
    pub(crate) fn settle(&mut self, node: NodeId) {
        self.allow(node, 0);
    }

    /// What is known of `node` may be said `tries` times more.
    pub(crate) fn allow(&mut self, node: NodeId, tries: u8) {
        if let Some(Some(entry)) = self.entries.get_mut(usize::from(node.0)) {
            entry.left = tries;
            self.mark(node.0, tries > 0);
        }
    }

    pub(crate) fn is_settled(&self, node: NodeId) -> bool {
        self.get(node).is_none_or(|entry| entry.left == 0)
    }

    /// From when on there is something to say in a turn of `wave`.
    pub(crate) fn ready(&self, wave: Wave) -> Option<Instant> {
        if self.waiting == 0 {
            return None;
        }
        self.left().map(|entry| entry.ready(wave == self.wave)).min()
    }

    /// What to say at `now`: what was said least, and of that what comes or goes farthest. The head
    /// is the farthest.
    pub(crate) fn next(&mut self, now: Instant, wave: Wave) -> Option<Capsule<N>> {
        let own = wave == self.wave;
        let node = self
            .left()
            .filter(|entry| entry.ready(own) <= now)
            .min_by_key(|entry| (entry.rank(), entry.capsule.node))?
            .capsule
            .node;
        self.say(now, node)
    }

    /// What was said last of `node`, once more.
    pub(crate) fn say(&mut self, now: Instant, node: NodeId) -> Option<Capsule<N>> {
        let entry = self.entries.get_mut(usize::from(node.0))?.as_mut()?;
        entry.left = entry.left.checked_sub(1)?;
        entry.said = entry.said.saturating_add(1);
        entry.at = now;
        let (capsule, more) = (entry.capsule, entry.left > 0);
        self.mark(node.0, more);
        Some(capsule)
    }

    /// The head's commands go on in every turn: the pilot waits. All else is said again a frame
    /// later, when whoever passed it on has surely been heard, even in a busy chain.
    fn pause(&self, node: NodeId) -> Duration {
        match self.wave {
            Wave::Outward if node == NodeId::HEAD => TURN,
            Wave::Outward | Wave::Inward => ROUND,
        }
    }

    fn get(&self, node: NodeId) -> Option<&Entry<N>> {
        self.entries.get(usize::from(node.0))?.as_ref()
    }

    fn left(&self) -> impl Iterator<Item = &Entry<N>> {
        self.entries.iter().flatten().filter(|entry| entry.left > 0)
    }

    const fn mark(&mut self, number: u8, waits: bool) {
        let bit = 1 << (number & 15);
        if waits {
            self.waiting |= bit;
        } else {
            self.waiting &= !bit;
        }
    }
}

impl<const N: usize> Entry<N> {
    /// From when on it may be said in a turn of its `own` wave, or of the other. In its own the
    /// next hop's turn comes right after, so it goes out in that if it is near.
    fn ready(&self, own: bool) -> Instant {
        match (self.said, own) {
            (0, true) => self.at,
            (0, false) => self.at + AGAINST,
            _ => self.at + self.pause,
        }
    }

    /// What has the smallest comes first: what was said least, the head's counting less.
    fn rank(&self) -> u8 {
        match self.capsule.node {
            NodeId::HEAD => self.said / HEADWAY,
            _ => self.said,
        }
    }
}

/// After so long something new is said in the wave that goes against its way.
pub(crate) const AGAINST: Duration = Duration::from_millis(25);

/// So often the head's is said before it counts as said once: it has the longest way, and before
/// its telemetry has come home nobody can order it about. With 1 the head of 16 nodes at 70 % loss
/// had its first order after up to 25 s, with 4 after 8 s (4 seeds each); more takes turns from the
/// others' telemetry.
const HEADWAY: u8 = 4;

/// Longer than from the first to the last packet of a turn, shorter than from one turn to the next.
const TURN: Duration = Duration::from_micros(1_500);

/// A little less than from a turn to the same one of the next frame.
const ROUND: Duration = Duration::from_millis(95);
