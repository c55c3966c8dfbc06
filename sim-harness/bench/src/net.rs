//! A chain of radio links without drones: ends that stand still, and the channel between them. The
//! ends are the firmware's own links, sealed.

use airlink::keys::{FleetSecret, Keys, Own, node};
use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Sealed};
use random::{Purpose, Stream};
use units::{Dbm, Instant, NodeId, Role};
use wire::p2p::Epoch;
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

use medium::{Ether, Medium};

const NEVER: u64 = u64::MAX;
/// The ends were switched on at different times, up to this long apart.
const OFFSETS_US: f32 = 60e6;
/// A link that was due and had no packet is asked again after this.
const RETRY_US: u64 = 1_000;

/// The keys of a fleet, as its host has them.
pub(super) struct Fleet {
    group: airlink::keys::Key,
    base: airlink::keys::Key,
}

impl Fleet {
    /// The fleet of this seed.
    pub(super) fn of(seed: u64) -> Self {
        let secret = FleetSecret::from_bytes(Stream::new(seed, Purpose::Keys).bytes());
        Self { group: secret.group(1), base: secret.base(1) }
    }

    /// The keys of node `number` of a chain.
    pub(super) fn keys(&self, number: u8, is_base: bool) -> Sealed {
        let own = if is_base {
            Own::Base(self.base.clone())
        } else {
            Own::Node(node(&self.base, NodeId(number)))
        };
        Sealed::new(Keys { group: self.group.clone(), own })
    }
}

/// One end.
pub(super) struct End {
    pub(super) link: Airlink<Sealed>,
    offset_us: u64,
    due_us: u64,
}

impl End {
    /// The end of number `number` in a chain whose base is `base`.
    pub(super) fn new(fleet: &Fleet, number: u8, base: u8, random: &mut Stream) -> Self {
        let role = match number {
            0 => Role::Head,
            _ if number == base => Role::Base,
            _ => Role::Relay,
        };
        let offset_us = (random.uniform() * OFFSETS_US) as u64;
        let schedule = Schedule::new(Datarate::Mbit2, NodeId(number))
            .expect("a chain of 16 has turns for all of its drones");
        let identity = Identity { node: NodeId(number), role };
        let seal = fleet.keys(number, number == base);
        let now = Instant::from_micros(offset_us);
        let epoch = Epoch::FIRST;
        let link = Airlink::new(LinkConfig::DEFAULT, identity, seal, epoch, schedule, now);
        let mut end = Self { link, offset_us, due_us: NEVER };
        end.look(0);
        end
    }

    /// The clock of the end.
    pub(super) const fn clock(&self, now_us: u64) -> Instant {
        Instant::from_micros(now_us + self.offset_us)
    }

    /// Asks the link anew when it wants to send; to be called after every other call.
    pub(super) fn look(&mut self, now_us: u64) {
        let due = self.link.due().map(|due| due.as_micros().saturating_sub(self.offset_us));
        self.due_us = due.map_or(NEVER, |due_us| due_us.max(now_us));
    }
}

/// A chain and its channel. The ends have the numbers of their stations.
pub(super) struct Net {
    pub(super) ends: Vec<End>,
    pub(super) medium: Medium,
}

impl Net {
    /// Lets all ends send and receive until `until_us`; `took` is called with each event.
    pub(super) fn run(
        &mut self,
        until_us: u64,
        ether: &mut impl Ether,
        mut took: impl FnMut(usize, u64, Event),
    ) {
        loop {
            let speaks = (0..self.ends.len()).min_by_key(|&n| self.ends[n].due_us);
            let due_us = speaks.map_or(NEVER, |n| self.ends[n].due_us);
            let arrives_us = self.medium.next().unwrap_or(NEVER);
            if due_us.min(arrives_us) >= until_us {
                return;
            }
            if arrives_us <= due_us {
                self.arrive(ether, &mut took);
            } else if let Some(n) = speaks {
                self.speak(n, due_us);
            }
        }
    }

    fn arrive(&mut self, ether: &mut impl Ether, took: &mut impl FnMut(usize, u64, Event)) {
        let Some(arrival) = self.medium.advance(ether) else { return };
        for receipt in arrival.heard {
            let Some(end) = self.ends.get_mut(receipt.by) else { continue };
            let event = end.link.receive(end.clock(arrival.at_us), receipt.rssi, arrival.data);
            end.look(arrival.at_us);
            if let Some(event) = event {
                took(receipt.by, arrival.at_us, event);
            }
        }
    }

    fn speak(&mut self, n: usize, now_us: u64) {
        let end = &mut self.ends[n];
        let mut packet = [0; MAX_P2P];
        match end.link.transmit(end.clock(now_us), &mut packet) {
            Some(length) => {
                end.look(now_us);
                self.medium.send(n, now_us, &packet[..length]);
            }
            None => end.look(now_us + RETRY_US),
        }
    }
}

/// Each node hears its neighbours in the chain only.
pub(super) fn next_only(from: usize, to: usize) -> Option<Dbm> {
    (from.abs_diff(to) == 1).then_some(Dbm(-60.0))
}
