//! The large-scale loss: the part of the path loss that distance and rock cause.
//!
//! A law splits the loss into a *term* that depends on the obstruction of the straight line alone
//! ([`PathLoss::term`]) and the rest, which depends on distances ([`PathLoss::loss`]). A simulator
//! tabulates the term, which takes a search through all walls, and computes the rest anew.

use units::{Db, Metres};

use crate::tabulated::Tabulated;
use crate::u_chain::{Attenuation, UChain, Walls};
use crate::waveguide::Waveguide;
use crate::{LogDistance, Subt};

/// The obstruction of the straight line between two antennas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstruction {
    /// The number of separate bodies of rock.
    pub walls: u8,
    /// The length of the line that is in rock.
    pub rock: Metres,
}

impl Obstruction {
    /// The line of sight, without any rock.
    pub const NONE: Self = Self { walls: 0, rock: Metres(0.0) };
}

/// The distances between two antennas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// The length of the shortest way through the tunnel.
    pub along: Metres,
    /// The length of the straight line.
    pub straight: Metres,
}

impl Geometry {
    /// Two antennas with nothing but air between them.
    #[must_use]
    pub const fn in_sight(distance: Metres) -> Self {
        Self { along: distance, straight: distance }
    }
}

/// The law of the path loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathLoss {
    /// Equation (19) of the U-Chain paper.
    UChain(UChain),
    /// A constant exponent, with losses at walls, in rock and at corners.
    LogDistance(LogDistance),
    /// The radio of the DARPA Subterranean Challenge's simulator.
    Subt(Subt),
    /// A tunnel as a waveguide: free space near by, modes that decay farther on.
    Waveguide(Waveguide),
    /// A table of losses.
    Tabulated(Tabulated),
}

impl PathLoss {
    /// The term of this obstruction, in a unit that is the law's own.
    #[must_use]
    pub fn term(&self, between: Obstruction) -> f32 {
        match self {
            Self::UChain(law) => law.term(between),
            Self::LogDistance(law) => law.term(between),
            Self::Subt(law) => law.term(between),
            Self::Waveguide(law) => law.corner.term(between),
            Self::Tabulated(law) => law.term(between),
        }
    }

    /// The loss over a link with these distances and the [term](Self::term) of its obstruction.
    #[must_use]
    pub fn loss(&self, link: Geometry, term: f32) -> Db {
        match self {
            Self::UChain(law) => law.loss(link, term),
            Self::LogDistance(law) => law.loss(link, term),
            Self::Subt(law) => law.loss(link, term),
            Self::Waveguide(law) => law.loss(link, term),
            Self::Tabulated(law) => law.loss(link, term),
        }
    }

    /// Whether the term is zero whatever stands between two antennas, so that it needs no table.
    #[must_use]
    pub fn ignores_walls(&self) -> bool {
        matches!(self, Self::UChain(UChain { walls: Walls::Paper, .. }))
    }

    /// Whether the term jumps from place to place, so that it must not be interpolated.
    #[must_use]
    pub fn jumps(&self) -> bool {
        match self {
            Self::UChain(law) => {
                law.walls == Walls::Rock && law.attenuation == Attenuation::WallCount
            }
            Self::Subt(_) | Self::Tabulated(_) => true,
            Self::LogDistance(_) | Self::Waveguide(_) => false,
        }
    }

    /// The loss over the first metre.
    #[must_use]
    pub fn loss_at_1m(&self) -> Db {
        match self {
            Self::UChain(law) => law.loss_at_1m,
            Self::LogDistance(law) => law.loss_at_1m,
            Self::Subt(law) => law.loss_at_1m,
            Self::Waveguide(law) => law.loss_at_1m,
            Self::Tabulated(law) => law.loss_at_1m(),
        }
    }
}

/// The least distance between two antennas, below which the logarithm would fall without end: two
/// Crazyflies side by side.
const NEAREST: Metres = Metres(0.3);

/// The loss over this distance beyond that over the first metre, with this exponent.
pub(crate) fn beyond(distance: Metres, exponent: f32) -> Db {
    Db(10.0 * exponent * libm::log10f(distance.0.max(NEAREST.0)))
}
