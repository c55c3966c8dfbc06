//! Keeps a robot off the walls of its map, and off what its map does not know.

use grid_map::CellState;
use units::Point2;

use crate::atlas::Ground;
use crate::explorer::Explorer;

/// A robot comes no nearer than this to the middle of a wall's cell, m: half the width of a drone of 0.16 m with
/// its guards, half a cell, and 9 cm for what its place is off. Our own number.
const KEPT: f32 = 0.22;
/// The time in which a robot may use up what a wall is farther away than that, s: a round of 0.2 s, and the 0.3 s by
/// which a drone lags behind its set-point in the simulator. Our own number.
const LAG: f32 = 0.5;
/// The walls that count, in cells to each side of the robot: at 0.1 m a cell, those that a robot of 0.3 m/s could come
/// too near to within that time.
const AROUND: i16 = 4;

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// The velocity, to the east and to the north in m/s, that a robot at this place flies in place of `wanted`: towards
    /// each cell that its map does not know to be free no faster than its distance allows. Beams to four sides do not
    /// see a corner that lies between them.
    pub fn off_known_walls(&self, at: Point2, wanted: [f32; 2]) -> [f32; 2] {
        let frame = self.ground.frame();
        let Some(own) = frame.cell_at(at) else { return wanted };
        let mut velocity = wanted;
        for north in -AROUND..=AROUND {
            for east in -AROUND..=AROUND {
                let wall = frame
                    .beside(own, east, north)
                    .filter(|&cell| self.ground.state(cell) != CellState::Free);
                if let Some(wall) = wall {
                    velocity = slowed(velocity, at, frame.centre(wall));
                }
            }
        }
        velocity
    }
}

/// A velocity without what is too fast towards a wall.
fn slowed(velocity: [f32; 2], at: Point2, wall: Point2) -> [f32; 2] {
    let off = at.distance(wall).0;
    if off <= 0.0 {
        return velocity;
    }
    let [east, north] = [(wall.x - at.x) / off, (wall.y - at.y) / off];
    let towards = velocity[0] * east + velocity[1] * north;
    let most = (off - KEPT) / LAG;
    let by = if most > 0.0 { towards - most } else { towards };
    // The larger of zero and zero with a sign is another one on the chip than on a laptop.
    if by > 0.0 { [velocity[0] - by * east, velocity[1] - by * north] } else { velocity }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Within the lag a robot comes no nearer to a wall than it may, and is not made faster.
        #[test]
        fn a_robot_stops_before_a_wall(
            (x, y) in (-0.4_f32..0.4, -0.4_f32..0.4),
            wanted in [-0.3_f32..0.3, -0.3_f32..0.3],
        ) {
            let (at, wall) = (Point2::new(0.0, 0.0), Point2::new(x, y));
            let off = at.distance(wall).0;
            prop_assume!(off > 0.01);
            let [east, north] = slowed(wanted, at, wall);
            let after = Point2::new(LAG * east, LAG * north).distance(wall).0;
            prop_assert!(after > KEPT.min(off) - 1e-3, "{after} of {off}");
            prop_assert!(east.hypot(north) <= wanted[0].hypot(wanted[1]) + 1e-5);
        }
    }
}
