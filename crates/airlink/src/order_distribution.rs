//! The base's end of the sealed exchange with the drones: distributes the operator's order, and
//! records which node has acknowledged it.

use core::mem::discriminant;

use units::{Duration, Instant, NODES, NodeId, Order};
use wire::p2p::{Counter, Epoch, Telemetry, Wave};

use crate::config::LinkConfig;
use crate::relay_queue::AGAINST_WAVE_DELAY;

/// The operator's order to all drones, and how far it has got.
#[derive(Clone, Debug)]
pub(crate) struct OrderDistribution {
    order: Option<Order>,
    /// The low half of the next packet's counter when the order last changed its kind. Telemetry
    /// that names this counter or a later one acknowledges the order.
    changed_at: u16,
    /// The counter of each node's last telemetry. A node without one gets no order, because its
    /// epoch, which an order names, is not known.
    last_telemetry: [Option<Counter>; NODES],
    /// Bit `n` is set when telemetry of node `n` has come.
    known: u16,
    /// Bit `n` is set when node `n` has acknowledged the order.
    acknowledged: u16,
    /// Bit `n` is set while the order is to be sent to node `n` as soon as possible.
    pending: u16,
    pending_since: Instant,
    /// When the operator last gave an order, if none was sent to the head since.
    stick_at: Option<Instant>,
    head_due_at: Instant,
    retry_due_at: Instant,
    reminder_due_at: Instant,
    last_reminded: u8,
}

/// More than a turn deviates from its time.
const TURN_MARGIN: Duration = Duration::from_millis(5);

const HEAD: u16 = 1 << NodeId::HEAD.0;

impl OrderDistribution {
    pub(crate) const fn new() -> Self {
        Self {
            order: None,
            changed_at: 0,
            last_telemetry: [None; NODES],
            known: 0,
            acknowledged: 0,
            pending: 0,
            pending_since: Instant::ZERO,
            stick_at: None,
            head_due_at: Instant::ZERO,
            retry_due_at: Instant::ZERO,
            reminder_due_at: Instant::ZERO,
            last_reminded: 0,
        }
    }

    /// Takes the operator's order, unless a Stop stands: a client that goes on sending set-points
    /// must not set a drone flying that has not heard the Stop yet. Returns whether `order` stands.
    pub(crate) fn set_order(
        &mut self,
        now: Instant,
        order: Order,
        next: Counter,
        config: &LinkConfig,
    ) -> bool {
        if self.order == Some(Order::Stop) {
            return order == Order::Stop;
        }
        let is_other = self.order.is_none_or(|old| discriminant(&old) != discriminant(&order));
        if self.order != Some(order) {
            self.head_due_at = now;
        }
        self.order = Some(order);
        self.stick_at = Some(now);
        if is_other {
            self.changed_at = next.low16();
            self.acknowledged = 0;
            self.add_pending(now, self.known);
            self.retry_due_at = now + config.again_after;
            self.reminder_due_at = now + config.remind_every;
        }
        true
    }

    pub(crate) const fn order(&self) -> Option<Order> {
        self.order
    }

    /// The epoch of `node`, known from its telemetry.
    pub(crate) fn epoch(&self, node: NodeId) -> Option<Epoch> {
        Some(self.last_telemetry(node)?.epoch())
    }

    /// The counter of the last telemetry of `node`.
    pub(crate) fn last_telemetry(&self, node: NodeId) -> Option<Counter> {
        *self.last_telemetry.get(usize::from(node.0))?
    }

    /// Accepts telemetry that is newer than the last of `node`, with the acknowledgement in it.
    pub(crate) fn accept_telemetry(
        &mut self,
        now: Instant,
        node: NodeId,
        counter: Counter,
        telemetry: &Telemetry,
    ) {
        let rebooted = self.epoch(node) != Some(counter.epoch());
        if let Some(last) = self.last_telemetry.get_mut(usize::from(node.0)) {
            *last = Some(counter);
            self.known |= bit(node);
        }
        let bit = bit(node);
        let heeded = telemetry.heeded;
        if rebooted {
            self.acknowledged &= !bit;
            // A head that has rebooted flies on only when the operator orders it again.
            match self.order {
                None => {}
                Some(Order::Explore(..)) => self.add_pending(now, bit & !HEAD),
                Some(Order::Wait | Order::Return | Order::Land | Order::Perch | Order::Stop) => {
                    self.add_pending(now, bit)
                }
            }
        } else if heeded != 0 && heeded.wrapping_sub(self.changed_at) < 1 << 15 {
            self.acknowledged |= bit;
        }
    }

