//! Explorers as agents, each a point that follows its set-point with a lag, in a room of 4 m by 4 m:
//! all is explored and all land, whatever packets are lost, whether by fixes or by their own motion.

use agent::{
    Agent, AgentConfig, BodyVelocity, Duty, Exploration, ExploreDuty, Fitness, Inputs, LandReason,
    Located, Outputs, State, Told,
};
use grid_map::CellState;
use proptest::prelude::*;
use tunnel_nav::{Diagonals, Range};
use units::{
    Dbm, Instant, Metres, MetresPerSecond, MissionKind, NodeId, Order, Payload, Point2, Pose2,
    Radians, Role, Setpoint,
};

/// The length of a round, s.
const ROUND: f32 = 0.2;
/// The part of a change of velocity that a round brings, with a lag of 0.3 s.
const RESPONSE: f32 = 0.486;
/// Half the room, m.
const WALL: f32 = 2.0;
/// Two drones touch where they are nearer, m: each is 0.08 m from its middle to its guards.
const TOUCH: f32 = 0.16;

const EXPLORE: Order = Order::explore(MetresPerSecond(0.2));

struct Drone {
    agent: Agent,
    exploration: Box<Exploration>,
    at: Point2,
    yaw: f32,
    velocity: [f32; 2],
    height: f32,
    inbox: Vec<Told>,
}

/// What the drones know of their places.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Places {
    /// A positioning system tells them.
    Fixed,
    /// They have their own motion alone.
    Reckoned,
}

struct World {
    config: AgentConfig,
    drones: Vec<Drone>,
    places: Places,
    loss: f32,
    order: Order,
    round: u32,
    random: u64,
    closest: f32,
    nearest_wall: f32,
}

impl World {
    fn new(drones: u8, places: Places, loss: f32, seed: u64) -> Self {
        let make = |n: u8| Drone {
            agent: Agent::new(NodeId(n), Role::usual_of(NodeId(n)), MissionKind::Explore),
            exploration: Box::new(Exploration::NEW),
            at: Point2::new(-0.35 * f32::from(n), 0.0),
            yaw: 0.0,
            velocity: [0.0; 2],
            height: 0.0,
            inbox: Vec::new(),
        };
        Self {
            config: AgentConfig::DEFAULT,
            drones: (0..drones).map(make).collect(),
            places,
            loss,
            order: EXPLORE,
            round: 0,
            random: seed,
            closest: f32::INFINITY,
            nearest_wall: f32::INFINITY,
        }
    }

