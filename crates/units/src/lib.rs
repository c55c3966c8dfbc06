//! The quantities that cross every API, and the vocabulary of a mission ([`Role`], [`Order`],
//! [`Phase`], [`Setpoint`] …).
//!
//! A quantity crosses a function boundary in its own type and becomes a plain `f32` inside the
//! maths: `link.rssi.0`. All quantities are in SI units, except signal strength, which is in
//! decibels:
//!
//! | type | unit | sign |
//! |---|---|---|
//! | [`Dbm`] | dBm | received power: negative, larger is better |
//! | [`Db`] | dB | a ratio of powers; a path loss is positive, larger is worse |
//! | [`Metres`], [`MetresPerSecond`] | m, m/s | body axes: x forward, y left, z up |
//! | [`Radians`], [`RadiansPerSecond`] | rad, rad/s | yaw counter-clockwise seen from above |
//! | [`Point2`], [`Pose2`] | m, rad | floor plan: x east, y north, yaw counter-clockwise from east |
//! | [`AngularVelocity`], [`Acceleration`] | rad/s, m/s² | along the board's axes |
//! | [`DbPerMetre`], [`MetresPerDb`] | dB/m, m/dB | slope and compliance of a link, positive |
//! | [`Volts`] | V | |
//! | [`Instant`], [`Duration`] | µs | since boot; never runs backwards |
//!
//! ```
//! use units::{Db, Dbm, Duration, Instant, Metres, MetresPerSecond};
//!
//! assert_eq!(Dbm(-57.0) - Dbm(-60.0), Db(3.0));
//! assert_eq!(MetresPerSecond(0.4) * Duration::from_millis(500), Metres(0.2));
//! // A clock that went backwards reads as no time at all, never as an underflow.
//! assert_eq!(Instant::from_millis(5).since(Instant::from_millis(9)), Duration::ZERO);
//! ```
#![no_std]

mod mission;
mod plane;
mod quantity;
mod time;
mod triad;

pub use mission::{
    Branch, Course, LinkSpan, LinkSum, MissionKind, NODES, Order, Payload, Phase, PolicyCode, Role,
    SIGNPOSTS, Setpoint, Signpost,
};
pub use plane::{Point2, Pose2};
pub use quantity::{
    Db, DbPerMetre, Dbm, Metres, MetresPerDb, MetresPerSecond, NodeId, Radians, RadiansPerSecond,
    Volts,
};
pub use time::{Duration, Instant};
pub use triad::{Acceleration, AngularVelocity};
