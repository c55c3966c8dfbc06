//! Measures whether every relay takes the branch that the pilot chose for the head, and whether a
//! relay in a wrong branch comes back.
//!
//! A drone is *right* while it is on the shortest way from the base to the end of the gallery to which
//! the pilot's choices lead. This is asked for at the end of the hold, when the chain has settled.

use agent::{ChainDuty, Duty, State};
use input::InputError;
use rayon::prelude::*;
use serde_json::{Value, json};
use units::NodeId;
use world::{SkeletonPlace, World};

use mission::{Linked, Mission};
use scenario::{Fidelity, Scenario};

/// A scenario, and the gallery to which the pilot's choices lead.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The built-in scenario.
    pub scenario: &'static str,
    /// The gallery that the pilot's choices lead to.
    pub goal: &'static str,
}

/// All cases: three forks that the chain flies through, in narrow galleries and in wide ones, and a
/// relay that begins in a wrong branch.
pub const CASES: [Case; 3] = [
    Case { scenario: "three-forks", goal: "third-left" },
    Case { scenario: "wide-forks", goal: "third-left" },
    Case { scenario: "fork-astray", goal: "left" },
];

/// The part of all missions in which every drone must be right.
pub const BOUND: f64 = 0.99;

/// A drone this far beside the way is in another branch, m. Our own number: half of a width of 1.6 m,
/// by which the skeletons of two branches part late, and the hysteresis of 0.3 m with which a place
/// changes to another gallery ([`Skeleton::LOYALTY_M`](world::Skeleton::LOYALTY_M)).
const BESIDE: f32 = 1.2;

/// All missions of one case at one fidelity.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the scenario.
    pub scenario: &'static str,
    /// How closely the drones are simulated.
    pub fidelity: Fidelity,
    /// The number of missions.
    pub seeds: usize,
    /// Missions in which every drone was right.
    pub right: usize,
    /// The seeds of the others.
    pub wrong: Vec<u64>,
    /// Missions in which the head came as far as the gallery that was chosen last.
    pub arrived: usize,
    /// Missions in which a relay was in a wrong branch and flew back from it.
    pub misled: usize,
    /// Those of them in which it was right at the end.
    pub misled_returned: usize,
    /// Missions in which a drone touched a wall or another drone, or did not come home.
    pub troubled: Vec<u64>,
}

impl Row {
    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({
            "scenario": self.scenario,
            "fidelity": self.fidelity.name(),
            "seeds": self.seeds,
            "right": self.right,
            "wrong": self.wrong,
            "arrived": self.arrived,
            "misled": self.misled,
            "misled_returned": self.misled_returned,
            "troubled": self.troubled,
            "bound": BOUND,
        })
    }

    /// What is to be complained of, if fewer missions are right than must be.
    #[must_use]
    pub fn missed(&self) -> Option<String> {
        let share = self.right as f64 / self.seeds.max(1) as f64;
        let Self { scenario, right, seeds, .. } = self;
        (share < BOUND).then(|| {
            let level = self.fidelity.name();
            format!("junctions: {scenario}, {level}: {right} of {seeds} right, must be {BOUND}")
        })
    }
}

/// One mission.
#[derive(Clone, Copy, Debug, Default)]
struct Flown {
    is_right: bool,
    has_arrived: bool,
    is_misled: bool,
    is_troubled: bool,
}

/// The cases of these scenarios; all of them where none is named.
///
/// # Errors
/// [`InputError`] where a scenario is none of this benchmark's.
pub fn cases_of(scenarios: &[String]) -> Result<Vec<Case>, InputError> {
    let known = |name: &String| CASES.into_iter().find(|case| case.scenario == name);
    if scenarios.is_empty() {
        return Ok(CASES.to_vec());
    }
    let case = |name: &String| {
        let names: Vec<_> = CASES.iter().map(|case| case.scenario).collect();
        let remedy = format!("it has {}", names.join(", "));
        known(name).ok_or_else(|| {
            InputError::new(format!("the benchmark junctions has no scenario \"{name}\""), remedy)
        })
    };
    scenarios.iter().map(case).collect()
}