    fn uniform(&mut self) -> f32 {
        self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.random >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn now(&self) -> Instant {
        Instant::from_millis(1_000 + 200 * u64::from(self.round))
    }

    /// One round of one drone, which knows its position or does not.
    fn step(&mut self, n: usize, knows: bool, order: Order) -> Outputs {
        let (now, places) = (self.now(), self.places);
        let Drone { agent, exploration, at, yaw, velocity, height, inbox } = &mut self.drones[n];
        let told = std::mem::take(inbox);
        let pose = Pose2 { at: *at, yaw: Radians(*yaw) };
        let beam = |eighths: f32| beam(pose.at, pose.yaw.0 + eighths * std::f32::consts::FRAC_PI_4);
        let flow = BodyVelocity {
            forward: MetresPerSecond(velocity[0]),
            lateral: MetresPerSecond(velocity[1]),
        };
        let inputs = Inputs {
            ranges: Diagonals { nw: beam(1.0), ne: beam(-1.0), sw: beam(3.0), se: beam(-3.0) },
            velocity: (knows || places == Places::Fixed).then_some(flow),
            heading: Some(pose.yaw),
            height: Some(Metres(*height)),
            located: (knows && places == Places::Fixed)
                .then_some(Located { pose, deviation: Metres(0.01) }),
            heard: &[],
            told: &told,
            order: Some(order),
            fitness: Fitness::Fit,
            endurance: None,
        };
        let outputs = agent.step_exploring(&self.config, now, &inputs, Some(&mut **exploration));
        let (wanted, turn) = match outputs.setpoint {
            Setpoint::Fly { forward, lateral, height: wanted, yaw_rate } => {
                *height += (wanted.0 - *height).clamp(-0.08, 0.08);
                ([forward.0, lateral.0], yaw_rate.0)
            }
            Setpoint::Off | Setpoint::Stop => {
                *height = 0.0;
                ([0.0; 2], 0.0)
            }
        };
        for (is, wanted) in velocity.iter_mut().zip(wanted) {
            *is += RESPONSE * (wanted - *is);
        }
        let (sin, cos) = (*yaw + ROUND * turn / 2.0).sin_cos();
        *at = Point2::new(
            at.x + ROUND * (velocity[0] * cos - velocity[1] * sin),
            at.y + ROUND * (velocity[0] * sin + velocity[1] * cos),
        );
        *yaw = Radians(*yaw + ROUND * turn).wrapped().0;
        self.nearest_wall = self.nearest_wall.min(WALL - at.x.abs().max(at.y.abs()));
        outputs
    }

    fn send(&mut self, from: usize) {
        let messages: Vec<Payload> = self.drones[from].agent.messages().to_vec();
        for payload in messages {
            for to in 0..self.drones.len() {
                if to != from && self.uniform() >= self.loss {
                    let at = self.now();
                    let told = Told { from: NodeId(from as u8), at, rssi: Dbm(-50.0), payload };
                    self.drones[to].inbox.push(told);
                }
            }
        }
    }

    /// One round of all; says whether all have ended.
    fn round(&mut self) -> bool {
        for n in 0..self.drones.len() {
            self.step(n, true, self.order);
            self.send(n);
        }
        for (n, one) in self.drones.iter().enumerate() {
            for other in self.drones[..n].iter().filter(|other| other.height > 0.1) {
                if one.height > 0.1 {
                    self.closest = self.closest.min(one.at.distance(other.at).0);
                }
            }
        }
        self.round += 1;
        let why = if self.order == EXPLORE { LandReason::Done } else { LandReason::Ordered };
        let is_over = |drone: &Drone| drone.agent.state() == State::Landed { why };
        self.drones.iter().all(is_over)
    }

    /// Flies until all have ended, at most 5 minutes.
    fn fly(&mut self) -> bool {
        (0..1_500).any(|_| self.round())
    }

    /// The part of the room's cells that a drone knows, without those at the walls.
    fn explored(&self) -> f32 {
        let frame = *self.drones[0].exploration.frame();
        let is_inside = |cell: &_| {
            let at = frame.centre(*cell);
            at.x.abs().max(at.y.abs()) < WALL - 0.1
        };
        let inside: Vec<_> = frame.cells().filter(is_inside).collect();
        let is_known = |cell: &&_| {
            let knows = |drone: &Drone| drone.exploration.state(**cell) != CellState::Unknown;
            self.drones.iter().any(knows)
        };
        inside.iter().filter(is_known).count() as f32 / inside.len() as f32
    }
}

/// The range of a beam in the room.
fn beam(from: Point2, direction: f32) -> Range {
    let (sin, cos) = direction.sin_cos();
    let to_wall = |at: f32, step: f32| (WALL.copysign(step) - at) / step;
    let distance = to_wall(from.x, cos).min(to_wall(from.y, sin));
    if distance > 2.0 { Range::Clear } else { Range::At(Metres(distance)) }
}

#[test]
fn two_drones_explore_a_room_and_land() {
    for places in [Places::Fixed, Places::Reckoned] {
        let mut world = World::new(2, places, 0.0, 1);
        assert!(world.fly(), "{places:?}");
        assert!(world.explored() > 0.99, "{places:?}: {}", world.explored());
        assert!(world.nearest_wall > 0.1, "{places:?}: {}", world.nearest_wall);
        assert!(world.closest > TOUCH, "{places:?}: {}", world.closest);
    }
}

#[test]
fn a_drone_that_loses_its_position_hovers_and_then_lands() {
    for places in [Places::Fixed, Places::Reckoned] {
        let mut world = World::new(1, places, 0.0, 1);
        for _ in 0..50 {
            world.round();
        }
        let mut last = None;
        for _ in 0..45 {
            last = Some(world.step(0, false, EXPLORE));
            world.round += 1;
        }
        let last = last.unwrap();
        let is_lost =
            |state| matches!(state, State::OnMission(Duty::Explore(ExploreDuty::Lost { .. })));
        assert!(is_lost(last.status.state), "{places:?}: {last:?}");
        let Setpoint::Fly { forward, lateral, .. } = last.setpoint else { panic!("{last:?}") };
        assert_eq!([forward, lateral], [MetresPerSecond::ZERO; 2]);
        for _ in 0..100 {
            world.step(0, false, EXPLORE);
            world.round += 1;
        }
        let state = world.drones[0].agent.state();
        assert_eq!(state, State::Landed { why: LandReason::PositionLost }, "{places:?}");
    }
}

#[test]
fn an_explorer_without_its_memory_or_with_too_large_a_number_stays_on_the_ground() {
    let inputs = |told| Inputs {
        ranges: Diagonals::default(),
        velocity: None,
        heading: Some(Radians::ZERO),
        height: Some(Metres::ZERO),
        located: None,
        heard: &[],
        told,
        order: Some(EXPLORE),
        fitness: Fitness::Fit,
        endurance: None,
    };
    let mut exploration = Box::new(Exploration::NEW);
    for (node, memory) in [(0, None), (6, Some(&mut *exploration))] {
        let id = NodeId(node);
        let mut agent = Agent::new(id, Role::usual_of(id), MissionKind::Explore);
        let mut memory = memory;
        for round in 0..20 {
            let now = Instant::from_millis(200 * round);
            agent.step_exploring(&AgentConfig::DEFAULT, now, &inputs(&[]), memory.as_deref_mut());
        }
        assert_eq!(agent.state(), State::Idle, "drone {node}");
    }
}

#[test]
fn drones_that_are_called_home_land_where_they_took_off() {
    let mut world = World::new(2, Places::Fixed, 0.1, 7);
    let starts: Vec<Point2> = world.drones.iter().map(|drone| drone.at).collect();
    for _ in 0..150 {
        world.round();
    }
    let before: Vec<f32> = world
        .drones
        .iter()
        .zip(&starts)
        .map(|(drone, start)| drone.at.distance(*start).0)
        .collect();
    assert!(before.iter().any(|off| *off > 0.8), "they have gone away: {before:?} m");
    world.order = Order::Return;
    assert!(world.fly(), "all land, because they were ordered to");
    for (drone, start) in world.drones.iter().zip(starts) {
        let off = drone.at.distance(start).0;
        assert!(off < 0.9, "{off} m off, where the other one keeps it 0.8 m away");
    }
    assert!(world.closest > TOUCH, "{} m", world.closest);
}

#[test]
fn an_order_to_land_is_obeyed() {
    let mut world = World::new(1, Places::Fixed, 0.0, 1);
    for _ in 0..50 {
        world.round();
    }
    world.step(0, true, Order::Land);
    let state = world.drones[0].agent.state();
    assert!(matches!(state, State::Landing { why: LandReason::Ordered, .. }), "{state:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn all_is_explored_and_no_drone_touches_though_packets_are_lost(
        drones in 1_u8..=4,
        loss in 0.0_f32..0.3,
        seed in any::<u64>(),
    ) {
        let mut world = World::new(drones, Places::Fixed, loss, seed);
        prop_assert!(world.fly(), "drones still fly");
        prop_assert!(world.explored() > 0.99, "explored {}", world.explored());
        prop_assert!(world.nearest_wall > 0.1, "wall at {}", world.nearest_wall);
        prop_assert!(world.closest > TOUCH, "closest {}", world.closest);
    }

    /// Any bytes of others are borne.
    #[test]
    fn any_packets_are_borne(packets in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=43), 0..40)) {
        let mut world = World::new(1, Places::Fixed, 0.0, 1);
        for _ in 0..40 {
            world.round();
        }
        for bytes in packets {
            let payload = Payload::new(&bytes).unwrap();
            let told = Told { from: NodeId(3), at: world.now(), rssi: Dbm(-50.0), payload };
            world.drones[0].inbox.push(told);
            world.round();
        }
        prop_assert!(world.drones[0].at.is_finite());
    }
}
