//! The decisions of a drone: one state machine turns what the drone has sensed and heard into a
//! set-point and a report.
//!
//! The firmware, the simulator and the replay of recorded flights all run exactly this type, five
//! times a second. It is sans-I/O: [`Agent::step`] is handed the time and everything that happened
//! since the last call, and returns what to do. It owns no clock, no radio and no random number,
//! never allocates and never panics; the same inputs give the same outputs, bit for bit.
//!
//! Head, relay and base are [`Role`]s of it. What a drone is doing is its [`State`]:
//!
//! ```text
//!          order             its turn           high enough
//!   Idle ─────────▶ Armed ─────────▶ TakingOff ─────────▶ Leading (head)
//!    ▲                                                    Relaying (relay) ⇄ Searching, Retiring
//!    │ order: wait                           front lost ⇅      ⇅ back weak or lost
//!   Landed ◀──────── Landing ◀──────── Reconnecting       BackingUp
//!             touched down    order, home, bound reached
//!
//!   Stopped: from anywhere, by order; for good.
//! ```
//!
//! A drone that comes back from a fault begins as Landed ([`Agent::restarted`]).
//!
//! The states on the ground, take-off, landing and stopping are a shell that every mission shares;
//! the four states on the right are the chain's, one of the missions that an agent can be on.
#![no_std]

mod config;
mod io;
mod mission;
mod motion;
mod state;

pub use config::{AgentConfig, ConfigError, FlightConfig};
pub use io::{BodyVelocity, Fitness, Inputs, LinkView, Outputs, Status};
pub use mission::Duty;
pub use mission::chain::ChainDuty;
pub use state::{LandReason, State};

use ::chain::report::Report;
use tunnel_nav::{Bearings, Navigator, Walls};
use units::{Duration, Instant, Metres, MetresPerSecond, NodeId, Order, Phase, Role, Setpoint};

use mission::chain::Chain;
use mission::{Mission, PassedOn, Round, Task, Wish};
use motion::Motion;
use state::Situation;

/// The agent of one drone: the shell that every mission shares, around the one that the drone is on.
#[derive(Clone, Debug)]
pub struct Agent {
    id: NodeId,
    role: Role,
    state: State,
    mission: Mission,
    navigator: Navigator,
    heeded: Option<Heeded>,
    /// Whether the chain must come home because one of its drones must.
    recalled: bool,
    /// Whether the drone would take off.
    fit: bool,
    odometer: Metres,
    motion: Motion,
    /// The way to the left since take-off, in the body axes of each moment.
    aside: Metres,
    last_step: Option<Instant>,
    sequence: u16,
}

/// The operator's latest order, and when it was last given.
#[derive(Clone, Copy, Debug)]
struct Heeded {
    task: Order,
    at: Instant,
}

/// The most that one step may move the estimates on: after a longer one the clock has jumped, and
/// the drone has not flown for so long unattended.
const LONGEST_STEP: Duration = Duration::from_secs(1);

impl Agent {
    /// A drone on the ground that has heard nothing.
    #[must_use]
    // Not inlined, it would be made on the stack where a static is initialised with it.
    #[inline(always)]
    pub const fn new(id: NodeId, role: Role) -> Self {
        Self {
            id,
            role,
            state: State::Idle,
            mission: Mission::Chain(Chain::new()),
            navigator: Navigator::new(),
            heeded: None,
            recalled: false,
            fit: true,
            odometer: Metres::ZERO,
            motion: Motion::STILL,
            aside: Metres::ZERO,
            last_step: None,
            sequence: 0,
        }
    }

    /// A drone whose last run ended by a fault or in the air. It may lie in a corner with a bent
    /// propeller while the order to fly still stands, so it stays where it is until the operator has
    /// told it to wait.
    #[must_use]
    pub const fn restarted(id: NodeId, role: Role) -> Self {
        let mut agent = Self::new(id, role);
        agent.state = match role {
            Role::Head | Role::Relay => State::Landed { why: LandReason::Restarted },
            Role::Base => State::Idle,
        };
        agent
    }

