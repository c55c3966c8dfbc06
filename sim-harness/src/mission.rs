//! One mission: the on-board agents, their bodies, and the packets between them.
//!
//! Time moves in physics steps of 20 ms at point level, of a millisecond at flight level; the
//! packets on the air have the very microsecond. Every member has its own phase of the 5 Hz loop:
//! in the step where its turn comes it reads its sensors and runs [`onboard::Drone::step`], whose
//! radio link sends its report in its slot. The same scenario and seed give the same mission, bit
//! for bit, in however small steps it is flown.
//!
//! The operator is the scenario's pilot, or, in a live mission, the caller of [`Mission::order`].

mod air;
mod hosted;
mod ideal;
mod intruders;
mod log;
mod member;
mod parts;
mod seal;
mod sections;
mod track;

use agent::{Outputs, State};
use onboard::{Operator, Sensed, Snapshot};
use tunnel_nav::Range;
use units::{NodeId, Order, Point2, Role, Setpoint};
use wire::p2p::{self, Telemetry};
use wire::radio::Datarate;

use crate::bodies::Body;
use crate::bodies::craft::Surroundings;
use crate::bodies::craft::faults::Failing;
use crate::bodies::emulated::{Emulated, Halted, RAMP_UP};
use crate::bodies::point::{Response, STEP_US};
use crate::measure::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};
use crate::medium::timing::air_us;
use crate::medium::{Arrives, Medium, MediumConfig};
use crate::random::{Purpose, Stream};
use crate::scenario::{Fidelity, LinkModel, Scenario};
use crate::world::SkeletonPlace;
pub use crate::world::World;

use air::Strengths;
use hosted::Clocks;
use ideal::IdealLink;
use intruders::Intruders;
pub use intruders::Overheard;
use log::OrderLog;
pub use log::RadioMetrics;
use member::{Member, Onboard, member, spots};
pub use parts::Part;
use parts::Stopwatch;
use seal::Cipher;
pub(crate) use sections::{
    AgentTables, DronesTable, LaunchTable, LossTable, MOST_DRONES, PilotTable, PolicyTable,
    RetreatTable,
};
pub use sections::{Drones, Loss, LossKind, PilotStep, Start};
pub use track::Linked;
use track::Track;

/// Physics steps in one round of the 5 Hz loop.
const STEPS_PER_ROUND: u64 = 10;
/// Length of a round, in microseconds.
pub const ROUND_US: u64 = STEPS_PER_ROUND * STEP_US;
/// Length of a step of a craft, in microseconds.
const CRAFT_STEP_US: u64 = 1_000;
/// How far emulated drones run before they exchange packets while one is on the air. No packet
/// that one of them sends meanwhile is on the air by then, so that no packet is heard late, and
/// all that disturbs a packet is known when it arrives.
const EMULATED_STEP_US: u64 = 100;
/// How far they run while nothing is on the air: no packet has arrived by then, either.
const EMULATED_STEP_IN_SILENCE_US: u64 = 250;
const _: () = {
    assert!(EMULATED_STEP_US * 1_000 < RAMP_UP);
    // None of the chain's is shorter, since no message is empty, and none faster.
    let on_air_us = air_us(Datarate::Mbit2, p2p::HEADER + 1 + p2p::TAG);
    assert!(EMULATED_STEP_IN_SILENCE_US * 1_000 < RAMP_UP + on_air_us * 1_000);
    assert!(CRAFT_STEP_US.is_multiple_of(EMULATED_STEP_US));
    assert!(CRAFT_STEP_US.is_multiple_of(EMULATED_STEP_IN_SILENCE_US));
};

/// Where a mission's orders come from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// The scenario's pilot.
    Script,
    /// The caller of [`Mission::order`], whose last order this is.
    Live(Order),
    /// Clients at the drones' own CRTP servers.
    Clients,
}

/// The last telemetry that the base has received from a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The moment at which it came, by the mission's clock, µs.
    pub at_us: u64,
    /// The telemetry.
    pub telemetry: Telemetry,
}

