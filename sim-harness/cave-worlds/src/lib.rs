//! Digs caves from a seed, and measures in them, and in maps of robots, where relays are put down.
//!
//! A [`Cave`] is a map of [`SIDE`] by [`SIDE`] cells in which corridors of random length, width and
//! direction branch from each other. A [`World`] is a cave or the map of a robot, with a base in it.
//! [`measure`] lets each rule of `relay_placement` put down relays, and returns a [`Row`] for each
//! rule; [`gather()`] lets a robot gather readings before it drops one.
//!
//! ```
//! let cave = cave_worlds::Cave::dig(7);
//! assert_eq!(cave, cave_worlds::Cave::dig(7));
//! ```

mod cave;
mod gather;
mod placement;
mod world;

pub use cave::{Cave, SIDE};
pub use gather::{Chooses, Dropped, DroppedTogether, Knows, gather, gather_for_several};
pub use placement::{Row, measure};
pub use world::{CELLS, World, WorldError, WorldPlanner};
