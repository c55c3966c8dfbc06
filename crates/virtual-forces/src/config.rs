//! Holds what the strategy can be told, with the values of the paper.

use units::Metres;

use crate::Formation;

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

/// The drones for which a drone waits before it sets out for its next goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// The neighbours at one hop and at two that it hears of (section 4.1 of the paper).
    Neighbours,
    /// Every drone of the swarm, whose progress neighbours pass on, except those that it has not
    /// heard of for so many rounds: they are taken for lost until they are heard again.
    Team(u16),
}

/// The direction in which the rows of a survey run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Along the area's width, as in the paper's table 2 with its 12 rows.
    AlongWidth,
    /// Along the side that gives the shorter way.
    Shortest,
}

/// The row that a drone takes in the next sweep of a survey. The paper does not say which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// Every drone moves by as many rows as there are drones, so their order stays. It is the
    /// default, because mirrored rows lose far more links than the paper's table 3.
    Shift,
    /// The last drone of one sweep is the first of the next, so each moves by another number of
    /// rows.
    Mirror,
}

/// The place that each drone takes in a compact formation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// The places in the order of the drones' numbers: "in a deterministic manner" (section 4.2).
    ByNumber,
    /// The places that make the sum of the squared ways small, by exchanges of two.
    Exchanged,
}

/// The distances and the open points of the strategy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The diameter of a drone.
    pub size: Metres,
    /// The range of the sensor that surveys.
    pub sensor_range: Metres,
    /// The distance from a drone's centre within which it heeds obstacles.
    pub obstacle_range: Metres,
    /// The range of the radio.
    pub radio_range: Metres,
    /// The factor k of equation (2), between 0 and 1, without unit.
    pub share: f32,
    /// The part of D_int that neighbours in a queue keep, before the passage and in it; 1 on paper.
    pub queue: f32,
    /// The longest way of a drone in one round.
    pub longest_step: Metres,
    /// The weight of a force in the average.
    pub weight: Weight,
    /// The law of obstacles.
    pub obstacle: ObstacleForce,
    /// The distance from a goal within which it counts as reached. The paper does not state it.
    pub tolerance: Metres,
    /// Whether a step that would pass a goal ends on it instead. The paper does not say so, and
    /// without it a drone may fly past a small goal again and again.
    pub stops_on_goals: bool,
    /// The distance from a goal within which a drone heads straight for it and heeds no other
    /// force; none on paper.
    pub straight_within: Metres,
    /// The drones for which a drone waits.
    pub wait: Wait,
    /// The direction of the rows.
    pub rows: Rows,
    /// The row of the next sweep.
    pub sweep: Sweep,
    /// The places in a compact formation.
    pub places: Places,
    /// The rounds after which a drone at its place sets out without those that are not at theirs:
    /// "a defined duration" (section 4.2), which the paper does not state.
    pub hold: u16,
    /// What keeps drones apart and linked besides the forces; nothing on paper.
    pub guard: Option<Guard>,
}

/// The conditions on the end of each step, checked against what a drone knows of its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    /// The distance from other drones within which no step may end.
    pub drones: Metres,
    /// The distance from obstacles within which no step may end.
    pub obstacles: Metres,
    /// The distance up to which a drone in a passage is not pulled towards a neighbour behind it.
    pub no_pull_back_within: Metres,
    /// The rounds without progress after which a drone in a passage lets another one beside it go
    /// first.
    pub blocked_rounds: u16,
    /// The rounds for which it then goes back.
    pub back_rounds: u16,
}

impl Config {
    /// The paper's values (section 6.2), read literally. The tolerance of 5 cm is the shortest step
    /// of a drone. Obstacles are heeded within the range of the sensor, and not within the three
    /// safety distances of section 3.5: with these a single drone never enters tunnel a.
    pub const PAPER: Self = Self {
        size: Metres(0.20),
        sensor_range: Metres(0.50),
        obstacle_range: Metres(0.50),
        radio_range: Metres(1.10),
        share: 0.75,
        queue: 1.0,
        longest_step: Metres(0.10),
        weight: Weight::Absolute,
        obstacle: ObstacleForce::Bent,
        tolerance: Metres(0.05),
        stops_on_goals: true,
        straight_within: Metres(0.0),
        wait: Wait::Neighbours,
        rows: Rows::AlongWidth,
        sweep: Sweep::Shift,
        places: Places::ByNumber,
        hold: 30,
        guard: None,
    };

    /// The paper's values with changes for clearance, links and speed. The whole team waits for its
    /// last drone, and takes one for lost that it has not heard of for 50 rounds (10 s at 5 Hz).
    /// Drones arrive on their goals: one heads straight for a goal that one step can reach, and the
    /// tolerance is for rounding. Rows run the shorter way, and places are exchanged. A queue is
    /// shorter, by a part of D_int that was tuned in a simulator: the last drone of a queue leaves a
    /// passage that much earlier. Steps are guarded.
    pub const OURS: Self = Self {
        tolerance: Metres(0.001),
        straight_within: Metres(0.10),
        wait: Wait::Team(50),
        rows: Rows::Shortest,
        places: Places::Exchanged,
        queue: 0.85,
        hold: 100,
        guard: Some(Guard::OURS),
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

    /// Returns the distance wanted between neighbours in a formation and in the passage behind it:
    /// D_int, or less in a queue, and never less than [`Config::safety_distance`].
    #[must_use]
    pub fn distance_in(&self, formation: Formation) -> Metres {
        let wanted = self.wanted_distance();
        match formation {
            Formation::Queue => Metres((self.queue * wanted.0).max(self.safety_distance().0)),
            Formation::TwoRows | Formation::ThreeRows => wanted,
        }
    }
}

impl Guard {
    /// No step ends within 1.3 safety distances of anything, the clearance that the paper reports
    /// (section 6.3.1), with a millimetre for rounding. The pull back begins at
    /// 0.95 m, 0.15 m before the link ends; that length and both numbers of rounds were tuned in a
    /// simulator.
    pub const OURS: Self = Self {
        drones: Metres(0.391),
        obstacles: Metres(0.391),
        no_pull_back_within: Metres(0.95),
        blocked_rounds: 3,
        back_rounds: 10,
    };
}
