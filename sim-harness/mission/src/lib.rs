//! One mission: the on-board agents, their bodies, and the packets between them.
//!
//! Time moves in physics steps of 20 ms at point level, of a millisecond at flight level; the
//! packets on the air have the very microsecond. Every member has its own phase of the 5 Hz loop:
//! in the step where its turn comes it reads its sensors and runs [`onboard::Drone::step`], whose
//! radio link sends its report in its slot. The same scenario and seed give the same mission, bit
//! for bit, in however small steps it is flown.
//!
//! The operator is the scenario's pilot, the caller of [`Mission::steer`], or, in a live mission, the
//! caller of [`Mission::order`].
//!
//! | module | holds |
//! |---|---|
//! | `begin` | how missions begin: piloted, live or served, on the host or in an emulator |
//! | `member`, `hosted` | a member: its body, and its on-board code with its clock |
//! | `operator`, `clients` | the orders of the operator, and the clients at the drones' servers |
//! | `air` | the packets between members and medium; `seal`, `intruders`: their seals, and forged ones |
//! | `ideal` | the link that carries reports and orders without packets |
//! | `called` | a speed law of the simulator's caller in the policy's place |
//! | `track` | where the members are on the skeleton |
//! | [`trace`] | the record of a mission; `team_map`: what its explorers know together; `team_links`: who hears whom |
//! | `view`, `record` | what may be looked at from outside, and the record of it |
//! | `contacts`, `log`, `parts` | contacts between drones, figures of the radio, time by parts |

mod air;
mod begin;
mod called;
mod clients;
mod contacts;
mod guide;
mod hosted;
mod ideal;
mod intruders;
mod log;
mod member;
mod operator;
mod parts;
mod record;
mod seal;
mod strengths;
mod team_links;
mod team_map;
pub mod trace;
mod track;
mod view;

use std::borrow::Cow;

use onboard::Sensed;
use random::Stream;
use units::{Metres, Radians, Role};
use wire::p2p;
use wire::radio::Datarate;
use world::World;

use bodies::craft::Surroundings;
use bodies::craft::faults::Failing;
use bodies::emulated::Halted;
use bodies::others::{Obstacle, Others};
use bodies::point::{Response, STEP_US};
use scenario::{Fidelity, Loss, LossKind, PilotStep, Scenario};

pub use called::{Law, with_called_law};
use contacts::Contacts;
use guide::Guide;
use ideal::IdealLink;
pub use ideal::delays;
use intruders::Intruders;
pub use intruders::Overheard;
use log::OrderLog;
pub use log::RadioMetrics;
use medium::timing::{RAMP_UP_US, air_us};
use medium::{Arrives, Medium};
use member::{Member, Onboard};
use operator::Source;
pub use parts::Part;
use parts::Stopwatch;
pub use recordings::{RecordedChannel, Residual};
pub use strengths::Gains;
use strengths::Strengths;
pub use track::Linked;
use track::Track;
pub use view::{Told, View};

/// Physics steps in one round of the 5 Hz loop.
const STEPS_PER_ROUND: u64 = 10;

/// A drone that is lower than this stands on its legs, m.
const LOW_M: f32 = 0.05;
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
    assert!(EMULATED_STEP_US < RAMP_UP_US);
    // None of the chain's is shorter, since no message is empty, and none faster.
    let on_air_us = air_us(Datarate::Mbit2, p2p::HEADER + 1 + p2p::TAG);
    assert!(EMULATED_STEP_IN_SILENCE_US < RAMP_UP_US + on_air_us);
    assert!(CRAFT_STEP_US.is_multiple_of(EMULATED_STEP_US));
    assert!(CRAFT_STEP_US.is_multiple_of(EMULATED_STEP_IN_SILENCE_US));
};

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
    /// The orders of the pilot, in order of time: the scenario's, or [steered](Self::steer) ones.
    pilot: Cow<'a, [PilotStep]>,
    /// What a pilot who follows a map's route chooses at its junctions.
    route: Guide,
    /// The drones that are lost, in order of time: the scenario's, and those that the caller loses.
    losses: Cow<'a, [Loss]>,
    now_us: u64,
    contacts: Contacts,
    /// Where the members are, as obstacles; empty where no ranger sees drones.
    obstacles: Vec<Obstacle>,
    orders: OrderLog,
    intruders: Option<Intruders>,
    /// The link that carries reports and orders without packets, where the scenario has it.
    ideal: Option<IdealLink>,
    stopwatch: Stopwatch,
    /// The speed law of the relays, where it is the host's.
    law: Option<Box<Law>>,
    /// Why the mission cannot go on.
    halted: Option<Halted>,
}

impl Mission<'_> {
    /// Whether any drone is in an emulator.
    fn is_emulated(&self) -> bool {
        self.medium.arrives() == Arrives::AtAntenna
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

    /// Makes something go wrong with one of the drones, at flight level.
    pub fn sabotage(&mut self, member: usize, failing: Failing, random: &mut Stream) {
        if let Some(craft) = self.members.get_mut(member).and_then(|m| m.body.craft_mut()) {
            craft.sabotage(failing, random);
        }
    }

    /// Takes from the chain the drones that are lost by now.
    fn lose_drones(&mut self) {
        for loss in self.losses.iter().take_while(|loss| loss.at_us <= self.now_us) {
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
        let place = self.track.follow(n, member.body.position(), &self.world.tunnel);
        let nose = (member.body.position(), Radians(member.body.yaw()));
        let flies = member.role != Role::Base;
        let is_low = flies && member.body.height() < LOW_M;
        self.strengths.moved(n, place, nose, is_low, &self.world.radio);
        member.senses = if flies {
            let around = surroundings(self.scenario, self.world, Others::of(&self.obstacles, n));
            member.body.sense(ROUND_US as f32 * 1e-6, around, &mut member.random)
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
                if let Some(fix) = &member.senses.fix {
                    emulated.locate(self.now_us, fix, Metres(member.body.height()));
                    if !matches!(self.source, Source::Clients) {
                        // Only a client reads what the radio chip acknowledges with.
                        emulated.take_answers(|_| {});
                    }
                }
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
        let senses = &member.senses;
        let outputs = called::with(n, &mut self.law, || hosted.step(now_us, senses));
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

    /// Notes where the drones are, for the rangers of the others.
    fn note_obstacles(&mut self) {
        self.obstacles.clear();
        if self.scenario.vehicle.sees_drones {
            self.obstacles.extend(self.members.iter().map(Member::as_obstacle));
        }
    }

    /// One physics step of all members.
    fn move_bodies(&mut self) {
        self.stopwatch.enter(Part::Bodies);
        self.note_obstacles();
        for (n, member) in self.members.iter_mut().enumerate() {
            let others = Others::of(&self.obstacles, n);
            let around = surroundings(self.scenario, self.world, others);
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
            let bodies = self.members.iter().map(|member| &member.body);
            let places = bodies.map(|body| (body.position(), body.height()));
            self.contacts.look(places, 2.0 * self.scenario.vehicle.radius);
        }
        self.stopwatch.enter(Part::Rest);
    }
}

/// The surroundings of a drone of this scenario.
pub(crate) fn surroundings<'a>(
    scenario: &'a Scenario,
    world: &'a World,
    others: Others<'a>,
) -> Surroundings<'a> {
    let (ground, vehicle) = (scenario.ground, &scenario.vehicle);
    Surroundings { tunnel: &world.tunnel, ground, vehicle, others }
}
