//! Collects what a verdict is made from, round by round.

use agent::{Duty, ExploreDuty, State};
use units::{Order, Point2, Role};
use world::{NodeKind, SkeletonPlace, World};

use super::branch::passed;
use super::head::{HeadFlight, HeadRecord, Moment, Pace};
use super::reach::END_M;
use crate::metrics::ROUND_S;
use mission::trace::Node;
use mission::{Linked, Mission};
use scenario::{Scenario, Start, Stretch};

/// One drone at the end of a mission, or the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DroneEnd {
    /// The drone.
    pub node: Node,
    /// The state of its agent.
    pub state: State,
    /// Where it is.
    pub at: Point2,
    /// Where it stood before it took off; `None` where it began in the air.
    pub home: Option<Point2>,
    /// Whether it is off the ground.
    pub is_up: bool,
    /// Whether it has flown in this mission.
    pub has_flown: bool,
    /// Whether the scenario has taken it from the chain.
    pub is_lost: bool,
    /// Why it flew back by itself while it was ordered to explore, if it is an explorer that did.
    pub turned_back: Option<TurnedBack>,
}

/// Why an explorer flew back by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnedBack {
    /// Its battery carried it home and not much farther.
    ForBattery,
    /// It had flown without fixes for so long that its place was too uncertain.
    ForDrift,
}

/// What a verdict is made from beside the metrics.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// The members, head first, base last.
    pub drones: Vec<DroneEnd>,
    /// Whether neighbours of the chain have changed places at the end.
    pub is_disordered: bool,
    /// The time for which the chain was to hold, without what follows a call home, and the part of
    /// it in which there was a chain, s.
    pub hold_s: [f32; 2],
    /// Whether a battery called the drones home.
    pub is_recalled: bool,
    /// The flight of the head; `None` where there is no chain.
    pub head: Option<HeadFlight>,
}

impl Evidence {
    /// The number of drones that the scenario has taken away.
    pub(super) fn lost(&self) -> usize {
        self.drones.iter().filter(|drone| drone.is_lost).count()
    }
}

/// Collects the evidence of one mission.
pub(crate) struct EvidenceRecord {
    homes: Vec<Option<Point2>>,
    has_flown: Vec<bool>,
    ways: Vec<ExplorersWay>,
    is_disordered: bool,
    is_recalled: bool,
    hold: Option<Stretch>,
    /// The rounds of the hold, and those with a chain.
    held: [u32; 2],
    head: Option<HeadRecord>,
    /// Whether the pilot chooses branches.
    has_choices: bool,
}

/// When a drone began to explore, s, and why it flew back by itself.
#[derive(Clone, Copy, Debug, Default)]
struct ExplorersWay {
    begun_s: Option<f32>,
    turned_back: Option<TurnedBack>,
}

impl ExplorersWay {
    /// Takes in one round of a drone that is ordered to explore, by fixes or without.
    fn take(&mut self, scenario: &Scenario, now_s: f32, state: State) {
        let State::OnMission(Duty::Explore(duty)) = state else { return };
        let begun_s = *self.begun_s.get_or_insert(now_s);
        if duty != (ExploreDuty::Returning { has_seen_all: false }) {
            return;
        }
        let longest_s = scenario.agent.explore.longest_reckoning.as_secs_f32();
        // The moment is known to a round or two.
        let is_uncertain = now_s - begun_s > longest_s - 1.0;
        let drifts = scenario.vehicle.position_noise.is_none() && is_uncertain;
        let why = if drifts { TurnedBack::ForDrift } else { TurnedBack::ForBattery };
        self.turned_back.get_or_insert(why);
    }
}

/// The chain in one round.
pub(crate) struct Seen {
    /// The head, where it is a link of a chain.
    pub(crate) head: Option<Linked>,
    /// Whether neighbours have changed places.
    pub(crate) is_disordered: bool,
    /// The relays in the chain, less those that the best chain needs.
    pub(crate) surplus: f32,
}

impl EvidenceRecord {
    pub(crate) fn new(scenario: &Scenario) -> Self {
        let is_chain = scenario.mission == units::MissionKind::Chain;
        let chooses = |order| matches!(order, Order::Explore(course) if course.branch.is_some());
        Self {
            homes: Vec::new(),
            has_flown: vec![false; scenario.drones.members()],
            ways: vec![ExplorersWay::default(); scenario.drones.members()],
            is_disordered: false,
            is_recalled: false,
            hold: scenario.hold().filter(|_| is_chain),
            held: [0; 2],
            head: is_chain.then(|| HeadRecord::new(Pace::of(scenario))),
            has_choices: scenario.pilot.iter().any(|step| chooses(step.task)),
        }
    }

