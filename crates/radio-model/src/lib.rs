//! The model of a radio link underground: path loss, noise, and packet loss, for the simulator and
//! the planners.
//!
//! The large-scale loss is equation (19) of the U-Chain paper, which follows E. Vinogradov and
//! S. Pollin, *Wireless Communications with Unmanned Aerial Vehicles* (ICC 2019):
//!
//! > L(x₁, x₂) = L₁ + 10 · α · log₁₀ |x₁ − x₂|
//!
//! with |x₁ − x₂| the distance along the tunnel and α between 2 (line of sight) and 6, depending on
//! the rock between the ends ([`Attenuation`]). On top of it a packet suffers Gaussian noise,
//! rounding to whole decibels and loss, which grows with its length and weakness ([`Reception`]),
//! and a link may be in a fade, in which it loses every packet ([`Fades`]).
//!
//! The model draws no random numbers: the caller passes it [`Draws`], and owns the seed.
//!
//! ```
//! use radio_model::{Attenuation, Obstruction, PathLoss};
//! use units::{Db, Metres};
//!
//! let air = PathLoss { attenuation: Attenuation::WallCount, loss_at_1m: Db(0.0) };
//! let round_a_corner = Obstruction { walls: 1, rock: Metres(0.8) };
//! assert_eq!(air.loss(Metres(10.0), Obstruction::NONE), Db(20.0));
//! assert_eq!(air.loss(Metres(10.0), round_a_corner), Db(40.0));
//! ```
#![no_std]

mod fades;
mod path_loss;
mod reception;

pub use fades::Fades;
pub use path_loss::{Attenuation, Obstruction, PathLoss};
pub use reception::{Draws, Reception};
