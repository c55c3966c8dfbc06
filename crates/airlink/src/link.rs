//! One node's link: packets in, at most one event out; what is to be said in, packets out.

mod life;
mod receiving;
mod sending;
mod turns;

use life::Life;
use turns::Open;
use units::{Dbm, Instant, NodeId, Order, Role};
use wire::p2p::{Beacon, Counter, Epoch, Membership, ORDER, Report, TELEMETRY, Telemetry, Wave};
use wire::syslink::MAX_P2P;

use crate::config::LinkConfig;
use crate::counters::Counters;
use crate::follow::Follow;
use crate::orders::Orders;
use crate::peers::Peers;
use crate::relay::Passing;
use crate::schedule::{FRAME, Schedule, first_wait};
use crate::seal::Seal;
use crate::teller::Teller;

/// Who a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// Its number.
    pub node: NodeId,
    /// What it is in the chain.
    pub role: Role,
}

/// What a packet has brought. All of it is authentic, and newer than the last of its kind.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// How somebody flies, and how it hears the others.
    Report {
        /// Who said it.
        from: NodeId,
        /// The packet's number.
        counter: Counter,
        /// What it said.
        report: Report,
        /// How strongly it came in.
        rssi: Dbm,
    },
    /// Somebody is there.
    Beacon {
        /// Who said it.
        from: NodeId,
        /// What it said.
        beacon: Beacon,
        /// How strongly it came in.
        rssi: Dbm,
    },
    /// What the base wants this node to do.
    Order {
        /// To do what.
        task: Order,
        /// The order's number.
        counter: Counter,
    },
    /// What a node tells this one, which is the base.
    Telemetry {
        /// Who says it, however it came here.
        from: NodeId,
        /// What it says.
        telemetry: Telemetry,
        /// The number that it gave to it.
        counter: Counter,
    },
    /// Somebody comes, goes, or may not.
    Membership {
        /// Who said so.
        from: NodeId,
        /// What changes.
        membership: Membership,
    },
}

/// How a node stands with the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Whether it may speak.
    pub standing: Standing,
    /// Whose frame it follows; `None` for its own clock's.
    pub follows: Option<NodeId>,
}

/// Whether a node may speak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Standing {
    /// Not yet: it listens for the others' turns.
    Listening,
    /// It may.
    Member,
    /// Never again until it is switched on anew: its number is somebody else's.
    Refused,
    /// Never again until it is switched on anew: it has said goodbye.
    Left,
    /// Never again until it is switched on anew: it has used up the numbers of this epoch.
    Exhausted,
}

/// The two ends of what is sealed end to end.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one, for ever, and no heap")]
enum End {
    Base(Orders),
    Drone(Teller),
}

/// One node's link. It cannot be copied: two that count alike would use every nonce twice.
#[derive(Debug)]
pub struct Airlink<S> {
    config: LinkConfig,
    identity: Identity,
    seal: S,
    schedule: Schedule,
    epoch: Epoch,
    life: Life,
    follow: Follow,
    peers: Peers,
    commands: Passing<ORDER>,
    telemetry: Passing<TELEMETRY>,
    end: End,
    /// No turn that began before this is used any more.
    from: Instant,
    open: Option<Open>,
    joins: bool,
    /// The epoch of another node of this one's number, which is to be told so from then on.
    refuses: Option<(u16, Instant)>,
    refused_at: Option<Instant>,
    report: Option<Report>,
    beacon: Beacon,
    beacon_at: Instant,
    counters: Counters,
}

/// The count of a node's first packet. None is zero, for telemetry says by a zero that no command
/// was heeded.
const FIRST: u32 = 1;

impl<S: Seal> Airlink<S> {
    /// The link of `identity`, switched on at `now` for the time `epoch`. It speaks after it has
    /// listened for a while.
    ///
    /// `epoch` must never have been used before with the keys of `seal`, and `schedule` must be
    /// made for `identity`'s number.
    pub fn new(
        config: LinkConfig,
        identity: Identity,
        seal: S,
        epoch: Epoch,
        schedule: Schedule,
        now: Instant,
    ) -> Self {
        let until = now + FRAME + FRAME + first_wait(identity.node);
        Self {
            config,
            identity,
            seal,
            schedule,
            epoch,
            life: Counter::new(epoch, FIRST)
                .map_or(Life::Exhausted, |next| Life::Listening { until, next }),
            follow: Follow::new(now),
            peers: Peers::new(),
            commands: Passing::new(Wave::Outward),
            telemetry: Passing::new(Wave::Inward),
            end: match identity.role {
                Role::Base => End::Base(Orders::new()),
                Role::Head | Role::Relay => End::Drone(Teller::new()),
            },
            from: until,
            open: None,
            joins: true,
            refuses: None,
            refused_at: None,
            report: None,
            beacon: Beacon { role: identity.role, state: 0, battery: None },
            beacon_at: until,
            counters: Counters::default(),
        }
    }

