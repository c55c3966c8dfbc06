//! A drone's end: its telemetry to the base, and the order that it heard last.

use core::mem::discriminant;

use units::{Duration, Instant, Order};
use wire::p2p::{Counter, Telemetry};

/// What the base is to know, and what it has said.
#[derive(Clone, Debug)]
pub(crate) struct Teller {
    telemetry: Option<Telemetry>,
    at: Instant,
    last: Option<Counter>,
    task: Option<Order>,
}

impl Teller {
    pub(crate) const fn new() -> Self {
        Self { telemetry: None, at: Instant::ZERO, last: None, task: None }
    }

    pub(crate) const fn tell(&mut self, telemetry: Telemetry) {
        self.telemetry = Some(telemetry);
    }

    /// From when on there is something to tell.
    pub(crate) fn ready(&self) -> Option<Instant> {
        self.telemetry.as_ref().map(|_| self.at)
    }

    /// What to tell at `now`, if it is time.
    pub(crate) fn next(&mut self, now: Instant, every: Duration) -> Option<Telemetry> {
        if self.at > now {
            return None;
        }
        let heeded = self.last.map_or(0, Counter::low16);
        let telemetry = Telemetry { heeded, ..self.telemetry? };
        self.at = now + every;
        Some(telemetry)
    }

    /// The number of the last order that was heeded.
    pub(crate) const fn last(&self) -> Option<Counter> {
        self.last
    }

    /// Heeds the order `counter`. If it is of another kind than the last, the base is told at once.
    pub(crate) fn heed(&mut self, now: Instant, counter: Counter, task: Order) {
        if self.task.is_none_or(|last| discriminant(&last) != discriminant(&task)) {
            self.at = self.at.min(now);
        }
        self.last = Some(counter);
        self.task = Some(task);
    }
}
