//! Plans on a map where relays that land for good are put down.

use std::fmt;
use std::path::Path;

use cave_worlds::{CELLS, World, WorldPlanner};
use grid_map::{Cell, CellState};
use relay_placement::{
    Belief, Correction, Curve, Demand, Expected, Ground, GroundError, MOST_PLANNED, Network, Place,
    Plan,
};
use robot_maps::Warning;
use units::{Db, Point2};

mod readings;
mod ways;

use input::{InputError, counted};

pub use readings::Received;
use ways::Ways;

/// The most relays that are planned together.
pub const MOST_DROPS: usize = MOST_PLANNED;

/// The world of the map `file`, of any format that `uchain map` reads, with the base at a point of the
/// map's own coordinates, or, where none is given, on the free cell nearest to (0, 0); with what was odd
/// about the map.
///
/// # Errors
/// [`InputError`] where the map cannot be used, or the base cannot stand there.
pub fn open(file: &Path, base: Option<[f64; 2]>) -> Result<(World, Vec<Warning>), InputError> {
    let map = maps::cells(file)?;
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    let world = World::of(&name, &map, base)
        .map_err(|error| InputError::new(error.to_string(), error.remedy()).in_file(file))?;
    Ok((world, map.warnings))
}

/// The reason why no relay can be put down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoDrops {
    /// No robot can begin at the base.
    Ground(GroundError),
    /// No place with a link to the base covers any of the cells that the base does not.
    NoLinkedPlace {
        /// The reachable cells that the base does not cover.
        uncovered_cells: usize,
    },
}

impl fmt::Display for NoDrops {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ground(why) => why.fmt(f),
            Self::NoLinkedPlace { uncovered_cells } => write!(
                f,
                "no linked place covers any of the {} that the base does not",
                counted(*uncovered_cells, "cell")
            ),
        }
    }
}

/// Relays put down in a world, and the coverage before and after.
pub struct Drops {
    /// The cells that a robot reaches from the base.
    pub ground: Box<Ground<CELLS>>,
    /// The network of the base and the relays that stand.
    pub before: Box<Network<CELLS>>,
    /// The same with the relays that are planned.
    pub after: Box<Network<CELLS>>,
    /// Of each relay that stands the ratio at which the network hears it; `None` where no way leads to it,
    /// because the map of strength has no such cells.
    pub standing: Vec<Option<Db>>,
    /// The places of the relays; with readings their new cells are the expected ones, rounded.
    pub places: Vec<Place>,
    /// With readings, of each relay the probability that it has a link to the network.
    pub chances: Option<Vec<f32>>,
    /// The new cells that no set of as many relays exceeds; not known by the way through the cave, and
    /// with readings.
    pub at_most_cells: Option<usize>,
}

/// How far a relay covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Coverage {
    /// In a straight line, also through rock
    Straight,
    /// Along the way through the cave
    Geodesic,
}

/// Where relays are put down: the world, and what stands in it.
pub struct Site<'a> {
    world: &'a World,
    coverage: Coverage,
    ground: Box<Ground<CELLS>>,
    planner: Box<WorldPlanner>,
    /// The cells of the base and the relays that stand.
    stand: &'a [Cell],
}

impl<'a> Site<'a> {
    /// The cells that a robot reaches, with the base first of those that `stand`.
    ///
    /// # Errors
    /// [`NoDrops`].
    pub fn new(world: &'a World, coverage: Coverage, stand: &'a [Cell]) -> Result<Self, NoDrops> {
        let mut planner = Box::new(WorldPlanner::new());
        let ground = world.ground(&mut planner).map_err(NoDrops::Ground)?;
        Ok(Self { world, coverage, ground, planner, stand })
    }

    /// The number of one that stands to which no way leads from the base, where coverage goes by ways.
    #[must_use]
    pub fn out_of_reach(&self) -> Option<usize> {
        let is_out = |cell: &Cell| !self.ground.is_reached(*cell);
        let found = self.stand.iter().position(is_out);
        found.filter(|_| self.coverage == Coverage::Geodesic)
    }

    /// Of each that stands the distances that a reading of it has in this coverage.
    pub(crate) fn ways(&mut self) -> Vec<Ways> {
        let Self { coverage, ground, planner, stand, .. } = self;
        stand.iter().map(|cell| Ways::new(*coverage, ground, planner, *cell)).collect()
    }

    /// Plans at most `nodes` relays beside those that stand. What was `received` of them corrects the
    /// map of strength, and the relays are planned by what they are expected to cover. There is none
    /// where all that can be reached is covered.
    ///
    /// # Errors
    /// [`NoDrops`].
    pub fn plan(mut self, nodes: usize, received: Option<&Received>) -> Result<Drops, NoDrops> {
        let (before, standing) = self.network(received);
        let mut at_most_cells = None;
        let mut chances = None;
        let mut places = match received {
            Some(received) => {
                let expected = self.expected(received, nodes);
                chances = Some(expected.iter().map(|place| place.link).collect());
                expected.iter().map(|place| self.place(place)).collect()
            }
            None => {
                let plan = self.plan_of(&before, nodes);
                at_most_cells = (self.coverage == Coverage::Straight)
                    .then(|| plan.at_most_cells(&self.ground, &before, nodes));
                plan.places().to_vec()
            }
        };
        let mut after = before.clone();
        for place in &mut places {
            place.link = after.ratio(place.cell);
            self.add(&mut after, place.cell, |_| Db(0.0));
        }
        let ground = self.ground;
        Drops { ground, before, after, standing, places, chances, at_most_cells }.checked()
    }