    /// The time from which an order is due in a turn of `wave`. The outward turn is preferred,
    /// because after it all other nodes have theirs.
    pub(crate) fn due_at(&self, wave: Wave) -> Option<Instant> {
        self.order?;
        let pending = (self.pending != 0).then_some(self.pending_since);
        let retry = (self.unacknowledged() != 0).then_some(self.retry_due_at);
        let reminder = (self.known & !HEAD != 0).then_some(self.reminder_due_at);
        let head = self.head_needs_order().then_some(self.head_due_at);
        let sooner = |a: Option<Instant>, b: Option<Instant>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let due_at = sooner(sooner(pending, retry), sooner(reminder, head))?;
        match wave {
            Wave::Outward => Some(due_at),
            Wave::Inward => Some(due_at + AGAINST_WAVE_DELAY),
        }
    }

    /// The node to send the order to at `now`: the head before all others, then the node with the
    /// longest way.
    pub(crate) fn next_recipient(
        &mut self,
        now: Instant,
        wave: Wave,
        config: &LinkConfig,
    ) -> Option<NodeId> {
        if self.due_at(wave)? > now {
            return None;
        }
        if let (Some(Order::Explore(..)), Some(at)) = (self.order, self.stick_at)
            && now.since(at) > config.stick_lasts
        {
            self.stick_at = None;
            self.pending &= !HEAD;
        }
        if self.unacknowledged() != 0 && self.retry_due_at <= now {
            self.remind_next(self.unacknowledged());
            self.retry_due_at = now + config.again_every;
        }
        if self.reminder_due_at <= now {
            self.remind_next(self.known & !HEAD);
            self.reminder_due_at = now + config.remind_every;
        }
        if self.head_needs_order() && self.head_due_at <= now {
            self.pending |= HEAD;
        }
        (self.pending != 0).then(|| NodeId(self.pending.trailing_zeros() as u8))
    }

    /// Records that the order was sent to `node`. All nodes have time to acknowledge it before it
    /// is repeated to any.
    pub(crate) fn mark_sent(&mut self, now: Instant, node: NodeId, config: &LinkConfig) {
        self.pending &= !bit(node);
        if node == NodeId::HEAD {
            self.stick_at = None;
            let every = match self.order {
                Some(Order::Explore(..)) => config.stick_every,
                _ => config.again_after,
            };
            // Without the margin each order would miss the next turn by a little and wait for the
            // one after it.
            self.head_due_at = now + every - TURN_MARGIN;
        } else if self.pending == 0 {
            self.retry_due_at = self.retry_due_at.max(now + config.again_every);
        }
        if self.pending != 0 {
            self.retry_due_at = now + config.again_after;
        }
    }

    fn add_pending(&mut self, now: Instant, nodes: u16) {
        self.pending |= nodes;
        self.pending_since = now;
    }

    /// Whether the order is to be repeated to the head: an order to explore for as long as the
    /// operator goes on giving it, any other order until the head acknowledges it.
    fn head_needs_order(&self) -> bool {
        self.known & HEAD != 0
            && match self.order {
                None => false,
                Some(Order::Explore(..)) => self.stick_at.is_some(),
                Some(Order::Wait | Order::Return | Order::Land | Order::Perch | Order::Stop) => {
                    self.acknowledged & HEAD == 0
                }
            }
    }

    /// The known nodes other than the head that have not acknowledged the order.
    fn unacknowledged(&self) -> u16 {
        self.known & !self.acknowledged & !HEAD
    }

    /// Makes the order pending for the one of `nodes` that follows the last reminded node, going
    /// round.
    fn remind_next(&mut self, nodes: u16) {
        let beyond = nodes & !((2_u16 << (self.last_reminded & 15)).wrapping_sub(1));
        let from = if beyond != 0 { beyond } else { nodes };
        if from != 0 {
            self.last_reminded = from.trailing_zeros() as u8;
            self.pending |= from & from.wrapping_neg();
        }
    }
}

const fn bit(node: NodeId) -> u16 {
    1 << (node.0 & 15)
}
