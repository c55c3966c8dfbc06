//! Plans a chain on paper: how many relays the radio model needs along a way, where they would
//! stand, and whether their batteries last.
//!
//! The plan is the best chain of [`best_chain`], with full knowledge of the place. Drones on board
//! have none of it, and need the margin that the plan leaves.

use flight::BatteryConfig;
use units::{Db, Dbm, MetresPerSecond, NODES, Point2};
use world::{BestChains, Path, SkeletonPlace, World, best_chain};

use scenario::Scenario;

/// The most relays of a chain: all nodes but the head and the base.
pub const MOST_RELAYS: usize = NODES - 2;

/// The distance between the depths for which the number of relays is told, m.
const EVERY_M: f32 = 10.0;

/// What to plan for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// How much stronger than the launch limit every link is to be.
    pub margin: Db,
    /// The speed at which the head flies out; home it comes at the speed of its mission's agent.
    pub speed: MetresPerSecond,
    /// How far from the base the head is to come, m; where left out, to the end of the way.
    pub depth_m: Option<f32>,
}

/// A planned chain.
#[derive(Clone, Debug, PartialEq)]
pub struct RelayPlan {
    /// The length of the way from the base to where the head is to come, m.
    pub way_m: f32,
    /// How far the head comes by radio: `way_m`, or as far as [`MOST_RELAYS`] reach, m.
    pub reached_m: f32,
    /// The strength that no link is to be weaker than.
    pub least: Dbm,
    /// The base, the relays, and the head: base first.
    pub stands: Vec<Stand>,
    /// The links between them, the base's first.
    pub links: Vec<PlannedLink>,
    /// How many relays each depth needs, in steps of 10 m, and the last one.
    pub needed: Vec<Needed>,
    /// The batteries.
    pub reach: Reach,
}

/// What ends the flight of a planned chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The head's battery calls the chain home, before the end of the way and of the radio.
    Battery,
    /// The most relays reach no farther.
    Radio,
    /// The way ends.
    Way,
}

impl Limit {
    /// The limit in one word, for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Battery => "battery",
            Self::Radio => "radio",
            Self::Way => "way",
        }
    }
}

impl RelayPlan {
    /// What ends a flight after which the drones come home by themselves.
    #[must_use]
    pub fn limit(&self) -> Limit {
        match self.limit_fetched() {
            _ if self.reach.farthest_m < self.reached_m => Limit::Battery,
            other => other,
        }
    }

    /// What ends a flight after which the drones are fetched, or land to save their batteries.
    #[must_use]
    pub fn limit_fetched(&self) -> Limit {
        if self.reached_m < self.way_m { Limit::Radio } else { Limit::Way }
    }

    /// How many relays the part of the way needs from which the head's battery carries it home.
    #[must_use]
    pub fn relays_by_battery(&self) -> usize {
        let there = self.needed.iter().find(|it| it.depth_m >= self.reach.farthest_m);
        there.or(self.needed.last()).map_or(0, |it| it.relays)
    }
}

/// How many relays a depth needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed {
    /// The depth, m from the base.
    pub depth_m: f32,
    /// The relays.
    pub relays: usize,
}

/// The place of one member of a planned chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// The length of the way from the base, m.
    pub along_m: f32,
    /// The point of the floor plan.
    pub at: Point2,
}

/// A link of a planned chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedLink {
    /// Its length along the way, m.
    pub length_m: f32,
    /// Its strength without noise.
    pub strength: Dbm,
    /// How much stronger it is than the limit at which a relay is launched, negative where it is
    /// weaker.
    pub over_launch: Db,
    /// How much stronger it is than the limit at which a drone flies back.
    pub over_retreat: Db,
}

/// How far new, full batteries carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The time that a drone hovers, with the reserve left over, s.
    pub endurance_s: f32,
    /// The time that the head can stay at the end of the way before its battery calls the chain home,
    /// s; negative where it calls before.
    pub stay_s: f32,
    /// Where the battery of a head that waits for nothing calls the chain home, m of way.
    pub farthest_m: f32,
}

