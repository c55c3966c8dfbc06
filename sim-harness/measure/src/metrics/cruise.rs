//! Computes how far a chain lags behind a head that flies in at one speed.

use super::mean;
use scenario::Stretch;

/// What is kept of a cruise to take its figure from.
pub(super) struct CruiseRecord {
    /// The second half of the cruise, in which the chain has taken up its lag.
    end: Stretch,
    gaps: Vec<f32>,
}

impl CruiseRecord {
    pub(super) const fn new(cruise: Stretch) -> Self {
        let from_us = cruise.from_us + (cruise.until_us - cruise.from_us) / 2;
        Self { end: Stretch { from_us, ..cruise }, gaps: Vec::new() }
    }

    /// Takes one sample of the gap, dB.
    pub(super) fn take(&mut self, now_us: u64, gap: f32) {
        if self.end.from_us < now_us && now_us <= self.end.until_us {
            self.gaps.push(gap);
        }
    }

    /// The mean gap, dB.
    pub(super) fn gap(&self) -> f32 {
        mean(self.gaps.iter().copied())
    }
}
