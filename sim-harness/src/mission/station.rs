//! A member's end of the radio link: the very `airlink::Airlink` that the firmware runs, on a clock
//! that is nobody else's.

use agent::{Outputs, air};
use airlink::{Airlink, Counters, Event, Identity, LinkConfig, Schedule, Status};
use chain::neighbours::Heard;
use units::{Dbm, Instant, NodeId, Order, Role};
use wire::p2p::{Beacon, Counter, Epoch, Telemetry};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

use super::seal::Cipher;
use crate::random::{Purpose, Stream};

/// Never.
const NEVER: u64 = u64::MAX;
/// Clocks are up to this far apart: somebody was switched on an hour before.
const OFFSETS_S: f32 = 3_600.0;
/// A drone has been switched on up to so many times before.
const BOOTS: f32 = 1_000.0;
/// A link that says that it has something to send, and then has nothing, is asked again only
/// after this long.
const RETRY_US: u64 = 1_000;

/// What the link brought, as the mission sees it.
#[derive(Clone, Copy, Debug)]
pub(super) enum News {
    /// A report.
    Heard(Heard),
    /// The operator's newest order.
    Order(Order),
    /// At the base: how a node is.
    Telemetry(NodeId, Telemetry),
}

/// One end of the link.
pub(super) struct Station {
    link: Airlink<Cipher>,
    /// Its clock is the mission's and this much.
    offset_us: u64,
    /// When it has something to send, by the mission's clock.
    due_us: u64,
    heeded: Option<Counter>,
}

impl Station {
    /// Switched on at the beginning of the mission.
    pub(super) fn new(identity: Identity, cipher: Cipher, datarate: Datarate, seed: u64) -> Self {
        let mut random = Stream::new(seed, Purpose::Radio(identity.node.0));
        let offset_us = (random.uniform() * OFFSETS_S * 1e6) as u64;
        let boots = (random.uniform() * BOOTS) as u32;
        let epoch = Epoch::new(1 + boots).unwrap_or(Epoch::FIRST);
        let schedule = Schedule::new(datarate, identity.node)
            .expect("a checked scenario has no more members than the frame has slots");
        let now = Instant::from_micros(offset_us);
        let link = Airlink::new(LinkConfig::DEFAULT, identity, cipher, epoch, schedule, now);
        let mut station = Self { link, offset_us, due_us: NEVER, heeded: None };
        station.look(0);
        station
    }

    const fn clock(&self, now_us: u64) -> Instant {
        Instant::from_micros(now_us + self.offset_us)
    }

    /// Asks the link anew when it wants to send.
    fn look(&mut self, now_us: u64) {
        let due = self.link.due().map(|due| due.as_micros().saturating_sub(self.offset_us));
        self.due_us = due.map_or(NEVER, |due_us| due_us.max(now_us));
    }

    /// When it next has something to send.
    pub(super) const fn due_us(&self) -> u64 {
        self.due_us
    }

    /// Takes a packet from the radio.
    pub(super) fn receive(&mut self, now_us: u64, rssi: Dbm, data: &[u8]) -> Option<News> {
        let now = self.clock(now_us);
        let event = self.link.receive(now, rssi, data);
        // Whoever has heard a report or a beacon has nothing new to pass on. Its turn may have
        // moved by a little, which it finds out when it comes.
        if !matches!(event, Some(Event::Report { .. } | Event::Beacon { .. })) {
            self.look(now_us);
        }
        match event? {
            Event::Report { from, counter, report, rssi } => {
                Some(News::Heard(air::report_from_air(from, counter, &report, rssi)))
            }
            Event::Order { task, counter } => {
                self.heeded = Some(counter);
                Some(News::Order(task))
            }
            Event::Telemetry { from, telemetry, .. } => Some(News::Telemetry(from, telemetry)),
            _ => None,
        }
    }

    /// Hands over what is due, if anything is.
    pub(super) fn transmit(&mut self, now_us: u64, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        let now = self.clock(now_us);
        let sent = self.link.transmit(now, out);
        self.look(now_us);
        if sent.is_none() && self.due_us == now_us {
            self.due_us = now_us + RETRY_US;
        }
        sent
    }

    /// What the mind has decided in its round goes into the link.
    pub(super) fn say(
        &mut self,
        now_us: u64,
        outputs: &Outputs,
        role: Role,
        machine: &air::Machine,
    ) {
        let machine = air::Machine { heeded: self.heeded, ..*machine };
        self.link.report(air::report_to_air(outputs));
        self.link.beacon(Beacon {
            role,
            state: outputs.status.state.code(),
            battery: machine.battery,
        });
        if role != Role::Base {
            self.link.telemeter(air::telemetry(outputs, &machine));
        }
        self.look(now_us);
    }

    /// At the base: the operator's word.
    pub(super) fn order(&mut self, now_us: u64, task: Order) {
        let now = self.clock(now_us);
        self.link.order(now, task);
        self.look(now_us);
    }

    /// What the link is doing.
    pub(super) fn status(&self) -> Status {
        self.link.status()
    }

    /// What it sent, took and refused.
    pub(super) fn counters(&self) -> Counters {
        self.link.counters()
    }

    /// The number of the last order that it delivered.
    pub(super) const fn heeded(&self) -> Option<Counter> {
        self.heeded
    }
}
