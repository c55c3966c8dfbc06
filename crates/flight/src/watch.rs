//! Whether a sensor still speaks, and says anything new: every real one has noise, so one that
//! repeats itself to the last bit has frozen.

use units::{Duration, Instant};

/// One sensor's record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch<T> {
    last: Option<T>,
    repeats: u16,
    fresh: Option<Instant>,
}

impl<T: Copy + PartialEq> Watch<T> {
    pub(crate) const fn new() -> Self {
        Self { last: None, repeats: 0, fresh: None }
    }

    /// Lets a reading pass unless it is the same as the `most` before it.
    pub(crate) fn pass(&mut self, now: Instant, reading: Option<T>, most: u16) -> Option<T> {
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
        self.fresh = Some(now);
        Some(reading)
    }

    /// How long ago something passed; for ever, if nothing has.
    pub(crate) fn age(&self, now: Instant) -> Duration {
        self.fresh.map_or(Duration::MAX, |at| now.since(at))
    }
}
