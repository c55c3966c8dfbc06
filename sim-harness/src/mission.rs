//! One mission: the on-board agents, their bodies, and the packets between them.
//!
//! Time moves in physics steps of 20 ms at policy level, of a millisecond at flight level; the
//! packets on the air have the very microsecond. Every member has its own phase of the 5 Hz loop:
//! in the step where its turn comes it reads its sensors and its mailbox, runs [`Agent::step`], and
//! hands its report to its radio link, which sends it in its slot. The same scenario and seed give
//! the same mission, bit for bit, in however small steps it is flown.
//!
//! The operator is the scenario's pilot, or, in a live mission, whoever calls [`Mission::order`].

mod intruders;
mod log;
mod member;
mod seal;
mod station;

use agent::{Agent, Inputs, Outputs, Role, Setpoint, air};
use chain::neighbours::Heard;
use chain::report::Task;
use tunnel_nav::Range;
use units::{Dbm, Instant, NodeId};
use wire::p2p::Telemetry;
use wire::syslink::MAX_P2P;

use crate::craft::Surroundings;
use crate::craft::faults::Failing;
use crate::drone::{Drone, Senses};
use crate::medium::{Ether, Medium};
use crate::random::{Purpose, Stream};
use crate::scenario::{Fidelity, Scenario};
use crate::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};
use crate::vehicle::{Response, STEP_US};
use crate::world::{Radio, Tunnel};

use intruders::Intruders;
pub use intruders::Overheard;
use log::OrderLog;
pub use log::RadioMetrics;
use member::{Member, Parcel, member, places};
use seal::Cipher;
use station::News;

/// Physics steps in one round of the 5 Hz loop.
const STEPS_PER_ROUND: u64 = 10;
/// Length of a round, in microseconds.
pub const ROUND_US: u64 = STEPS_PER_ROUND * STEP_US;
/// Length of a step of a craft, in microseconds.
const CRAFT_STEP_US: u64 = 1_000;

/// The surroundings of a mission, shared by all that fly in them.
pub struct World {
    /// The walls.
    pub tunnel: Tunnel,
    /// The radio.
    pub radio: Radio,
}

impl World {
    /// Digs and surveys a scenario's tunnel.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let tunnel = scenario.tunnel();
        let radio = Radio::survey(&tunnel, scenario.path_loss, scenario.walls);
        Self { tunnel, radio }
    }
}

/// Who says what is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Operator {
    /// The scenario's pilot.
    Script,
    /// Somebody outside, whose last word this is.
    Live(Task),
}

/// What the base last heard of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// When, by the mission's clock.
    pub at_us: u64,
    /// What.
    pub telemetry: Telemetry,
}

/// A look at one member.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Its number.
    pub id: NodeId,
    /// Its part.
    pub role: Role,
    /// Its body; at flight level with a [`craft`](Drone::craft), unless it is the base.
    pub body: &'a Drone,
    /// Its mind.
    pub agent: &'a Agent,
    /// What its mind last put out; `None` before its first turn.
    pub outputs: Option<&'a Outputs>,
    /// What its mind last sensed.
    pub senses: &'a Senses,
    /// What its radio link is doing.
    pub link: airlink::Status,
    /// What its radio link sent, took and refused.
    pub counters: airlink::Counters,
    /// The last 16 bits of the count of the last order that reached it; zero for none.
    pub heeded: u16,
}

/// A mission under way.
pub struct Mission<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    members: Vec<Member>,
    medium: Medium,
    strengths: Strengths,
    response: Response,
    operator: Operator,
    now_us: u64,
    drone_contacts: u32,
    touching: Vec<(usize, usize)>,
    /// What the base has heard of everybody.
    told: Vec<Option<Told>>,
    orders: OrderLog,
    unpacked: Vec<Heard>,
    intruders: Option<Intruders>,
}

