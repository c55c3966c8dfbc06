//! The decisions of a drone: one state machine turns what the drone has sensed and heard into a
//! set-point and a report.
//!
//! The firmware, the simulator and the replay of recorded flights all run exactly this type, five
//! times a second. It is sans-I/O: [`Agent::step`] is handed the time and everything that happened
//! since the last call, and returns what to do. It owns no clock, no radio and no random number,
//! never allocates and never panics; the same inputs give the same outputs, bit for bit.
//!
//! Head, relay and base are [`Role`]s of it. What a drone is doing is its [`State`]: on the ground,
//! on its way up or down, and stopped it is in the hands of a shell that every mission shares; in the
//! air it is [`State::OnMission`], with the [`Duty`] that the mission has for it.
//!
//! ```text
//!          order             its turn           high enough
//!   Idle ─────────▶ Armed ─────────▶ TakingOff ─────────▶ OnMission(Duty)
//!    ▲                                    │                   │
//!    │ order: wait, or it                 │ order: land,      │ unfit, or for the mission's
//!    │ landed as not needed               │ unfit, too slow   │ reason: order: land, home …
//!   Landed ◀──────── Landing ◀────────────┴───────────────────┘
//!             touched down
//!
//!   OnMission ──order: perch──▶ Landing ──touched down──▶ Perched ──order: explore, return──▶ Rising
//!       ▲                                                                                        │
//!       └──────────────────────────────────── high enough ◀───────────────────────────────────────┘
//!
//!   Stopped: from anywhere, by order; for good.
//! ```
//!
//! A drone that comes back from a fault begins as Landed ([`Agent::restarted`]).
//!
//! A swarm ([`SwarmDuty`]) surveys, gathers and crosses a passage, hovers where it does not know its
//! position, and comes back the same way when it is recalled. Explorers ([`ExploreDuty`]) wait for a goal
//! or fly to it, and land when nothing is left.
//! The duties of the chain ([`ChainDuty`]):
//!
//! ```text
//!   Leading (head) ⇄ BackingUp      back link weak or lost
//!
//!   Relaying (relay) ⇄ BackingUp    the same
//!                    ⇄ Reconnecting front link lost; backs up where the back link is weak or lost
//!                    ⇄ Searching    the chain is at rest, and weak with equal links
//!                    ⇄ Retiring     no longer needed; lands at home
//!                    ⇄ Rejoining    in another branch than the drone in front
//!
//!   BackingUp ──nothing heard──▶ Homing     flies home, until it hears the base's side again
//!   any of these ──order: return─▶ Homing   flies home, and lands there
//!   any of these ──order: perch──▶ Siting   looks for a spot, and lands there
//! ```
#![no_std]

mod config;
mod io;
mod mission;
mod motion;
mod odometry;
mod renew;
mod state;
mod step_aside;

pub use config::{AgentConfig, ConfigError, FlightConfig};
pub use io::{BodyVelocity, Fitness, Inputs, LinkView, Located, Outputs, Status, Told};
pub use mission::Duty;
pub use mission::chain::ChainDuty;
pub use mission::explore::{Exploration, ExploreConfig, ExploreDuty, MOST_EXPLORERS};
pub use mission::swarm::{SwarmConfig, SwarmDuty};
pub use odometry::{Reckoning, odometer_deviation};
pub use state::{LandReason, State};

pub use virtual_forces::Target as SwarmTarget;

use ::chain::filter::LinkEstimate;
use ::chain::report::Report;
use tunnel_nav::{Diagonals, Guide, NavCommand, Navigator, Walls};
use units::{
    Duration, Instant, Metres, MetresPerSecond, MissionKind, NodeId, Order, Payload, Phase, Role,
    Setpoint,
};

use mission::{Mission, Outbox, PassedOn, Round, Task, Wish};
use odometry::{Odometry, along_tunnel};
use state::Situation;

