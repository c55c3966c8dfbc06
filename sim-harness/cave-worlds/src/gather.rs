//! Lets a robot gather readings around its goal before it drops a relay, and measures what that gains.
//!
//! The strength of each relay on the ground differs from the curve by an offset, of its antenna, and by
//! shadowing over space, both drawn from the seed of the world; the robot knows the curve alone. The
//! relay that it drops counts by the true strength: without a link it covers nothing.

use grid_map::{Cell, Planner};
use radio_model::Shadowing;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use relay_placement::{
    Act, Belief, Correction, Curve, Demand, Errand, ErrandConfig, Ground, GroundError,
    MOST_PLANNED, Network, Pattern, Plan, Readings, RefineConfig, Rule,
};
use units::{Db, Duration, Instant, Metres, Point2};

use crate::world::{CELLS, World, WorldPlanner};

/// The relays that are on the ground before, beside the base.
const BEFORE: usize = 3;
/// The speed of the robot, m/s. It is a choice, as is a reading of each relay in each cell.
const SPEED: f32 = 0.5;
/// The longest errand, in cells: the gathering, and the ways there and to the place.
const MOST_CELLS: usize = 4_000;
/// The places at which readings are kept apart.
const SPOTS: usize = 64;
/// The cautious map is lower by so many standard deviations: nine of ten places are at least as strong.
const CAUTION: f32 = 1.28;
/// The readings of each relay that the robot takes at its place before it drops its own: two seconds
/// of reports. It is a choice.
const CHECKS: usize = 10;
/// The most places at which it does.
const MOST_CHECKED: usize = 5;

/// What the robot knows of the strength of the relays when it chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knows {
    /// The curve.
    Curve,
    /// The curve, and readings that it has gathered in a pattern.
    Readings(Pattern),
    /// The true strength everywhere.
    Truth,
}

impl Knows {
    /// All kinds of knowledge.
    pub const ALL: [Self; 6] = [
        Self::Curve,
        Self::Readings(Pattern::ZigZag),
        Self::Readings(Pattern::Spiral),
        Self::Readings(Pattern::RandomWalk),
        Self::Readings(Pattern::WallFollowing),
        Self::Truth,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Curve => "curve",
            Self::Readings(pattern) => pattern.name(),
            Self::Truth => "truth",
        }
    }
}

/// How the robot chooses the place from what it knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chooses {
    /// By [`Rule::Ours`] on the likeliest map, with its margin.
    Margin,
    /// By [`Rule::Ours`] on a map on which nine of ten places are at least as strong.
    Caution,
    /// By the expected coverage, [`Belief::choose`].
    Expected,
    /// The same; at the place it reads once more before it drops the relay, and chooses anew.
    Checked,
}

impl Chooses {
    /// All ways to choose.
    pub const ALL: [Self; 4] = [Self::Margin, Self::Caution, Self::Expected, Self::Checked];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Margin => "margin",
            Self::Caution => "caution",
            Self::Expected => "expected",
            Self::Checked => "checked",
        }
    }
}

/// One relay that was dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// The name of the world.
    pub world: String,
    /// What the robot knew.
    pub knows: Knows,
    /// How it chose.
    pub chooses: Chooses,
    /// The true margin of the relay's link over the covered ratio, dB; `None` where no place was chosen.
    pub margin_db: Option<f32>,
    /// The area that it truly covers and the network before did not, m²; 0 without a link.
    pub gained_m2: f32,
    /// The root mean square error of the map of strength within the radius of the goal, dB; `None`
    /// where no relay is heard there.
    pub error_db: Option<f32>,
    /// The way on which readings were gathered, m.
    pub way_m: f32,
}