impl<'a> Mission<'a> {
    /// Everybody at their places, nothing said yet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        let mut start = Stream::new(seed, Purpose::Start);
        let places = places(scenario, &mut start);
        let count = places.len();
        let members: Vec<_> = places
            .into_iter()
            .enumerate()
            .map(|(n, place)| member(scenario, world, seed, &mut start, n, count, place))
            .collect();
        Self {
            scenario,
            world,
            medium: Medium::new(scenario.medium(), count, seed),
            strengths: Strengths::new(count),
            told: vec![None; count],
            members,
            response: Response::new(&scenario.vehicle),
            operator: Operator::Script,
            now_us: 0,
            drone_contacts: 0,
            touching: Vec::new(),
            orders: OrderLog::default(),
            unpacked: Vec::new(),
            intruders: None,
        }
    }

    /// The same without the scenario's pilot: everybody waits for [`order`](Self::order).
    #[must_use]
    pub fn live(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        Self { operator: Operator::Live(Task::Wait), ..Self::new(scenario, world, seed) }
    }

    /// In a live mission: the operator's word at the base, which holds until the next.
    pub fn order(&mut self, task: Task) {
        let word = Operator::Live(task);
        if self.operator == Operator::Script || self.operator == word {
            return;
        }
        self.operator = word;
        self.give_order(self.now_us);
    }

    /// Flies for one round, 0.2 s.
    pub fn round(&mut self) {
        self.advance(ROUND_US);
    }

    /// Flies for so many microseconds.
    pub fn advance(&mut self, us: u64) {
        let until_us = self.now_us + us;
        let quantum_us = match self.scenario.fidelity {
            Fidelity::Policy => STEP_US,
            Fidelity::Flight => CRAFT_STEP_US,
        };
        while self.now_us < until_us {
            if self.now_us.is_multiple_of(STEP_US) {
                self.take_turns();
            }
            let next_us = (self.now_us / quantum_us + 1) * quantum_us;
            let step_us = next_us.min(until_us);
            self.carry_packets(step_us);
            self.now_us = step_us;
            if step_us == next_us {
                self.move_bodies();
            }
        }
    }

    /// Whether the scenario's time is up.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.time_us() >= self.scenario.duration_us
    }

    /// Microseconds since the start.
    #[must_use]
    pub const fn time_us(&self) -> u64 {
        self.now_us
    }

    /// The bodies, head first, base last.
    pub fn bodies(&self) -> impl Iterator<Item = &Drone> {
        self.members.iter().map(|member| &member.body)
    }

    /// Makes something go wrong with one of the drones, at flight level.
    pub fn sabotage(&mut self, member: usize, failing: Failing, random: &mut Stream) {
        if let Some(craft) = self.members.get_mut(member).and_then(|m| m.body.craft_mut()) {
            craft.sabotage(failing, random);
        }
    }

    /// The agents, head first, base last.
    pub fn agents(&self) -> impl Iterator<Item = &Agent> {
        self.members.iter().map(|member| &member.agent)
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
            agent: &found.agent,
            outputs: found.outputs.as_ref(),
            senses: &found.senses,
            link: found.station.status(),
            counters: found.station.counters(),
            heeded: found.station.heeded().map_or(0, |counter| counter.low16()),
        })
    }

    /// What the base last heard of a member, and when.
    #[must_use]
    pub fn told(&self, member: usize) -> Option<Told> {
        self.told.get(member).copied().flatten()
    }

    /// What has become of all packets.
    #[must_use]
    pub fn radio(&self) -> RadioMetrics {
        let sealed = Cipher::is_sealed(self.scenario.fidelity);
        RadioMetrics::of(sealed, self.medium.tally(), self.now_us, &self.orders)
    }

    /// The abscissae of the links of the chain as it is now, base first, head last: the base, and
    /// every drone that flies as relay or head.
    pub fn chain(&self, into: &mut Vec<(NodeId, f32)>) {
        into.clear();
        let linked = self.members.iter().enumerate().rev().filter(|(_, member)| {
            member.outputs.is_some_and(|outputs| outputs.report.phase.is_link())
        });
        into.extend(linked.map(|(n, member)| (NodeId(n as u8), member.body.abscissa())));
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
        let now_us = self.now_us;
        let scenario = self.scenario;
        let spec = &scenario.vehicle;
        let member = &mut self.members[n];
        member.body.locate(&self.world.tunnel);
        self.strengths.moved(n, member.body.abscissa());
        let flies = member.role != Role::Base;

        self.unpacked.clear();
        let mut order = None;
        while let Some(parcel) = member.mailbox.pop_front_if(|p| p.arrives_us <= now_us) {
            match parcel.news {
                News::Heard(heard) => self.unpacked.push(heard),
                News::Order(task) => order = Some(task),
                News::Telemetry(..) => {}
            }
        }

        member.senses = if flies {
            let elapsed = ROUND_US as f32 * 1e-6;
            member.body.sense(elapsed, &self.world.tunnel, spec, &mut member.random)
        } else {
            Senses::NONE
        };
        if !flies {
            order = Some(operators_word(scenario, self.operator, now_us));
        }
        let senses = &self.members[n].senses;
        let inputs = Inputs {
            ranges: senses.ranges,
            velocity: senses.velocity,
            heading: senses.heading,
            height: senses.height,
            heard: &self.unpacked,
            order,
            fitness: senses.fitness,
            endurance: senses.endurance,
            emergency: false,
        };
        let machine = air::Machine {
            fitness: senses.fitness,
            battery: senses.battery,
            endurance: senses.endurance,
            height: senses.height,
            heeded: None,
        };
        let member = &mut self.members[n];
        let outputs = member.agent.step(&scenario.agent, Instant::from_micros(now_us), &inputs);
        member.body.command(outputs.setpoint);
        member.outputs = Some(outputs);
        member.station.say(now_us, &outputs, member.role, &machine);
        if !flies {
            self.give_order(now_us);
        }
    }

    /// The operator's stick is read at every turn of the base, and the base's link told.
    fn give_order(&mut self, now_us: u64) {
        let task = operators_word(self.scenario, self.operator, now_us);
        if let Some(base) = self.members.last_mut() {
            self.orders.given(now_us);
            base.station.order(now_us, task);
        }
    }

    /// All that is on the air before `until_us`.
    fn carry_packets(&mut self, until_us: u64) {
        loop {
            let arrival_us = self.medium.next().unwrap_or(u64::MAX);
            let speaker = self.members.iter().enumerate().min_by_key(|(_, m)| m.station.due_us());
            let Some((n, due_us)) = speaker.map(|(n, m)| (n, m.station.due_us())) else { return };
            if arrival_us.min(due_us) >= until_us {
                return;
            }
            if arrival_us <= due_us {
                self.receive();
            } else {
                self.transmit(n, due_us);
            }
        }
    }

    fn transmit(&mut self, n: usize, now_us: u64) {
        let mut packet = [0; MAX_P2P];
        let member = &mut self.members[n];
        let Some(length) = member.station.transmit(now_us, &mut packet) else { return };
        if member.is_silenced() {
            return;
        }
        let data = packet.get(..length).unwrap_or_default();
        if member.role == Role::Base {
            self.orders.sent(data);
        }
        self.medium.send(n, now_us, data);
    }

    /// The packet that arrives next, at all who hear it.
    fn receive(&mut self) {
        let Self { medium, members, strengths, world, told, orders, scenario, intruders, .. } =
            self;
        let count = members.len();
        let mut ether = Tube { members, strengths, radio: &world.radio };
        let Some(arrival) = medium.arrive(&mut ether) else { return };
        let now_us = arrival.at_us;
        for receipt in arrival.heard {
            let Some(member) = members.get_mut(receipt.by) else {
                if let Some(intruders) = intruders.as_mut().filter(|_| receipt.by == count) {
                    intruders.overhear(now_us, arrival.data);
                }
                continue;
            };
            let news = match intruders.as_mut().filter(|_| arrival.from >= count) {
                None => member.station.receive(now_us, receipt.rssi, arrival.data),
                Some(intruders) => {
                    let taken = member.station.counters().taken;
                    let news = member.station.receive(now_us, receipt.rssi, arrival.data);
                    if member.station.counters().taken != taken {
                        intruders.accept();
                    }
                    news
                }
            };
            let Some(news) = news else { continue };
            match news {
                News::Telemetry(from, telemetry) => {
                    if let Some(told) = told.get_mut(usize::from(from.0)) {
                        *told = Some(Told { at_us: now_us, telemetry });
                    }
                }
                News::Order(_) if member.role == Role::Head => {
                    if let Some(counter) = member.station.heeded() {
                        orders.delivered(now_us, counter);
                    }
                }
                _ => {}
            }
            let arrives_us = now_us + scenario.latency_us;
            member.mailbox.push_back(Parcel { arrives_us, news });
        }
    }

    /// One physics step of everybody.
    fn move_bodies(&mut self) {
        let around = surroundings(self.scenario, self.world);
        for member in &mut self.members {
            member.body.advance(around, self.response);
        }
        if self.now_us.is_multiple_of(2 * STEP_US) {
            self.count_drone_contacts();
        }
    }

    fn count_drone_contacts(&mut self) {
        let least = 2.0 * self.scenario.vehicle.radius;
        for a in 0..self.members.len() {
            for b in 0..a {
                let (one, other) = (&self.members[a].body, &self.members[b].body);
                let flying = one.height() > 0.0 && other.height() > 0.0;
                let (dx, dy) = (
                    one.position()[0] - other.position()[0],
                    one.position()[1] - other.position()[1],
                );
                let touch = flying && dx * dx + dy * dy < least * least;
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

    /// What is, for the record.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let drones = self.members.iter().map(|member| self.drone_frame(member)).collect();
        Frame { time_us: self.time_us(), drones }
    }

    fn drone_frame(&self, member: &Member) -> DroneFrame {
        let body = &member.body;
        let [x, y] = body.position();
        let (commanded, yaw_rate) = match body.setpoint() {
            Setpoint::Off | Setpoint::Stop => ([0.0; 2], 0.0),
            Setpoint::Fly { forward, lateral, yaw_rate, .. } => {
                ([forward.0, lateral.0], yaw_rate.0)
            }
        };
        let link = |view: Option<agent::LinkView>| {
            view.and_then(|view| {
                let peer = &self.members.get(usize::from(view.peer.0))?.body;
                let truth = self.world.radio.strength(body.abscissa(), peer.abscissa());
                Some(LinkFrame { peer: view.peer, raw: view.raw, filtered: view.rssi, truth })
            })
        };
        let status = member.outputs.map(|outputs| outputs.status);
        let beams = &member.senses.ranges;
        DroneFrame {
            position: [x, y, body.height()],
            yaw: body.yaw(),
            abscissa: body.abscissa(),
            commanded,
            yaw_rate,
            ranges: [beams.nw, beams.ne, beams.sw, beams.se].map(metres),
            state: member.agent.state(),
            front: link(status.and_then(|status| status.front)),
            back: link(status.and_then(|status| status.back)),
        }
    }
}

/// What the operator wants now.
fn operators_word(scenario: &Scenario, operator: Operator, now_us: u64) -> Task {
    match operator {
        Operator::Live(task) => task,
        Operator::Script => scenario
            .pilot
            .iter()
            .take_while(|step| step.at_us <= now_us)
            .last()
            .map_or(Task::Wait, |step| step.task),
    }
}

/// The links' strengths, which change only when somebody has moved.
struct Strengths {
    count: usize,
    places: Vec<f32>,
    /// By sender and receiver: their places, and the strength between them.
    known: Vec<(f32, f32, Dbm)>,
}

impl Strengths {
    fn new(count: usize) -> Self {
        let unknown = (f32::NAN, f32::NAN, Dbm(f32::NEG_INFINITY));
        Self { count, places: vec![0.0; count], known: vec![unknown; count * count] }
    }

    fn moved(&mut self, n: usize, abscissa: f32) {
        self.places[n] = abscissa;
    }

    fn between(&mut self, radio: &Radio, from: usize, to: usize) -> Dbm {
        let (here, there) = (self.places[from], self.places[to]);
        let known = &mut self.known[from * self.count + to];
        if known.0 != here || known.1 != there {
            *known = (here, there, radio.strength(here, there));
        }
        known.2
    }
}

/// The tunnel as the air sees it.
struct Tube<'a> {
    members: &'a [Member],
    strengths: &'a mut Strengths,
    radio: &'a Radio,
}

impl Ether for Tube<'_> {
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm> {
        // What a silenced sender sends never comes here.
        let silenced = self.members.get(to).is_some_and(Member::is_silenced);
        (!silenced).then(|| self.strengths.between(self.radio, from, to))
    }
}

fn metres(range: Range) -> f32 {
    match range {
        Range::At(distance) => distance.0,
        Range::Clear => f32::INFINITY,
        Range::Invalid => f32::NAN,
    }
}

/// What drones of this scenario fly among.
pub(crate) const fn surroundings<'a>(scenario: &'a Scenario, world: &'a World) -> Surroundings<'a> {
    Surroundings { tunnel: &world.tunnel, ground: scenario.ground, vehicle: &scenario.vehicle }
}
