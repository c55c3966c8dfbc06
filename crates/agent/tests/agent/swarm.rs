//! Swarms of agents, each a point that follows its set-point with a lag: nobody touches another one,
//! and all finish, whatever packets are lost and however wrong positions are.

use agent::{
    Agent, AgentConfig, BodyVelocity, Duty, Fitness, Inputs, LandReason, Located, Outputs, State,
    SwarmDuty, Told,
};
use proptest::prelude::*;
use tunnel_nav::{Diagonals, Range};
use units::{
    Dbm, Duration, Instant, Metres, MetresPerSecond, MissionKind, NodeId, Order, Payload, Point2,
    Pose2, Radians, Role, Setpoint,
};
use virtual_forces::Passage;

/// The length of a round, s.
const ROUND: f32 = 0.2;
/// The part of a change of velocity that a round brings, with a lag of 0.3 s.
const RESPONSE: f32 = 0.486;
/// Two drones touch where they are nearer, m: each is 0.08 m from its middle to its guards.
const TOUCH: f32 = 0.16;

/// Drones on the ground are farther from each other, m: a drone's own width and a hand's breadth.
const APART: f32 = 0.25;

/// What goes wrong.
#[derive(Clone, Copy, Debug)]
struct Trouble {
    noise: f32,
    loss: f32,
    /// A drone that is gone from this round on.
    gone: Option<(usize, u32)>,
    /// The round from which on the operator calls the swarm home.
    recall: Option<u32>,
    /// How long a battery carries drone 0, s.
    endurance: Option<f32>,
}

impl Trouble {
    const NONE: Self = Self { noise: 0.0, loss: 0.0, gone: None, recall: None, endurance: None };
}

struct Drone {
    agent: Agent,
    at: Point2,
    yaw: Radians,
    /// In body axes.
    velocity: [f32; 2],
    height: f32,
    inbox: Vec<Told>,
}

struct World {
    config: AgentConfig,
    drones: Vec<Drone>,
    trouble: Trouble,
    round: u32,
    random: u64,
    closest: f32,
    /// Where the drones have flown.
    flown: Vec<Point2>,
}

impl World {
    fn new(drones: u16, trouble: Trouble, seed: u64) -> Self {
        let mut config = AgentConfig::DEFAULT;
        let swarm = &mut config.swarm;
        swarm.drones = drones;
        swarm.corner = Point2::new(-4.5, -1.5);
        swarm.area = (Metres(3.75), Metres(3.0));
        swarm.passage = Passage { width: Metres(1.51), length: Metres(2.0), ..swarm.passage };
        let make = |n: u16| Drone {
            agent: Agent::new(NodeId(n as u8), Role::usual_of(NodeId(n as u8)), MissionKind::Swarm),
            at: Point2::new(-5.0 + 0.6 * f32::from(n), 0.0),
            yaw: Radians::ZERO,
            velocity: [0.0; 2],
            height: 0.0,
            inbox: Vec::new(),
        };
        let drones = (0..drones).map(make).collect();
        Self {
            config,
            drones,
            trouble,
            round: 0,
            random: seed,
            closest: f32::INFINITY,
            flown: Vec::new(),
        }
    }

    /// The same with drones that stand as near to each other as before a mission.
    fn in_a_row(drones: u16, trouble: Trouble, seed: u64) -> Self {
        let mut world = Self::new(drones, trouble, seed);
        for (drone, n) in world.drones.iter_mut().zip(0_u8..) {
            drone.at = Point2::new(-4.5 + 0.35 * f32::from(n), 0.0);
        }
        world
    }

