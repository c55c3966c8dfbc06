//! An occupancy grid for robots that explore: two bits a cell, fixed size, without allocation.
//!
//! A [`Frame`] says where the cells lie on the floor plan. A [`GridMap`] holds for each cell what
//! range readings say of it: unknown, free or occupied. From the map follow its *frontiers*, the
//! free cells beside unknown ones; a [`Clearance`], the distance of each cell from the nearest
//! occupied one; and, by a [`Planner`], shortest paths that keep away from walls.
//!
//! All of it is arithmetic on integers, but for the way of a ray through the cells, which takes
//! sums, products and comparisons of `f32`: the same readings give the same bytes on a laptop and
//! on the chip.
//!
//! ```
//! use grid_map::{CellState, Frame, GridMap, RayEnd};
//! use units::{Metres, Point2};
//!
//! // 8 m by 8 m at 0.1 m: 80 · 80 cells, four in a byte.
//! let frame = Frame::new(Point2::new(-4.0, -4.0), Metres(0.1), 80, 80).unwrap();
//! let mut map = GridMap::<1600>::new(frame).unwrap();
//! map.trace(Point2::new(0.0, 0.05), Point2::new(2.0, 0.05), RayEnd::Obstacle);
//! let at = |x| frame.cell_at(Point2::new(x, 0.05)).unwrap();
//! assert_eq!(map.state(at(1.0)), CellState::Free);
//! assert_eq!(map.state(at(2.05)), CellState::Occupied);
//! assert_eq!(map.state(at(3.0)), CellState::Unknown);
//! assert!(map.is_frontier(at(1.0)));
//! ```
#![no_std]

mod area;
mod clearance;
mod cone;
mod frame;
mod frontier;
mod map;
mod path;
mod ray;

pub use area::Area;
pub use clearance::{Clearance, FARTHEST_CLEARANCE};
pub use cone::{Beam, Cone, Side};
pub use frame::{Cell, Frame, FrameError};
pub use frontier::MOST_GAIN;
pub use map::{CellState, GridMap, RayEnd, TooManyCells};
pub use path::{DIAGONAL_COST, PathError, Planner, STRAIGHT_COST, Visit};
