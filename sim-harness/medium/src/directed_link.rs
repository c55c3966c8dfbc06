//! The random numbers of directed links, and the fades of links.

use radio_model::Fades;
use random::{Purpose, Stream};
use units::Duration;

/// The random numbers of all directed links between so many stations, sender-major.
pub fn streams(stations: usize, seed: u64) -> Vec<Stream> {
    let between = |n: usize| Purpose::Link((n / stations) as u8, (n % stations) as u8);
    (0..stations * stations).map(|n| Stream::new(seed, between(n))).collect()
}

/// The fades of all links between so many stations. A fade holds in both directions: what weakens a
/// wave on its way weakens the one that comes back on the same way (reciprocity).
pub struct LinkFades {
    fades: Fades,
    stations: usize,
    /// By the smaller and the larger number of both stations.
    links: Vec<LinkFade>,
}

struct LinkFade {
    stream: Stream,
    /// Whether the link was in a fade when it was last looked at, and when that was, µs.
    last: Option<(u64, bool)>,
}

impl LinkFades {
    /// The fades of all links, as a mission begins.
    pub fn new(fades: Fades, stations: usize, seed: u64) -> Self {
        let between = |n: usize| Purpose::Fade((n / stations) as u8, (n % stations) as u8);
        let link = |n| LinkFade { stream: Stream::new(seed, between(n)), last: None };
        let count = if fades.any() { stations * stations } else { 0 };
        Self { fades, stations, links: (0..count).map(link).collect() }
    }

    /// Whether the link between two stations is in a fade.
    pub fn is_faded(&mut self, one: usize, other: usize, now_us: u64) -> bool {
        let at = one.min(other) * self.stations + one.max(other);
        let Some(LinkFade { stream, last }) = self.links.get_mut(at) else { return false };
        // The two directions may be looked at in another order than that of the packets' ends.
        let elapsed_us = last.map_or(0, |(at_us, _)| now_us.saturating_sub(at_us));
        let was = last.map(|(_, was)| was);
        let is = self.fades.faded(was, Duration::from_micros(elapsed_us), stream.uniform());
        *last = Some((now_us, is));
        is
    }
}