    fn uniform(&mut self) -> f32 {
        self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.random >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn is_gone(&self, drone: usize) -> bool {
        self.trouble.gone.is_some_and(|(gone, since)| gone == drone && self.round >= since)
    }

    fn now(&self) -> Instant {
        Instant::from_millis(1_000 + 200 * u64::from(self.round))
    }

    /// One round of one drone, which knows its position or does not.
    fn step(&mut self, n: usize, knows: bool, order: Order) -> Outputs {
        let now = self.now();
        let (radius, angle) =
            (self.trouble.noise * self.uniform().sqrt(), std::f32::consts::TAU * self.uniform());
        let Drone { agent, at, yaw, velocity, height, inbox } = &mut self.drones[n];
        let told = std::mem::take(inbox);
        let pose = Pose2 {
            at: Point2::new(at.x + radius * angle.cos(), at.y + radius * angle.sin()),
            yaw: *yaw,
        };
        let clear = Range::Clear;
        let inputs = Inputs {
            ranges: Diagonals { nw: clear, ne: clear, sw: clear, se: clear },
            velocity: Some(BodyVelocity {
                forward: MetresPerSecond(velocity[0]),
                lateral: MetresPerSecond(velocity[1]),
            }),
            heading: Some(*yaw),
            height: Some(Metres(*height)),
            // An error in a disc has along each axis half its radius as standard deviation.
            located: knows.then_some(Located { pose, deviation: Metres(0.5 * self.trouble.noise) }),
            heard: &[],
            told: &told,
            order: Some(order),
            fitness: Fitness::Fit,
            endurance: self.trouble.endurance.filter(|_| n == 0).map(|all| {
                let left = all - ROUND * self.round as f32;
                Duration::from_millis((1e3 * left) as u64)
            }),
        };
        let outputs = agent.step(&self.config, now, &inputs);
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
        let (sin, cos) = Radians(yaw.0 + 0.5 * ROUND * turn).sin_cos();
        let [forward, left] = velocity.map(|along| ROUND * along);
        *at = Point2::new(at.x + forward * cos - left * sin, at.y + forward * sin + left * cos);
        *yaw = Radians(yaw.0 + ROUND * turn).wrapped();
        outputs
    }

    fn send(&mut self, from: usize) {
        let messages: Vec<Payload> = self.drones[from].agent.messages().to_vec();
        for payload in messages {
            for to in 0..self.drones.len() {
                if to != from && self.uniform() >= self.trouble.loss {
                    let at = self.now();
                    let told = Told { from: NodeId(from as u8), at, rssi: Dbm(-50.0), payload };
                    self.drones[to].inbox.push(told);
                }
            }
        }
    }

    /// One round of all; says whether all that are not gone have finished.
    fn round(&mut self) -> bool {
        let flying: Vec<_> = (0..self.drones.len()).filter(|n| !self.is_gone(*n)).collect();
        let is_recalled = self.trouble.recall.is_some_and(|since| self.round >= since);
        let explore = Order::explore(MetresPerSecond(0.2));
        let reports: Vec<_> = flying
            .iter()
            .map(|&n| self.step(n, true, if is_recalled { Order::Return } else { explore }).report)
            .collect();
        // What one drone knows of a short battery comes to all others by their reports.
        if reports.iter().any(|report| report.recall) {
            self.trouble.recall.get_or_insert(self.round + 1);
        }
        self.flown.extend(flying.iter().map(|n| self.drones[*n].at));
        // All have their rounds at the same time: what they tell is a round old when it is used.
        flying.iter().for_each(|n| self.send(*n));
        for (place, &n) in flying.iter().enumerate() {
            for &other in &flying[..place] {
                let (one, other) = (&self.drones[n], &self.drones[other]);
                if one.height > 0.1 && other.height > 0.1 {
                    self.closest = self.closest.min(one.at.distance(other.at).0);
                }
            }
        }
        self.round += 1;
        let is_over = |why| why == LandReason::Done || is_recalled && why == LandReason::Home;
        flying
            .iter()
            .all(|n| matches!(self.drones[*n].agent.state(), State::Landed { why } if is_over(why)))
    }

    /// What each drone does, and where.
    fn states(&self) -> Vec<(&'static str, Point2)> {
        self.drones.iter().map(|drone| (drone.agent.state().name(), drone.at)).collect()
    }

    /// The places of the drones, gone ones left out.
    fn places(&self) -> Vec<Point2> {
        let there = (0..self.drones.len()).filter(|n| !self.is_gone(*n));
        there.map(|n| self.drones[n].at).collect()
    }

    /// The least distance of two drones that are not gone.
    fn apart(&self) -> f32 {
        let places = self.places();
        let others = |n: usize| places.iter().skip(n + 1);
        let gaps =
            places.iter().enumerate().flat_map(|(n, one)| others(n).map(|it| it.distance(*one).0));
        gaps.fold(f32::INFINITY, f32::min)
    }

    /// Whether some drone has been at both ends of each row of an area.
    fn has_flown_over(&self, area: usize) -> bool {
        let survey = self.config.swarm.plan().surveys[area];
        let places = 0..self.config.swarm.drones;
        let goals =
            places.flat_map(|n| (0..survey.goals()).filter_map(move |at| survey.goal(n, at)));
        goals.clone().count() > 0
            && goals.into_iter().all(|goal| self.flown.iter().any(|at| at.distance(goal).0 < 0.25))
    }

    /// Flies until all have finished, at most 10 minutes.
    fn fly(&mut self) -> bool {
        (0..3_000).any(|_| self.round())
    }
}

fn duty(state: State) -> Option<SwarmDuty> {
    match state {
        State::OnMission(Duty::Swarm(duty)) => Some(duty),
        _ => None,
    }
}

#[test]
fn a_swarm_surveys_gathers_and_crosses() {
    let mut world = World::new(4, Trouble::NONE, 1);
    let mut seen = Vec::new();
    for _ in 0..3_000 {
        let over = world.round();
        let state = world.drones[0].agent.state();
        if duty(state).is_some() && seen.last() != Some(&state.name()) {
            seen.push(state.name());
        }
        if over {
            break;
        }
    }
    assert_eq!(seen, ["hovering", "surveying", "gathering", "crossing"]);
    assert!(world.drones.iter().all(|drone| drone.at.x > 2.0), "through the passage");
    assert!(world.closest > TOUCH, "{}", world.closest);
}

#[test]
fn both_areas_are_surveyed_and_the_drones_land_apart() {
    for drones in 1..=4 {
        let mut world = World::new(drones, Trouble::NONE, 1);
        world.config.swarm.both = true;
        assert_eq!(world.config.swarm.second_corner(), Point2::new(2.75, -1.5));
        assert!(world.fly(), "{drones} drones");
        assert!(world.has_flown_over(0) && world.has_flown_over(1), "{drones} drones");
        assert!(world.apart() > APART, "{drones} drones: {}", world.apart());
    }
}

/// A drone without charge for the way back calls all of them.
#[test]
fn a_swarm_comes_home_before_a_battery_is_empty() {
    for endurance in [100.0, 120.0, 150.0] {
        let trouble = Trouble { endurance: Some(endurance), ..Trouble::NONE };
        let mut world = World::in_a_row(4, trouble, 1);
        world.config.swarm.both = true;
        let homes = world.places();
        assert!(world.fly(), "{endurance} s");
        assert!((world.round as f32) < endurance / ROUND, "down after {} rounds", world.round);
        for (home, drone) in homes.iter().zip(&world.drones) {
            let is_home = drone.agent.state() == State::Landed { why: LandReason::Home };
            assert!(!is_home || home.distance(drone.at).0 < 0.3, "{home:?} {:?}", drone.at);
        }
    }
}

#[test]
fn a_drone_that_does_not_know_its_position_hovers_and_then_lands() {
    let mut world = World::new(1, Trouble::NONE, 1);
    let explore = Order::explore(MetresPerSecond(0.2));
    let rounds = |world: &mut World, count, knows| {
        let mut last = None;
        for _ in 0..count {
            last = Some(world.step(0, knows, explore));
            world.round += 1;
        }
        last.unwrap()
    };
    rounds(&mut world, 60, true);
    assert_eq!(duty(world.drones[0].agent.state()), Some(SwarmDuty::Surveying));
    let lost = rounds(&mut world, 2, false);
    assert!(matches!(duty(lost.status.state), Some(SwarmDuty::Hovering { .. })));
    assert_eq!(lost.setpoint, Setpoint::hover(world.config.flight.height));
    rounds(&mut world, 1, true);
    assert_eq!(duty(world.drones[0].agent.state()), Some(SwarmDuty::Surveying));
    let down = rounds(&mut world, 80, false);
    assert_eq!(down.status.state, State::Landed { why: LandReason::PositionLost });
}

#[test]
fn a_drone_that_does_not_know_its_position_does_not_take_off() {
    let mut world = World::new(1, Trouble::NONE, 1);
    for _ in 0..20 {
        world.step(0, false, Order::explore(MetresPerSecond(0.2)));
        world.round += 1;
    }
    assert_eq!(world.drones[0].agent.state(), State::Idle);
}

#[test]
fn a_drone_lands_where_it_is_ordered_to() {
    let mut world = World::new(1, Trouble::NONE, 1);
    for n in 0..100 {
        let order = if n < 60 { Order::explore(MetresPerSecond(0.2)) } else { Order::Land };
        world.step(0, true, order);
        world.round += 1;
    }
    assert_eq!(world.drones[0].agent.state(), State::Landed { why: LandReason::Ordered });
}

#[test]
fn drones_that_take_off_nearer_than_the_guard_come_no_nearer() {
    for seed in 0..40 {
        let mut world = World::new(6, Trouble { noise: 0.02, loss: 0.1, ..Trouble::NONE }, seed);
        for (drone, x) in world.drones.iter_mut().zip(0_u8..) {
            drone.at = Point2::new(-4.5 + 0.35 * f32::from(x), 0.0);
        }
        (0..150).for_each(|_| {
            world.round();
        });
        assert!(world.closest > 0.34, "seed {seed}: {}", world.closest);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn nobody_touches_and_all_finish_with_noise_and_loss(
        drones in 1_u16..=4,
        noise in 0.01_f32..0.10,
        loss in 0.0_f32..0.3,
        seed in any::<u64>(),
    ) {
        let mut world = World::new(drones, Trouble { noise, loss, ..Trouble::NONE }, seed);
        prop_assert!(world.fly(), "not over: {:?}", world.states());
        prop_assert!(world.closest > TOUCH, "{}", world.closest);
    }

    #[test]
    fn any_bytes_of_others_are_borne(
        messages in proptest::collection::vec(
            (any::<u8>(), proptest::collection::vec(any::<u8>(), 0..=Payload::MOST)),
            0..40,
        ),
    ) {
        let mut world = World::new(2, Trouble { noise: 0.02, ..Trouble::NONE }, 1);
        (0..40).for_each(|_| { world.round(); });
        for (from, bytes) in messages {
            let payload = Payload::new(&bytes).unwrap();
            let told = Told { from: NodeId(from), at: world.now(), rssi: Dbm(-50.0), payload };
            world.drones[0].inbox.push(told);
            world.round();
        }
        let Drone { at, .. } = world.drones[0];
        prop_assert!(at.is_finite() && world.drones[0].agent.state().is_airborne());
    }

    /// From anywhere: from the first area, from the passage, and from behind it.
    #[test]
    fn a_swarm_that_is_called_home_lands_apart_where_it_took_off(
        drones in 1_u16..=6,
        recall in 20_u32..900,
        noise in 0.01_f32..0.03,
        loss in 0.0_f32..0.2,
        seed in any::<u64>(),
    ) {
        let trouble = Trouble { noise, loss, recall: Some(recall), ..Trouble::NONE };
        let mut world = World::in_a_row(drones, trouble, seed);
        world.config.swarm.both = true;
        let homes = world.places();
        prop_assert!(world.fly(), "not home: {:?}", world.states());
        prop_assert!(world.closest > TOUCH, "{}", world.closest);
        prop_assert!(world.apart() > APART, "{}", world.apart());
        for (home, drone) in homes.iter().zip(&world.drones) {
            let is_home = drone.agent.state() == State::Landed { why: LandReason::Home };
            prop_assert!(!is_home || home.distance(drone.at).0 < 0.75, "{home:?} {:?}", drone.at);
        }
    }

    #[test]
    fn the_rows_of_a_drone_that_is_gone_are_flown_over_by_the_others(
        drones in 2_u16..=4,
        gone in 0_usize..4,
        since in 0_u32..1_000,
        both in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let gone = Some((gone % usize::from(drones), since));
        let trouble = Trouble { noise: 0.02, loss: 0.1, gone, ..Trouble::NONE };
        let mut world = World::new(drones, trouble, seed);
        world.config.swarm.both = both;
        prop_assert!(world.fly(), "not over: {:?}", world.states());
        prop_assert!(world.closest > TOUCH, "{}", world.closest);
        prop_assert!(world.has_flown_over(0), "{:?}", world.states());
        prop_assert!(!both || world.has_flown_over(1), "{:?}", world.states());
    }

    #[test]
    fn nobody_touches_and_the_rest_finish_without_a_drone_that_is_gone(
        drones in 2_u16..=4,
        gone in 0_usize..4,
        since in 0_u32..600,
        seed in any::<u64>(),
    ) {
        let gone = Some((gone % usize::from(drones), since));
        let mut world = World::new(drones, Trouble { noise: 0.02, loss: 0.1, gone, ..Trouble::NONE }, seed);
        prop_assert!(world.fly(), "not over: {:?}", world.states());
        prop_assert!(world.closest > TOUCH, "{}", world.closest);
    }
}