/// The agent of one drone: the shell that every mission shares, around the one that the drone is on.
#[derive(Clone, Debug)]
pub struct Agent {
    id: NodeId,
    role: Role,
    state: State,
    mission: Mission,
    /// What the mission tells the others in this round.
    outbox: Outbox,
    navigator: Navigator,
    heeded: Option<Heeded>,
    /// Whether the chain must come home because one of its drones must.
    recalled: bool,
    /// Whether the drone would take off.
    fit: bool,
    odometry: Odometry,
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
    pub const fn new(id: NodeId, role: Role, mission: MissionKind) -> Self {
        Self {
            id,
            role,
            state: State::Idle,
            mission: Mission::new(mission),
            outbox: Outbox::new(),
            navigator: Navigator::new(),
            heeded: None,
            recalled: false,
            fit: true,
            odometry: Odometry::new(),
            last_step: None,
            sequence: 0,
        }
    }

    /// A drone whose last run ended by a fault or in the air. It may lie in a corner with a bent
    /// propeller while the order to fly still stands, so it stays where it is until the operator has
    /// told it to wait.
    #[must_use]
    pub const fn restarted(id: NodeId, role: Role, mission: MissionKind) -> Self {
        let mut agent = Self::new(id, role, mission);
        agent.note_restart();
        agent
    }

    /// Makes a new agent that of a drone whose last run ended by a fault or in the air.
    pub const fn note_restart(&mut self) {
        self.state = match self.role {
            Role::Head | Role::Relay => State::Landed { why: LandReason::Restarted },
            Role::Base => State::Idle,
        };
    }

    /// A drone that is already at its place in the air, with two seconds from `now` on to hear its
    /// neighbours: for studies that begin in mid-mission.
    #[must_use]
    pub fn new_linked(id: NodeId, role: Role, mission: MissionKind, now: Instant) -> Self {
        let mut agent = Self::new(id, role, mission);
        agent.place_in_air(now, Metres::ZERO);
        agent
    }

    /// Makes a new agent that of a drone which is already at its place in the air, and has `flown` so
    /// far from its own place in the row before the base.
    pub fn place_in_air(&mut self, now: Instant, flown: Metres) {
        self.odometry.settle(flown);
        let patient_until = now + Duration::from_secs(2);
        self.state = match self.role {
            Role::Head | Role::Relay => {
                State::OnMission(self.mission.first_duty(self.role, patient_until))
            }
            Role::Base => State::Idle,
        };
    }

    /// The state of the drone.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// The mission that the drone flies.
    #[must_use]
    pub const fn mission(&self) -> MissionKind {
        self.mission.kind()
    }

    /// The messages of the mission that the last step gives the link to send, the oldest first.
    #[must_use]
    pub fn messages(&self) -> &[Payload] {
        &self.outbox
    }

    /// The estimates of the links to all drones that were heard, lost or not, for observers.
    pub fn estimates(&self) -> impl Iterator<Item = (NodeId, LinkEstimate)> {
        self.mission.estimates()
    }

    /// Whether the strength of a link to a neighbour of the chain is only reckoned: reports come, and for a
    /// second none has brought a strength.
    pub fn is_blind(&self) -> bool {
        self.mission.is_blind()
    }

    /// Carries out one round. `now` must not run backwards; a negative time since the last step counts
    /// as none.
    pub fn step(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        self.step_exploring(config, now, inputs, None)
    }

    /// Carries out one round as [`step`](Self::step) does, with the memory that the mission explore
    /// needs: without it a drone of that mission does not take off. It must be the same in each round.
    pub fn step_exploring(
        &mut self,
        config: &AgentConfig,
        now: Instant,
        inputs: &Inputs<'_>,
        exploration: Option<&mut Exploration>,
    ) -> Outputs {
        let dt = self.last_step.map_or(Duration::ZERO, |last| now.since(last)).min(LONGEST_STEP);
        self.last_step = Some(now);
        self.listen(config, now, dt, inputs, exploration);

        let round = self.round(now);
        let Inputs { fitness, height, .. } = *inputs;
        let situation = Situation { fit: self.fit, fitness, height };
        let next = self.state.next(config, &mut self.mission, &round, &situation);
        if matches!(next, State::TakingOff { .. }) && !matches!(self.state, State::TakingOff { .. })
        {
            self.odometry.take_off();
        }
        if matches!(next, State::TakingOff { .. }) {
            self.mission.note_home();
        }
        if let (State::OnMission(_), State::Landing { why, .. }) = (self.state, next)
            && let Some(way) = self.mission.settled(&round, why)
        {
            self.odometry.settle(way);
        }
        self.state = next;
        self.outputs(config, now, inputs)
    }

