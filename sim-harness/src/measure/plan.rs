//! Plans a chain on paper: how many relays the radio model needs along a way, where they would
//! stand, and whether their batteries last.
//!
//! The plan is the best chain of [`best_chain`], with full knowledge of the place. Drones on board
//! have none of it, and need the margin that the plan leaves.

use flight::BatteryConfig;
use units::{Db, Dbm, MetresPerSecond, NODES, Point2};

use crate::mission::World;
use crate::scenario::Scenario;
use crate::world::{BestChains, best_chain};

/// The most relays of a chain: all nodes but the head and the base.
pub const MOST_RELAYS: usize = NODES - 2;

/// What to plan for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// How much stronger than the launch limit every link is to be.
    pub margin: Db,
    /// The speed at which the head flies out and comes home.
    pub speed: MetresPerSecond,
}

/// A planned chain.
#[derive(Clone, Debug, PartialEq)]
pub struct RelayPlan {
    /// The length of the way from the base to the head, m.
    pub way_m: f32,
    /// The strength that no link is to be weaker than.
    pub least: Dbm,
    /// The base, the relays, and the head: base first.
    pub stands: Vec<Stand>,
    /// The links between them, the base's first.
    pub links: Vec<PlannedLink>,
    /// The batteries.
    pub reach: Reach,
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
    /// The time that the head can stay at the end of the way, and still come home, s; negative
    /// where it cannot even turn round there.
    pub stay_s: f32,
    /// The farthest point from which the head can come home, m of way.
    pub farthest_m: f32,
}

/// A way that no chain covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfReach {
    /// The length of the way, m.
    pub way_m: f32,
    /// How far a chain of [`MOST_RELAYS`] reaches, m.
    pub reached_m: f32,
    /// The strength that no link was to be weaker than.
    pub least: Dbm,
}

/// The chain with the fewest relays along the whole main gallery of a scenario, or along the route
/// of its survey.
///
/// # Errors
/// [`OutOfReach`] where the most relays that a chain can have do not suffice.
pub fn relays(scenario: &Scenario, demand: Demand) -> Result<RelayPlan, OutOfReach> {
    let world = World::of(scenario);
    let length = world.skeleton().edge(0).line().length();
    let end = crate::world::SkeletonPlace { edge: 0, along: length };
    let way = world.path_to(end);
    let launch = scenario.agent.launch.limit;
    let least = launch + demand.margin;
    let suffices = |loss: &Db| Dbm::after_loss(*loss) >= least;
    let rows = BestChains::along(&world.radio, way.clone(), MOST_RELAYS + 1).all();
    let enough = rows.iter().position(|row| row.last().is_some_and(suffices));
    let Some(relays) = enough else {
        let farthest = rows.last().and_then(|row| row.iter().rposition(suffices)).unwrap_or(0);
        let steps = rows.last().map_or(1, Vec::len).max(2) - 1;
        let reached_m = way.length() * farthest as f32 / steps as f32;
        return Err(OutOfReach { way_m: way.length(), reached_m, least });
    };
    let best = best_chain(&world.radio, &way, relays + 1);
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
    Ok(RelayPlan {
        way_m: way.length(),
        least,
        stands: best.positions.iter().map(stand).collect(),
        links: best.positions.windows(2).map(link).collect(),
        reach: reach(&BatteryConfig::DEFAULT, way.length(), demand.speed),
    })
}

fn reach(battery: &BatteryConfig, way_m: f32, speed: MetresPerSecond) -> Reach {
    let endurance_s = (1.0 - battery.reserve) * battery.capacity / battery.hover_current;
    Reach {
        endurance_s,
        stay_s: endurance_s - 2.0 * way_m / speed.0,
        farthest_m: endurance_s * speed.0 / 2.0,
    }
}
