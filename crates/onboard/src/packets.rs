//! Receives and transmits a drone's packets of the chain.

use agent::Told;
use airlink::{Airlink, Event, Opened, Seal};
use chain::neighbours::Heard;
use crtp::Node;
use units::{Dbm, Instant, Order};
use wire::p2p::Kind;
use wire::syslink::MAX_P2P;

use crate::link::Link;
use crate::{Drone, Keys, air};

impl<S: Seal> Drone<S> {
    /// Gives the drone its keys, once. With usable ones its link opens: it listens, then transmits.
    pub fn open_link(&mut self, now: Instant, keys: Keys<S>) {
        match keys {
            Keys::Missing => self.link = Link::NoKeys,
            Keys::Unusable => self.link = Link::Shut,
            Keys::Held { seal, epoch, schedule, may_fly } => {
                self.may_fly = may_fly;
                let (config, identity) = (self.config.link, self.identity);
                let link = Airlink::new(config, identity, seal, epoch, schedule, now);
                self.link = Link::Open(link);
                self.repeat_order(now);
            }
        }
    }

    /// Processes a P2P packet of the chain at the moment of its reception. Returns the kind of the
    /// message in it that is for this drone, if any.
    pub fn receive(&mut self, now: Instant, rssi: Dbm, packet: &[u8]) -> Option<Kind> {
        let opened = self.open(packet)?;
        self.receive_opened(now, rssi, &opened)
    }

    /// Reads a P2P packet of the chain with the fleet's key; `None` while the link is shut. The
    /// result is the same for all drones of a fleet.
    #[must_use]
    pub fn open(&self, packet: &[u8]) -> Option<Opened> {
        Some(self.link.open()?.open(packet))
    }

    /// Processes an opened packet as [`Drone::receive`] processes its bytes.
    pub fn receive_opened(&mut self, now: Instant, rssi: Dbm, packet: &Opened) -> Option<Kind> {
        Some(match self.link.open_mut()?.receive_opened(now, rssi, packet)? {
            Event::Report { from, counter, report, rssi } => {
                let me = self.identity.node;
                self.hear(now, air::report_from_air(me, from, counter, &report, rssi));
                Kind::Report
            }
            Event::Order { task, counter } => {
                self.heeded.last = Some(counter);
                self.heed(now, task);
                Kind::Command
            }
            Event::Telemetry { from, telemetry, .. } => {
                if let Some(place) = self.nodes.get_mut(usize::from(from.0)) {
                    *place = Some(Node { telemetry, heard: now });
                }
                Kind::Telemetry
            }
            Event::Beacon { .. } => Kind::Beacon,
            Event::Membership { .. } => Kind::Membership,
            Event::Mission { from, message, rssi } => {
                if message.mission == self.agent.mission() {
                    self.mailbox.told(Told { from, at: now, rssi, payload: message.payload });
                }
                Kind::Mission
            }
        })
    }

    /// Processes another node's report, which came in a packet or, in a simulation with the ideal
    /// link, without one.
    pub fn hear(&mut self, now: Instant, report: Heard) {
        self.mailbox.report(now, report);
    }

    /// Processes an order of the base, which came in a packet or, in a simulation with the ideal
    /// link, without one.
    pub fn heed(&mut self, now: Instant, order: Order) {
        self.heeded.count = self.heeded.count.wrapping_add(1);
        self.mailbox.order(now, order);
    }

    /// Returns the time at which to call [`Drone::transmit`] next. Every other call may change it.
    #[must_use]
    pub fn due(&mut self) -> Option<Instant> {
        self.link.open_mut()?.due()
    }

    /// Writes the packet of the chain that is to be sent now, if there is one, and returns its
    /// length. The packet must be given to the serial line at once.
    pub fn transmit(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        self.link.open_mut()?.transmit(now, out)
    }

    /// Leaves the chain in the drone's next turn, if its link is open. Returns whether the link is
    /// open.
    pub fn leave(&mut self) -> bool {
        self.link.open_mut().map(Airlink::leave).is_some()
    }
}
