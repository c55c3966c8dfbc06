//! Lets each rule put down relays, and measures what they cover.

#[cfg(any(unix, windows))]
use cpu_time::ThreadTime;
use grid_map::Cell;
use relay_placement::{Curve, Demand, Ground, GroundError, Network, Place, Plan, Rule};
use units::Point2;

use crate::world::{CELLS, World, WorldPlanner};

// A browser has no clock of the processor time.
#[cfg(not(any(unix, windows)))]
use std::time::Instant as ThreadTime;

/// What one rule did in one world.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the world.
    pub world: String,
    /// The rule.
    pub rule: Rule,
    /// The relays that were asked for.
    pub asked: usize,
    /// The relays that it put down.
    pub nodes: usize,
    /// The area that they cover and the base does not, m².
    pub covered_m2: f32,
    /// The area that they cover and the base does not where a relay covers the cells to which a way of
    /// 20 m leads, and sees through no rock, m².
    pub by_way_m2: f32,
    /// The covered area as a share of that of [`Rule::Best`], which takes the best step after the best step;
    /// `None` where that is 0.
    pub of_best: Option<f32>,
    /// The covered area as a share of a bound that no set of as many relays exceeds
    /// ([`Plan::at_most_cells`]); `None` where that is 0.
    pub of_bound: Option<f32>,
    /// The smallest margin of a link over the covered ratio, dB; negative where a relay has no link,
    /// `None` where no relay was put down.
    pub link_margin_db: Option<f32>,
    /// The smallest free width left beside a relay, m; `None` where no relay was put down.
    pub free_width_m: Option<f32>,
    /// The processor time of all selections together, ms; of each the shortest of three, because
    /// other processes slow one down.
    pub ms: f32,
}

/// Puts down `nodes` relays by each rule. Before each, the goal is the covered cell at which the
/// network is weakest: the last one where the robot still has a link. Several relays of
/// [`Rule::Ours`] and [`Rule::OursGeodesic`] are planned together, without goals. The rules of chance draw by `seed`.
///
/// # Errors
/// [`GroundError`] where no robot can begin at the base.
pub fn measure(world: &World, nodes: usize, seed: u64) -> Result<Vec<Row>, GroundError> {
    let mut planner = Box::new(WorldPlanner::new());
    let ground = world.ground(&mut planner)?;
    let mut trial = Trial { ground: &ground, world, nodes, seed, planner };
    let mut rows: Vec<_> = Rule::ALL.into_iter().map(|rule| trial.row(rule)).collect();
    let best = rows.iter().find(|row| row.rule == Rule::Best).map_or(0.0, |row| row.covered_m2);
    let bound = trial.bound_m2();
    for row in &mut rows {
        row.of_best = (best > 0.0).then(|| row.covered_m2 / best);
        row.of_bound = (bound > 0.0).then(|| row.covered_m2 / bound);
    }
    Ok(rows)
}

/// The relays of one world.
struct Trial<'a> {
    ground: &'a Ground<CELLS>,
    world: &'a World,
    nodes: usize,
    seed: u64,
    planner: Box<WorldPlanner>,
}

