//! One mission: the on-board agents, their bodies, and the packets between them.
//!
//! Time moves in physics steps of 20 ms; at flight level each drone takes them a millisecond at a
//! time. Every drone has its own phase of the 5 Hz loop: in the
//! step where its turn comes it reads its sensors and its mailbox, runs [`Agent::step`], and
//! broadcasts its report. The same scenario and seed give the same mission, bit for bit.

use agent::{Agent, Inputs, Outputs, Role, Setpoint};
use chain::neighbours::Heard;
use chain::report::{Order, Task};
use radio_model::Draws;
use tunnel_nav::{Diagonals, Range};
use units::{Instant, Metres, NodeId};

use crate::craft::faults::Failing;
use crate::craft::{Craft, Surroundings};
use crate::drone::{Drone, Flown, Senses};
use crate::random::{Purpose, Stream};
use crate::scenario::{Fidelity, Scenario, Start};
use crate::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};
use crate::vehicle::{Body, Response, STEP_US};
use crate::world::{Radio, Tunnel};

/// Physics steps in one round of the 5 Hz loop.
const STEPS_PER_ROUND: u64 = 10;
/// Length of a round, in microseconds.
pub const ROUND_US: u64 = STEPS_PER_ROUND * STEP_US;

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

/// One member of the chain.
struct Member {
    agent: Agent,
    role: Role,
    body: Drone,
    random: Stream,
    /// In which physics step of a round its turn comes.
    phase: u64,
    outputs: Option<Outputs>,
    ranges: Diagonals,
    mailbox: Vec<Parcel>,
}

/// A packet on its way.
#[derive(Clone, Copy)]
struct Parcel {
    arrives_us: u64,
    heard: Heard,
}

/// A mission under way.
pub struct Mission<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    members: Vec<Member>,
    /// One stream per directed link, sender-major.
    links: Vec<Stream>,
    response: Response,
    step: u64,
    order_sequence: u16,
    drone_contacts: u32,
    touching: Vec<(usize, usize)>,
    unpacked: Vec<Heard>,
}

