//! The large-scale loss: the part of the path loss that distance and rock cause.

use units::{Db, Metres};

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

    /// The loss of a wave that goes straight through walls that leak: 4 dB for each wall and 2 dB
    /// for each metre in a wall. These are the figures for thin brick walls in the study behind the
    /// book's chapter "Chain control" (its environment `euclid`). The rock of a mine causes far
    /// more loss.
    #[must_use]
    pub fn leak(self) -> Db {
        Db(4.0 * f32::from(self.walls) + 2.0 * self.rock.0)
    }
}

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

/// The law of the path loss: equation (19) without its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLoss {
    /// The law for α.
    pub attenuation: Attenuation,
    /// The loss L₁ over the first metre: zero as the paper prints it, 40 dB for a real 2.4 GHz link
    /// in free space (20·log₁₀(4π/λ), λ = 0.125 m).
    pub loss_at_1m: Db,
}

impl PathLoss {
    /// The exponent in line of sight.
    const LEAST: f32 = 2.0;
    /// The exponent behind any amount of rock.
    const MOST: f32 = 6.0;
    /// Metres of rock over which a continuous α makes 63 % of its way from least to most.
    const ROCK_DEPTH: f32 = 2.0;
    /// The least distance between two antennas, below which the logarithm would fall without end:
    /// two Crazyflies side by side.
    const NEAREST: Metres = Metres(0.3);

    /// Returns the exponent α for this obstruction.
    #[must_use]
    pub fn exponent(&self, between: Obstruction) -> f32 {
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

    /// The loss over `distance` along the tunnel with this obstruction.
    #[must_use]
    pub fn loss(&self, distance: Metres, between: Obstruction) -> Db {
        self.loss_with_exponent(distance, self.exponent(between))
    }

    /// The loss over `distance` with this exponent.
    #[must_use]
    pub fn loss_with_exponent(&self, distance: Metres, exponent: f32) -> Db {
        let distance = distance.0.max(Self::NEAREST.0);
        // Below a metre the logarithm is negative, and more rock would make the link better.
        let exponent = if distance < 1.0 { Self::LEAST } else { exponent };
        self.loss_at_1m + Db(10.0 * exponent * libm::log10f(distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_exponent_goes_from_two_to_six() {
        let printed = PathLoss { attenuation: Attenuation::WallCount, loss_at_1m: Db(0.0) };
        let walls = |walls| printed.exponent(Obstruction { walls, rock: Metres(1.0) });
        assert_eq!([0, 1, 2, 3, 200].map(walls), [2.0, 4.0, 6.0, 6.0, 6.0]);

        let continuous = PathLoss { attenuation: Attenuation::RockDepth, ..printed };
        let rock = |m| continuous.exponent(Obstruction { walls: 1, rock: Metres(m) });
        assert_eq!(rock(0.0), 2.0);
        assert!((rock(2.0) - 4.53).abs() < 0.01);
        assert!((rock(1e6) - 6.0).abs() < 1e-6);
    }

    proptest! {
        /// Section III-B assumes it: the farther apart two drones, the weaker their link.
        #[test]
        fn loss_never_falls_with_distance_or_rock(
            near in 0.0f32..40.0, farther in 0.0f32..10.0,
            rock in 0.0f32..20.0, more in 0.0f32..5.0,
        ) {
            let law = PathLoss { attenuation: Attenuation::RockDepth, loss_at_1m: Db(40.0) };
            let a = law.loss(Metres(near), Obstruction { walls: 1, rock: Metres(rock) });
            let b = law.loss(
                Metres(near + farther),
                Obstruction { walls: 1, rock: Metres(rock + more) },
            );
            prop_assert!(b.0 >= a.0 - 1e-4, "{a} then {b}");
        }
    }
}
