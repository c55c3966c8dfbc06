//! Holds what the strategy can be told, with the values of the paper.

use units::Metres;

/// The weight of a force in the average (section 3.6 of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// e to the absolute magnitude, so that strong repulsion counts as much as strong attraction.
    /// It is the default, because the weight of Casteigts et al. (2012), whom the paper cites for
    /// it, is an exponential of a magnitude that is never negative.
    Absolute,
    /// e to the signed magnitude, as the paper's sentence reads: repulsion, which is negative,
    /// counts less the stronger it is.
    Signed,
}

/// The law by which obstacles push a drone away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstacleForce {
    /// Equation (6): weak between two and three safety distances.
    Bent,
    /// Equation (5), which the authors tried first and rejected: linear up to three safety
    /// distances.
    Linear,
}

/// The drones for which a surveying drone waits before it sets out for its next goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// The neighbours at one hop and at two that it hears of (section 4.1 of the paper).
    Neighbours,
    /// Every drone of the swarm, whose progress neighbours pass on. A drone that is lost holds up
    /// all others.
    Team,
}

/// The distances and the open points of the strategy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The diameter of a drone.
    pub size: Metres,
    /// The range of the sensor that surveys and that sees obstacles.
    pub sensor_range: Metres,
    /// The range of the radio.
    pub radio_range: Metres,
    /// The factor k of equation (2), between 0 and 1, without unit.
    pub share: f32,
    /// The weight of a force in the average.
    pub weight: Weight,
    /// The law of obstacles.
    pub obstacle: ObstacleForce,
    /// The distance from a goal within which it counts as reached. The paper does not state it.
    pub tolerance: Metres,
    /// The distance from a goal within which a surveying drone heads straight for it and heeds no
    /// other force; none on paper.
    pub straight_within: Metres,
    /// The distance from another drone within which no step of a surveying drone may end; none on
    /// paper.
    pub guard: Metres,
    /// The drones for which a surveying drone waits.
    pub wait: Wait,
}

impl Config {
    /// The paper's values (section 6.2), read literally; the tolerance of 5 cm is the shortest step
    /// of a drone.
    pub const PAPER: Self = Self {
        size: Metres(0.20),
        sensor_range: Metres(0.50),
        radio_range: Metres(1.10),
        share: 0.75,
        weight: Weight::Absolute,
        obstacle: ObstacleForce::Bent,
        tolerance: Metres(0.05),
        straight_within: Metres(0.0),
        guard: Metres(0.0),
        wait: Wait::Neighbours,
    };

    /// The paper's values with three changes for clearance: the whole team waits for its last drone,
    /// arrives on its goals, and no step ends within 1.3 safety distances of another drone, the
    /// clearance that the paper reports (section 6.3.1), with a millimetre for rounding. A drone heads straight for a goal that one step can reach (0.10 m,
    /// section 6.2 of the paper), and a millimetre is for rounding.
    pub const BARRIER: Self = Self {
        tolerance: Metres(0.001),
        straight_within: Metres(0.10),
        guard: Metres(0.391),
        wait: Wait::Team,
        ..Self::PAPER
    };

    /// Returns D_safe, the distance that a drone keeps from everything: equation (1).
    #[must_use]
    pub fn safety_distance(&self) -> Metres {
        Metres(1.5 * self.size.0)
    }

    /// Returns D_int, the distance wanted between neighbours: equation (2), and never less than
    /// [`Config::safety_distance`], which section 3.2 of the paper requires.
    #[must_use]
    pub fn wanted_distance(&self) -> Metres {
        let reach = (2.0 * self.sensor_range.0).min(self.radio_range.0);
        Metres((self.share * reach).max(self.safety_distance().0))
    }
}
