//! The log-distance law with losses by material, and that of the DARPA Subterranean Challenge.

use units::{Db, Metres};

use crate::material::Material;
use crate::path_loss::{Geometry, Obstruction, beyond};

/// The loss of a wave that gets behind an obstruction: straight through it, or round it.
///
/// The weaker of both losses counts, so that the loss sets in continuously as a corner comes
/// between two antennas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The loss straight through, on each metre in the rock, dB.
    pub through_db_per_m: f32,
    /// The loss round each body of rock on the straight line.
    pub round: Db,
}

impl Corner {
    /// The loss for this obstruction, dB.
    pub(crate) fn term(&self, between: Obstruction) -> f32 {
        let round = self.round.0 * f32::from(between.walls);
        (self.through_db_per_m * between.rock.0).min(round)
    }
}

/// The log-distance law L = L₁ + 10·n·log₁₀ d, with a loss at corners; d is the length of the way
/// through the tunnel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogDistance {
    /// The loss over the first metre.
    pub loss_at_1m: Db,
    /// The exponent n: 2 in free space, less in a gallery that guides waves.
    pub exponent: f32,
    /// The losses behind rock.
    pub corner: Corner,
}

impl LogDistance {
    /// Free space between corners of concrete. The 20 dB of a corner are what equation (19) of the
    /// U-Chain paper takes for a wall at 10 m.
    pub const DEFAULT: Self = Self {
        loss_at_1m: Db(40.0),
        exponent: 2.0,
        corner: Corner { through_db_per_m: Material::Concrete.loss_per_m(), round: Db(20.0) },
    };

    pub(crate) fn term(&self, between: Obstruction) -> f32 {
        self.corner.term(between)
    }

    pub(crate) fn loss(&self, link: Geometry, term: f32) -> Db {
        self.loss_at_1m + beyond(link.along, self.exponent) + Db(term)
    }
}

/// The radio of the DARPA Subterranean Challenge's simulator (osrf/subt, packages
/// `subt_communication_model` and `subt_rf_interface`): a log-distance law over the straight line
/// whose exponent grows with the *visibility cost* between both ends, which the simulator looks up
/// in a graph of its tiles.
///
/// A floor plan has no such graph. Here the cost is the number of bodies of rock on the straight
/// line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subt {
    /// The loss over the first metre.
    pub loss_at_1m: Db,
    /// The exponent in sight.
    pub exponent: f32,
    /// The growth of the exponent with each unit of the cost.
    pub per_cost: f32,
}

impl Subt {
    /// The competition's constants: `l0` 40 dB, `fading_exponent` 2.5 (the default; its worlds set
    /// 1.5), `visibility_cost_to_fading_exponent` 0.2. Its noise has a standard deviation of 10 dB.
    pub const DEFAULT: Self = Self { loss_at_1m: Db(40.0), exponent: 2.5, per_cost: 0.2 };
    /// The variance of the noise of each packet, dB²: `sigma` = 10 dB.
    pub const NOISE_VARIANCE: f32 = 100.0;
    /// `comms_cost_max`, beyond which the cost counts no more.
    const MOST_COST: f32 = 15.0;

    pub(crate) fn term(&self, between: Obstruction) -> f32 {
        self.exponent + self.per_cost * f32::from(between.walls).min(Self::MOST_COST)
    }

    pub(crate) fn loss(&self, link: Geometry, term: f32) -> Db {
        // As in equation (19): below a metre more rock would make the link better.
        let exponent = if link.straight < Metres(1.0) { self.exponent } else { term };
        self.loss_at_1m + beyond(link.straight, exponent)
    }
}
