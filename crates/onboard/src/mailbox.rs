//! Stores reports and orders between the radio link, which delivers them at any time, and the
//! agent, which takes them five times a second.

use agent::Told;
use chain::neighbours::Heard;
use heapless::Vec;
use units::{Duration, Instant, NODES, Order};

/// Reports that may come in between two rounds: two of each other node, since one that was held
/// back on the air may arrive shortly before the next.
pub(crate) const REPORTS: usize = 2 * (NODES - 1);

/// Messages of the mission that may come in between two rounds: four of each of five other drones
/// that explore, and some that were held back on the air.
pub(crate) const TOLD: usize = 24;

/// Orders that may come in between two rounds: the base repeats its order every 200 ms at most, and
/// the simulator may delay them by several rounds.
const ORDERS: usize = 8;

/// Reports and orders in order of arrival.
#[derive(Clone, Debug)]
pub(crate) struct Mailbox {
    reports: Vec<Heard, REPORTS>,
    /// When each report came in.
    arrived: Vec<Instant, REPORTS>,
    told: Vec<Told, TOLD>,
    orders: Vec<(Instant, Order), ORDERS>,
    /// Whether an order to stop has come in. It is neither delayed nor replaced.
    stop: bool,
    dropped: u32,
}

impl Mailbox {
    pub(crate) const fn new() -> Self {
        Self {
            reports: Vec::new(),
            arrived: Vec::new(),
            told: Vec::new(),
            orders: Vec::new(),
            stop: false,
            dropped: 0,
        }
    }

    /// Puts a report in. When the mailbox is full, the oldest report is dropped.
    pub(crate) fn report(&mut self, now: Instant, heard: Heard) {
        if self.reports.is_full() {
            self.forget(1);
            self.dropped = self.dropped.wrapping_add(1);
        }
        // There is room for one now.
        let _ = self.reports.push(heard);
        let _ = self.arrived.push(now);
    }

    /// Puts a message of the mission in. When the mailbox is full, the oldest one is dropped.
    pub(crate) fn told(&mut self, told: Told) {
        if self.told.is_full() {
            self.told.remove_first(1);
            self.dropped = self.dropped.wrapping_add(1);
        }
        // There is room for one now.
        let _ = self.told.push(told);
    }

    /// The messages of the mission that came in at least `delay` ago.
    pub(crate) fn due_told(&self, now: Instant, delay: Duration) -> &[Told] {
        let due = self.told.iter().take_while(|told| told.at + delay <= now).count();
        self.told.get(..due).unwrap_or_default()
    }

    /// Takes the oldest `count` messages of the mission out.
    pub(crate) fn forget_told(&mut self, count: usize) {
        self.told.remove_first(count);
    }

    /// Puts an order in. When the mailbox is full, the oldest order is dropped: a newer one replaces
    /// it anyway.
    pub(crate) fn order(&mut self, now: Instant, order: Order) {
        self.stop |= order == Order::Stop;
        if self.orders.is_full() {
            self.orders.remove_first(1);
        }
        let _ = self.orders.push((now, order));
    }

    /// Takes the newest order that came in at least `delay` ago. A stop is returned each time.
    pub(crate) fn take_order(&mut self, now: Instant, delay: Duration) -> Option<Order> {
        let due = self.orders.iter().take_while(|(at, _)| *at + delay <= now).count();
        let newest = due.checked_sub(1).and_then(|last| self.orders.get(last)).copied();
        self.orders.remove_first(due);
        if self.stop { Some(Order::Stop) } else { newest.map(|(_, order)| order) }
    }

    /// The reports that came in at least `delay` ago.
    pub(crate) fn due(&self, now: Instant, delay: Duration) -> &[Heard] {
        let due = self.arrived.iter().take_while(|at| **at + delay <= now).count();
        self.reports.get(..due).unwrap_or_default()
    }

    /// Takes the oldest `count` reports out.
    pub(crate) fn forget(&mut self, count: usize) {
        self.reports.remove_first(count);
        self.arrived.remove_first(count);
    }

    /// Whether an order to stop has come in.
    pub(crate) const fn stops(&self) -> bool {
        self.stop
    }

    /// The number of reports and messages that were dropped.
    pub(crate) const fn dropped(&self) -> u32 {
        self.dropped
    }
}

/// Removal from the front of a [`Vec`], which heapless does not have. The slice's `rotate_left`
/// panics on a count that is too large; this does not.
trait RemoveFirst {
    /// Takes out the first `count` elements, or all where there are fewer.
    fn remove_first(&mut self, count: usize);
}

impl<T: Copy, const N: usize> RemoveFirst for Vec<T, N> {
    fn remove_first(&mut self, count: usize) {
        let left = self.len().saturating_sub(count);
        for place in 0..left {
            let Some(&moved) = self.get(place + count) else { return };
            if let Some(slot) = self.get_mut(place) {
                *slot = moved;
            }
        }
        self.truncate(left);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::MetresPerSecond;

    const EXPLORE: Order = Order::explore(MetresPerSecond(0.25));

    #[test]
    fn nothing_replaces_a_stop() {
        let mut mailbox = Mailbox::new();
        let now = Instant::from_millis(1);
        mailbox.order(now, Order::Stop);
        (0..20).for_each(|_| mailbox.order(now, EXPLORE));
        for _ in 0..3 {
            assert_eq!(mailbox.take_order(now, Duration::ZERO), Some(Order::Stop));
        }
    }

    #[test]
    fn an_order_is_given_once_and_not_before_its_time() {
        let mut mailbox = Mailbox::new();
        let delay = Duration::from_millis(200);
        mailbox.order(Instant::from_millis(100), Order::Land);
        mailbox.order(Instant::from_millis(150), Order::Return);
        assert_eq!(mailbox.take_order(Instant::from_millis(299), delay), None);
        assert_eq!(mailbox.take_order(Instant::from_millis(300), delay), Some(Order::Land));
        assert_eq!(mailbox.take_order(Instant::from_millis(400), delay), Some(Order::Return));
        assert_eq!(mailbox.take_order(Instant::from_millis(500), delay), None);
    }
}