impl Trial<'_> {
    /// The network of the base alone.
    fn base(&self) -> Network<CELLS> {
        let mut network = Network::new(self.ground, Curve::DEFAULT);
        network.add(self.ground, self.ground.frame().centre(self.world.base));
        network
    }

    fn row(&mut self, rule: Rule) -> Row {
        let mut network = self.base();
        let before = network.covered(self.ground);
        let (places, ms) = match rule {
            Rule::Ours if self.nodes > 1 => self.planned(&network),
            Rule::OursGeodesic => self.by_way(),
            rule => self.one_by_one(rule, network.clone()),
        };
        for place in &places {
            network.add(self.ground, place.at);
        }
        let gained = network.covered(self.ground).saturating_sub(before);
        let margin = |place: &Place| (place.link - network.curve().covered).0;
        Row {
            world: self.world.name.clone(),
            rule,
            asked: self.nodes,
            nodes: places.len(),
            covered_m2: gained as f32 * self.cell_m2(),
            by_way_m2: self.gained_by_way(&places) as f32 * self.cell_m2(),
            of_best: None,
            of_bound: None,
            link_margin_db: places.iter().map(margin).reduce(f32::min),
            free_width_m: places.iter().map(|place| place.free_width.0).reduce(f32::min),
            ms,
        }
    }

    /// The places of a plan, and the time that it took.
    fn planned(&self, network: &Network<CELLS>) -> (Vec<Place>, f32) {
        let mut plan = || Plan::new(self.ground, network, &Demand::DEFAULT, self.nodes);
        let (plan, ms) = shortest(&mut plan);
        (plan.places().to_vec(), ms)
    }

    /// The places of [`Rule::OursGeodesic`]: one near the goal, or several, planned together, anywhere.
    fn by_way(&mut self) -> (Vec<Place>, f32) {
        let network = self.base_by_way();
        let (ground, demand, nodes) = (self.ground, &Demand::DEFAULT, self.nodes);
        if nodes > 1 {
            let mut plan = || Plan::by_way(ground, &network, &mut self.planner, demand, nodes);
            let (plan, ms) = shortest(&mut plan);
            return (plan.places().to_vec(), ms);
        }
        let Some(goal) = self.weakest(&network) else { return (Vec::new(), 0.0) };
        let (place, ms) = shortest(&mut || {
            Rule::OursGeodesic.choose(ground, &network, goal, demand, 0, &mut self.planner)
        });
        (place.into_iter().filter(|place| place.gain_cells > 0).collect(), ms)
    }

    fn base_by_way(&mut self) -> Network<CELLS> {
        let mut network = Network::new(self.ground, Curve::DEFAULT);
        self.add_by_way(&mut network, self.world.base);
        network
    }

    fn add_by_way(&mut self, network: &mut Network<CELLS>, at: Cell) {
        // A search that ran out of room has added the nearest cells, which are those that count.
        let _ = network.add_by_way(self.ground, &mut self.planner, at);
    }

    /// The cells that relays cover and the base does not, by the way through the cave.
    fn gained_by_way(&mut self, places: &[Place]) -> usize {
        let mut network = self.base_by_way();
        let before = network.covered(self.ground);
        for place in places {
            self.add_by_way(&mut network, place.cell);
        }
        network.covered(self.ground).saturating_sub(before)
    }

    /// The places of a rule that is given a goal for each, and the time that it took.
    fn one_by_one(&mut self, rule: Rule, mut network: Network<CELLS>) -> (Vec<Place>, f32) {
        let mut places = Vec::new();
        let mut sum_ms = 0.0;
        while places.len() < self.nodes {
            let Some(goal) = self.weakest(&network) else { break };
            let seed = self.seed.wrapping_mul(64).wrapping_add(places.len() as u64);
            let (place, ms) = shortest(&mut || {
                let demand = &Demand::DEFAULT;
                rule.choose(self.ground, &network, goal, demand, seed, &mut self.planner)
            });
            sum_ms += ms;
            let Some(place) = place else { break };
            network.add(self.ground, place.at);
            places.push(place);
        }
        (places, sum_ms)
    }

    /// The middle of the covered cell at which the network is weakest.
    fn weakest(&self, network: &Network<CELLS>) -> Option<Point2> {
        let covered = self.ground.reached().filter(|&cell| network.covers(cell));
        let ratio = |cell: &Cell| network.ratio(*cell).0;
        let weakest = covered.min_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
        Some(self.ground.frame().centre(weakest))
    }

    /// An area that no set of relays exceeds, m².
    fn bound_m2(&self) -> f32 {
        let network = self.base();
        let plan = Plan::new(self.ground, &network, &Demand::DEFAULT, self.nodes);
        plan.at_most_cells(self.ground, &network, self.nodes) as f32 * self.cell_m2()
    }

    fn cell_m2(&self) -> f32 {
        self.ground.frame().resolution().0 * self.ground.frame().resolution().0
    }
}

/// What a piece of work returns, and the shortest of three processor times that it took, ms.
fn shortest<T>(work: &mut impl FnMut() -> T) -> (T, f32) {
    let mut timed = || {
        let begun = ThreadTime::now();
        let done = std::hint::black_box(work());
        (done, begun.elapsed().as_secs_f32() * 1e3)
    };
    let (_, first) = timed();
    let (_, second) = timed();
    let (done, third) = timed();
    (done, first.min(second).min(third))
}
