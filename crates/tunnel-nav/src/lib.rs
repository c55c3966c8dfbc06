//! Navigation along a tunnel by four diagonal ranges, section IV-E of the paper: it keeps a drone
//! in the middle, follows walls and turns at bends.
//!
//! While the chain decides only *how fast along the tunnel* a drone flies, this crate turns that
//! speed into body velocities and a yaw rate that keep the drone off the walls and pointing along
//! the tunnel. The state of the [`Navigator`] consists of the walls that the drone follows, the
//! side on which the tunnel last opened, and the path of the last metres with the headings of the
//! nose along it.
//!
//! # Rest in a bend
//! In the middle of a right-angle bend the four ranges do not determine the heading, and in early
//! versions a drone that hovered there ended with its nose towards the base. There were three
//! causes: one missing range made a wall count as lost, and the drone followed a false wall on the
//! other side; with four equal beams nothing corrected the heading; and headings that were looked
//! up by the forward odometer came at the wrong place after some motion back and forth. So a
//! missing range is replaced by the last one for a moment, the headings of the flown path correct
//! the nose wherever the drone is not in a straight gallery, and the place on the path is found by
//! position.
//!
//! A drone that *starts* in a right-angle bend has no path yet. In early versions it flew on into
//! the outer corner, treated the long rear beam beside the short front beam as an opening, turned
//! towards the wall, and continued until its nose was reversed. So a side with an obstacle near one
//! of its beams does not count as open, an obstacle that only one leading beam sees counts as
//! beside the drone, and the heading at the end of the path follows a drone that turns on the spot
//! by less than half a turn: a drone that turns farther faces back, and is turned round again.
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
//! A side counts as a wall while its two beams agree to within 40 %, and does not where the tunnel
//! opens to that side.
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

mod company;
mod fork;
mod gallery;
mod hits;
mod margin;
mod plane;
mod ranges;
mod scan;
mod spot;
mod steer;
mod trail;
mod wall;

pub use fork::{Guide, Homing};
pub use ranges::{Diagonals, Range};
pub use spot::{SpotConfig, SpotSearch, SpotView};
pub use steer::{Bearings, NavCommand, NavConfig, Navigator, Side, Walls};
