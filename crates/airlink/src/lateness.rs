//! How late the packets of a node are beside the fastest that was heard of it, by the stamps in their
//! counters. A packet that was jammed, recorded and sent again later has the counter that is due,
//! but not the delay of the others.

use units::{Duration, Instant};
use wire::p2p::{Counter, STAMP_US};

/// The least delay between a node's stamps and their arrival, in steps of [`STAMP_US`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lateness {
    least: i32,
    /// When the packet with the least delay came.
    least_at: Instant,
}

/// The least delay grows by one step in 2 to the power of this many steps, 122 ppm: more than the
/// clocks of two drones drift apart, whose crystals are good to 30 ppm each.
const DRIFT_BITS: u32 = 13;

impl Lateness {
    /// The lateness after a first packet.
    pub(crate) const fn new(now: Instant, counter: Counter) -> Self {
        Self { least: counter.delay(now), least_at: now }
    }

    /// How much later a packet is than the fastest one, which it may become itself.
    #[inline(never)]
    pub(crate) fn of(&mut self, now: Instant, counter: Counter) -> Duration {
        let delay = counter.delay(now);
        let drift = (now.since(self.least_at).as_micros() / STAMP_US) >> DRIFT_BITS;
        let late = delay.wrapping_sub(self.least).wrapping_sub(drift as i32);
        if late <= 0 {
            *self = Self { least: delay, least_at: now };
        }
        Duration::from_micros(u64::from(late.max(0).unsigned_abs()) * STAMP_US)
    }
}