/// Drops one relay with each kind of knowledge, at the covered cell at which the network is weakest by
/// the curve.
///
/// # Errors
/// [`GroundError`] where no robot can begin at the base.
pub fn gather(world: &World, seed: u64) -> Result<Vec<Dropped>, GroundError> {
    let mut planner = Box::new(WorldPlanner::new());
    let ground = world.ground(&mut planner)?;
    let truth = Truth::of(world, &ground, seed);
    let goal = truth.weakest(&ground).unwrap_or(world.base);
    let mut errands = Errands { world, ground: &ground, truth: &truth, goal, seed, planner };
    Ok(Knows::ALL.into_iter().flat_map(|knows| errands.run(knows)).collect())
}

/// Relays that were planned together and dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct DroppedTogether {
    /// The name of the world.
    pub world: String,
    /// What was known.
    pub knows: Knows,
    /// How they were planned.
    pub chooses: Chooses,
    /// The relays that were planned.
    pub relays: usize,
    /// Those of them that truly have a link to the network, over others of them or not.
    pub linked: usize,
    /// The area that these truly cover and the network before did not, m².
    pub gained_m2: f32,
}

/// Plans `nodes` relays anywhere, by the curve, by readings that were gathered in a zig-zag, and by the
/// truth, each by the margin and by the expected coverage.
///
/// # Errors
/// [`GroundError`] where no robot can begin at the base.
pub fn gather_for_several(
    world: &World,
    seed: u64,
    nodes: usize,
) -> Result<Vec<DroppedTogether>, GroundError> {
    let mut planner = Box::new(WorldPlanner::new());
    let ground = world.ground(&mut planner)?;
    let truth = Truth::of(world, &ground, seed);
    let goal = truth.weakest(&ground).unwrap_or(world.base);
    let mut errands = Errands { world, ground: &ground, truth: &truth, goal, seed, planner };
    let (readings, _) = errands.readings(Pattern::ZigZag);
    let fits: Vec<_> = readings.iter().map(Readings::fit).collect();
    let mut rows = Vec::new();
    for chooses in [Chooses::Margin, Chooses::Expected] {
        let mut row = |knows, places| rows.push(errands.together(knows, chooses, places));
        row(Knows::Curve, truth.plan(&ground, chooses, |_, _| Correction::NONE, nodes));
        let zig_zag = Knows::Readings(Pattern::ZigZag);
        row(zig_zag, truth.plan(&ground, chooses, |n, at| fits[n].at(at), nodes));
        row(Knows::Truth, truth.plan(&ground, chooses, |n, at| truth.correction(n, at), nodes));
    }
    Ok(rows)
}

/// The relays on the ground, with their true strength.
struct Truth {
    places: Vec<Point2>,
    /// The offsets of the relays, and those of the ones to be dropped.
    offsets: Vec<f32>,
    shadowing: Shadowing,
}

impl Truth {
    fn of(world: &World, ground: &Ground<CELLS>, seed: u64) -> Self {
        let RefineConfig { offset, shadowing, decorrelation, .. } = RefineConfig::DEFAULT;
        let base = ground.frame().centre(world.base);
        let mut network = Network::new(ground, Curve::DEFAULT);
        network.add(ground, base);
        let plan = Plan::new(ground, &network, &Demand::DEFAULT, BEFORE);
        let places: Vec<_> =
            [base].into_iter().chain(plan.places().iter().map(|place| place.at)).collect();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut offsets: Vec<_> =
            (0..=places.len()).map(|_| offset.0 * normal(&mut random)).collect();
        let wave = || std::array::from_fn(|_| uniform(&mut random));
        let shadowing = Shadowing::new(shadowing, decorrelation, wave);
        offsets.extend((1..MOST_PLANNED).map(|_| offset.0 * normal(&mut random)));
        Self { places, offsets, shadowing }
    }

    /// What a relay's strength at a point is over the curve's.
    fn over(&self, relay: usize, place: Point2, at: Point2) -> Db {
        Db(self.offsets[relay] - self.shadowing.loss(place, at).0)
    }