impl<'a> Mission<'a> {
    /// Everybody at their places, nothing said yet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        let mut start = Stream::new(seed, Purpose::Start);
        let places = places(scenario, &mut start);
        let count = places.len();
        let members = places
            .into_iter()
            .enumerate()
            .map(|(n, place)| member(scenario, world, seed, &mut start, n, count, place))
            .collect();
        let link = |n: usize| Purpose::Link((n / count) as u8, (n % count) as u8);
        Self {
            scenario,
            world,
            members,
            links: (0..count * count).map(|n| Stream::new(seed, link(n))).collect(),
            response: Response::new(&scenario.vehicle),
            step: 0,
            order_sequence: 0,
            drone_contacts: 0,
            touching: Vec::new(),
            unpacked: Vec::new(),
        }
    }

    /// Flies for one round, 0.2 s.
    pub fn round(&mut self) {
        for phase in 0..STEPS_PER_ROUND {
            for n in 0..self.members.len() {
                if self.members[n].phase == phase {
                    self.tick(n);
                }
            }
            let around = surroundings(self.scenario, self.world);
            for member in &mut self.members {
                member.body.advance(around, self.response);
            }
            if phase % 2 == 0 {
                self.count_drone_contacts();
            }
            self.step += 1;
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
        self.step * STEP_US
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

    /// One turn of one member's 5 Hz loop.
    fn tick(&mut self, n: usize) {
        let now_us = self.time_us();
        let scenario = self.scenario;
        let spec = &scenario.vehicle;
        let order = self.operators_order(n, now_us);
        let member = &mut self.members[n];
        member.body.locate(&self.world.tunnel);
        let flies = member.role != Role::Base;

        self.unpacked.clear();
        let arrived = member.mailbox.partition_point(|parcel| parcel.arrives_us <= now_us);
        self.unpacked.extend(member.mailbox.drain(..arrived).map(|parcel| parcel.heard));

        let senses = if flies {
            let elapsed = ROUND_US as f32 * 1e-6;
            member.body.sense(elapsed, &self.world.tunnel, spec, &mut member.random)
        } else {
            Senses::NONE
        };
        member.ranges = senses.ranges;
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
        let outputs = member.agent.step(&scenario.agent, Instant::from_micros(now_us), &inputs);
        member.body.command(outputs.setpoint);
        member.outputs = Some(outputs);
        self.broadcast(n, now_us, &outputs);
    }

    /// What the operator's stick says, read anew at every turn of the base.
    fn operators_order(&mut self, n: usize, now_us: u64) -> Option<Order> {
        if self.members[n].role != Role::Base {
            return None;
        }
        let current = self.scenario.pilot.iter().take_while(|step| step.at_us <= now_us).last();
        self.order_sequence = self.order_sequence.wrapping_add(1);
        let task = current.map_or(Task::Wait, |step| step.task);
        Some(Order { sequence: self.order_sequence, task })
    }

    fn broadcast(&mut self, from: usize, now_us: u64, outputs: &Outputs) {
        let count = self.members.len();
        let here = self.members[from].body.abscissa();
        let reception = &self.scenario.reception;
        for to in (0..count).filter(|&to| to != from) {
            let stream = &mut self.links[from * count + to];
            let draws = Draws { luck: stream.uniform(), normal: stream.normal() };
            let there = self.members[to].body.abscissa();
            let strength = self.world.radio.strength(here, there);
            let silenced = [from, to].iter().any(|&n| is_silenced(&self.members[n]));
            if let Some(rssi) = reception.receive(strength, draws).filter(|_| !silenced) {
                let heard = Heard { report: outputs.report, rssi };
                let arrives_us = now_us + self.scenario.latency_us;
                self.members[to].mailbox.push(Parcel { arrives_us, heard });
            }
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
        let beams = &member.ranges;
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

fn metres(range: Range) -> f32 {
    match range {
        Range::At(distance) => distance.0,
        Range::Clear => f32::INFINITY,
        Range::Invalid => f32::NAN,
    }
}

fn is_silenced(member: &Member) -> bool {
    member.body.craft().is_some_and(Craft::is_silenced)
}

/// What drones of this scenario fly among.
pub(crate) const fn surroundings<'a>(scenario: &'a Scenario, world: &'a World) -> Surroundings<'a> {
    Surroundings { tunnel: &world.tunnel, ground: scenario.ground, vehicle: &scenario.vehicle }
}

/// A craft on the ground or in the air at this place of the centre-line.
fn flown(
    scenario: &Scenario,
    world: &World,
    place: f32,
    flying: bool,
    height: Metres,
    random: Stream,
) -> Flown {
    let (at, nose) = world.tunnel.centre_line().at(place);
    let spread = scenario.vehicle.flow_scale_error;
    let config = flight::FlightConfig::CRAZYFLIE_2_1;
    let craft = Craft::standing(config, at, nose, scenario.charge, spread, random);
    if flying {
        let craft = craft.hovering(height, surroundings(scenario, world));
        Flown::at(craft, place, Setpoint::hover(height))
    } else {
        Flown::at(craft, place, Setpoint::Off)
    }
}

/// Where everybody starts, head first, base last.
fn places(scenario: &Scenario, start: &mut Stream) -> Vec<f32> {
    let relays = scenario.relays;
    let mut places = Vec::with_capacity(relays + 2);
    match &scenario.start {
        Start::Mouth => {
            // In a row in front of the base, in the order in which they will fly.
            places.extend((0..=relays).map(|n| Start::SPACING * (relays + 1 - n) as f32));
        }
        Start::Random { head } => {
            let mut drawn = draw_apart(relays, *head, start);
            drawn.sort_by(f32::total_cmp);
            places.push(*head);
            places.extend(drawn.into_iter().rev());
        }
        Start::Placed(at) => places.extend(at),
    }
    places.push(0.0);
    places
}

/// `count` places between the base and `head`, uniform but for keeping apart from each other.
fn draw_apart(count: usize, head: f32, start: &mut Stream) -> Vec<f32> {
    let mut drawn: Vec<f32> = Vec::with_capacity(count);
    // A scenario has room for three times as many, so a dozen tries place each of them; the
    // bound is for the reader.
    for _ in 0..10_000 {
        if drawn.len() == count {
            break;
        }
        let place = head * start.uniform();
        let apart = |other: f32| (place - other).abs() >= Start::APART;
        if apart(0.0) && apart(head) && drawn.iter().all(|&other| apart(other)) {
            drawn.push(place);
        }
    }
    drawn
}

fn member(
    scenario: &Scenario,
    world: &World,
    seed: u64,
    start: &mut Stream,
    n: usize,
    count: usize,
    place: f32,
) -> Member {
    let role = match n {
        0 => Role::Head,
        _ if n + 1 == count => Role::Base,
        _ => Role::Relay,
    };
    let id = NodeId(n as u8);
    let mut random = Stream::new(seed, Purpose::Drone(id.0));
    let flying = role != Role::Base && !matches!(scenario.start, Start::Mouth);
    let height = if flying { scenario.agent.flight.height } else { Metres::ZERO };
    let body = match (scenario.fidelity, role) {
        (Fidelity::Flight, Role::Head | Role::Relay) => {
            let random = Stream::new(seed, Purpose::Craft(id.0));
            Drone::Craft(Box::new(flown(scenario, world, place, flying, height, random)))
        }
        (Fidelity::Policy, _) | (Fidelity::Flight, Role::Base) => {
            let mut body = Body::at(&world.tunnel, place, height.0, &scenario.vehicle, &mut random);
            if flying {
                body.command(Setpoint::hover(height));
            }
            Drone::Point(body)
        }
    };
    Member {
        agent: if flying { Agent::new_linked(id, role) } else { Agent::new(id, role) },
        role,
        body,
        random,
        phase: ((start.uniform() * STEPS_PER_ROUND as f32) as u64).min(STEPS_PER_ROUND - 1),
        outputs: None,
        ranges: Diagonals::default(),
        mailbox: Vec::new(),
    }
}