    /// The network of all that stand, and of each but the base the ratio at which those nearer the base
    /// hear it: it is added to them in the order in which it is heard best.
    fn network(&mut self, received: Option<&Received>) -> (Box<Network<CELLS>>, Vec<Option<Db>>) {
        let mut network = Box::new(Network::new(&self.ground, Curve::DEFAULT));
        let mut heard = vec![None; self.stand.len()];
        let mut left: Vec<_> = self.stand.iter().copied().enumerate().collect();
        let mut next = (!left.is_empty()).then_some(0);
        while let Some(at) = next {
            let (n, cell) = left.remove(at);
            heard[n] = self.ground.is_reached(cell).then(|| network.ratio(cell));
            let correction = received.map(|received| received.corrections(n));
            let over = |at| correction.as_ref().map_or(Db(0.0), |correction| correction(at).over);
            self.add(&mut network, cell, over);
            let ratio = |at: &usize| network.ratio(left[*at].1).0;
            next = (0..left.len()).max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        }
        (network, heard.into_iter().skip(1).collect())
    }

    fn add(&mut self, network: &mut Network<CELLS>, at: Cell, over: impl Fn(Point2) -> Db) {
        let Self { ground, planner, .. } = self;
        match self.coverage {
            Coverage::Straight => network.add_corrected(ground, ground.frame().centre(at), over),
            // A search that ran out of room has added the nearest cells, which are those that count.
            Coverage::Geodesic => {
                let _ = network.add_by_way_corrected(ground, planner, at, over);
            }
        }
    }

    fn plan_of(&mut self, before: &Network<CELLS>, nodes: usize) -> Plan {
        let Self { ground, planner, .. } = self;
        match self.coverage {
            Coverage::Straight => Plan::new(ground, before, &Demand::DEFAULT, nodes),
            Coverage::Geodesic => Plan::by_way(ground, before, planner, &Demand::DEFAULT, nodes),
        }
    }

    /// The relays that are planned by what they are expected to cover.
    fn expected(&mut self, received: &Received, nodes: usize) -> Vec<Expected> {
        let Self { ground, planner, .. } = self;
        let (demand, spread) = (&Demand::DEFAULT, Correction::NONE.deviation);
        let mut belief = Box::new(Belief::new(ground, Curve::DEFAULT));
        for (n, cell) in self.stand.iter().enumerate() {
            let correction = received.corrections(n);
            match self.coverage {
                Coverage::Straight => {
                    belief.add(ground, ground.frame().centre(*cell), correction);
                }
                Coverage::Geodesic => {
                    let _ = belief.add_by_way(ground, planner, *cell, correction);
                }
            }
        }
        let places = match self.coverage {
            Coverage::Straight => belief.plan(ground, demand, spread, nodes),
            Coverage::Geodesic => belief.plan_by_way(ground, planner, demand, spread, nodes),
        };
        places.to_vec()
    }

    fn place(&self, expected: &Expected) -> Place {
        Place {
            cell: expected.cell,
            at: expected.at,
            gain_cells: expected.gain_cells.round() as usize,
            link: Db(0.0),
            free_width: self.ground.free_width(expected.cell),
        }
    }

    /// The world.
    #[must_use]
    pub const fn world(&self) -> &World {
        self.world
    }
}

impl Drops {
    fn checked(self) -> Result<Self, NoDrops> {
        let uncovered_cells = self.ground.reached().count() - self.before.covered(&self.ground);
        if self.places.is_empty() && uncovered_cells > 0 {
            return Err(NoDrops::NoLinkedPlace { uncovered_cells });
        }
        Ok(self)
    }

    /// The cells that the planned relays cover and those that stand do not.
    #[must_use]
    pub fn gain_cells(&self) -> usize {
        self.places.iter().map(|place| place.gain_cells).sum()
    }

    /// The probability that the n-th relay has a link, where readings tell it.
    #[must_use]
    pub fn chance(&self, n: usize) -> Option<f32> {
        self.chances.as_ref().and_then(|chances| chances.get(n).copied())
    }

    /// The area of so many cells, m².
    #[must_use]
    pub fn square_metres(&self, cells: usize) -> f32 {
        let side = self.ground.frame().resolution().0;
        cells as f32 * side * side
    }

    /// What a picture shows of a cell.
    #[must_use]
    pub fn shown(&self, world: &World, cell: Cell) -> Shown {
        if self.ground.is_reached(cell) {
            return match (self.before.covers(cell), self.after.covers(cell)) {
                (true, _) => Shown::CoveredByBase,
                (false, true) => Shown::CoveredByRelays,
                (false, false) => Shown::Uncovered,
            };
        }
        match world.map.state(cell) {
            CellState::Occupied => Shown::Wall,
            CellState::Free | CellState::Unknown => Shown::OutOfReach,
        }
    }
}

/// What a picture shows of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// It is a wall.
    Wall,
    /// It is unknown, or no robot gets there.
    OutOfReach,
    /// No relay covers it.
    Uncovered,
    /// The base covers it.
    CoveredByBase,
    /// A relay covers it, and the base does not.
    CoveredByRelays,
}
