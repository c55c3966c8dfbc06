//! A drone on the bench: an agent with a clock, and a world that is said in a few words.

use agent::{Agent, AgentConfig, BodyVelocity, Fitness, Inputs, Outputs, State};
use chain::launch::LaunchConfig;
use chain::neighbours::Heard;
use chain::policy::PolicyConfig;
use chain::report::Report;
use tunnel_nav::{Diagonals, Range};
use units::{
    Dbm, Duration, Instant, Metres, MetresPerSecond, MissionKind, NodeId, Order, Phase, Role,
    Setpoint,
};

/// The length of a round.
pub(crate) const ROUND: u64 = 200;
/// A relay on the bench is number 2: the head is 0, 1 is not heard unless a story says so.
pub(crate) const RELAY: NodeId = NodeId(2);
/// The base of that chain.
pub(crate) const BASE: u8 = 3;
/// The order that starts a mission.
pub(crate) const EXPLORE: Order = Order::explore(MetresPerSecond(0.2));

pub(crate) const CONFIG: AgentConfig =
    AgentConfig { policy: PolicyConfig::T0, launch: LaunchConfig::AT_ONCE, ..AgentConfig::DEFAULT };

/// What the drone meets in the rounds to come.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    /// What the operator orders anew each round, if anything.
    pub(crate) task: Option<Order>,
    /// Strength and phase of everyone heard, by number.
    pub(crate) heard: Vec<(u8, Phase, f32)>,
    /// How strongly the drone's own last packet came there, by number.
    pub(crate) reverse: Vec<(u8, f32)>,
    /// `None` while it is not measured.
    pub(crate) height: Option<f32>,
    /// What the flow says, m/s.
    pub(crate) flow: Option<f32>,
    pub(crate) fitness: Fitness,
    /// Seconds left in the battery.
    pub(crate) endurance: Option<u64>,
}

impl Scene {
    /// On the ground with a good link either way, and nothing ordered.
    pub(crate) fn quiet() -> Self {
        Self {
            task: None,
            heard: vec![(0, Phase::Linked, -52.0), (BASE, Phase::Base, -52.0)],
            reverse: Vec::new(),
            height: Some(0.0),
            flow: Some(0.0),
            fitness: Fitness::Fit,
            endurance: None,
        }
    }

    pub(crate) fn order(mut self, task: Order) -> Self {
        self.task = Some(task);
        self
    }

    /// Hears this number this strongly, in its old phase.
    pub(crate) fn link(mut self, from: u8, rssi: f32) -> Self {
        for known in self.heard.iter_mut().filter(|known| known.0 == from) {
            known.2 = rssi;
        }
        self
    }

    /// Hears somebody else too.
    pub(crate) fn also(mut self, from: u8, phase: Phase, rssi: f32) -> Self {
        self.heard.push((from, phase, rssi));
        self
    }

    /// This number says how strongly it hears the drone.
    pub(crate) fn reverse(mut self, from: u8, rssi: f32) -> Self {
        self.reverse.push((from, rssi));
        self
    }

    /// No longer hears this number.
    pub(crate) fn without(mut self, from: u8) -> Self {
        self.heard.retain(|known| known.0 != from);
        self
    }

    pub(crate) fn at_height(mut self, height: Option<f32>) -> Self {
        self.height = height;
        self
    }

    pub(crate) fn flow(mut self, flow: Option<f32>) -> Self {
        self.flow = flow;
        self
    }

    pub(crate) fn fitness(mut self, fitness: Fitness) -> Self {
        self.fitness = fitness;
        self
    }

    /// The battery lasts for so many seconds.
    pub(crate) fn endurance(mut self, seconds: u64) -> Self {
        self.endurance = Some(seconds);
        self
    }
}

/// A drone on the bench.
#[derive(Clone, Debug)]
pub(crate) struct Rig {
    pub(crate) agent: Agent,
    pub(crate) now: Instant,
    sequence: u16,
}

impl Rig {
    pub(crate) fn new(role: Role) -> Self {
        Self::of(Agent::new(id(role), role, MissionKind::Chain))
    }

    /// The same, back from a fault.
    pub(crate) fn restarted(role: Role) -> Self {
        Self::of(Agent::restarted(id(role), role, MissionKind::Chain))
    }