    /// A drone that is already at its place in the air, with two seconds from `now` on to hear its
    /// neighbours: for studies that begin in mid-mission.
    #[must_use]
    pub fn new_linked(id: NodeId, role: Role, now: Instant) -> Self {
        let mut agent = Self::new(id, role);
        let patient_until = now + Duration::from_secs(2);
        agent.state = match role {
            Role::Head | Role::Relay => {
                State::OnMission(agent.mission.first_duty(role, patient_until))
            }
            Role::Base => State::Idle,
        };
        agent
    }

    /// The state of the drone.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Carries out one round. `now` must not run backwards; a negative time since the last step counts
    /// as none.
    pub fn step(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let dt = self.last_step.map_or(Duration::ZERO, |last| now.since(last)).min(LONGEST_STEP);
        self.last_step = Some(now);
        self.listen(config, now, dt, inputs);

        let round = self.round(now);
        let Inputs { fitness, height, .. } = *inputs;
        let situation = Situation { fit: self.fit, fitness, height };
        let next = self.state.next(config, &mut self.mission, &round, &situation);
        if matches!(next, State::TakingOff { .. }) && !matches!(self.state, State::TakingOff { .. })
        {
            self.odometer = Metres::ZERO;
            self.aside = Metres::ZERO;
        }
        if matches!(next, State::TakingOff { .. }) {
            self.mission.note_home();
        }
        self.state = next;
        self.outputs(config, now, inputs)
    }

    /// Takes in the motion, the packets and the orders since the last step.
    fn listen(&mut self, config: &AgentConfig, now: Instant, dt: Duration, inputs: &Inputs<'_>) {
        let measured = self.along_tunnel(inputs);
        let flown = if self.state.is_airborne() {
            self.motion.step(measured, dt)
        } else {
            self.motion = Motion::STILL;
            MetresPerSecond::ZERO
        };
        self.odometer += flown * dt;
        let velocity = match config.policy.estimates_slopes() {
            true => flown,
            false => measured.unwrap_or(MetresPerSecond::ZERO),
        };
        self.aside += self.aside_of_tunnel(inputs) * dt;
        let round = self.round(now);
        self.mission.listen(config, &round, dt, velocity, inputs.heard);
        self.recalled |= inputs.heard.iter().any(|heard| heard.report.recall);
        if let Some(task) = inputs.order {
            self.heeded = Some(Heeded { task, at: now });
        }
        let lasts = |left| left >= config.flight.least_endurance;
        self.fit = inputs.fitness == Fitness::Fit && inputs.endurance.is_none_or(lasts);
        self.recalled |= self.state.is_airborne() && self.must_turn_back(config, inputs);
        if self.told() == Some(Order::Wait) {
            self.recalled = false;
        }
    }

    /// Whether the battery has little more than the way home takes.
    fn must_turn_back(&self, config: &AgentConfig, inputs: &Inputs<'_>) -> bool {
        let way = self.odometer.0.max(0.0) / config.flight.return_speed.0;
        inputs
            .endurance
            .is_some_and(|left| left.as_secs_f32() < config.flight.turns_back_below(way))
    }

    /// The operator's latest order.
    fn told(&self) -> Option<Order> {
        self.heeded.map(|heeded| heeded.task)
    }

    /// The order to follow: the operator's latest one, but exploring ends for all drones when one
    /// of the chain must come home.
    fn task(&self) -> Option<Order> {
        match self.told() {
            Some(Order::Explore(_)) if self.recalled => Some(Order::Return),
            told => told,
        }
    }

    /// The measured velocity along the tunnel: the drone's nose points along it, so it is the body's
    /// own forward velocity. `None` without flow, and on the ground, where the flow sees nothing.
    fn along_tunnel(&self, inputs: &Inputs<'_>) -> Option<MetresPerSecond> {
        let forward = inputs.velocity?.forward;
        (self.state.is_airborne() && forward.0.is_finite()).then_some(forward)
    }

