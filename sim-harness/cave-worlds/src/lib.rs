//! Digs caves from a seed, and measures in them where relays are put down.
//!
//! A [`Cave`] is a map of [`SIDE`] by [`SIDE`] cells in which corridors of random length, width and
//! direction branch from each other. [`measure`] lets each rule of `relay_placement` put down relays
//! one after the other, and gives a [`Row`] for each rule.
//!
//! ```
//! let cave = cave_worlds::Cave::dig(7);
//! assert_eq!(cave, cave_worlds::Cave::dig(7));
//! ```

mod cave;
mod placement;

pub use cave::{Cave, SIDE};
pub use placement::{Row, measure};
