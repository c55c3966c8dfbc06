//! Plans on a map where relays that land for good are put down.

use std::fmt;
use std::path::Path;

use cave_worlds::{CELLS, World, WorldPlanner};
use grid_map::{Cell, CellState};
use relay_placement::{
    Curve, Demand, Ground, GroundError, MOST_PLANNED, Network, Place, Plan, Rule,
};
use units::{Metres, Point2};

mod readings;

pub use readings::Received;

use crate::input_error::InputError;
use crate::world::import;

/// The most relays that are planned together.
pub const MOST_DROPS: usize = MOST_PLANNED;

/// The world of the map `file`, of any format that `uchain map` reads, with the base at a point of the
/// map's own coordinates, or, where none is given, on the free cell nearest to (0, 0).
///
/// # Errors
/// [`InputError`] where the map cannot be used, or the base cannot stand there.
pub fn open(file: &Path, base: Option<[f64; 2]>) -> Result<World, InputError> {
    let map = import::cells(file)?;
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    World::of(&name, &map, base)
        .map_err(|error| InputError::new(error.to_string(), error.remedy()).in_file(file))
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
                "no linked place covers any of the {uncovered_cells} cells that the base does not"
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
    /// The places of the relays.
    pub places: Vec<Place>,
    /// The new cells that no set of as many relays exceeds; not known by the way through the cave.
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

impl Drops {
    /// Plans at most `nodes` relays beside those that `stand`, the base first, by the straight line.
    /// What was `received` of them corrects the map of strength. There is none where all that can be
    /// reached is covered.
    ///
    /// # Errors
    /// [`NoDrops`].
    pub fn plan(
        world: &World,
        nodes: usize,
        stand: &[Point2],
        received: Option<&Received>,
    ) -> Result<Self, NoDrops> {
        let mut planner = Box::new(WorldPlanner::new());
        let ground = world.ground(&mut planner).map_err(NoDrops::Ground)?;
        let mut before = Box::new(Network::new(&ground, Curve::DEFAULT));
        for (n, at) in stand.iter().enumerate() {
            match received.map(|received| received.corrections(n)) {
                Some(correction) => before.add_corrected(&ground, *at, |at| correction(at).over),
                None => before.add(&ground, *at),
            }
        }
        let plan = Plan::new(&ground, &before, &Demand::DEFAULT, nodes);
        let at_most_cells = Some(plan.at_most_cells(&ground, &before, nodes));
        let mut after = before.clone();
        for place in plan.places() {
            after.add(&ground, place.at);
        }
        Self { ground, before, after, places: plan.places().to_vec(), at_most_cells }.checked()
    }

    /// The same by the way through the cave: one relay after the other is put where it covers most.
    ///
    /// # Errors
    /// [`NoDrops`].
    pub fn plan_by_way(world: &World, nodes: usize, stand: &[Cell]) -> Result<Self, NoDrops> {
        let mut planner = Box::new(WorldPlanner::new());
        let ground = world.ground(&mut planner).map_err(NoDrops::Ground)?;
        let mut before = Box::new(Network::new(&ground, Curve::DEFAULT));
        // A search that ran out of room has added the nearest cells, which are those that count.
        for cell in stand {
            let _ = before.add_by_way(&ground, &mut planner, *cell);
        }
        let demand = Demand { within: Metres(f32::INFINITY), ..Demand::DEFAULT };
        let base = ground.frame().centre(world.base);
        let (mut after, mut places) = (before.clone(), Vec::new());
        while places.len() < nodes {
            let rule = Rule::OursGeodesic;
            let place = rule.choose(&ground, &after, base, &demand, 0, &mut planner);
            let Some(place) = place.filter(|place| place.gain_cells > 0) else { break };
            let _ = after.add_by_way(&ground, &mut planner, place.cell);
            places.push(place);
        }
        Self { ground, before, after, places, at_most_cells: None }.checked()
    }

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
