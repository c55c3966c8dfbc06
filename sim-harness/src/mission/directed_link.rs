//! The random numbers of a directed link, and whether it is in a fade.

use radio_model::Fades;
use units::Duration;

use crate::random::{Purpose, Stream};

/// A link from one station to another.
pub(super) struct DirectedLink {
    pub(super) stream: Stream,
    /// Whether the link was in a fade when it was last looked at, and when that was, µs.
    fade: Option<(u64, bool)>,
}

impl DirectedLink {
    /// All links between so many stations, sender-major.
    pub(super) fn all(stations: usize, seed: u64) -> Vec<Self> {
        let between = |n: usize| Purpose::Link((n / stations) as u8, (n % stations) as u8);
        let one = |n| Self { stream: Stream::new(seed, between(n)), fade: None };
        (0..stations * stations).map(one).collect()
    }

    /// Whether the link is in a fade. Without fades it draws nothing.
    pub(super) fn is_faded(&mut self, fades: Fades, now_us: u64) -> bool {
        if !fades.any() {
            return false;
        }
        let elapsed_us = self.fade.map_or(0, |(at_us, _)| now_us.saturating_sub(at_us));
        let was = self.fade.map(|(_, was)| was);
        let is = fades.faded(was, Duration::from_micros(elapsed_us), self.stream.uniform());
        self.fade = Some((now_us, is));
        is
    }
}
