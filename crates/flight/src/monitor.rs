//! Detects a sensor that is silent or frozen. Every real sensor has noise, so one that repeats a
//! reading to the last bit has frozen.

use units::{Duration, Instant};

/// The last reading of one sensor and its age.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorMonitor<T> {
    last: Option<T>,
    repeats: u16,
    last_accepted: Option<Instant>,
}

impl<T: Copy + PartialEq> SensorMonitor<T> {
    pub(crate) const fn new() -> Self {
        Self { last: None, repeats: 0, last_accepted: None }
    }

    /// Returns the reading unless it is the `most`-th bit-identical repetition or a later one.
    pub(crate) fn accept(&mut self, now: Instant, reading: Option<T>, most: u16) -> Option<T> {
        let reading = reading?;
        if self.last == Some(reading) {
            self.repeats = self.repeats.saturating_add(1);
        } else {
            self.repeats = 0;
        }
        self.last = Some(reading);
        if self.repeats >= most {
            return None;
        }
        self.last_accepted = Some(now);
        Some(reading)
    }

    /// Time since the last reading that was returned; [`Duration::MAX`] if there has been none.
    pub(crate) fn age(&self, now: Instant) -> Duration {
        self.last_accepted.map_or(Duration::MAX, |at| now.since(at))
    }
}
