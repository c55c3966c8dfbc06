//! Plans on a map where relays that land for good are put down.

use std::fmt;
use std::path::Path;

use cave_worlds::{CELLS, World, WorldPlanner};
use grid_map::{Cell, CellState};
use relay_placement::{Curve, Demand, Ground, GroundError, MOST_PLANNED, Network, Plan};

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
    /// The network of the base alone.
    pub before: Box<Network<CELLS>>,
    /// The network of the base and the relays.
    pub after: Box<Network<CELLS>>,
    /// The places of the relays.
    pub plan: Plan,
    /// The new cells that no set of as many relays exceeds.
    pub at_most_cells: usize,
}

impl Drops {
    /// Plans at most `nodes` relays. There is none where the base covers all that can be reached.
    ///
    /// # Errors
    /// [`NoDrops`].
    pub fn plan(world: &World, nodes: usize) -> Result<Self, NoDrops> {
        let mut planner = Box::new(WorldPlanner::new());
        let ground = world.ground(&mut planner).map_err(NoDrops::Ground)?;
        let mut before = Box::new(Network::new(&ground, Curve::DEFAULT));
        before.add(&ground, ground.frame().centre(world.base));
        let plan = Plan::new(&ground, &before, &Demand::DEFAULT, nodes);
        let uncovered_cells = ground.reached().count() - before.covered(&ground);
        if plan.places().is_empty() && uncovered_cells > 0 {
            return Err(NoDrops::NoLinkedPlace { uncovered_cells });
        }
        let mut after = before.clone();
        for place in plan.places() {
            after.add(&ground, place.at);
        }
        let at_most_cells = plan.at_most_cells(&ground, &before, nodes);
        Ok(Self { ground, before, after, plan, at_most_cells })
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
