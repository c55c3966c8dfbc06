//! [`Airlink`], one node's link: takes received packets and returns events, takes messages to send
//! and returns packets.

mod lifecycle;
mod opened;
mod receiving;
mod sending;
mod turns;

use heapless::Deque;
use lifecycle::Lifecycle;
pub use opened::Opened;
use turns::OpenTurn;
use units::{Dbm, Instant, NodeId, Order, Role};
use wire::p2p::{
    Beacon, Counter, Epoch, Membership, MissionMessage, ORDER, Report, TELEMETRY, Telemetry, Wave,
};
use wire::syslink::MAX_P2P;

use crate::clock_sync::ClockSync;
use crate::config::LinkConfig;
use crate::counters::Counters;
use crate::order_distribution::OrderDistribution;
use crate::peers::Peers;
use crate::relay_queue::RelayQueue;
use crate::schedule::{FRAME, Schedule, Turns, first_wait};
use crate::seal::Seal;
use crate::telemetry_sender::TelemetrySender;

/// The number and the role of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// The node's number in the chain.
    pub node: NodeId,
    /// The node's role in the chain.
    pub role: Role,
}

/// The content of a received packet. It is authentic, and newer than the last of its kind from the
/// same node.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// A node reports how it flies, and how strongly it hears other nodes.
    Report {
        /// The node that sent the report.
        from: NodeId,
        /// The counter of the packet.
        counter: Counter,
        /// The report itself.
        report: Report,
        /// The strength at which this packet was received; `None` where it came later than the
        /// sender's packets do or out of its turn, so that it may have been held back.
        rssi: Option<Dbm>,
    },
    /// A node is present.
    Beacon {
        /// The node that sent the beacon.
        from: NodeId,
        /// The beacon itself.
        beacon: Beacon,
        /// The strength at which the sender's last packet in its turn was received.
        rssi: Dbm,
    },
    /// The base gives this node an order.
    Order {
        /// The order itself.
        task: Order,
        /// The counter of the order.
        counter: Counter,
    },
    /// A node sends telemetry to this one, which is the base.
    Telemetry {
        /// The node whose telemetry it is, which need not be the sender of the last hop.
        from: NodeId,
        /// The telemetry itself.
        telemetry: Telemetry,
        /// The counter that this node gave to the telemetry.
        counter: Counter,
    },
    /// A node joins, leaves, or is refused.
    Membership {
        /// The node that sent the message.
        from: NodeId,
        /// The change.
        membership: Membership,
    },
    /// A drone tells the others of its mission what only the mission reads.
    Mission {
        /// The node that sent the message.
        from: NodeId,
        /// The message itself.
        message: MissionMessage,
        /// The strength at which the sender's last packet in its turn was received.
        rssi: Dbm,
    },
}

/// Whether a node may send, and whose frame it follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Whether the node may send.
    pub standing: Standing,
    /// The node whose frame this node follows; `None` if it keeps time by its own clock.
    pub follows: Option<NodeId>,
}

/// Whether a node may send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Standing {
    /// The node may not send yet: it listens for the other nodes' turns.
    Listening,
    /// The node may send.
    Member,
    /// The node may not send before its next boot: another node keeps its number.
    Refused,
    /// The node may not send before its next boot: it has said that it leaves.
    Left,
    /// The node may not send before its next boot: it has used up the counters of this epoch.
    Exhausted,
}

/// This node's end of the exchange that is sealed end to end between the base and each drone.
#[derive(Clone, Debug)]
enum End {
    Base(OrderDistribution),
    Drone(TelemetrySender),
}