/// The values of one member that may be looked at from outside.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The member's number.
    pub id: NodeId,
    /// The member's role.
    pub role: Role,
    /// The member's body; at flight level with a [`craft`](Body::craft), unless it is the base.
    pub body: &'a Body,
    /// The outputs of the agent's last round; `None` before the first.
    pub outputs: Option<&'a Outputs>,
    /// The sensor values of the last round.
    pub senses: &'a Sensed,
    /// The operator's orders as the member has them; `None` for a drone in an emulator.
    pub operator: Option<Operator>,
}

/// A mission under way.
pub struct Mission<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    members: Vec<Member>,
    medium: Medium,
    track: Track,
    strengths: Strengths,
    /// While packets are carried: when each member next has something to send.
    due_us: Vec<u64>,
    response: Response,
    source: Source,
    now_us: u64,
    drone_contacts: u32,
    /// While contacts are counted: where each member is.
    positions: Vec<Point2>,
    touching: Vec<(usize, usize)>,
    orders: OrderLog,
    intruders: Option<Intruders>,
    /// The link that carries reports and orders without packets, where the scenario has it.
    ideal: Option<IdealLink>,
    stopwatch: Stopwatch,
    /// Why the mission cannot go on.
    halted: Option<Halted>,
}

impl<'a> Mission<'a> {
    /// All members at their places, before the first packet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        Self::with_clocks(scenario, world, seed, Clocks::Apart)
    }

    fn with_clocks(scenario: &'a Scenario, world: &'a World, seed: u64, clocks: Clocks) -> Self {
        let mut start = Stream::new(seed, Purpose::Start);
        let spots = spots(scenario, world, &mut start);
        let count = spots.len();
        let members: Vec<_> = spots
            .iter()
            .enumerate()
            .map(|(n, spot)| member(scenario, world, seed, &mut start, n, spot, clocks))
            .collect();
        Self {
            scenario,
            world,
            medium: Medium::new(scenario.medium(), count, seed),
            track: Track::new(spots.iter().map(|spot| spot.on).collect()),
            strengths: Strengths::new(&world.radio, spots.iter().map(|spot| spot.on)),
            due_us: Vec::with_capacity(count),
            members,
            response: Response::new(&scenario.vehicle),
            source: Source::Script,
            now_us: 0,
            drone_contacts: 0,
            positions: Vec::with_capacity(count),
            touching: Vec::new(),
            orders: OrderLog::default(),
            intruders: None,
            ideal: match scenario.link {
                LinkModel::Exact => None,
                LinkModel::Ideal => Some(IdealLink::new(scenario, count, seed)),
            },
            stopwatch: Stopwatch::default(),
            halted: None,
        }
    }

    /// The same with these drones in an emulator, in place of those of their numbers.
    #[must_use]
    pub fn emulated(
        scenario: &'a Scenario,
        world: &'a World,
        seed: u64,
        drones: Vec<Emulated>,
    ) -> Self {
        let mut mission = Self::new(scenario, world, seed);
        let config = MediumConfig { arrives: Arrives::AtAntenna, ..scenario.medium() };
        mission.medium = Medium::new(config, mission.members.len(), seed);
        for drone in drones {
            if let Some(member) = mission.members.get_mut(usize::from(drone.node().0)) {
                member.emulate(drone);
            }
        }
        mission
    }

    /// The same with a stopwatch that tells what [`spent`](Self::spent) is asked for.
    #[must_use]
    pub fn timed(self) -> Self {
        Self { stopwatch: Stopwatch::started(), ..self }
    }

    /// The time that this machine has spent in each part of the simulation, of a
    /// [timed](Self::timed) mission.
    pub fn spent(&self) -> impl Iterator<Item = (Part, std::time::Duration)> {
        self.stopwatch.spent().into_iter().flat_map(|spent| Part::ALL.into_iter().zip(spent))
    }

    /// Whether any drone is in an emulator.
    fn is_emulated(&self) -> bool {
        self.medium.arrives() == Arrives::AtAntenna
    }

    /// A drone that is in an emulator.
    #[must_use]
    pub fn emulated_drone(&self, member: usize) -> Option<&Emulated> {
        self.members.get(member)?.onboard.emulated()
    }

    /// The same, to make something go wrong with it, or to watch it.
    pub fn emulated_drone_mut(&mut self, member: usize) -> Option<&mut Emulated> {
        self.members.get_mut(member)?.onboard.emulated_mut()
    }

    /// The same without the scenario's pilot: all drones wait for [`order`](Self::order).
    #[must_use]
    pub fn live(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        Self { source: Source::Live(Order::Wait), ..Self::new(scenario, world, seed) }
    }

    /// The same with clients at the drones in the pilot's place, by [`client`](Self::client).
    #[must_use]
    pub fn served(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        let mission = Self::with_clocks(scenario, world, seed, Clocks::InStep);
        Self { source: Source::Clients, ..mission }
    }

    /// This mission with clients in the pilot's place, as [`served`](Self::served): for one with
    /// emulated drones.
    #[must_use]
    pub fn for_clients(self) -> Self {
        Self { source: Source::Clients, ..self }
    }

    /// Gives a member a packet of a client: one on the host at once, one in an emulator over its
    /// radio chip.
    pub fn client(&mut self, member: usize, packet: &[u8]) {
        let now_us = self.now_us;
        match self.members.get_mut(member).map(|member| &mut member.onboard) {
            Some(Onboard::Hosted(hosted)) => {
                let (drone, now) = hosted.at(now_us);
                drone.client(now, packet);
                hosted.look(now_us);
            }
            Some(Onboard::Emulated(emulated)) => emulated.client(now_us, packet),
            None => {}
        }
    }

    /// Lets what is due by the clock at a member's server happen, and gives `take` the packets that
    /// it then sends to its client. `measured` is what the member's body has to show.
    pub fn poll_client(&mut self, member: usize, measured: &Snapshot, mut take: impl FnMut(&[u8])) {
        /// More packets than a server's queues hold.
        const BURST: usize = 64;
        let now_us = self.now_us;
        let hosted = match self.members.get_mut(member).map(|member| &mut member.onboard) {
            Some(Onboard::Hosted(hosted)) => hosted,
            // Its radio chip answers one packet for each that it is asked for.
            Some(Onboard::Emulated(emulated)) => return emulated.take_answers(take),
            None => return,
        };
        let (drone, now) = hosted.at(now_us);
        drone.attend(now);
        let snapshot = drone.snapshot(now, measured);
        for _ in 0..BURST {
            let Some(packet) = drone.poll_client(now, &snapshot) else { break };
            take(packet.bytes());
        }
        hosted.look(now_us);
    }

    /// Gives the operator's order at the base of a live mission; it holds until the next.
    pub fn order(&mut self, task: Order) {
        let word = Source::Live(task);
        if self.source == Source::Script || self.source == word {
            return;
        }
        self.source = word;
        self.give_order(self.now_us);
    }

    /// Flies for one round, 0.2 s.
    pub fn round(&mut self) {
        self.advance(ROUND_US);
    }

    /// Flies for so many microseconds.
    pub fn advance(&mut self, us: u64) {
        let until_us = self.now_us + us;
        let is_emulated = self.is_emulated();
        while self.now_us < until_us && self.halted.is_none() {
            if self.now_us.is_multiple_of(STEP_US) {
                self.lose_drones();
                self.take_turns();
            }
            let quantum_us = match self.scenario.fidelity {
                _ if is_emulated && self.medium.is_silent() => EMULATED_STEP_IN_SILENCE_US,
                _ if is_emulated => EMULATED_STEP_US,
                Fidelity::Point => STEP_US,
                Fidelity::Flight | Fidelity::Virtual => CRAFT_STEP_US,
            };
            let next_us = (self.now_us / quantum_us + 1) * quantum_us;
            let step_us = next_us.min(until_us);
            self.stopwatch.enter(Part::Medium);
            self.carry_packets(step_us);
            self.stopwatch.enter(Part::Rest);
            if is_emulated {
                self.emulate(step_us);
            }
            self.now_us = step_us;
            if step_us == next_us && (!is_emulated || step_us.is_multiple_of(CRAFT_STEP_US)) {
                self.move_bodies();
            }
        }
    }

    /// Whether the operator is a client, and not the scenario's script.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        !matches!(self.source, Source::Script)
    }

    /// The operator's order at this time.
    #[must_use]
    pub fn task(&self) -> Order {
        let of_clients = || self.members.last()?.onboard.hosted()?.drone().operator().order();
        let order = operators_order(self.scenario, self.source, self.now_us);
        order.or_else(of_clients).unwrap_or(Order::Wait)
    }

    /// Whether a drone calls the whole chain home, against the operator's order to explore.
    #[must_use]
    pub fn is_recalled(&self) -> bool {
        let calls = |outputs: &Outputs| outputs.report.recall;
        self.members.iter().any(|member| member.outputs.as_ref().is_some_and(calls))
    }

    /// Whether the scenario's time is up, or it cannot go on.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.halted.is_some() || self.time_us() >= self.scenario.duration_us
    }

    /// Why it cannot go on: an emulated drone does what the emulator does not know.
    #[must_use]
    pub const fn halted(&self) -> Option<&Halted> {
        self.halted.as_ref()
    }

    /// Microseconds since the start.
    #[must_use]
    pub const fn time_us(&self) -> u64 {
        self.now_us
    }

    /// The bodies, head first, base last.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.members.iter().map(|member| &member.body)
    }

    /// Makes something go wrong with one of the drones, at flight level.
    pub fn sabotage(&mut self, member: usize, failing: Failing, random: &mut Stream) {
        if let Some(craft) = self.members.get_mut(member).and_then(|m| m.body.craft_mut()) {
            craft.sabotage(failing, random);
        }
    }

    /// The state of each member's agent, head first, base last.
    pub fn states(&self) -> impl Iterator<Item = State> {
        self.members.iter().map(Member::state)
    }

    /// How many members there are, base included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// A look at one member, head first, base last.
    #[must_use]
    pub fn view(&self, member: usize) -> Option<View<'_>> {
        let found = self.members.get(member)?;
        Some(View {
            id: NodeId(member as u8),
            role: found.role,
            body: &found.body,
            outputs: found.outputs.as_ref(),
            senses: &found.senses,
            operator: found.onboard.hosted().map(|hosted| hosted.drone().operator()),
        })
    }

    /// The last telemetry that the base has received from a member.
    #[must_use]
    pub fn told(&self, member: usize) -> Option<Told> {
        let base = self.members.last()?.onboard.hosted()?;
        let node = base.drone().node(NodeId(member as u8))?;
        Some(Told { at_us: base.mission_us(node.heard), telemetry: node.telemetry })
    }

    /// The figures of the radio so far.
    #[must_use]
    pub fn radio(&self) -> RadioMetrics {
        let sealed = Cipher::is_sealed(self.scenario.fidelity);
        let tally = self.ideal.as_ref().map_or(self.medium.tally(), IdealLink::tally);
        RadioMetrics::of(sealed, tally, self.now_us, &self.orders)
    }

    /// The links of the chain as it is now, base first, head last: the base, and every drone that
    /// flies as relay or explorer and is not lost.
    pub fn chain(&self, into: &mut Vec<Linked>) {
        into.clear();
        let linked = self.members.iter().enumerate().rev().filter(|(_, member)| {
            let is_link = member.outputs.is_some_and(|outputs| outputs.report.phase.is_link());
            is_link && member.lost.is_none()
        });
        into.extend(linked.map(|(n, _)| self.track.linked(n, self.world)));
    }

    /// The members' places on the skeleton, head first, base last.
    pub fn places(&self) -> impl Iterator<Item = SkeletonPlace> {
        (0..self.members.len()).map(|n| self.track.place(n))
    }

    /// The length of the shortest way from the base to each member, head first, base last, m.
    pub fn ways(&self) -> impl Iterator<Item = f32> {
        self.places().map(|place| self.world.way(place))
    }

    /// How often any drone has touched a wall.
    #[must_use]
    pub fn wall_contacts(&self) -> u32 {
        self.members.iter().map(|member| member.body.contacts()).sum()
    }

    /// How often two flying drones have touched.
    #[must_use]
    pub const fn drone_contacts(&self) -> u32 {
        self.drone_contacts
    }

    /// Whether the scenario has taken this member from the chain.
    #[must_use]
    pub fn is_lost(&self, member: usize) -> bool {
        self.members.get(member).is_some_and(|member| member.lost.is_some())
    }

    /// Takes from the chain the drones that the scenario loses by now.
    fn lose_drones(&mut self) {
        for loss in self.scenario.losses.iter().take_while(|loss| loss.at_us <= self.now_us) {
            if let Some(member) = self.members.get_mut(loss.drone) {
                member.lose(loss.how);
            }
        }
    }

    /// The turns of those whose turn it is in this physics step.
    fn take_turns(&mut self) {
        let phase = self.now_us / STEP_US % STEPS_PER_ROUND;
        for n in 0..self.members.len() {
            if self.members[n].phase == phase {
                self.tick(n);
            }
        }
    }

    /// One turn of one member's 5 Hz loop.
    fn tick(&mut self, n: usize) {
        self.stopwatch.enter(Part::Bodies);
        let member = &mut self.members[n];
        if member.lost == Some(LossKind::Gone) {
            return;
        }
        let place = self.track.follow(n, member.body.position(), self.world.skeleton());
        self.strengths.moved(n, place, &self.world.radio);
        let flies = member.role != Role::Base;
        member.senses = if flies {
            let (elapsed, spec) = (ROUND_US as f32 * 1e-6, &self.scenario.vehicle);
            member.body.sense(elapsed, &self.world.tunnel, spec, &mut member.random)
        } else {
            Sensed::NONE
        };
        if member.lost == Some(LossKind::Lands) {
            member.senses.fitness = member.forced_down();
        }
        self.stopwatch.enter(Part::Agents);
        match &mut member.onboard {
            Onboard::Hosted(_) => self.step_hosted(n),
            Onboard::Emulated(emulated) => {
                member.outputs = emulated.outputs();
                if let Some(outputs) = member.outputs {
                    member.body.note(outputs.setpoint);
                }
            }
        }
    }

    /// One round of a member on the host. The operator's stick is read at every round of the base.
    fn step_hosted(&mut self, n: usize) {
        let now_us = self.now_us;
        if self.members[n].role == Role::Base {
            self.give_order(now_us);
        }
        let member = &mut self.members[n];
        let Onboard::Hosted(hosted) = &mut member.onboard else { return };
        let outputs = hosted.step(now_us, &member.senses);
        self.stopwatch.enter(Part::Links);
        match &mut self.ideal {
            None => hosted.look(now_us),
            Some(ideal) => {
                ideal.report(now_us, outputs.agent.report);
                if member.role == Role::Base {
                    ideal.order(now_us, hosted.drone().operator().order());
                }
            }
        }
        member.body.command(outputs.setpoint);
        member.outputs = Some(outputs.agent);
        self.stopwatch.enter(Part::Rest);
    }

    /// Gives the base the operator's present order.
    fn give_order(&mut self, now_us: u64) {
        self.orders.given(now_us);
        let Some(order) = operators_order(self.scenario, self.source, now_us) else { return };
        if let Some(Member { onboard: Onboard::Hosted(base), .. }) = self.members.last_mut() {
            base.order(now_us, order);
        }
    }

    /// One physics step of all members.
    fn move_bodies(&mut self) {
        self.stopwatch.enter(Part::Bodies);
        let around = surroundings(self.scenario, self.world);
        for member in &mut self.members {
            match &mut member.onboard {
                Onboard::Hosted(_) => member.body.advance(around, self.response),
                Onboard::Emulated(emulated) => {
                    if let Some(craft) = member.body.craft_mut() {
                        emulated.fly(craft, around);
                    }
                }
            }
        }
        if self.now_us.is_multiple_of(2 * STEP_US) {
            self.count_drone_contacts();
        }
        self.stopwatch.enter(Part::Rest);
    }

    fn count_drone_contacts(&mut self) {
        let least = 2.0 * self.scenario.vehicle.radius;
        let Self { members, positions, .. } = self;
        positions.clear();
        positions.extend(members.iter().map(|member| member.body.position()));
        for a in 0..self.positions.len() {
            for b in 0..a {
                let (here, there) = (self.positions[a], self.positions[b]);
                let (dx, dy) = (here.x - there.x, here.y - there.y);
                let near = dx * dx + dy * dy < least * least;
                if !near && self.touching.is_empty() {
                    continue;
                }
                let flies = |n: usize| self.members[n].body.height() > 0.0;
                let touch = near && flies(a) && flies(b);
                let known = self.touching.iter().position(|&pair| pair == (a, b));
                match (touch, known) {
                    (true, None) => {
                        self.touching.push((a, b));
                        self.drone_contacts += 1;
                    }
                    (false, Some(at)) => {
                        self.touching.swap_remove(at);
                    }
                    _ => {}
                }
            }
        }
    }

    /// Flies a whole mission and returns its record.
    #[must_use]
    pub fn record(scenario: &'a Scenario, world: &'a World, seed: u64) -> Trace {
        let mut mission = Self::new(scenario, world, seed);
        let mut trace = mission.begin_trace(seed);
        while !mission.is_over() {
            mission.round();
            trace.frames.push(mission.frame());
        }
        trace
    }

    /// An empty record of this mission.
    #[must_use]
    pub fn begin_trace(&self, seed: u64) -> Trace {
        Trace {
            scenario: self.scenario.name.clone(),
            seed,
            floor_plan: self.world.tunnel.floor_plan(),
            nodes: self
                .members
                .iter()
                .enumerate()
                .map(|(n, member)| Node { id: NodeId(n as u8), role: member.role })
                .collect(),
            launch_limit: self.scenario.agent.launch.limit,
            frames: Vec::new(),
        }
    }

    /// The present state of the mission, for the record.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let drones = (0..self.members.len()).map(|n| self.drone_frame(n)).collect();
        Frame { time_us: self.time_us(), order: self.task(), drones }
    }

    fn drone_frame(&self, n: usize) -> DroneFrame {
        let member = &self.members[n];
        let body = &member.body;
        let place = self.track.place(n);
        let (commanded, yaw_rate) = match body.setpoint() {
            Setpoint::Off | Setpoint::Stop => ([0.0; 2], 0.0),
            Setpoint::Fly { forward, lateral, yaw_rate, .. } => {
                ([forward.0, lateral.0], yaw_rate.0)
            }
        };
        let link = |view: Option<agent::LinkView>| {
            view.and_then(|view| {
                let peer = usize::from(view.peer.0);
                let there = (peer < self.members.len()).then(|| self.track.place(peer))?;
                let truth = self.world.radio.strength(place, there);
                Some(LinkFrame { peer: view.peer, raw: view.raw, filtered: view.rssi, truth })
            })
        };
        let status = member.outputs.map(|outputs| outputs.status);
        let beams = &member.senses.ranges;
        DroneFrame {
            pose: body.pose(),
            height: body.height(),
            place,
            way: self.world.way(place),
            commanded,
            yaw_rate,
            ranges: [beams.nw, beams.ne, beams.sw, beams.se].map(metres),
            state: member.state(),
            battery_v: body.craft().map_or(f32::NAN, |craft| craft.battery().volts()),
            front: link(status.and_then(|status| status.front)),
            back: link(status.and_then(|status| status.back)),
        }
    }
}

/// The operator's order at this time; `None` where clients give orders.
fn operators_order(scenario: &Scenario, source: Source, now_us: u64) -> Option<Order> {
    match source {
        Source::Clients => None,
        Source::Live(task) => Some(task),
        Source::Script => {
            let step = scenario.pilot.iter().take_while(|step| step.at_us <= now_us).last();
            Some(step.map_or(Order::Wait, |step| step.task))
        }
    }
}

fn metres(range: Range) -> f32 {
    match range {
        Range::At(distance) => distance.0,
        Range::Clear => f32::INFINITY,
        Range::Invalid => f32::NAN,
    }
}

/// The surroundings of the drones of this scenario.
pub(crate) fn surroundings<'a>(scenario: &'a Scenario, world: &'a World) -> Surroundings<'a> {
    Surroundings { tunnel: &world.tunnel, ground: scenario.ground, vehicle: &scenario.vehicle }
}
