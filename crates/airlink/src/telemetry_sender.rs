//! A drone's end of the sealed exchange with the base: its telemetry, and the last order that it
//! accepted, which the telemetry acknowledges.

use core::mem::discriminant;

use units::{Duration, Instant, Order};
use wire::p2p::{Counter, Telemetry};

/// The newest telemetry to send to the base, and the last order that the base has sent.
#[derive(Clone, Debug)]
pub(crate) struct TelemetrySender {
    telemetry: Option<Telemetry>,
    due_at: Instant,
    last_order: Option<Counter>,
    order: Option<Order>,
}

impl TelemetrySender {
    pub(crate) const fn new() -> Self {
        Self { telemetry: None, due_at: Instant::ZERO, last_order: None, order: None }
    }

    pub(crate) const fn set_telemetry(&mut self, telemetry: Telemetry) {
        self.telemetry = Some(telemetry);
    }

    /// The time from which telemetry is due; `None` if the drone has given none yet.
    pub(crate) fn due_at(&self) -> Option<Instant> {
        self.telemetry.as_ref().map(|_| self.due_at)
    }

    /// The telemetry to send at `now`, if it is due.
    pub(crate) fn take_due(&mut self, now: Instant, every: Duration) -> Option<Telemetry> {
        if self.due_at > now {
            return None;
        }
        let heeded = self.last_order.map_or(0, Counter::low16);
        let telemetry = Telemetry { heeded, ..self.telemetry? };
        self.due_at = now + every;
        Some(telemetry)
    }

    /// The counter of the last order that was accepted.
    pub(crate) const fn last_order(&self) -> Option<Counter> {
        self.last_order
    }

    /// Accepts the order numbered `counter`. If its kind differs from the last order's, telemetry
    /// is due at once, so that the base learns of it.
    pub(crate) fn accept(&mut self, now: Instant, counter: Counter, order: Order) {
        if self.order.is_none_or(|last| discriminant(&last) != discriminant(&order)) {
            self.due_at = self.due_at.min(now);
        }
        self.last_order = Some(counter);
        self.order = Some(order);
    }
}