/// One node's link. It cannot be copied, because two links with the same counter would use every
/// nonce twice.
#[derive(Debug)]
pub struct Airlink<S> {
    config: LinkConfig,
    identity: Identity,
    seal: S,
    schedule: Schedule,
    epoch: Epoch,
    lifecycle: Lifecycle,
    clock_sync: ClockSync,
    peers: Peers,
    commands: RelayQueue<ORDER>,
    telemetry: RelayQueue<TELEMETRY>,
    end: End,
    /// A turn that began before this moment is not used any more.
    no_turn_before: Instant,
    open_turn: Option<OpenTurn>,
    turns: Turns,
    /// When nodes that would share turns were last seen to be too near to each other.
    crowded_at: Option<Instant>,
    join_pending: bool,
    /// The epoch of another node with this one's number, and when to send the refusal to it.
    pending_refusal: Option<(Epoch, Instant)>,
    last_refusal: Option<Instant>,
    report: Option<Report>,
    /// The mission's messages that are to be sent, the oldest first.
    missions: Deque<MissionMessage, MISSIONS>,
    beacon: Beacon,
    beacon_due_at: Instant,
    counters: Counters,
    /// What [`due`](Self::due) has found, until something changes on which it depends.
    due: Option<Due>,
}

/// The time at which a link has something to send next, if ever.
#[derive(Clone, Copy, Debug)]
struct Due(Option<Instant>);

/// The most messages of a mission that wait to be sent: one for each turn of a round of the mission.
const MISSIONS: usize = 4;

/// The count of a node's first packet. It is not zero, because a zero in telemetry means that no
/// command was accepted.
const FIRST: u32 = 1;

