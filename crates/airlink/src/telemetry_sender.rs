//! A drone's end of the sealed exchange with the base: its telemetry, and the last order that it
//! accepted, which the telemetry acknowledges.

use core::mem::discriminant;

use units::{Duration, Instant, Order};
use wire::p2p::{Counter, Telemetry};

use crate::lateness::Lateness;

/// The newest telemetry to send to the base, and the last order that the base has sent.
#[derive(Clone, Debug)]
pub(crate) struct TelemetrySender {
    telemetry: Option<Telemetry>,
    due_at: Instant,
    /// The counter of the last order, and when it came.
    last_order: Option<(Counter, Instant)>,
    lateness: Option<Lateness>,
    order: Option<Order>,
}

/// An order that is older than this is not acknowledged any more. The low halves of two counts tell
/// which is later only where they are less than 268 s apart.
const ACKNOWLEDGED_FOR: Duration = Duration::from_secs(120);

impl TelemetrySender {
    pub(crate) const fn new() -> Self {
        Self {
            telemetry: None,
            due_at: Instant::ZERO,
            last_order: None,
            lateness: None,
            order: None,
        }
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
        let recent = self.last_order.filter(|(_, at)| now.since(*at) < ACKNOWLEDGED_FOR);
        let heeded = recent.map_or(0, |(counter, _)| counter.low16());
        let telemetry = Telemetry { heeded, ..self.telemetry? };
        self.due_at = now + every;
        Some(telemetry)
    }

    /// The counter of the last order that was accepted.
    pub(crate) fn last_order(&self) -> Option<Counter> {
        self.last_order.map(|(counter, _)| counter)
    }

    /// How much later an order of the base comes than its fastest one since its boot.
    pub(crate) fn lateness(&mut self, now: Instant, counter: Counter) -> Duration {
        let same_boot = self.last_order().is_some_and(|last| last.epoch() == counter.epoch());
        let known = self.lateness.filter(|_| same_boot);
        self.lateness.insert(known.unwrap_or(Lateness::new(now, counter))).of(now, counter)
    }

    /// Accepts the order numbered `counter`. If its kind differs from the last order's, telemetry
    /// is due at once, so that the base learns of it.
    pub(crate) fn accept(&mut self, now: Instant, counter: Counter, order: Order) {
        if self.order.is_none_or(|last| discriminant(&last) != discriminant(&order)) {
            self.due_at = self.due_at.min(now);
        }
        self.last_order = Some((counter, now));
        self.order = Some(order);
    }
}
