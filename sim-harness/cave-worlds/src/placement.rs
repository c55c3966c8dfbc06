//! Lets each rule put down relays, and measures what they cover.

use std::time::Instant;

use grid_map::Planner;
use relay_placement::{Curve, Demand, Ground, Network, Rule};
use units::Point2;

use crate::cave::{Cave, SIDE};

const CELLS: usize = SIDE as usize * SIDE as usize;

/// What one rule did in one cave.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The seed of the cave.
    pub world: u64,
    /// The rule.
    pub rule: Rule,
    /// The relays that it put down.
    pub nodes: usize,
    /// The area that they cover and the base does not, m².
    pub covered_m2: f32,
    /// This area as a share of that of [`Rule::Best`]; `None` where that is 0.
    pub of_best: Option<f32>,
    /// The smallest margin of a link over the covered ratio, dB; negative where a relay has no link.
    pub link_margin_db: f32,
    /// The smallest free width left beside a relay, m.
    pub free_width_m: f32,
    /// The time of all selections together, ms; of each the shortest of three, because other
    /// processes may interrupt one.
    pub ms: f32,
}

/// Puts down `nodes` relays by each rule. Before each, the goal is the covered cell at which the
/// network is weakest: the last one where the robot still has a link.
#[must_use]
pub fn measure(world: u64, nodes: usize) -> Vec<Row> {
    let cave = Cave::dig(world);
    let mut planner = Box::new(Planner::<{ CELLS / 2 }, 8000>::new());
    let Ok(ground) = Ground::<CELLS>::new(&cave.map, &mut planner, cave.entrance) else {
        return Vec::new();
    };
    let mut rows: Vec<_> =
        Rule::ALL.into_iter().map(|rule| row(&ground, &cave, world, rule, nodes)).collect();
    let best = rows.iter().find(|row| row.rule == Rule::Best).map_or(0.0, |row| row.covered_m2);
    for row in &mut rows {
        row.of_best = (best > 0.0).then(|| row.covered_m2 / best);
    }
    rows
}

fn row(ground: &Ground<CELLS>, cave: &Cave, world: u64, rule: Rule, nodes: usize) -> Row {
    let frame = ground.frame();
    let mut network = Network::new(ground, Curve::DEFAULT);
    network.add(ground, frame.centre(cave.entrance));
    let before = network.covered(ground);
    let mut row = Row {
        world,
        rule,
        nodes: 0,
        covered_m2: 0.0,
        of_best: None,
        link_margin_db: f32::INFINITY,
        free_width_m: f32::INFINITY,
        ms: 0.0,
    };
    while row.nodes < nodes {
        let Some(goal) = edge(ground, &network) else { break };
        let seed = world.wrapping_mul(64).wrapping_add(row.nodes as u64);
        let choose = || rule.choose(ground, &network, goal, &Demand::DEFAULT, seed);
        let place = choose();
        row.ms += shortest_ms(choose);
        let Some(place) = place else { break };
        row.nodes += 1;
        row.link_margin_db = row.link_margin_db.min((place.link - network.curve().covered).0);
        row.free_width_m = row.free_width_m.min(place.free_width.0);
        network.add(ground, place.at);
    }
    let gained = network.covered(ground).saturating_sub(before);
    row.covered_m2 = gained as f32 * frame.resolution().0 * frame.resolution().0;
    row
}

fn shortest_ms<T>(work: impl Fn() -> T) -> f32 {
    let times = (0..3).map(|_| {
        let begun = Instant::now();
        std::hint::black_box(work());
        begun.elapsed().as_secs_f32() * 1e3
    });
    times.fold(f32::INFINITY, f32::min)
}

/// The covered cell at which the network is weakest.
fn edge(ground: &Ground<CELLS>, network: &Network<CELLS>) -> Option<Point2> {
    let covered = ground.reached().filter(|&cell| network.covers(cell));
    let weakest = covered.min_by(|a, b| network.ratio(*a).0.total_cmp(&network.ratio(*b).0))?;
    Some(ground.frame().centre(weakest))
}