    /// Takes in one round of any mission.
    pub(crate) fn look(&mut self, scenario: &Scenario, mission: &Mission<'_>) {
        if self.homes.is_empty() {
            let stands = scenario.drones.start == Start::Mouth;
            let homes = mission.bodies().map(|body| stands.then_some(body.position()));
            self.homes.extend(homes);
        }
        for (body, has_flown) in mission.bodies().zip(&mut self.has_flown) {
            *has_flown |= body.height() > 0.0;
        }
        self.is_recalled |= mission.is_recalled();
        let now_s = (mission.time_us() as f64 * 1e-6) as f32;
        if matches!(mission.task(), Order::Explore(..)) {
            for (state, way) in mission.states().zip(&mut self.ways) {
                way.take(scenario, now_s, state);
            }
        }
    }

    /// Takes in one round of a chain.
    pub(crate) fn look_at_chain(
        &mut self,
        scenario: &Scenario,
        world: &World,
        mission: &Mission<'_>,
        seen: &Seen,
    ) {
        self.is_disordered = seen.is_disordered;
        let (now_us, is_recalled) = (mission.time_us(), mission.is_recalled());
        let holds = |hold: &Stretch| hold.from_us < now_us && now_us <= hold.until_us;
        if self.hold.as_ref().is_some_and(holds) && !is_recalled && !mission.is_live() {
            let [all, held] = &mut self.held;
            *all += 1;
            *held += u32::from(seen.head.is_some());
        }
        let Some(record) = &mut self.head else { return };
        let relays = || {
            let numbers = scenario.drones.explorers..scenario.drones.flying();
            let states = mission.states().enumerate();
            states.filter(move |(n, _)| numbers.contains(n) && !mission.is_lost(*n))
        };
        let waits = |state| matches!(state, State::Idle | State::Armed { .. });
        let rises = |state| matches!(state, State::TakingOff { .. });
        let junctions = seen.head.filter(|_| self.has_choices);
        record.take(Moment {
            now_s: (now_us as f64 * 1e-6) as f32,
            order: mission.task(),
            is_recalled,
            head: seen.head,
            is_at_end: seen.head.is_some_and(|head| is_at_end(world, head.place)),
            relay_waits: relays().any(|(_, state)| waits(state)),
            relay_rises: relays().any(|(_, state)| rises(state)),
            surplus: seen.surplus,
            passed: junctions
                .map_or_else(Vec::new, |head| passed(world.skeleton(), &world.path_to(head.place))),
        });
    }

    /// What was collected, at the end of the mission.
    pub(crate) fn evidence(&self, scenario: &Scenario, mission: &Mission<'_>) -> Evidence {
        let drone = |(n, (body, state)): (usize, (&bodies::Body, State))| {
            let role = scenario.drones.role(n);
            DroneEnd {
                node: Node { id: units::NodeId(n as u8), role, mission: scenario.mission },
                state,
                at: body.position(),
                home: self.homes.get(n).copied().flatten().filter(|_| role != Role::Base),
                is_up: body.height() > 0.0,
                has_flown: self.has_flown.get(n).is_some_and(|flown| *flown),
                is_lost: mission.is_lost(n),
                turned_back: self.ways.get(n).and_then(|way| way.turned_back),
            }
        };
        let members = mission.bodies().zip(mission.states()).enumerate();
        Evidence {
            drones: members.map(drone).collect(),
            is_disordered: self.is_disordered,
            is_recalled: self.is_recalled,
            hold_s: self.held.map(|rounds| rounds as f32 * ROUND_S),
            head: self.head.as_ref().map(HeadRecord::flight),
        }
    }
}

/// Whether a place is where a gallery ends.
fn is_at_end(world: &World, place: SkeletonPlace) -> bool {
    let skeleton = world.skeleton();
    let joints = skeleton.edge(place.edge).joints().iter();
    let near = joints.filter(|joint| (joint.along - place.along).abs() <= END_M);
    let kinds = near.filter_map(|joint| skeleton.nodes().get(joint.node));
    kinds.map(|node| node.kind).any(|kind| kind == NodeKind::End)
}