/// The chain with the fewest relays along the main gallery of a scenario or the route of its survey,
/// to the depth that is asked for or as far as [`MOST_RELAYS`] reach.
#[must_use]
pub fn relays(scenario: &Scenario, demand: Demand) -> RelayPlan {
    let world = scenario.world();
    let along = world.skeleton().edge(0).line().length();
    // The base may stand anywhere, and a loop may be shorter than the main gallery.
    let whole = world.path_to(SkeletonPlace { edge: 0, along });
    let way_to = |distance: f32| world.path_to(whole.at(distance));
    let wanted = way_to(demand.depth_m.unwrap_or(f32::INFINITY));
    let way_m = wanted.length();
    let launch = scenario.agent.launch.limit;
    let least = launch + demand.margin;
    let radio = Covered::of(&world, wanted, least);
    let reached_m = radio.reached_m();
    let way = way_to(reached_m);
    let best = best_chain(&world.radio, &way, radio.relays_to(reached_m) + 1);
    let stand = |&along_m: &f32| Stand { along_m, at: world.skeleton().at(way.at(along_m)).0 };
    let retreat = scenario.agent.retreat.limit;
    let link = |pair: &[f32]| {
        let [near, far] = [pair[0], pair[1]];
        let strength = world.radio.strength(way.at(near), way.at(far));
        PlannedLink {
            length_m: far - near,
            strength,
            over_launch: strength - launch,
            over_retreat: strength - retreat,
        }
    };
    let depths = (1..).map(|n| EVERY_M * n as f32).take_while(|depth| *depth < reached_m);
    let needed = |depth_m: f32| Needed { depth_m, relays: radio.relays_to(depth_m) };
    RelayPlan {
        way_m,
        reached_m,
        least,
        stands: best.positions.iter().map(stand).collect(),
        links: best.positions.windows(2).map(link).collect(),
        needed: depths.chain([reached_m]).map(needed).collect(),
        reach: reach(scenario, reached_m, demand.speed),
    }
}

/// How far chains of each number of relays reach along a way.
struct Covered {
    way_m: f32,
    /// For each number of relays, how far the head can fly so that at every place before there is a
    /// chain with no link weaker than asked for, m.
    reached: Vec<f32>,
}

impl Covered {
    fn of(world: &World, way: Path, least: Dbm) -> Self {
        let way_m = way.length();
        let chains = BestChains::along(&world.radio, way, MOST_RELAYS + 1);
        let reached = |weak: Option<usize>| {
            weak.map_or(way_m, |weak| {
                way_m * weak.saturating_sub(1) as f32 / chains.last().max(1) as f32
            })
        };
        let weak = chains.first_weak(|loss| Dbm::after_loss(loss) < least);
        Self { way_m, reached: weak.into_iter().map(reached).collect() }
    }

    /// How far the most relays reach, but at least a decimetre, m.
    fn reached_m(&self) -> f32 {
        let most = self.reached.iter().copied().fold(0.0, f32::max);
        most.max(0.1).min(self.way_m)
    }

    /// The fewest relays that reach a place.
    fn relays_to(&self, depth_m: f32) -> usize {
        let enough = self.reached.iter().position(|reached| *reached >= depth_m);
        enough.unwrap_or(MOST_RELAYS)
    }
}

fn reach(scenario: &Scenario, way_m: f32, speed: MetresPerSecond) -> Reach {
    let (battery, flight) = (&BatteryConfig::DEFAULT, &scenario.agent.flight);
    let endurance_s = (1.0 - battery.reserve) * battery.capacity / battery.hover_current;
    let home_s = flight.turns_back_below(way_m / flight.return_speed.0);
    Reach {
        endurance_s,
        stay_s: endurance_s - flight.rise_s() - way_m / speed.0 - home_s,
        farthest_m: flight.turns_back_at(endurance_s, speed).0,
    }
}
