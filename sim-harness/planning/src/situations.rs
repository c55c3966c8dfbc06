//! Makes the figures of the paper on placing communication nodes (Stegun Vaquero et al. 2020) again:
//! four situations of a goal beside what the network covers, each in many caves, with what the paper's
//! rule, ours and chance choose there, and what each of the paper's sentences is worth.
//!
//! The paper shows one place of each situation, as a picture, and prints no number. Here each is looked
//! for in caves that seeds dig; the base stands at the place that is farthest from the cave's entrance, so
//! that there is room on one side of it, and no relay stands yet.

mod claims;
mod criteria;
mod trial;

use cave_worlds::{CELLS, World, WorldPlanner};
use grid_map::Cell;
use relay_placement::{Curve, Demand, Ground, Network};
use serde_json::{Value, json};

pub use criteria::{Criteria, Scored};
pub use trial::{Dropped, Trial};

/// Where a goal lies beside what the network covers: the four scenarios of the paper's figure 4.
///
/// The paper tells them by words and pictures; the shares of the drop cells that are covered are a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// Nothing is covered that a relay near the goal could cover.
    Far,
    /// A quarter to three quarters of the drop cells are covered.
    Transition,
    /// The goal is covered, and more than three quarters of the drop cells.
    Inside,
    /// More than 95 % of the drop cells are covered, but not all.
    Covered,
}

impl Situation {
    /// All of them, from the farthest to the nearest, as in the paper's figure from top to bottom.
    pub const ALL: [Self; 4] = [Self::Far, Self::Transition, Self::Inside, Self::Covered];

    /// The name in tables and pictures.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Far => "far",
            Self::Transition => "transition",
            Self::Inside => "inside",
            Self::Covered => "covered",
        }
    }
}

/// A cave with a base in it.
pub struct Cave {
    /// The seed that dug it.
    pub seed: u64,
    /// The map, with the base.
    pub world: World,
    /// The cells that a robot reaches.
    pub ground: Box<Ground<CELLS>>,
    /// The strength of the base.
    pub network: Box<Network<CELLS>>,
    planner: Box<WorldPlanner>,
}

impl Cave {
    /// The cave of a seed; `None` where no robot can begin in it.
    #[must_use]
    pub fn dig(seed: u64) -> Option<Self> {
        let mut world = World::dig(seed);
        let mut planner = Box::new(WorldPlanner::new());
        let ground = world.ground(&mut planner).ok()?;
        let from = world.base;
        world.base = ground.reached().max_by_key(|cell| square(*cell, from))?;
        let mut network = Box::new(Network::new(&ground, Curve::DEFAULT));
        network.add(&ground, ground.frame().centre(world.base));
        Some(Self { seed, world, ground, network, planner })
    }

    /// A goal in each situation that the cave has, drawn by its seed.
    #[must_use]
    pub fn goals(&self) -> [Option<Cell>; 4] {
        let mut cells: Vec<_> = self.ground.reached().collect();
        cells.sort_by_key(|cell| {
            mixed(self.seed ^ (self.ground.frame().number(*cell) as u64) << 32)
        });
        let mut goals = [None; 4];
        for goal in cells {
            if goals.iter().all(Option::is_some) {
                break;
            }
            let Some(found) = self.situation(goal) else { continue };
            let slots = goals.iter_mut().zip(Situation::ALL);
            for (slot, _) in slots.filter(|(slot, own)| slot.is_none() && *own == found) {
                *slot = Some(goal);
            }
        }
        goals
    }

    /// The situation of a goal; `None` between those that the paper tells apart.
    fn situation(&self, goal: Cell) -> Option<Situation> {
        let (mut covered, mut all) = (0, 0);
        for cell in self.drop_cells(goal) {
            covered += usize::from(self.network.covers(cell));
            all += 1;
        }
        let share = covered as f32 / all as f32;
        match share {
            _ if covered == 0 => self.is_far(goal).then_some(Situation::Far),
            0.25..=0.75 => Some(Situation::Transition),
            _ if share <= 0.75 || !self.network.covers(goal) || covered == all => None,
            _ if share <= 0.95 => Some(Situation::Inside),
            _ => Some(Situation::Covered),
        }
    }

    /// Whether no cell is covered that a relay within the largest distance from the goal covers.
    fn is_far(&self, goal: Cell) -> bool {
        let far = Demand::DEFAULT.within.0 + self.network.curve().knee.0;
        !self.around(goal, far).any(|cell| self.network.covers(cell))
    }

