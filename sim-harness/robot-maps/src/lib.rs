//! Reads maps that robots made or were tested in: occupancy maps of ROS, and worlds of DARPA's
//! Subterranean (SubT) Challenge.
//!
//! | files | are read by |
//! |---|---|
//! | map_server's YAML, with the PGM or PNG that it names | [`map_server::read`], which returns an [`Occupancy`] |
//! | SubT's `.dot` and `.sdf` | [`subt::read`], which returns a [`World`](subt::World) |
//!
//! A reader opens its files through a [`Files`], and returns a map, or a [`Refusal`] that names
//! file, line and remedy. No bytes make it panic, and what it takes is bounded.
//!
//! ```
//! use cave_survey::Memory;
//! use robot_maps::{Cell, map_server};
//!
//! let yaml = "image: room.pgm\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\n\
//!             occupied_thresh: 0.65\nfree_thresh: 0.196\n";
//! let files = Memory::default().with("room.yaml", yaml).with("room.pgm", "P2 3 1 255 0 254 205");
//! let map = map_server::read(&files, "room.yaml")?;
//! assert_eq!(map.cells(), [Cell::Occupied, Cell::Free, Cell::Unknown]);
//! # Ok::<(), robot_maps::Refusal>(())
//! ```

pub mod map_server;
mod occupancy;
mod open;
pub mod subt;

pub use cave_survey::{FileError, Files, Place, Refusal, Warning};
pub use occupancy::{Cell, Occupancy};