impl<S: Seal> Airlink<S> {
    /// The link of the node `identity`, which is switched on at `now` and begins the epoch `epoch`.
    /// It sends after it has listened for a while.
    ///
    /// `epoch` must never have been used before with the keys of `seal`, and `schedule` must be
    /// that of `identity`'s number.
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
            lifecycle: Counter::new(epoch, FIRST)
                .map_or(Lifecycle::Exhausted, |next| Lifecycle::Listening { until, next }),
            clock_sync: ClockSync::new(now),
            peers: Peers::new(),
            commands: RelayQueue::new(Wave::Outward),
            telemetry: RelayQueue::new(Wave::Inward),
            end: match identity.role {
                Role::Base => End::Base(OrderDistribution::new()),
                Role::Head | Role::Relay => End::Drone(TelemetrySender::new()),
            },
            no_turn_before: until,
            open_turn: None,
            turns: Turns::Own,
            crowded_at: None,
            join_pending: true,
            pending_refusal: None,
            last_refusal: None,
            report: None,
            missions: Deque::new(),
            beacon: Beacon { role: identity.role, state: 0, battery: None },
            beacon_due_at: until,
            counters: Counters::default(),
            due: None,
        }
    }

    /// Takes the data of a P2P packet at the moment of its reception, and returns its event, if
    /// any.
    pub fn receive(&mut self, now: Instant, rssi: Dbm, data: &[u8]) -> Option<Event> {
        let opened = self.open(data);
        self.receive_opened(now, rssi, &opened)
    }

    /// Reads the data of a P2P packet with the fleet's key. The result is the same for all nodes
    /// with the same key and data rate, so a simulator can open a packet once for all nodes that
    /// receive it.
    #[must_use]
    pub fn open(&self, data: &[u8]) -> Opened {
        Opened::open(&self.seal, &self.schedule, data)
    }

    /// Takes an opened packet as [`receive`](Self::receive) takes its data.
    pub fn receive_opened(&mut self, now: Instant, rssi: Dbm, opened: &Opened) -> Option<Event> {
        let before = self.turn_state();
        let processed = self.process(now, rssi, opened);
        if self.turn_state() != before {
            self.due = None;
        }
        match processed {
            Ok(event) => event,
            Err(reason) => {
                self.counters.refused.count(reason);
                None
            }
        }
    }

    /// Sets the agent's newest report, which is sent once. The link adds the nodes that it
    /// receives.
    pub fn report(&mut self, report: Report) {
        self.report = Some(report);
        self.due = None;
    }

    /// Puts a message of the mission behind those that are to be sent. Each is sent once. Where four
    /// wait already, the oldest is dropped.
    pub fn tell(&mut self, message: MissionMessage) {
        if self.missions.is_full() {
            let _ = self.missions.pop_front();
        }
        // There is room for one now.
        let _ = self.missions.push_back(message);
        self.due = None;
    }

    /// Sets the content of the next beacons.
    pub fn beacon(&mut self, beacon: Beacon) {
        self.beacon = beacon;
    }

    /// Gives the base the operator's order to all drones, which is valid until the next. An order
    /// to explore is sent to the head once for each call, but no more often than every
    /// [`LinkConfig::stick_every`]: when the operator's client stops sending, the base stops
    /// sending it, too.
    ///
    /// Returns whether the order is now valid. The order is refused after a [`Stop`](Order::Stop),
    /// which only a reset of the base revokes, and at a node that is not the base or that may not
    /// send any more.
    pub fn order(&mut self, now: Instant, order: Order) -> bool {
        self.due = None;
        match (&mut self.end, self.lifecycle.next()) {
            (End::Base(orders), Some(next)) => orders.set_order(now, order, next, &self.config),
            (End::Base(_), None) | (End::Drone(_), _) => false,
        }
    }

    /// Sets the content of a drone's next telemetry, and does nothing at the base. The link fills
    /// in the last command that the drone has accepted.
    pub fn telemeter(&mut self, telemetry: Telemetry) {
        if let End::Drone(sender) = &mut self.end {
            sender.set_telemetry(telemetry);
            self.due = None;
        }
    }

    /// Lets this node leave the chain: it announces this in its next turn, sends nothing else, and
    /// is then silent until its next boot. Nodes that receive the announcement remove this node
    /// from their tables at once.
    pub fn leave(&mut self) {
        self.lifecycle.leave();
        self.due = None;
    }

    /// Returns the time at which to call [`transmit`](Self::transmit) next; `None` if there is
    /// nothing to send. Any other call may change it. The time may be past, and
    /// [`transmit`](Self::transmit) may then have nothing to send; call `due` again afterwards.
    #[must_use]
    pub fn due(&mut self) -> Option<Instant> {
        let Due(due) = self.due.unwrap_or_else(|| Due(self.next_turn()));
        self.due = Some(Due(due));
        due
    }

    /// Writes the packet to send at `now`, if there is one, and returns its length. The packet must
    /// be given to the serial line at once, because the other nodes derive this node's frame from
    /// the time at which they receive it.
    pub fn transmit(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        self.due = None;
        self.write_next(now, out)
    }

    /// Whether this node may send, and whose frame it follows.
    #[must_use]
    pub fn status(&self) -> Status {
        Status { standing: self.lifecycle.standing(), follows: self.clock_sync.leader() }
    }

    /// The counts of packets since boot.
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

    /// A test cannot wait for 2²⁴ packets, so this one begins near the end.
    #[test]
    fn a_node_that_has_used_up_its_counters_falls_silent() {
        let identity = Identity { node: NodeId(1), role: Role::Relay };
        let key = Key::from_bytes([7; 16]);
        let seal = Sealed::new(Keys { group: key.clone(), own: Own::Node(key) });
        let schedule = Schedule::new(Datarate::Mbit2, identity.node).unwrap();
        let epoch = Epoch::FIRST;
        let mut link =
            Airlink::new(LinkConfig::DEFAULT, identity, seal, epoch, schedule, Instant::ZERO);
        let last = Counter::new(epoch, (1 << 24) - 1).unwrap();
        let next = Counter::new(epoch, last.count() - 1).unwrap();
        link.lifecycle = Lifecycle::Member { since: Instant::ZERO, next };
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

    /// The board sets aside 4 KiB for the link.
    #[test]
    fn a_link_takes_less_than_4_kilobytes() {
        assert!(size_of::<Airlink<Sealed>>() < 4096, "{}", size_of::<Airlink<Sealed>>());
    }
}
