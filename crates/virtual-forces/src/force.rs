//! Gives the magnitude of each virtual force: from -1 to 1, positive towards its source.

use units::Metres;

use crate::{Config, ObstacleForce};

/// Returns the force between two drones `distance` apart that should be `wanted` apart: equation (3),
/// repulsion below and attraction above, half as steep. On paper `wanted` is D_int.
#[must_use]
pub fn between_drones(wanted: Metres, distance: Metres) -> f32 {
    let ratio = distance.0 / wanted.0;
    if ratio < 1.0 { ratio - 1.0 } else { (0.5 * (ratio - 1.0)).min(0.5) }
}

/// Returns the force towards a goal `distance` away: equation (4), 0.5 beyond D_int and linear
/// within.
#[must_use]
pub fn attraction_to_goal(config: &Config, distance: Metres) -> f32 {
    (0.5 * distance.0 / config.wanted_distance().0).min(0.5)
}

/// Returns the force of an obstacle `distance` away from the drone's centre: equation (6) or (5),
/// never positive, and none beyond three safety distances.
#[must_use]
pub fn from_obstacle(config: &Config, distance: Metres) -> f32 {
    let ratio = distance.0 / config.safety_distance().0;
    let force = match config.obstacle {
        ObstacleForce::Bent if ratio < 2.0 => 0.45 * ratio - 1.0,
        ObstacleForce::Bent => 0.1 * (ratio - 3.0),
        ObstacleForce::Linear => ratio / 3.0 - 1.0,
    };
    force.min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(left: f32, right: f32) -> bool {
        libm::fabsf(left - right) < 1e-5
    }

    #[test]
    fn the_forces_are_those_of_the_equations() {
        let paper = Config::PAPER;
        for (distance, expected) in
            [(0.0, -1.0), (0.375, -0.5), (0.75, 0.0), (1.125, 0.25), (1.5, 0.5), (9.0, 0.5)]
        {
            assert!(
                near(between_drones(paper.wanted_distance(), Metres(distance)), expected),
                "{distance}"
            );
        }
        for (distance, expected) in [(0.0, 0.0), (0.375, 0.25), (0.75, 0.5), (9.0, 0.5)] {
            assert!(near(attraction_to_goal(&paper, Metres(distance)), expected), "{distance}");
        }
        for (distance, expected) in
            [(0.0, -1.0), (0.3, -0.55), (0.6, -0.1), (0.75, -0.05), (0.9, 0.0), (2.0, 0.0)]
        {
            assert!(near(from_obstacle(&paper, Metres(distance)), expected), "{distance}");
        }
        let linear = Config { obstacle: ObstacleForce::Linear, ..paper };
        for (distance, expected) in [(0.0, -1.0), (0.45, -0.5), (0.9, 0.0), (2.0, 0.0)] {
            assert!(near(from_obstacle(&linear, Metres(distance)), expected), "{distance}");
        }
    }
}
