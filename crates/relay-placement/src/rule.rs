//! The rules that choose the next place.

use core::cmp::Ordering;

use grid_map::{Cell, Planner};
use units::Point2;

use crate::ground::{Ground, index};
use crate::network::{Network, distance};
use crate::place::{Demand, Place, Shortlist};
use crate::score::{Disc, Score};
use crate::squares::{side, visit};

/// A rule that chooses a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rule {
    /// The paper's: the Pareto front of coverage and clearance, moved to the wall; nearest the goal.
    Paper,
    /// The paper's, where coverage goes no farther through the cave than the reach of a relay: not
    /// through rock.
    PaperGeodesic,
    /// Any drop cell, at random.
    Random,
    /// Any drop cell beside a wall, at random.
    NearWall,
    /// The linked place that covers most, beside a wall and with the free width left where that
    /// costs no more than a fifth of the coverage.
    Ours,
    /// The same, where coverage goes through the cave as in [`Rule::PaperGeodesic`]; for a network
    /// whose relays were added by [`Network::add_by_way`], so that links do as well. Several relays
    /// are planned faster, and the same, by [`Plan::by_way`](crate::Plan::by_way).
    OursGeodesic,
    /// Of all drop cells with a link, with the margin where one has it, the one that covers most.
    Best,
}

impl Rule {
    /// All rules.
    pub const ALL: [Self; 7] = [
        Self::Paper,
        Self::PaperGeodesic,
        Self::Random,
        Self::NearWall,
        Self::Ours,
        Self::OursGeodesic,
        Self::Best,
    ];

    /// The name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::PaperGeodesic => "paper-geodesic",
            Self::Random => "random",
            Self::NearWall => "near-wall",
            Self::Ours => "ours",
            Self::OursGeodesic => "ours-geodesic",
            Self::Best => "best",
        }
    }

    /// Chooses the next place near `goal`; `seed` is used by the rules that choose at random.
    /// `None` where no drop cell is left, and for our rules and [`Rule::Best`] also where none has a
    /// link. The rules of the paper and of chance may choose a place without a link.
    /// `planner` finds the ways of the rules that go by them.
    #[must_use]
    pub fn choose<const CELLS: usize, const MARKS: usize, const POOL: usize>(
        self,
        ground: &Ground<CELLS>,
        network: &Network<CELLS>,
        goal: Point2,
        demand: &Demand,
        seed: u64,
        planner: &mut Planner<MARKS, POOL>,
    ) -> Option<Place> {
        let gains = Score::of_reached(ground, |cell| i16::from(!network.covers(cell)));
        let disc = Disc::new(network.curve().knee.0 / ground.frame().resolution().0);
        let question = Question { ground, network, goal, demand, gains, disc };
        let cell = match self {
            Self::Paper => question.paper(),
            Self::PaperGeodesic => question.paper_geodesic(planner),
            Self::Random => question.random(seed, |_| true),
            Self::NearWall => question.random(seed, |cell| question.is_beside_wall(cell)),
            Self::Ours => question.ours(),
            Self::OursGeodesic => return question.ours_geodesic(planner),
            Self::Best => question.best(),
        }?;
        Some(Place::new(ground, cell, question.gain(cell), network.ratio(cell)))
    }
}

/// One choice, with what it is made from.
struct Question<'a, const CELLS: usize> {
    ground: &'a Ground<CELLS>,
    network: &'a Network<CELLS>,
    goal: Point2,
    demand: &'a Demand,
    gains: Score<CELLS>,
    /// The cells that a relay covers.
    disc: Disc,
}