    fn of(agent: Agent) -> Self {
        // The numbers of reports wrap during the story.
        Self { agent, now: Instant::from_millis(1_000), sequence: 65_530 }
    }

    pub(crate) fn state(&self) -> State {
        self.agent.state()
    }

    /// One step, `gap` milliseconds after the last.
    pub(crate) fn step_after(&mut self, gap: u64, scene: &Scene) -> Outputs {
        self.now = self.now + Duration::from_millis(gap);
        self.sequence = self.sequence.wrapping_add(1);
        let heard: Vec<_> = scene
            .heard
            .iter()
            .map(|&(from, phase, rssi)| {
                let reverse = scene.reverse.iter().find(|(by, _)| *by == from);
                let reverse = reverse.map(|(_, rssi)| Dbm(*rssi));
                Heard { reverse, ..heard(from, self.sequence, phase, rssi) }
            })
            .collect();
        let along =
            |v| BodyVelocity { forward: MetresPerSecond(v), lateral: MetresPerSecond::ZERO };
        let inputs = Inputs {
            ranges: gallery(),
            velocity: scene.flow.map(along),
            heading: None,
            height: scene.height.map(Metres),
            heard: &heard,
            located: None,
            told: &[],
            order: scene.task,
            fitness: scene.fitness,
            endurance: scene.endurance.map(Duration::from_secs),
        };
        self.agent.step(&CONFIG, self.now, &inputs)
    }

    /// One round of 0.2 s.
    pub(crate) fn step(&mut self, scene: &Scene) -> Outputs {
        self.step_after(ROUND, scene)
    }

    /// So many seconds of the same.
    pub(crate) fn during(&mut self, seconds: f32, scene: &Scene) -> Outputs {
        let mut last = None;
        for _ in 0..(seconds * 5.0).round().max(1.0) as u32 {
            last = Some(self.step(scene));
        }
        last.unwrap()
    }

    /// Rounds of the same until it is in the state of that name; the story is wrong where that
    /// takes over 80 s: the longest search for a spot takes 70 s.
    pub(crate) fn until(&mut self, state: &str, scene: &Scene) -> &mut Self {
        for _ in 0..400 {
            if self.state().name() == state {
                return self;
            }
            self.step(scene);
        }
        panic!("never {state} but {:?}", self.state());
    }

    /// On duty half a metre from home: the head leads, the relay relays. At home the base was
    /// heard at -38 dBm, here it is at -52.
    pub(crate) fn on_duty(role: Role) -> Self {
        let mut rig = Self::new(role);
        let home = Scene::quiet().order(EXPLORE).link(BASE, -38.0);
        rig.until("taking-off", &home.clone().link(0, -62.0));
        let duty = if role == Role::Head { "leading" } else { "relaying" };
        let home = home.at_height(Some(0.3));
        rig.until(duty, &home);
        // Both links are equal, so that the relay stays.
        let home = home.link(0, -50.0).link(BASE, -50.0);
        rig.during(1.0, &home.clone().flow(Some(0.5)));
        // A drift shows in the odometer within seconds, not at once.
        rig.during(2.0, &home);
        rig.during(2.0, &Scene::quiet().order(EXPLORE).at_height(Some(0.3)));
        rig
    }
}

/// A packet of this number; NaN is a strength that was not measured.
pub(crate) fn heard(from: u8, sequence: u16, phase: Phase, rssi: f32) -> Heard {
    let report = Report::plain(NodeId(from), sequence, phase);
    Heard { report, rssi: (!rssi.is_nan()).then_some(Dbm(rssi)), reverse: None }
}

/// In the middle of a straight gallery.
pub(crate) fn gallery() -> Diagonals {
    let beam = Range::At(Metres(0.8));
    Diagonals { nw: beam, ne: beam, sw: beam, se: beam }
}

/// Forward speed and height of a set-point, or `None` with the motors off.
pub(crate) fn flown(setpoint: Setpoint) -> Option<(f32, f32)> {
    match setpoint {
        Setpoint::Off | Setpoint::Stop => None,
        Setpoint::Fly { forward, height, .. } => Some((forward.0, height.0)),
    }
}

const fn id(role: Role) -> NodeId {
    match role {
        Role::Head => NodeId::HEAD,
        Role::Relay => RELAY,
        Role::Base => NodeId(BASE),
    }
}