    /// The drone's velocity to its left. Without flow it is taken to stand still, and on the ground
    /// it does.
    fn aside_of_tunnel(&self, inputs: &Inputs<'_>) -> MetresPerSecond {
        match inputs.velocity {
            Some(velocity) if self.state.is_airborne() && velocity.lateral.0.is_finite() => {
                velocity.lateral
            }
            _ => MetresPerSecond::ZERO,
        }
    }

    /// This round as the mission is told of it.
    fn round(&self, now: Instant) -> Round {
        let task = self.task().zip(self.heeded);
        let task = task.map(|(order, Heeded { at, .. })| Task { order, given: at });
        Round { now, id: self.id, role: self.role, task, way: self.odometer }
    }

    fn outputs(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let round = self.round(now);
        let [front, back] = self.mission.views();
        let (setpoint, walls) = match self.wish(config, &round) {
            Wish::Rest => {
                self.motion.command(MetresPerSecond::ZERO);
                self.navigator = Navigator::new();
                (Setpoint::Off, Walls::Neither)
            }
            Wish::Stop => {
                self.motion.command(MetresPerSecond::ZERO);
                (Setpoint::Stop, Walls::Neither)
            }
            // Low above the floor the side beams see the floor.
            Wish::Along { height, .. } if self.is_low(config, inputs.height) => {
                self.motion.command(MetresPerSecond::ZERO);
                self.navigator = Navigator::new();
                (Setpoint::hover(height), Walls::Neither)
            }
            Wish::Along { speed, height } => {
                let bearings =
                    Bearings { way: self.odometer, aside: self.aside, heading: inputs.heading };
                let command = self.navigator.step(&config.nav, &inputs.ranges, speed, &bearings);
                self.motion.command(command.forward);
                let setpoint = Setpoint::Fly {
                    forward: command.forward,
                    lateral: command.lateral,
                    yaw_rate: command.yaw_rate,
                    height,
                };
                (setpoint, command.walls)
            }
        };
        let PassedOn { links, sums, waiting, head_velocity } =
            self.mission.passed_on(config, &round);
        let report = Report {
            from: self.id,
            sequence: self.sequence,
            phase: self.phase(),
            velocity: self.along_tunnel(inputs).unwrap_or(MetresPerSecond::ZERO),
            odometer: self.odometer,
            links,
            sums,
            waiting,
            head_velocity,
            recall: self.recalled,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let status = Status { state: self.state, front, back, odometer: self.odometer, walls };
        Outputs { setpoint, report, status }
    }

    /// Whether the drone is on its way up or down and not near its height.
    fn is_low(&self, config: &AgentConfig, height: Option<Metres>) -> bool {
        matches!(self.state, State::TakingOff { .. } | State::Landing { .. })
            && !config.flight.sees_walls(height)
    }

    fn phase(&self) -> Phase {
        if self.role == Role::Base {
            return Phase::Base;
        }
        match self.state {
            State::Idle | State::Armed { .. } if !self.fit => Phase::Out,
            State::Idle | State::Armed { .. } => Phase::Waiting,
            State::TakingOff { .. } => Phase::Transit,
            State::OnMission(duty) => duty.phase(),
            State::Landing { .. } | State::Landed { .. } | State::Stopped => Phase::Out,
        }
    }

    /// The wish of the mission at its duties, and of the shell everywhere else.
    fn wish(&mut self, config: &AgentConfig, round: &Round) -> Wish {
        let hover = |height| Wish::Along { speed: MetresPerSecond::ZERO, height };
        match self.state {
            State::TakingOff { since } => hover(config.flight.climbing(round.now.since(since))),
            State::OnMission(duty) => self.mission.wish(config, round, duty),
            State::Landing { since, .. } => hover(config.flight.descending(round.now.since(since))),
            State::Stopped => Wish::Stop,
            State::Idle | State::Armed { .. } | State::Landed { .. } => Wish::Rest,
        }
    }
}