impl<const CELLS: usize> Question<'_, CELLS> {
    fn drop_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.ground.reached().filter(|&cell| self.goal_distance(cell) <= self.demand.within.0)
    }

    fn goal_distance(&self, cell: Cell) -> f32 {
        distance(self.ground.frame().centre(cell), self.goal).0
    }

    fn is_beside_wall(&self, cell: Cell) -> bool {
        self.demand.is_beside_wall(self.ground, cell)
    }

    /// The linked cell that covers most, of those with margin where there is one.
    fn best(&self) -> Option<Cell> {
        self.linked().max_by_key(|&cell| self.gain(cell))
    }

    /// The linked cell of the [`Shortlist`].
    fn ours(&self) -> Option<Cell> {
        let mut shortlist = Shortlist::default();
        for cell in self.linked() {
            shortlist.offer(self.ground, self.demand, cell, self.gain(cell));
        }
        shortlist.pick().map(|(cell, _)| cell)
    }

    /// The same by the way through the cave.
    fn ours_geodesic<const MARKS: usize, const POOL: usize>(
        &self,
        planner: &mut Planner<MARKS, POOL>,
    ) -> Option<Place> {
        let gain = |cell| i16::from(!self.network.covers(cell));
        let mut shortlist = Shortlist::default();
        let mut gains = self.by_blocks(planner, &gain);
        for cell in self.linked() {
            shortlist.offer(self.ground, self.demand, cell, gains(cell));
        }
        let (cell, gain) = shortlist.pick()?;
        Some(Place::new(self.ground, cell, gain, self.network.ratio(cell)))
    }

    /// The drop cells with a link: those with margin, or where there are none, those without.
    fn linked(&self) -> impl Iterator<Item = Cell> + '_ {
        let covered = self.network.curve().covered;
        let has = move |margin: f32, cell| self.network.ratio(cell).0 >= covered.0 + margin;
        let margin = self.demand.margin.0.max(0.0);
        let least = if self.drop_cells().any(|cell| has(margin, cell)) { margin } else { 0.0 };
        self.drop_cells().filter(move |&cell| has(least, cell))
    }

    fn gain(&self, cell: Cell) -> i32 {
        self.gains.around(self.ground, cell, &self.disc)
    }

    /// The paper's value of a cell that the new relay covers: 1 where the network is heard too
    /// weakly, 1/2 where it is not heard, and −1 where it is strong; here all twice, to be whole
    /// numbers.
    fn value(&self, cell: Cell) -> i16 {
        match self.network.ratio(cell).0 {
            _ if self.network.covers(cell) => -2,
            ratio if ratio > 0.0 => 2,
            _ => 1,
        }
    }

    /// The paper's choice.
    fn paper(&self) -> Option<Cell> {
        let scores = Score::of_reached(self.ground, |cell| self.value(cell));
        self.of_front(|cell| scores.around(self.ground, cell, &self.disc))
    }

    /// The paper's choice with the distance through the cave in place of the straight one.
    fn paper_geodesic<const MARKS: usize, const POOL: usize>(
        &self,
        planner: &mut Planner<MARKS, POOL>,
    ) -> Option<Cell> {
        let value = |cell| self.value(cell);
        let scores = self.by_blocks(planner, &value);
        self.of_front(scores)
    }

    /// The sum of these values over the cells to which a way of the reach of a relay leads from a
    /// cell; within a square that of the first cell that is asked for.
    fn by_blocks<const MARKS: usize, const POOL: usize>(
        &self,
        planner: &mut Planner<MARKS, POOL>,
        value: &impl Fn(Cell) -> i16,
    ) -> impl FnMut(Cell) -> i32 {
        let side = side(self.ground);
        let reach = self.network.curve().knee.0 / self.ground.frame().resolution().0;
        let mut known = [None; CELLS];
        move |from| {
            let corner = Cell::new(from.column - from.column % side, from.row - from.row % side);
            let mut sum = || {
                let mut sum = 0;
                let add = |cell, _| sum += i32::from(value(cell));
                // A search without room has visited the nearest cells.
                let _ = visit(self.ground, planner, from, reach, add);
                sum
            };
            match known.get_mut(index(self.ground.frame(), corner)) {
                Some(score) => *score.get_or_insert_with(sum),
                None => sum(),
            }
        }
    }

    /// Of the Pareto front of coverage and clearance the cell beside a wall that is nearest the
    /// goal, or else the front moved to the wall.
    fn of_front(&self, mut score: impl FnMut(Cell) -> i32) -> Option<Cell> {
        let mut scores = [i32::MIN; CELLS];
        for cell in self.drop_cells() {
            if let Some(slot) = scores.get_mut(index(self.ground.frame(), cell)) {
                *slot = score(cell);
            }
        }
        let score =
            |cell| scores.get(index(self.ground.frame(), cell)).copied().unwrap_or(i32::MIN);
        // The best score of the cells at each clearance, then of those at this one or a larger.
        let mut best = [i32::MIN; 256];
        for cell in self.drop_cells() {
            if let Some(slot) = best.get_mut(usize::from(self.ground.square(cell))) {
                *slot = (*slot).max(score(cell));
            }
        }
        let mut beyond = i32::MIN;
        for slot in best.iter_mut().rev() {
            // A cell is dominated by one of a larger clearance already where their scores are equal.
            let own = *slot;
            *slot = if own > beyond { own } else { i32::MAX };
            beyond = beyond.max(own);
        }
        let is_on_front = |cell: Cell| {
            best.get(usize::from(self.ground.square(cell))).is_some_and(|&most| score(cell) == most)
        };
        let nearest_goal = |a: &Cell, b: &Cell| by(self.goal_distance(*a), self.goal_distance(*b));
        let front = || self.drop_cells().filter(|&cell| is_on_front(cell));
        let beside_wall = front().filter(|&cell| self.is_beside_wall(cell)).min_by(nearest_goal);
        beside_wall.or_else(|| front().filter_map(|cell| self.project(cell)).min_by(nearest_goal))
    }

    /// The drop cell beside a wall that is nearest to a cell.
    fn project(&self, from: Cell) -> Option<Cell> {
        let at = self.ground.frame().centre(from);
        let far = |cell: &Cell| distance(self.ground.frame().centre(*cell), at).0;
        self.drop_cells()
            .filter(|&cell| self.is_beside_wall(cell))
            .min_by(|a, b| by(far(a), far(b)))
    }

    /// A drop cell at random, of those that pass.
    fn random(&self, seed: u64, passes: impl Fn(Cell) -> bool) -> Option<Cell> {
        let count = self.drop_cells().filter(|&cell| passes(cell)).count() as u64;
        // The finaliser of SplitMix64 (Steele, Lea and Flood 2014) spreads neighbouring seeds.
        let mixed = (seed ^ seed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        let chosen = (mixed ^ mixed >> 31).checked_rem(count)?;
        self.drop_cells().filter(|&cell| passes(cell)).nth(usize::try_from(chosen).ok()?)
    }
}

fn by(a: f32, b: f32) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}