    /// The network of the relays with a correction of each, lower by so many deviations.
    fn network(
        &self,
        ground: &Ground<CELLS>,
        correction: impl Fn(usize, Point2) -> Correction,
        deviations: f32,
    ) -> Box<Network<CELLS>> {
        let mut network = Box::new(Network::new(ground, Curve::DEFAULT));
        for (n, place) in self.places.iter().enumerate() {
            network.add_corrected(ground, *place, |at| {
                let Correction { over, deviation, .. } = correction(n, at);
                Db(over.0 - deviations * deviation.0)
            });
        }
        network
    }

    /// The belief with a correction of each.
    fn belief(
        &self,
        ground: &Ground<CELLS>,
        correction: impl Fn(usize, Point2) -> Correction,
    ) -> Box<Belief<CELLS>> {
        let mut belief = Box::new(Belief::new(ground, Curve::DEFAULT));
        for (n, place) in self.places.iter().enumerate() {
            belief.add(ground, *place, |at| correction(n, at));
        }
        belief
    }

    /// The covered cell at which the network is weakest by the curve.
    fn weakest(&self, ground: &Ground<CELLS>) -> Option<Cell> {
        let known = self.network(ground, |_, _| Correction::NONE, 0.0);
        let covered = ground.reached().filter(|&cell| known.covers(cell));
        covered.min_by(|a, b| known.ratio(*a).0.total_cmp(&known.ratio(*b).0))
    }

    /// Where several relays are planned, by the corrections of those on the ground.
    fn plan(
        &self,
        ground: &Ground<CELLS>,
        chooses: Chooses,
        correction: impl Fn(usize, Point2) -> Correction,
        nodes: usize,
    ) -> Vec<Point2> {
        let demand = Demand::DEFAULT;
        if chooses == Chooses::Expected {
            let belief = self.belief(ground, correction);
            let places = belief.plan(ground, &demand, Correction::NONE.deviation, nodes);
            return places.iter().map(|place| place.at).collect();
        }
        let network = self.network(ground, correction, 0.0);
        let plan = Plan::new(ground, &network, &demand, nodes);
        plan.places().iter().map(|place| place.at).collect()
    }

    /// The true correction.
    fn correction(&self, relay: usize, at: Point2) -> Correction {
        let over = self.over(relay, self.places[relay], at);
        Correction { over, deviation: Db(0.0), reading_deviation: RefineConfig::DEFAULT.noise }
    }
}

/// The errands in one world.
struct Errands<'a> {
    world: &'a World,
    ground: &'a Ground<CELLS>,
    truth: &'a Truth,
    goal: Cell,
    seed: u64,
    planner: Box<WorldPlanner>,
}

