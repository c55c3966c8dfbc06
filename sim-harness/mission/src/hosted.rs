//! A drone on the host: the very `onboard::Drone` that the firmware runs, on a clock that no other
//! drone has.

use airlink::{LinkConfig, Opened, Schedule};
use chain::neighbours::Heard;
use onboard::{Config, Drone, Exploration, Keys, Outputs, Sensed, Setup, Start};
use random::{Purpose, Stream};
use units::{Dbm, Duration, Instant, Metres, MissionKind, NodeId, Order, Role};
use wire::p2p::{Counter, Epoch, Kind};
use wire::syslink::MAX_P2P;

use super::member::OnLine;
use super::seal::Cipher;
use scenario::Scenario;

/// The due time of a drone that never sends.
const NEVER: u64 = u64::MAX;
/// Clocks are up to this far apart: a drone may have been switched on an hour before.
const OFFSETS_S: f32 = 3_600.0;
/// A drone has been switched on up to so many times before.
const BOOTS: f32 = 1_000.0;
/// A link that says that it has something to send, and then has nothing, is asked again only
/// after this long.
const RETRY_US: u64 = 1_000;

/// The times that drones' clocks show at the beginning of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clocks {
    /// Each another time: every drone was switched on at another moment before.
    Apart,
    /// Zero, so that what clients log has the mission's time.
    InStep,
}

/// A drone on the host, and its clock.
pub(super) struct Hosted {
    drone: Drone<Cipher>,
    /// The memory of a drone that explores.
    exploration: Option<Box<Exploration>>,
    /// The drone's clock is the mission's and this much.
    offset_us: u64,
    /// When the drone has something to send, by the mission's clock.
    due_us: u64,
    /// Packets on their way from the drone's radio to its processor.
    pub(super) line: Vec<OnLine>,
}

impl Hosted {
    /// A drone that is switched on at the beginning of the mission, or that is at its place in the air then and
    /// has `flown` so far.
    pub(super) fn new(
        scenario: &Scenario,
        seed: u64,
        (node, role): (NodeId, Role),
        flown: Option<Metres>,
        clocks: Clocks,
    ) -> Self {
        let mut random = Stream::new(seed, Purpose::Radio(node.0));
        let apart_us = (random.uniform() * OFFSETS_S * 1e6) as u64;
        let offset_us = match clocks {
            Clocks::Apart => apart_us,
            Clocks::InStep => 0,
        };
        let boots = (random.uniform() * BOOTS) as u32;
        let now = Instant::from_micros(offset_us);
        let config = Config {
            agent: scenario.agent,
            link: LinkConfig::DEFAULT,
            mailbox_delay: Duration::from_micros(scenario.radio.latency_us),
        };
        let start = flown.map_or(Start::OnGround, |flown| Start::InAir { at: now, flown });
        let mission = scenario.mission;
        let mut setup = Setup { start, mission, ..Setup::new(node, role) };
        setup.about.has_flow = role != Role::Base;
        setup.about.has_rangers = role != Role::Base;
        let mut drone = Drone::new(config, &setup);
        let keys = Keys::Held {
            seal: Cipher::of(scenario.fidelity, seed, node, role == Role::Base),
            epoch: Epoch::new(1 + boots).unwrap_or(Epoch::FIRST),
            schedule: Schedule::new(scenario.radio.datarate, node)
                .expect("a checked scenario has no more members than the frame has slots"),
            may_fly: true,
        };
        drone.open_link(now, keys);
        let explores = mission == MissionKind::Explore && role != Role::Base;
        let exploration = explores.then(|| Box::new(Exploration::NEW));
        let mut hosted = Self { drone, exploration, offset_us, due_us: NEVER, line: Vec::new() };
        hosted.look(0);
        hosted
    }

    /// The drone, to look at.
    pub(super) const fn drone(&self) -> &Drone<Cipher> {
        &self.drone
    }

    /// The map of a drone that explores.
    pub(super) fn exploration(&self) -> Option<&Exploration> {
        self.exploration.as_deref()
    }

    /// The drone, and a moment of the mission by its clock.
    pub(super) fn at(&mut self, now_us: u64) -> (&mut Drone<Cipher>, Instant) {
        let now = self.clock(now_us);
        (&mut self.drone, now)
    }

    /// A moment of the mission by the drone's clock.
    pub(super) const fn clock(&self, now_us: u64) -> Instant {
        Instant::from_micros(now_us + self.offset_us)
    }

    /// A moment of the drone's clock by the mission's.
    pub(super) const fn mission_us(&self, moment: Instant) -> u64 {
        moment.as_micros().saturating_sub(self.offset_us)
    }

    /// Asks the drone anew when it wants to send.
    pub(super) fn look(&mut self, now_us: u64) {
        let due = self.drone.due().map(|due| self.mission_us(due));
        self.due_us = due.map_or(NEVER, |due_us| due_us.max(now_us));
    }

    /// When the drone next has something to send.
    pub(super) const fn due_us(&self) -> u64 {
        self.due_us
    }

    /// Reads a packet. All members have the fleet's key, so each of them reads the same in it.
    pub(super) fn open(&self, data: &[u8]) -> Option<Opened> {
        self.drone.open(data)
    }

    /// Takes a packet from the radio. Returns the number of the order that it has brought, if any.
    pub(super) fn receive(&mut self, now_us: u64, rssi: Dbm, packet: &Opened) -> Option<Counter> {
        let kind = self.drone.receive_opened(self.clock(now_us), rssi, packet);
        // A report, a beacon or a message of the mission gives the drone nothing new to pass on. Its turn may have moved by a
        // little, which it finds out when it comes.
        if !matches!(kind, Some(Kind::Report | Kind::Beacon | Kind::Mission)) {
            self.look(now_us);
        }
        if kind == Some(Kind::Command) { self.drone.last_order() } else { None }
    }

    /// Hands over what is due, if anything is.
    pub(super) fn transmit(&mut self, now_us: u64, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        let sent = self.drone.transmit(self.clock(now_us), out);
        self.look(now_us);
        if sent.is_none() && self.due_us == now_us {
            self.due_us = now_us + RETRY_US;
        }
        sent
    }

    /// Takes a report that has come by the ideal link.
    pub(super) fn hear(&mut self, now_us: u64, report: Heard) {
        self.drone.hear(self.clock(now_us), report);
    }

    /// Takes an order that has come by the ideal link.
    pub(super) fn heed(&mut self, now_us: u64, order: Order) {
        self.drone.heed(self.clock(now_us), order);
    }

    /// One round of the mission. Where there are packets, [`look`](Self::look) has to follow.
    pub(super) fn step(&mut self, now_us: u64, sensed: &Sensed) -> Outputs {
        let now = self.clock(now_us);
        self.drone.step_shown(now, sensed, self.exploration.as_deref_mut(), |_, _| {})
    }

    /// Gives the operator's order, at the base.
    pub(super) fn order(&mut self, now_us: u64, order: Order) {
        self.drone.order(self.clock(now_us), order);
        self.look(now_us);
    }
}
