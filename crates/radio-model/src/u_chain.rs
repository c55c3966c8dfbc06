//! The law of the U-Chain paper: equation (19), as printed and in a continuous version.
//!
//! It follows E. Vinogradov and S. Pollin, *Wireless Communications with Unmanned Aerial Vehicles*
//! (ICC 2019).

use units::Db;

use crate::path_loss::{Geometry, Obstruction, beyond};

/// The law by which the attenuation exponent α grows with the obstruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attenuation {
    /// The exponent is α = min(6, 2 + 2 × walls), as the paper prints it. The loss jumps at every
    /// corner, by up to 20 dB at 10 m: in this model equal links need not exist, and the best chain
    /// is not always one with equal links.
    WallCount,
    /// The exponent is α = 2 + 4·(1 − exp(−rock / 2 m)), a continuous version of the same law,
    /// which meets the assumption of section III-B that the loss is continuous. Two metres of rock
    /// add as much as one and a quarter walls.
    RockDepth,
}

/// The way in which walls act on the waves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// Waves follow the tunnel, and the exponent grows with the rock on the straight line.
    #[default]
    Rock,
    /// Waves go straight through without loss, as in the circuit of section V-B.
    Paper,
    /// Waves go straight through and lose 4 dB at each wall and 2 dB on each metre in it. These are
    /// the figures for thin brick walls in the study behind the book's chapter "Chain control" (its
    /// environment `euclid`). The rock of a mine causes far more loss.
    Leaky,
}

/// Equation (19) without its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UChain {
    /// The law for α.
    pub attenuation: Attenuation,
    /// How walls act.
    pub walls: Walls,
    /// The loss L₁ over the first metre: zero as the paper prints it, 40 dB for a real 2.4 GHz link
    /// in free space (20·log₁₀(4π/λ), λ = 0.125 m).
    pub loss_at_1m: Db,
}

impl UChain {
    /// The exponent in line of sight.
    const LEAST: f32 = 2.0;
    /// The exponent behind any amount of rock.
    const MOST: f32 = 6.0;
    /// Metres of rock over which a continuous α makes 63 % of its way from least to most.
    const ROCK_DEPTH: f32 = 2.0;

    /// The term for this obstruction: the exponent α, or, through walls that leak, the loss in dB.
    pub(crate) fn term(&self, between: Obstruction) -> f32 {
        match self.walls {
            Walls::Rock => self.exponent(between),
            Walls::Paper => 0.0,
            Walls::Leaky => 4.0 * f32::from(between.walls) + 2.0 * between.rock.0,
        }
    }

    /// The exponent α for this obstruction.
    fn exponent(&self, between: Obstruction) -> f32 {
        match self.attenuation {
            Attenuation::WallCount => {
                (Self::LEAST + 2.0 * f32::from(between.walls)).min(Self::MOST)
            }
            Attenuation::RockDepth => {
                let taken = -libm::expm1f(-between.rock.0 / Self::ROCK_DEPTH);
                Self::LEAST + (Self::MOST - Self::LEAST) * taken
            }
        }
    }

    /// The loss over this link.
    pub(crate) fn loss(&self, link: Geometry, term: f32) -> Db {
        match self.walls {
            Walls::Rock => {
                // Below a metre the logarithm is negative, and more rock would make the link better.
                let exponent = if link.along.0 < 1.0 { Self::LEAST } else { term };
                self.loss_at_1m + beyond(link.along, exponent)
            }
            Walls::Paper | Walls::Leaky => {
                self.loss_at_1m + beyond(link.straight, Self::LEAST) + Db(term)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;

    #[test]
    fn the_exponent_goes_from_two_to_six() {
        let printed =
            UChain { attenuation: Attenuation::WallCount, walls: Walls::Rock, loss_at_1m: Db(0.0) };
        let walls = |walls| printed.term(Obstruction { walls, rock: Metres(1.0) });
        assert_eq!([0, 1, 2, 3, 200].map(walls), [2.0, 4.0, 6.0, 6.0, 6.0]);

        let continuous = UChain { attenuation: Attenuation::RockDepth, ..printed };
        let rock = |m| continuous.term(Obstruction { walls: 1, rock: Metres(m) });
        assert_eq!(rock(0.0), 2.0);
        assert!((rock(2.0) - 4.53).abs() < 0.01);
        assert!((rock(1e6) - 6.0).abs() < 1e-6);
    }
}
