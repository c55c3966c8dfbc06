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
    Act, Curve, Demand, Errand, ErrandConfig, Ground, GroundError, Network, Pattern, Plan,
    Readings, RefineConfig, Rule,
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
/// The map is drawn lower by so many standard deviations: nine of ten places are at least as strong.
const CAUTION: f32 = 1.28;

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

/// One relay that was dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// The name of the world.
    pub world: String,
    /// What the robot knew.
    pub knows: Knows,
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
    let known = truth.network(&ground, |_, _| Db(0.0));
    let covered = ground.reached().filter(|&cell| known.covers(cell));
    let weakest = covered.min_by(|a, b| known.ratio(*a).0.total_cmp(&known.ratio(*b).0));
    let goal = weakest.unwrap_or(world.base);
    let mut errands = Errands { world, ground: &ground, truth: &truth, goal, seed, planner };
    Ok(Knows::ALL.into_iter().map(|knows| errands.run(knows, &known)).collect())
}

/// The relays on the ground, with their true strength.
struct Truth {
    places: Vec<Point2>,
    /// The offsets of the relays, and that of the one to be dropped.
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
        let offsets = (0..=places.len()).map(|_| offset.0 * normal(&mut random)).collect();
        let wave = || std::array::from_fn(|_| uniform(&mut random));
        Self { places, offsets, shadowing: Shadowing::new(shadowing, decorrelation, wave) }
    }

    /// What a relay's strength at a point is over the curve's.
    fn over(&self, relay: usize, place: Point2, at: Point2) -> Db {
        Db(self.offsets[relay] - self.shadowing.loss(place, at).0)
    }

    /// The network of the relays with a correction of each.
    fn network(
        &self,
        ground: &Ground<CELLS>,
        over: impl Fn(usize, Point2) -> Db,
    ) -> Box<Network<CELLS>> {
        let mut network = Box::new(Network::new(ground, Curve::DEFAULT));
        for (n, place) in self.places.iter().enumerate() {
            network.add_corrected(ground, *place, |at| over(n, at));
        }
        network
    }

    fn true_network(&self, ground: &Ground<CELLS>) -> Box<Network<CELLS>> {
        self.network(ground, |n, at| self.over(n, self.places[n], at))
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
    fn run(&mut self, knows: Knows, known: &Network<CELLS>) -> Dropped {
        let truth = self.truth.true_network(self.ground);
        match knows {
            Knows::Curve => self.drop_by(knows, known, known, 0.0, &truth),
            Knows::Truth => self.drop_by(knows, &truth, &truth, 0.0, &truth),
            Knows::Readings(pattern) => {
                let (readings, way_m) = self.readings(pattern);
                let fits: Vec<_> = readings.iter().map(Readings::fit).collect();
                let by = |deviations: f32| {
                    self.truth.network(self.ground, |n, at| {
                        let correction = fits[n].at(at);
                        Db(correction.over.0 - deviations * correction.deviation.0)
                    })
                };
                let (mean, cautious) = (by(0.0), by(CAUTION));
                self.drop_by(knows, &mean, &cautious, way_m, &truth)
            }
        }
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

    /// Drops a relay at the place that the rule chooses on the map `used`; `mean` is the map without
    /// caution, whose error is measured.
    fn drop_by(
        &mut self,
        knows: Knows,
        mean: &Network<CELLS>,
        used: &Network<CELLS>,
        way_m: f32,
        truth: &Network<CELLS>,
    ) -> Dropped {
        let goal = self.ground.frame().centre(self.goal);
        let demand = Demand::DEFAULT;
        let place = Rule::Ours.choose(self.ground, used, goal, &demand, 0, &mut self.planner);
        let margin_db = place.map(|place| (truth.ratio(place.cell) - truth.curve().covered).0);
        let gained = place.filter(|_| margin_db.is_some_and(|margin| margin >= 0.0)).map(|place| {
            let mut after = truth.clone();
            let own = self.truth.places.len();
            after.add_corrected(self.ground, place.at, |at| self.truth.over(own, place.at, at));
            after.covered(self.ground).saturating_sub(truth.covered(self.ground))
        });
        let side = self.ground.frame().resolution().0;
        Dropped {
            world: self.world.name.clone(),
            knows,
            margin_db,
            gained_m2: gained.unwrap_or(0) as f32 * side * side,
            error_db: self.error(mean, truth),
            way_m,
        }
    }

    fn error(&self, mean: &Network<CELLS>, truth: &Network<CELLS>) -> Option<f32> {
        let frame = self.ground.frame();
        let goal = frame.centre(self.goal);
        let is_near = |cell: &Cell| far(frame.centre(*cell), goal) <= ErrandConfig::DEFAULT.within;
        let near = self.ground.reached().filter(is_near);
        let squares: Vec<_> = near
            .filter(|&cell| truth.ratio(cell).0 > 0.0)
            .map(|cell| (mean.ratio(cell) - truth.ratio(cell)).0.powi(2))
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
