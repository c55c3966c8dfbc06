//! The drone's mind: one state machine that turns what was sensed and heard into a set-point and
//! what to say.
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
//!    ▲                                                    Relaying (relay)
//!    │ order: wait                           front lost ⇅      ⇅ back weak or lost
//!   Landed ◀──────── Landing ◀──────── Reconnecting       BackingUp
//!             touched down    order, home, bound reached
//!
//!   Stopped: from anywhere, by order or emergency; for good.
//! ```
//!
//! A drone that comes back from a fault begins as Landed ([`Agent::restarted`]).
#![no_std]

mod config;
mod io;
mod state;

pub use config::{AgentConfig, ConfigError, FlightConfig};
pub use io::{BodyVelocity, Fitness, Inputs, LinkView, Outputs, Status};
pub use state::{LandReason, State};

use chain::launch::LaunchWatch;
use chain::neighbours::{Neighbour, Neighbours};
use chain::report::Report;
use tunnel_nav::{Bearings, Navigator, Walls};
use units::{
    Dbm, Duration, Instant, LinkSpan, Metres, MetresPerSecond, NodeId, Order, Phase, Role, Setpoint,
};

use state::Situation;

/// One drone's mind.
#[derive(Clone, Debug)]
pub struct Agent {
    id: NodeId,
    role: Role,
    state: State,
    neighbours: Neighbours,
    launch: LaunchWatch,
    navigator: Navigator,
    heeded: Option<Heeded>,
    /// Somebody in the chain must come home.
    recalled: bool,
    /// Whether it would take off.
    fit: bool,
    odometer: Metres,
    /// The strength of the base where this drone took off.
    home_rssi: Option<Dbm>,
    last_step: Option<Instant>,
    sequence: u16,
}

/// The operator's latest word, and when it was last said.
#[derive(Clone, Copy, Debug)]
struct Heeded {
    task: Order,
    at: Instant,
}

/// A step longer than this is a clock that jumped, not a drone that flew so long unattended:
/// the most that one step may move the estimates on.
const LONGEST_STEP: Duration = Duration::from_secs(1);

impl Agent {
    /// A drone on the ground that has heard nothing.
    #[must_use]
    pub const fn new(id: NodeId, role: Role) -> Self {
        Self {
            id,
            role,
            state: State::Idle,
            neighbours: Neighbours::new(),
            launch: LaunchWatch::new(),
            navigator: Navigator::new(),
            heeded: None,
            recalled: false,
            fit: true,
            odometer: Metres::ZERO,
            home_rssi: None,
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
            Role::Head => State::Leading { patient_until },
            Role::Relay => State::Relaying { patient_until },
            Role::Base => State::Idle,
        };
        agent
    }

    /// What the drone is doing.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// One round. `now` must not run backwards; a step it calls negative counts as none.
    pub fn step(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let dt = self.last_step.map_or(Duration::ZERO, |last| now.since(last)).min(LONGEST_STEP);
        self.last_step = Some(now);
        self.listen(config, now, dt, inputs);

        let situation = self.situation(config, now, inputs);
        let next = self.state.next(config, self.role, &situation);
        if matches!(next, State::TakingOff { .. }) && !matches!(self.state, State::TakingOff { .. })
        {
            self.odometer = Metres::ZERO;
        }
        if matches!(next, State::TakingOff { .. }) {
            self.home_rssi = situation.base;
        }
        self.state = next;
        self.outputs(config, now, inputs)
    }