/// Flies each of these cases `seeds` times from `first` on.
///
/// # Errors
/// [`InputError`] where a scenario cannot be read.
pub fn run(
    cases: &[Case],
    fidelity: Fidelity,
    seeds: usize,
    first: u64,
    after_each: impl Fn() + Sync,
) -> Result<Vec<Row>, InputError> {
    cases.iter().map(|case| row(case, fidelity, seeds, first, &after_each)).collect()
}

fn row(
    case: &Case,
    fidelity: Fidelity,
    seeds: usize,
    first: u64,
    after_each: &(impl Fn() + Sync),
) -> Result<Row, InputError> {
    let scenario = Scenario::open(case.scenario)?.at(fidelity);
    let world = scenario.world();
    let fly = |n: u64| {
        let seed = first.wrapping_add(n);
        let flown = fly(case, &scenario, &world, seed);
        after_each();
        (seed, flown)
    };
    let flown: Vec<(u64, Flown)> = (0..seeds as u64).into_par_iter().map(fly).collect();
    let seeds_of = |is: fn(&Flown) -> bool| -> Vec<u64> {
        flown.iter().filter(|(_, flown)| is(flown)).map(|(seed, _)| *seed).collect()
    };
    Ok(Row {
        scenario: case.scenario,
        fidelity,
        seeds,
        right: seeds_of(|flown| flown.is_right).len(),
        wrong: seeds_of(|flown| !flown.is_right),
        arrived: seeds_of(|flown| flown.has_arrived).len(),
        misled: seeds_of(|flown| flown.is_misled).len(),
        misled_returned: seeds_of(|flown| flown.is_misled && flown.is_right).len(),
        troubled: seeds_of(|flown| flown.is_troubled),
    })
}

fn fly(case: &Case, scenario: &Scenario, world: &World, seed: u64) -> Flown {
    let mut mission = Mission::new(scenario, world, seed);
    let end_us = scenario.hold().map_or(scenario.duration_us, |hold| hold.until_us);
    let edge = world.skeleton().edge_named(case.goal).unwrap_or_default();
    let goal = SkeletonPlace { edge, along: world.skeleton().edge(edge).line().length() };
    let mut flown = Flown::default();
    let mut is_asked = false;
    while !mission.is_over() {
        mission.round();
        flown.is_misled |= mission.states().any(is_rejoining);
        if !is_asked && mission.time_us() >= end_us.min(scenario.duration_us) {
            is_asked = true;
            flown.is_right = is_right(goal, world, &mission);
            flown.has_arrived = mission.places().next().is_some_and(|head| head.edge == goal.edge);
        }
    }
    let comes_home = end_us < scenario.duration_us;
    let still_flies = comes_home && mission.states().any(|state| state.is_airborne());
    flown.is_troubled = still_flies || mission.wall_contacts() > 0 || mission.drone_contacts() > 0;
    flown
}

const fn is_rejoining(state: State) -> bool {
    matches!(state, State::OnMission(Duty::Chain(ChainDuty::Rejoining { .. })))
}

/// Whether the chain explores, and every drone in the air is on the way to the end of the gallery that
/// was chosen.
fn is_right(goal: SkeletonPlace, world: &World, mission: &Mission<'_>) -> bool {
    let (base, skeleton) = (world.base.on, world.skeleton());
    let mut chain: Vec<Linked> = Vec::new();
    mission.chain(&mut chain);
    let way = skeleton.distance(base, goal);
    let is_on_way = |member: &Linked| {
        let through = skeleton.distance(base, member.place) + skeleton.distance(member.place, goal);
        through.0 - way.0 <= 2.0 * BESIDE
    };
    let has_head = chain.iter().any(|member| member.id == NodeId::HEAD);
    has_head && !mission.is_recalled() && chain.iter().all(is_on_way)
}
