//! Chooses where a relay that lands for good is put down.
//!
//! The [`Ground`] holds the cells that a robot can reach, with their distances from the nearest
//! wall. The [`Network`] holds the signal-to-noise ratio that the relays on the ground give to each
//! of these cells, by a [`Curve`] over distance. A [`Rule`] chooses the next [`Place`] among the
//! *drop cells*: those that can be reached and lie within [`Demand::within`] of the goal.
//!
//! The rule [`Rule::Paper`] is that of the nodes which robots dropped in the Subterranean
//! Challenge (JPL 2020, its equations as the book's chapter on drops gives them); [`Rule::Ours`]
//! adds what that rule lacks: the place has a link to the network whenever a place with one exists.
//! A [`Plan`] chooses several places together, each linked to those before it, in a straight line or by
//! the way through the cave. [`Readings`] of the strength of a relay are fitted to become a correction
//! of the curve, with its variance; a [`Belief`] holds what they leave in doubt, and chooses the places
//! of the largest expected coverage. An
//! [`Errand`] is the way of a robot that gathers them in a motion [`Pattern`] and then drops its relay.
//!
//! ```
//! use grid_map::{Cell, CellState, Frame, GridMap, Planner};
//! use relay_placement::{Curve, Demand, Ground, Network, Rule};
//! use units::{Metres, Point2};
//!
//! let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.5), 60, 10).unwrap();
//! let mut map = GridMap::<150>::new(frame).unwrap();
//! for cell in frame.cells() {
//!     let is_wall = cell.row == 0 || cell.row == 9;
//!     map.set(cell, if is_wall { CellState::Occupied } else { CellState::Free });
//! }
//! let base = Cell::new(1, 5);
//! let mut planner = Planner::<300, 600>::new();
//! let ground = Ground::<600>::new(&map, &mut planner, base).unwrap();
//! let mut network = Network::<600>::new(&ground, Curve::DEFAULT);
//! network.add(&ground, frame.centre(base));
//! let demand = Demand { within: Metres(60.0), ..Demand::DEFAULT };
//! let goal = frame.centre(base);
//! let place = Rule::Ours.choose(&ground, &network, goal, &demand, 0, &mut planner).unwrap();
//! assert!(place.link >= Curve::DEFAULT.covered && place.gain_cells > 0);
//! ```
#![no_std]

mod belief;
mod curve;
mod errand;
mod ground;
mod network;
mod pattern;
mod place;
mod plan;
mod rule;
mod score;
mod signal;
mod squares;

pub use belief::{Belief, Expected};
pub use curve::Curve;
pub use errand::{Act, Errand, ErrandConfig};
pub use ground::{Ground, GroundError};
pub use network::Network;
pub use pattern::{Pattern, Tour};
pub use place::{Demand, Place};
pub use plan::{MOST_PLANNED, Plan};
pub use rule::Rule;
pub use signal::{Correction, NotFinite, Readings, RefineConfig, Refined};