    /// Takes in the motion, the packets and the orders since the last step.
    fn listen(
        &mut self,
        config: &AgentConfig,
        now: Instant,
        dt: Duration,
        inputs: &Inputs<'_>,
        exploration: Option<&mut Exploration>,
    ) {
        let is_airborne = self.state.is_airborne();
        let flown = self.odometry.step(inputs, is_airborne, dt);
        let velocity = match config.policy.estimates_slopes() {
            true => flown,
            false => along_tunnel(inputs.velocity, is_airborne).unwrap_or(MetresPerSecond::ZERO),
        };
        let round = self.round(now);
        self.mission.listen(config, &round, dt, velocity, inputs, exploration);
        self.recalled |= inputs.heard.iter().any(|heard| heard.report.recall);
        if let Some(task) = inputs.order {
            self.heeded = Some(Heeded { task, at: now });
        }
        let lasts = |left| left >= config.flight.least_endurance;
        self.fit = inputs.fitness == Fitness::Fit && inputs.endurance.is_none_or(lasts);
        let must_turn_back =
            config.flight.keeps_way_home && self.mission.must_turn_back(config, &round, inputs);
        self.fit &= self.state != State::Perched || !must_turn_back;
        self.recalled |= is_airborne && must_turn_back;
        if self.told() == Some(Order::Wait) {
            self.recalled = false;
        }
    }

    /// The operator's latest order.
    fn told(&self) -> Option<Order> {
        self.heeded.map(|heeded| heeded.task)
    }

    /// The order to follow: the operator's latest one, but exploring ends for all drones when one
    /// of the chain must come home.
    fn task(&self) -> Option<Order> {
        match self.told() {
            Some(Order::Explore(..)) if self.recalled => Some(Order::Return),
            told => told,
        }
    }

    /// This round as the mission is told of it.
    fn round(&self, now: Instant) -> Round {
        let task = self.task().zip(self.heeded);
        let task = task.map(|(order, Heeded { at, .. })| Task { order, given: at });
        let here = self.odometry.reckoning();
        let junction = self.navigator.opened();
        let phase = self.phase();
        Round { now, id: self.id, role: self.role, phase, task, here, junction }
    }