    /// The cells in which a relay for this goal may be put down.
    pub fn drop_cells(&self, goal: Cell) -> impl Iterator<Item = Cell> + '_ {
        self.around(goal, Demand::DEFAULT.within.0)
    }

    /// The cells that a robot reaches whose middles are within so many metres of a cell's, row by row.
    fn around(&self, cell: Cell, metres: f32) -> impl Iterator<Item = Cell> + '_ {
        let frame = *self.ground.frame();
        let reach = metres / frame.resolution().0;
        let side = reach as i16;
        let offsets =
            (-side..=side).flat_map(move |north| (-side..=side).map(move |east| (east, north)));
        let is_near = move |(east, north): &(i16, i16)| {
            let square = i32::from(*east).pow(2) + i32::from(*north).pow(2);
            square as f32 <= reach * reach
        };
        offsets
            .filter(is_near)
            .filter_map(move |(east, north)| frame.beside(cell, east, north))
            .filter(|cell| self.ground.is_reached(*cell))
    }

    /// The area of so many cells, m².
    #[must_use]
    pub fn square_metres(&self, cells: usize) -> f32 {
        let side = self.ground.frame().resolution().0;
        cells as f32 * side * side
    }
}

/// One situation in one cave, for a picture.
pub struct Scene {
    /// The cave.
    pub cave: Cave,
    /// What was chosen in it.
    pub trial: Trial,
    /// The values of its drop cells.
    pub criteria: Criteria,
}

/// All that is measured for the figures.
pub struct Figures {
    /// The caves that were asked for in each situation.
    pub caves: usize,
    /// The trials, in the order of the caves.
    pub trials: Vec<Trial>,
    /// The first scene of each situation.
    pub scenes: Vec<Scene>,
}

/// The first cave: a number that no rule was tuned on, nor measured on before.
const FIRST_CAVE: u64 = 400_000;
/// The most caves that are dug for each that is asked for; most have all situations.
const MOST_DUG: usize = 20;

/// Digs caves until each situation was found in as many as asked for.
#[must_use]
pub fn make(caves: usize, seed: u64, mut after_each: impl FnMut()) -> Figures {
    let mut figures = Figures { caves, trials: Vec::new(), scenes: Vec::new() };
    for n in 0..(caves * MOST_DUG) as u64 {
        let wanted = |figures: &Figures, of| figures.of(of).count() < caves;
        if !Situation::ALL.iter().any(|of| wanted(&figures, *of)) {
            break;
        }
        let first = FIRST_CAVE.wrapping_add(seed.wrapping_sub(1));
        let Some(mut cave) = Cave::dig(first.wrapping_add(n)) else { continue };
        for (situation, goal) in Situation::ALL.into_iter().zip(cave.goals()) {
            let Some(goal) = goal.filter(|_| wanted(&figures, situation)) else { continue };
            let criteria = Criteria::of(&cave, goal);
            let Some(trial) = Trial::of(&mut cave, situation, goal, &criteria) else { continue };
            if figures.of(situation).next().is_none() {
                // The scene keeps a cave of its own: digging takes less room than a copy.
                let kept = Cave::dig(cave.seed);
                figures.scenes.extend(kept.map(|cave| Scene { cave, trial, criteria }));
            }
            figures.trials.push(trial);
            after_each();
        }
    }
    let rank = |scene: &Scene| Situation::ALL.iter().position(|of| *of == scene.trial.situation);
    figures.scenes.sort_by_key(rank);
    figures
}

impl Figures {
    /// The trials of one situation.
    pub fn of(&self, situation: Situation) -> impl Iterator<Item = &Trial> {
        self.trials.iter().filter(move |trial| trial.situation == situation)
    }

    /// All trials and claims as JSON.
    #[must_use]
    pub fn json(&self, seed: u64) -> Value {
        let trials: Vec<_> = self.trials.iter().map(Trial::json).collect();
        let claims: Vec<_> = self.claims().iter().map(measure::claim::Claim::json).collect();
        json!({
            "figures": "2 to 4",
            "caves": self.caves,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "trials": trials,
            "claims": claims,
        })
    }
}

/// The square of the distance of two cells.
fn square(a: Cell, b: Cell) -> i32 {
    (i32::from(a.column) - i32::from(b.column)).pow(2)
        + (i32::from(a.row) - i32::from(b.row)).pow(2)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014), which spreads neighbouring numbers.
fn mixed(number: u64) -> u64 {
    let number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ number >> 31
}

#[cfg(test)]
mod tests;
