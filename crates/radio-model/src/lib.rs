//! The model of a radio link underground: path loss, shadowing, fading, noise, and packet loss, for
//! the simulator and the planners.
//!
//! The large-scale loss follows one of four laws ([`PathLoss`]), each with its source: equation
//! (19) of the U-Chain paper ([`UChain`]), log-distance with losses by material ([`LogDistance`]),
//! the DARPA Subterranean Challenge's ([`Subt`]), and a waveguide ([`Waveguide`]); or a table that the
//! user gives ([`Tabulated`]). The place of both
//! ends adds correlated [`Shadowing`] and small-scale [`Fading`], a drone's heading the pattern of its
//! [`Antenna`]. On top of it a packet suffers Gaussian noise, rounding to whole decibels and loss,
//! which grows with its length and weakness ([`Reception`]), and a link may be in a fade, in which it
//! loses every packet ([`Fades`]).
//!
//! The model draws no random numbers: the caller passes them in, and owns the seed.
//!
//! ```
//! use radio_model::{Attenuation, Geometry, Obstruction, PathLoss, UChain, Walls};
//! use units::{Db, Metres};
//!
//! let air = PathLoss::UChain(UChain {
//!     attenuation: Attenuation::WallCount,
//!     walls: Walls::Rock,
//!     loss_at_1m: Db(0.0),
//! });
//! let link = Geometry::in_sight(Metres(10.0));
//! assert_eq!(air.loss(link, air.term(Obstruction::NONE)), Db(20.0));
//! let round_a_corner = Obstruction { walls: 1, rock: Metres(0.8) };
//! assert_eq!(air.loss(link, air.term(round_a_corner)), Db(40.0));
//! ```
#![no_std]

mod antenna;
mod fades;
mod field;
mod log_distance;
mod material;
mod path_loss;
mod reception;
mod tabulated;
mod u_chain;
mod waveguide;

pub use antenna::Antenna;
pub use fades::Fades;
pub use field::{Fading, Shadowing, WAVES, WaveDraws};
pub use log_distance::{Corner, LogDistance, Subt};
pub use material::Material;
pub use path_loss::{Geometry, Obstruction, PathLoss};
pub use reception::{Draws, Reception};
pub use tabulated::Tabulated;
pub use u_chain::{Attenuation, UChain, Walls};
pub use waveguide::{WAVELENGTH, Waveguide};