    // A part of its own in the program, so that no table of the step lies far from its branch.
    #[inline(never)]
    fn outputs(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let round = self.round(now);
        let [front, back] = self.mission.views();
        let wish = self.wish(config, &round, &inputs.ranges);
        let (setpoint, walls) = self.carry_out(wish, config, inputs);
        let PassedOn { links, sums, waiting, head_velocity, calls, is_uneven, signpost } =
            self.mission.passed_on(config, &round);
        self.outbox.clear();
        self.mission.tell(&round, &mut self.outbox);
        let velocity = along_tunnel(inputs.velocity, self.state.is_airborne());
        let report = Report {
            from: self.id,
            sequence: self.sequence,
            phase: self.phase(),
            velocity: velocity.unwrap_or(MetresPerSecond::ZERO),
            odometer: round.way(),
            links,
            sums,
            waiting,
            head_velocity,
            signpost,
            recall: self.recalled,
            calls,
            is_uneven,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let status = Status { state: self.state, front, back, here: round.here, walls };
        Outputs { setpoint, report, status }
    }

    /// The set-point that carries a wish out, and the walls that it steers by.
    fn carry_out(
        &mut self,
        wish: Wish,
        config: &AgentConfig,
        inputs: &Inputs<'_>,
    ) -> (Setpoint, Walls) {
        let (forward, setpoint, walls) = match wish {
            Wish::Rest => {
                self.navigator.renew();
                (MetresPerSecond::ZERO, Setpoint::Off, Walls::Neither)
            }
            Wish::Stop => (MetresPerSecond::ZERO, Setpoint::Stop, Walls::Neither),
            // Low above the floor the side beams see the floor.
            Wish::Along { height, .. }
            | Wish::Over { height, .. }
            | Wish::Beside { height, .. }
                if self.is_low(config, inputs.height) =>
            {
                self.navigator.renew();
                (MetresPerSecond::ZERO, Setpoint::hover(height), Walls::Neither)
            }
            Wish::Along { speed, height, guide } => {
                self.navigator.guide(guide);
                let bearings = self.odometry.bearings(inputs.heading);
                let NavCommand { forward, lateral, yaw_rate, walls } =
                    self.navigator.step(&config.nav, &inputs.ranges, speed, &bearings);
                (forward, Setpoint::Fly { forward, lateral, yaw_rate, height }, walls)
            }
            Wish::Beside { command, height } => {
                // The way along the wall is no part of the path that the navigator keeps.
                self.navigator.renew();
                let NavCommand { forward, lateral, yaw_rate, walls } = command;
                (forward, Setpoint::Fly { forward, lateral, yaw_rate, height }, walls)
            }
            Wish::Over { east, north, yaw, yaw_rate, height } => {
                let (sin, cos) = yaw.sin_cos();
                let forward = east * cos + north * sin;
                let lateral = north * cos - east * sin;
                (forward, Setpoint::Fly { forward, lateral, yaw_rate, height }, Walls::Neither)
            }
        };
        self.odometry.command(forward);
        (setpoint, walls)
    }

    /// Whether the drone is on its way up or down and not near its height.
    fn is_low(&self, config: &AgentConfig, height: Option<Metres>) -> bool {
        matches!(self.state, State::TakingOff { .. } | State::Rising { .. } | State::Landing { .. })
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
            // A relay that lands since it was not needed waits again at once: one with a higher number that
            // took off meanwhile would fly ahead of it.
            State::Landing { why: LandReason::Retired, .. }
            | State::Landed { why: LandReason::Retired } => Phase::Transit,
            State::OnMission(duty) => duty.phase(),
            State::Landing { why: LandReason::Perched, .. } => Phase::Linked,
            // A drone that cannot fly home must not keep the others from it.
            State::Perched if self.task() == Some(Order::Return) && !self.fit => Phase::Out,
            State::Perched | State::Rising { .. } => Phase::Perched,
            State::Landing { .. } | State::Landed { .. } | State::Stopped => Phase::Out,
        }
    }

    /// The wish of the mission at its duties, and of the shell everywhere else.
    fn wish(&mut self, config: &AgentConfig, round: &Round, ranges: &Diagonals) -> Wish {
        let still = |height| Wish::Beside { command: NavCommand::STILL, height };
        // A drone of a chain keeps to the middle of the gallery. The others are led by places, and walls and
        // neighbours would push them off theirs.
        let hover = |height| match self.mission.kind() {
            MissionKind::Chain => {
                Wish::Along { speed: MetresPerSecond::ZERO, height, guide: Guide::NONE }
            }
            MissionKind::Swarm | MissionKind::Explore => still(height),
        };
        match self.state {
            State::TakingOff { since } | State::Rising { since } => {
                hover(config.flight.climbing(round.now.since(since)))
            }
            State::OnMission(duty) => self.mission.wish(config, round, duty),
            State::Landing { since, why } => {
                let elapsed = round.now.since(since);
                let height = config.flight.descending(elapsed);
                match why {
                    LandReason::Home | LandReason::LinkLost | LandReason::Retired
                        if self.mission.kind() == MissionKind::Chain =>
                    {
                        let descends = round.now.since(since + step_aside::LASTS);
                        let height = config.flight.descending(descends);
                        let command = step_aside::command(self.id, elapsed, ranges);
                        Wish::Beside { command, height }
                    }
                    // A drone that has looked for its spot stays over it.
                    LandReason::Perched => still(height),
                    _ => hover(height),
                }
            }
            State::Stopped => Wish::Stop,
            State::Idle | State::Armed { .. } | State::Perched | State::Landed { .. } => Wish::Rest,
        }
    }
}
