//! The candidates that a robot could not reach, and does not try for a while.

use heapless::Vec;
use units::{Duration, Instant};

use crate::tile::Tile;

/// A candidate is barred twice for a while, and the third time for good.
const MOST_BARS: u8 = 3;
/// The candidates that are barred at a time.
const MOST_BARRED: usize = 32;

#[derive(Clone, Copy, Debug)]
struct Bar {
    tile: Tile,
    until: Instant,
    times: u8,
}

/// The candidates that a robot does not try, the oldest first.
#[derive(Clone, Debug)]
pub(crate) struct Bars(Vec<Bar, MOST_BARRED>);

impl Bars {
    pub(crate) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Bars a candidate for so long, the third time for good.
    pub(crate) fn bar(&mut self, now: Instant, tile: Tile, length: Duration) {
        self.add(tile, now + length, 1);
    }

    /// Bars a candidate for so long, as often as that may be.
    pub(crate) fn put_off(&mut self, now: Instant, tile: Tile, length: Duration) {
        self.add(tile, now + length, 0);
    }

    fn add(&mut self, tile: Tile, until: Instant, times: u8) {
        if let Some(bar) = self.0.iter_mut().find(|bar| bar.tile == tile) {
            bar.until = until;
            bar.times = bar.times.saturating_add(times);
        } else if self.0.push(Bar { tile, until, times }).is_err() {
            // The oldest is tried again in the place of the newest.
            self.0.remove(0);
            let _ = self.0.push(Bar { tile, until, times });
        }
    }

    /// Whether a candidate is barred now.
    pub(crate) fn holds(&self, tile: Tile, now: Instant) -> bool {
        let bar = self.0.iter().find(|bar| bar.tile == tile);
        bar.is_some_and(|bar| bar.times >= MOST_BARS || now < bar.until)
    }

    /// Whether a candidate is barred now that will be tried again.
    pub(crate) fn has_to_come(&self, now: Instant, is_candidate: impl Fn(Tile) -> bool) -> bool {
        let is_open = |bar: &Bar| bar.times < MOST_BARS && now < bar.until;
        self.0.iter().any(|bar| is_open(bar) && is_candidate(bar.tile))
    }
}
