//! The base's end: what everybody is to do, and who has been told.

use core::mem::discriminant;

use units::{Duration, Instant, NODES, NodeId, Order};
use wire::p2p::{Counter, Epoch, Telemetry, Wave};

use crate::config::LinkConfig;
use crate::relay::AGAINST;

/// The base's word, and how far it has got.
#[derive(Clone, Debug)]
pub(crate) struct Orders {
    task: Option<Order>,
    /// The number of the next packet when the task last changed its kind.
    changed: u16,
    /// Of each node the telemetry that came last. A node without is told nothing: its epoch, which
    /// an order names, is not known.
    known: [Option<Counter>; NODES],
    /// Bit `n`: node `n` has said that it heeds the task.
    heeded: u16,
    /// Bit `n`: node `n` is to be told as soon as possible.
    pending: u16,
    pending_at: Instant,
    /// When the operator last said anything, if the head has not been told since.
    stick: Option<Instant>,
    head_at: Instant,
    again_at: Instant,
    remind_at: Instant,
    reminded: u8,
}

/// More than a turn is off its time.
const EARLY: Duration = Duration::from_millis(5);

const HEAD: u16 = 1 << NodeId::HEAD.0;

impl Orders {
    pub(crate) const fn new() -> Self {
        Self {
            task: None,
            changed: 0,
            known: [None; NODES],
            heeded: 0,
            pending: 0,
            pending_at: Instant::ZERO,
            stick: None,
            head_at: Instant::ZERO,
            again_at: Instant::ZERO,
            remind_at: Instant::ZERO,
            reminded: 0,
        }
    }

    /// Takes the operator's order, unless a Stop stands: a client that goes on sending set-points
    /// must not set a drone flying that has not heard the Stop yet. Returns whether `task` stands.
    pub(crate) fn order(
        &mut self,
        now: Instant,
        task: Order,
        next: Counter,
        config: &LinkConfig,
    ) -> bool {
        if self.task == Some(Order::Stop) {
            return task == Order::Stop;
        }
        let is_other = self.task.is_none_or(|old| discriminant(&old) != discriminant(&task));
        if self.task != Some(task) {
            self.head_at = now;
        }
        self.task = Some(task);
        self.stick = Some(now);
        if is_other {
            self.changed = next.low16();
            self.heeded = 0;
            self.tell(now, self.all());
            self.again_at = now + config.again_after;
            self.remind_at = now + config.remind_every;
        }
        true
    }

    pub(crate) const fn task(&self) -> Option<Order> {
        self.task
    }

    pub(crate) fn epoch(&self, node: NodeId) -> Option<Epoch> {
        Some(self.last(node)?.epoch())
    }

    /// The number of the last telemetry of `node`.
    pub(crate) fn last(&self, node: NodeId) -> Option<Counter> {
        *self.known.get(usize::from(node.0))?
    }

    /// Takes in telemetry that is newer than the last of `node`.
    pub(crate) fn hear(&mut self, now: Instant, node: NodeId, counter: Counter, said: &Telemetry) {
        let reborn = self.epoch(node) != Some(counter.epoch());
        if let Some(place) = self.known.get_mut(usize::from(node.0)) {
            *place = Some(counter);
        }
        let bit = bit(node);
        if reborn {
            self.heeded &= !bit;
            // A head that comes back flies on when the operator says so again, not before.
            match self.task {
                None => {}
                Some(Order::Explore(_)) => self.tell(now, bit & !HEAD),
                Some(Order::Wait | Order::Return | Order::Land | Order::Stop) => {
                    self.tell(now, bit)
                }
            }
        } else if said.heeded != 0 && said.heeded.wrapping_sub(self.changed) < 1 << 15 {
            self.heeded |= bit;
        }
    }

    /// From when on somebody is to be told something in a turn of `wave`. The outward turn comes
    /// first: after it all others have theirs.
    pub(crate) fn ready(&self, wave: Wave) -> Option<Instant> {
        self.task?;
        let pending = (self.pending != 0).then_some(self.pending_at);
        let again = (self.slow() != 0).then_some(self.again_at);
        let remind = (self.all() & !HEAD != 0).then_some(self.remind_at);
        let head = self.head_waits().then_some(self.head_at);
        let ready = [pending, again, remind, head].into_iter().flatten().min()?;
        match wave {
            Wave::Outward => Some(ready),
            Wave::Inward => Some(ready + AGAINST),
        }
    }

    /// Whom to tell at `now`: the head before all others, and whoever has the longest way first.
    pub(crate) fn next(&mut self, now: Instant, wave: Wave, config: &LinkConfig) -> Option<NodeId> {
        if self.ready(wave)? > now {
            return None;
        }
        if let (Some(Order::Explore(_)), Some(at)) = (self.task, self.stick)
            && now.since(at) > config.stick_lasts
        {
            self.stick = None;
            self.pending &= !HEAD;
        }
        if self.slow() != 0 && self.again_at <= now {
            self.remind(self.slow());
            self.again_at = now + config.again_every;
        }
        if self.remind_at <= now {
            self.remind(self.all() & !HEAD);
            self.remind_at = now + config.remind_every;
        }
        if self.head_waits() && self.head_at <= now {
            self.pending |= HEAD;
        }
        (self.pending != 0).then(|| NodeId(self.pending.trailing_zeros() as u8))
    }

    /// `node` has been told. Everybody has time to say so before anybody is told again.
    pub(crate) fn told(&mut self, now: Instant, node: NodeId, config: &LinkConfig) {
        self.pending &= !bit(node);
        if node == NodeId::HEAD {
            self.stick = None;
            let every = match self.task {
                Some(Order::Explore(_)) => config.stick_every,
                _ => config.again_after,
            };
            // A little less, or each would wait for the turn after next.
            self.head_at = now + every - EARLY;
        } else if self.pending == 0 {
            self.again_at = self.again_at.max(now + config.again_every);
        }
        if self.pending != 0 {
            self.again_at = now + config.again_after;
        }
    }

    fn tell(&mut self, now: Instant, nodes: u16) {
        self.pending |= nodes;
        self.pending_at = now;
    }

    /// Whether the head is to be told its task every so often: to fly at a speed for as long as
    /// the operator says so, everything else until it does it.
    fn head_waits(&self) -> bool {
        self.all() & HEAD != 0
            && match self.task {
                None => false,
                Some(Order::Explore(_)) => self.stick.is_some(),
                Some(Order::Wait | Order::Return | Order::Land | Order::Stop) => {
                    self.heeded & HEAD == 0
                }
            }
    }

    /// Who has been told but does not say so; of the others than the head.
    fn slow(&self) -> u16 {
        self.all() & !self.heeded & !HEAD
    }

    /// Tells the next one of `nodes` after whoever was reminded last, going round.
    fn remind(&mut self, nodes: u16) {
        let beyond = nodes & !((2_u16 << (self.reminded & 15)).wrapping_sub(1));
        let from = if beyond != 0 { beyond } else { nodes };
        if from != 0 {
            self.reminded = from.trailing_zeros() as u8;
            self.pending |= from & from.wrapping_neg();
        }
    }

    fn all(&self) -> u16 {
        self.known
            .iter()
            .zip(0..16)
            .filter(|(last, _)| last.is_some())
            .fold(0, |set, (_, n)| set | 1 << n)
    }
}

const fn bit(node: NodeId) -> u16 {
    1 << (node.0 & 15)
}