    /// Takes a P2P packet's data, the moment that it has come in. At most one event comes of it.
    pub fn receive(&mut self, now: Instant, rssi: Dbm, data: &[u8]) -> Option<Event> {
        match self.take(now, rssi, data) {
            Ok(event) => event,
            Err(reason) => {
                self.counters.refused.count(reason);
                None
            }
        }
    }

    /// The agent's newest report, to be sent once. Whom it has heard is filled in then.
    pub fn report(&mut self, report: Report) {
        self.report = Some(report);
    }

    /// What the next beacons say.
    pub fn beacon(&mut self, beacon: Beacon) {
        self.beacon = beacon;
    }

    /// Gives the base the operator's order to all drones, which stands until the next. An order to
    /// explore reaches the head once for each time that this is called, but no more often than
    /// [`LinkConfig::stick_every`]: when the operator falls silent, so does the base.
    ///
    /// It returns whether the order now stands. It does not where a [`Stop`](Order::Stop) stands
    /// already, which only a reset of the base takes back, nor at a node that is not the base or
    /// that may not speak any more.
    pub fn order(&mut self, now: Instant, order: Order) -> bool {
        match (&mut self.end, self.life.next()) {
            (End::Base(orders), Some(next)) => orders.order(now, order, next, &self.config),
            (End::Base(_), None) | (End::Drone(_), _) => false,
        }
    }

    /// Everywhere but at the base: what the next telemetry says. Which command was heeded last is
    /// filled in here.
    pub fn telemeter(&mut self, telemetry: Telemetry) {
        if let End::Drone(teller) = &mut self.end {
            teller.tell(telemetry);
        }
    }

    /// Says goodbye in this node's next turn, and is then silent for good: whoever hears it forgets
    /// this node at once. Nothing else is said any more.
    pub fn leave(&mut self) {
        self.life.leave();
    }

    /// When to call [`transmit`](Self::transmit) next; ask again after every other call. It may be
    /// past, and [`transmit`](Self::transmit) may then have nothing after all: ask again.
    #[must_use]
    pub fn due(&self) -> Option<Instant> {
        self.next_turn()
    }

    /// Writes the packet that is to be sent now, if there is one, and returns its length. It must
    /// be given to the serial line at once: its moment tells the others when this node's turns are.
    pub fn transmit(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        self.speak(now, out)
    }

    /// How this node stands with the others.
    #[must_use]
    pub fn status(&self) -> Status {
        Status { standing: self.life.standing(), follows: self.follow.lead() }
    }

    /// What has been counted since boot.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }
}

#[cfg(test)]
mod tests {
    use wire::p2p::Header;
    use wire::radio::Datarate;

    use super::*;
    use crate::keys::{Key, Keys, Own};
    use crate::seal::Sealed;

    /// Nobody can wait for 2²⁴ packets, so this begins near the end.
    #[test]
    fn when_the_count_is_used_up_a_node_falls_silent() {
        let identity = Identity { node: NodeId(1), role: Role::Relay };
        let key = Key::from_bytes([7; 16]);
        let seal = Sealed::new(Keys { group: key.clone(), own: Own::Node(key) });
        let schedule = Schedule::new(Datarate::Mbit2, identity.node).unwrap();
        let epoch = Epoch::FIRST;
        let mut link =
            Airlink::new(LinkConfig::DEFAULT, identity, seal, epoch, schedule, Instant::ZERO);
        let last = Counter::new(epoch, (1 << 24) - 1).unwrap();
        let next = Counter::new(epoch, last.count() - 1).unwrap();
        link.life = Life::Member { since: Instant::ZERO, next };
        let mut sent = std::vec::Vec::new();
        let mut out = [0; MAX_P2P];
        for _ in 0..100 {
            let Some(due) = link.due() else { break };
            if let Some(length) = link.transmit(due, &mut out) {
                sent.push(Header::decode(out.get(..length).unwrap()).unwrap().0.counter);
            }
        }
        assert_eq!(sent, [next, last]);
        assert_eq!(link.status().standing, Standing::Exhausted);
        assert_eq!(link.transmit(Instant::from_millis(99_999), &mut out), None);
    }

    /// What the board sets aside for it.
    #[test]
    fn a_link_takes_less_than_4_kilobytes() {
        assert!(size_of::<Airlink<Sealed>>() < 4096, "{}", size_of::<Airlink<Sealed>>());
    }
}