    /// Motion, packets and orders since the last step.
    fn listen(&mut self, config: &AgentConfig, now: Instant, dt: Duration, inputs: &Inputs<'_>) {
        let velocity = self.along_tunnel(inputs);
        self.odometer += velocity * dt;
        let smoothing = &config.policy.smoothing;
        self.neighbours.predict(self.id, velocity, dt, smoothing);
        for heard in inputs.heard {
            let lost_after = config.retreat.lost_after;
            self.neighbours.hear(self.id, now, heard, smoothing, lost_after);
            self.recalled |= heard.report.recall;
        }
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

    /// Whether the battery has what the way home takes, and little more.
    fn must_turn_back(&self, config: &AgentConfig, inputs: &Inputs<'_>) -> bool {
        let way = self.odometer.0.max(0.0) / config.flight.return_speed.0;
        inputs
            .endurance
            .is_some_and(|left| left.as_secs_f32() < config.flight.turns_back_below(way))
    }

    /// The operator's latest word.
    fn told(&self) -> Option<Order> {
        self.heeded.map(|heeded| heeded.task)
    }

    /// What is to be done: the operator's latest word, but exploring ends for everybody when one
    /// of the chain must come home.
    fn task(&self) -> Option<Order> {
        match self.told() {
            Some(Order::Explore(_)) if self.recalled => Some(Order::Return),
            told => told,
        }
    }

    /// The drone's velocity along the tunnel: its nose points along it, so the body's own forward
    /// velocity. Without flow it is taken to stand still, and on the ground it does.
    fn along_tunnel(&self, inputs: &Inputs<'_>) -> MetresPerSecond {
        match inputs.velocity {
            Some(velocity) if self.state.is_airborne() && velocity.forward.0.is_finite() => {
                velocity.forward
            }
            _ => MetresPerSecond::ZERO,
        }
    }

    fn front(&self, config: &AgentConfig, now: Instant) -> Option<&Neighbour> {
        self.neighbours.front(self.id, now, config.retreat.lost_after)
    }

    fn back(&self, config: &AgentConfig, now: Instant) -> Option<&Neighbour> {
        self.neighbours.back(self.id, now, config.retreat.lost_after)
    }

    /// Everything a transition depends on.
    fn situation(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Situation {
        let front = self.front(config, now).copied();
        let back = self.back(config, now).copied();
        let (lower_waits, lower_linked) = self
            .neighbours
            .heard(now, config.retreat.lost_after)
            .filter(|n| n.report.from < self.id)
            .fold((false, false), |(waits, linked), n| {
                let phase = n.report.phase;
                (
                    waits || matches!(phase, Phase::Waiting | Phase::Transit),
                    linked || phase == Phase::Linked,
                )
            });
        let launch = match self.state {
            State::Armed { since } if now.since(since) >= config.launch.arm_delay => {
                let ahead = front.and_then(|n| n.report.links);
                self.launch.step(now, &config.launch, front.map(|n| n.rssi()), ahead)
            }
            _ => {
                self.launch = LaunchWatch::new();
                false
            }
        };
        Situation {
            now,
            task: self.task(),
            fit: self.fit,
            fitness: inputs.fitness,
            front: front.map(|n| n.rssi()),
            back: back.map(|n| n.rssi()),
            base: back.filter(|n| n.report.phase == Phase::Base).map(|n| n.rssi()),
            home_rssi: self.home_rssi,
            height: inputs.height,
            odometer: self.odometer,
            my_turn: !lower_waits,
            chain_flies: lower_linked,
            launch,
        }
    }

    fn outputs(&mut self, config: &AgentConfig, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let front = self.front(config, now).map(LinkView::of);
        let back = self.back(config, now).map(LinkView::of);
        let (setpoint, walls) = match self.wish(config, now, front, back) {
            Wish::Rest => {
                self.navigator = Navigator::new();
                (Setpoint::Off, Walls::Neither)
            }
            Wish::Stop => (Setpoint::Stop, Walls::Neither),
            // Low above the floor the side beams see the floor.
            Wish::Fly { height, .. } if self.is_low(config, inputs.height) => {
                self.navigator = Navigator::new();
                (Setpoint::hover(height), Walls::Neither)
            }
            Wish::Fly { speed, height } => {
                let bearings = Bearings { way: self.odometer, heading: inputs.heading };
                let command = self.navigator.step(&config.nav, &inputs.ranges, speed, &bearings);
                let setpoint = Setpoint::Fly {
                    forward: command.forward,
                    lateral: command.lateral,
                    yaw_rate: command.yaw_rate,
                    height,
                };
                (setpoint, command.walls)
            }
        };
        let ahead = self.front(config, now).and_then(|n| n.report.links);
        let report = Report {
            from: self.id,
            sequence: self.sequence,
            phase: self.phase(),
            velocity: self.along_tunnel(inputs),
            odometer: self.odometer,
            links: front.map(|link| LinkSpan::extended(ahead, link.rssi)),
            recall: self.recalled,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let status = Status { state: self.state, front, back, odometer: self.odometer, walls };
        Outputs { setpoint, report, status }
    }

    /// On the way up or down, and not near its height.
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
            State::Leading { .. }
            | State::Relaying { .. }
            | State::Reconnecting { .. }
            | State::BackingUp { .. } => Phase::Linked,
            State::Landing { .. } | State::Landed { .. } | State::Stopped => Phase::Out,
        }
    }

    /// How fast along the tunnel, and how high.
    fn wish(
        &self,
        config: &AgentConfig,
        now: Instant,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> Wish {
        let flight = &config.flight;
        let (speed, height) = match self.state {
            State::Idle | State::Armed { .. } | State::Landed { .. } => return Wish::Rest,
            State::Stopped => return Wish::Stop,
            State::TakingOff { since } => {
                (MetresPerSecond::ZERO, flight.climbing(now.since(since)))
            }
            State::Landing { since, .. } => {
                (MetresPerSecond::ZERO, flight.descending(now.since(since)))
            }
            State::Leading { .. } => (self.leading_speed(config, now, back), flight.height),
            State::Relaying { .. } => (self.relaying_speed(config, front, back), flight.height),
            State::Reconnecting { since, from } => {
                let waited = now.since(since);
                (reconnecting_speed(config, waited, self.odometer - from, back), flight.height)
            }
            State::BackingUp { .. } => (-config.retreat.speed, flight.height),
        };
        Wish::Fly { speed, height }
    }

    /// The pilot's stick while it is alive and the link can spare it, or the way home.
    fn leading_speed(
        &self,
        config: &AgentConfig,
        now: Instant,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let (Some(task), Some(Heeded { at, .. })) = (self.task(), self.heeded) else {
            return MetresPerSecond::ZERO;
        };
        match task {
            Order::Explore(speed) if now.since(at) <= config.flight.pilot_timeout => {
                let speed = speed.limited_to(config.policy.max_speed);
                if speed.0 >= 0.0 {
                    speed * config.retreat.freedom(back.map(|link| link.rssi))
                } else {
                    behind_clear(config, back, speed)
                }
            }
            Order::Return => homeward(config, back),
            Order::Explore(_) | Order::Wait | Order::Land | Order::Stop => MetresPerSecond::ZERO,
        }
    }

    /// Algorithm 1; a relay that is called home and has nobody in front any more flies home.
    fn relaying_speed(
        &self,
        config: &AgentConfig,
        front: Option<LinkView>,
        back: Option<LinkView>,
    ) -> MetresPerSecond {
        let called_home = self.task() == Some(Order::Return);
        match (front, back) {
            (None, _) if called_home => homeward(config, back),
            // The base is not to be kept clear of by who goes home to it.
            (_, Some(back)) if called_home && back.is_base && is_too_near(config, back) => {
                homeward(config, Some(back))
            }
            (Some(front), Some(back)) => config.policy.velocity(front.end(), back.end()),
            _ => MetresPerSecond::ZERO,
        }
    }
}

/// Flying home, but not into the next drone that has not landed yet.
fn homeward(config: &AgentConfig, back: Option<LinkView>) -> MetresPerSecond {
    behind_clear(config, back, -config.flight.return_speed)
}

/// `speed`, a backward one, unless a drone is too near behind.
fn behind_clear(
    config: &AgentConfig,
    back: Option<LinkView>,
    speed: MetresPerSecond,
) -> MetresPerSecond {
    match back {
        Some(back) if !back.is_base && is_too_near(config, back) => MetresPerSecond::ZERO,
        _ => speed,
    }
}

fn is_too_near(config: &AgentConfig, link: LinkView) -> bool {
    config.policy.is_too_near(link.rssi)
}

/// What a state wants before the walls have their say.
enum Wish {
    /// Motors off.
    Rest,
    /// Motors off for good.
    Stop,
    /// Along the tunnel at this speed and height.
    Fly { speed: MetresPerSecond, height: Metres },
}

/// With the front neighbour lost, a relay advances while its own back link can spare it, and
/// waits where that, or the bound on its advance, ends. Half of all relays that only hover are
/// found after 20 s, of those that advance after 12 s (the book, "Lost neighbours").
fn reconnecting_speed(
    config: &AgentConfig,
    waited: Duration,
    advanced: Metres,
    back: Option<LinkView>,
) -> MetresPerSecond {
    let retreat = &config.retreat;
    let spare = !retreat.wanted(None, back.map(|link| link.rssi), true);
    if spare && waited <= retreat.max_time && advanced < retreat.max_distance {
        retreat.speed
    } else {
        MetresPerSecond::ZERO
    }
}
