//! Navigation along a tunnel by four diagonal ranges, section IV-E of the paper: it keeps a drone
//! in the middle, follows walls and turns at bends.
//!
//! While the chain decides only *how fast along the tunnel* a drone flies, this crate turns that
//! speed into body velocities and a yaw rate that keep the drone off the walls and pointing along
//! the tunnel. Its state is the walls that it has, the side on which the tunnel last opened, and the
//! path of the last metres with the headings of the nose along it.
//!
//! # Rest in a bend
//! In a right angle four beams tell too little, and a drone that rested there used to end with its
//! nose towards the base. One missing range ended a wall, and the false wall on the other side was
//! taken up; between four equal beams the nose turned freely; and headings remembered by the forward
//! odometer were held at another place after some creeping back and forth. So a missing range is
//! bridged for a moment, the nose is held by the headings of the flown path wherever the drone is
//! not in a straight gallery, and the place on the path is found by position.
//!
//! A drone that *starts* in a right angle has no path yet. It flew on into the outer corner, and took
//! the long rear beam beside the near front beam for an opening: it turned towards the wall, and on
//! until its nose was reversed. So a side with an obstacle near one of its beams does not open, an
//! obstacle that one leading beam alone sees is beside the drone, and the end of the path follows the
//! nose by less than a half turn: a drone that turns farther there faces back, and turns again.
//!
//! ```text
//!        x forward           NW, NE, SW, SE: beams at ±45° and ±135° from the nose.
//!     NW   ↑   NE            The multi-ranger deck looks along the drone's own axes; the drone
//!       ╲  │  ╱              flies yawed by 45° and `src/` turns the frame, as the authors' did.
//!  y ←── drone
//!       ╱     ╲
//!     SW       SE
//! ```
//!
//! # Modes
//! Each side has a wall while its two beams agree to within 40 %; a side that opens has none.
//!
//! | walls | command |
//! |---|---|
//! | both | equation (17): centre between the leading beams, align with both walls |
//! | one | equation (18), mirrored for the right side: follow it at a set distance |
//! | none | straight on; away from obstacles ahead, slowly, to the preferred side in doubt |
//!
//! The paper writes its equations for a drone that flies forward. A relay flies backward half of
//! the time; then the rear beams lead. The equations are mirrored front to back, which leaves the
//! yaw law as it is and centres by the two beams that look where the drone is going.
#![no_std]

mod gallery;
mod ranges;
mod steer;
mod trail;
mod wall;

pub use ranges::{Diagonals, Range};
pub use steer::{Bearings, NavCommand, NavConfig, Navigator, Side, Walls};