impl Errands<'_> {
    fn run(&mut self, knows: Knows) -> Vec<Dropped> {
        let network = self.truth.network(self.ground, |n, at| self.truth.correction(n, at), 0.0);
        let ways = Chooses::ALL.into_iter();
        match knows {
            Knows::Curve => {
                let ways = ways.filter(|chooses| *chooses != Chooses::Checked);
                ways.map(|chooses| {
                    let place = self.choose(chooses, |_, _| Correction::NONE);
                    self.dropped(knows, chooses, place, |_, _| Correction::NONE, 0.0, &network)
                })
                .collect()
            }
            Knows::Truth => {
                let ways = ways.filter(|way| matches!(way, Chooses::Margin | Chooses::Expected));
                let truth = self.truth;
                ways.map(|chooses| {
                    let place = self.choose(chooses, |n, at| truth.correction(n, at));
                    let known = |n, at| truth.correction(n, at);
                    self.dropped(knows, chooses, place, known, 0.0, &network)
                })
                .collect()
            }
            Knows::Readings(pattern) => {
                let (readings, way_m) = self.readings(pattern);
                ways.map(|chooses| {
                    let fits: Vec<_> = readings.iter().map(Readings::fit).collect();
                    let mut place = self.choose(chooses, |n, at| fits[n].at(at));
                    if chooses == Chooses::Checked {
                        place = self.checked(readings.clone(), place);
                    }
                    self.dropped(knows, chooses, place, |n, at| fits[n].at(at), way_m, &network)
                })
                .collect()
            }
        }
    }

    /// The place that is chosen from the corrections of the relays.
    fn choose(
        &mut self,
        chooses: Chooses,
        correction: impl Fn(usize, Point2) -> Correction,
    ) -> Option<Cell> {
        let goal = self.ground.frame().centre(self.goal);
        let demand = Demand::DEFAULT;
        let deviations = match chooses {
            Chooses::Margin => 0.0,
            Chooses::Caution => CAUTION,
            Chooses::Expected | Chooses::Checked => {
                let belief = self.truth.belief(self.ground, correction);
                let place = belief.choose(self.ground, goal, &demand, Correction::NONE.deviation);
                return place.map(|place| place.cell);
            }
        };
        let network = self.truth.network(self.ground, correction, deviations);
        let place = Rule::Ours.choose(self.ground, &network, goal, &demand, 0, &mut self.planner);
        place.map(|place| place.cell)
    }

    /// The place at which the robot stays that reads at each place that it has chosen.
    fn checked(
        &mut self,
        mut readings: Vec<Readings<SPOTS>>,
        mut place: Option<Cell>,
    ) -> Option<Cell> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed ^ 0xc4ec_4ed0);
        for _ in 0..MOST_CHECKED {
            let at = self.ground.frame().centre(place?);
            for _ in 0..CHECKS {
                self.read(&mut readings, at, &mut random);
            }
            let fits: Vec<_> = readings.iter().map(Readings::fit).collect();
            let next = self.choose(Chooses::Checked, |n, at| fits[n].at(at));
            if next == place {
                break;
            }
            place = next;
        }
        place
    }

    /// Gathers readings of each relay on an errand, and returns them with the way.
    fn readings(&mut self, pattern: Pattern) -> (Vec<Readings<SPOTS>>, f32) {
        let frame = self.ground.frame();
        let step = Duration::from_micros((1e6 * frame.resolution().0 / SPEED) as u64);
        let config = ErrandConfig::DEFAULT;
        let mut errand = Errand::new(config, self.ground, self.goal, pattern, self.seed);
        let mut readings = vec![Readings::new(RefineConfig::DEFAULT); self.truth.places.len()];
        let mut random = ChaCha8Rng::seed_from_u64(self.seed ^ 0x9a7e_4e12);
        let (mut at, mut now, mut way_m) = (self.world.base, Instant::ZERO, 0.0);
        for _ in 0..MOST_CELLS {
            let Act::Drive(to) = errand.step(now, self.ground, at) else { break };
            let next = next_on_way(&mut self.planner, self.ground, at, to).unwrap_or(to);
            now = now + step;
            at = next;
            if errand.is_gathering() {
                way_m += frame.resolution().0;
                self.read(&mut readings, frame.centre(at), &mut random);
            }
        }
        (readings, way_m)
    }

    /// Reads each relay that is heard at a point once.
    fn read(&self, readings: &mut [Readings<SPOTS>], at: Point2, random: &mut ChaCha8Rng) {
        for (n, (place, readings)) in self.truth.places.iter().zip(readings).enumerate() {
            let over = self.truth.over(n, *place, at).0;
            let noise = RefineConfig::DEFAULT.noise.0 * normal(random);
            let is_heard = Curve::DEFAULT.at(far(*place, at)).0 + over > 0.0;
            if is_heard {
                // A reading of finite numbers is never refused.
                let _ = readings.add(at, Db(over + noise));
            }
        }
    }

    /// What becomes of a relay that is dropped in this cell, by a robot that knew these corrections.
    fn dropped(
        &self,
        knows: Knows,
        chooses: Chooses,
        place: Option<Cell>,
        known: impl Fn(usize, Point2) -> Correction,
        way_m: f32,
        truth: &Network<CELLS>,
    ) -> Dropped {
        let margin_db = place.map(|cell| (truth.ratio(cell) - truth.curve().covered).0);
        let gained = place.filter(|_| margin_db.is_some_and(|margin| margin >= 0.0)).map(|cell| {
            let mut after = truth.clone();
            let (own, place) = (self.truth.places.len(), self.ground.frame().centre(cell));
            after.add_corrected(self.ground, place, |at| self.truth.over(own, place, at));
            after.covered(self.ground).saturating_sub(truth.covered(self.ground))
        });
        let side = self.ground.frame().resolution().0;
        Dropped {
            world: self.world.name.clone(),
            knows,
            chooses,
            margin_db,
            gained_m2: gained.unwrap_or(0) as f32 * side * side,
            error_db: self.error(known, truth),
            way_m,
        }
    }

    /// What becomes of relays that are dropped at these places together.
    fn together(&self, knows: Knows, chooses: Chooses, places: Vec<Point2>) -> DroppedTogether {
        let before = self.truth.network(self.ground, |n, at| self.truth.correction(n, at), 0.0);
        let mut network = before.clone();
        let relays = places.len();
        let own = self.truth.places.len();
        let mut left: Vec<_> = places.into_iter().enumerate().collect();
        let is_linked = |network: &Network<CELLS>, at: Point2| {
            self.ground.frame().cell_at(at).is_some_and(|cell| network.covers(cell))
        };
        while let Some(next) = left.iter().position(|(_, at)| is_linked(&network, *at)) {
            let (n, place) = left.swap_remove(next);
            network.add_corrected(self.ground, place, |at| self.truth.over(own + n, place, at));
        }
        let gained = network.covered(self.ground).saturating_sub(before.covered(self.ground));
        let side = self.ground.frame().resolution().0;
        DroppedTogether {
            world: self.world.name.clone(),
            knows,
            chooses,
            relays,
            linked: relays - left.len(),
            gained_m2: gained as f32 * side * side,
        }
    }

    fn error(
        &self,
        known: impl Fn(usize, Point2) -> Correction,
        truth: &Network<CELLS>,
    ) -> Option<f32> {
        let frame = self.ground.frame();
        let goal = frame.centre(self.goal);
        let is_near = |cell: &Cell| far(frame.centre(*cell), goal) <= ErrandConfig::DEFAULT.within;
        let near = self.ground.reached().filter(is_near);
        let ratio = |cell: Cell| {
            let at = frame.centre(cell);
            let of = |(n, place): (usize, &Point2)| {
                Curve::DEFAULT.at(far(*place, at)).0 + known(n, at).over.0
            };
            self.truth.places.iter().enumerate().map(of).fold(0.0, f32::max)
        };
        let squares: Vec<_> = near
            .filter(|&cell| truth.ratio(cell).0 > 0.0)
            .map(|cell| (ratio(cell) - truth.ratio(cell).0).powi(2))
            .collect();
        let count = squares.len() as f32;
        (count > 0.0).then(|| (squares.iter().sum::<f32>() / count).sqrt())
    }
}

/// The next cell on the shortest way.
fn next_on_way<const MARKS: usize, const POOL: usize>(
    planner: &mut Planner<MARKS, POOL>,
    ground: &Ground<CELLS>,
    at: Cell,
    to: Cell,
) -> Option<Cell> {
    let free = |cell| ground.is_reached(cell).then_some(1);
    let visit = |visit: grid_map::Visit| match visit.cell == at {
        true => std::ops::ControlFlow::Break(()),
        false => std::ops::ControlFlow::Continue(()),
    };
    // A search that ends early has visited the cell or has no room for it.
    let _ = planner.search(ground.frame(), to, free, visit);
    planner.before(at)
}

fn far(a: Point2, b: Point2) -> Metres {
    Metres((a.x - b.x).hypot(a.y - b.y))
}

/// A uniform number in [0, 1).
fn uniform(random: &mut ChaCha8Rng) -> f32 {
    (random.next_u32() >> 8) as f32 / (1 << 24) as f32
}

/// A normal number, by Box and Muller.
fn normal(random: &mut ChaCha8Rng) -> f32 {
    let (radius, angle) = (1.0 - uniform(random), uniform(random));
    (-2.0 * radius.ln()).sqrt() * (std::f32::consts::TAU * angle).cos()
}
