//! The plan of a swarm's mission, and the rules by which it is flown.

use units::{Duration, Metres, MetresPerSecond, Point2, RadiansPerSecond};
use virtual_forces::{Config, Guard, Passage, Plan, Survey};

/// The plan of a swarm's mission, and the rules by which it is flown. All drones of a swarm must have
/// the same plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmConfig {
    /// The virtual forces.
    pub forces: Config,
    /// The number of drones, which are those from number 0 on.
    pub drones: u16,
    /// The south-western corner of the area that is surveyed.
    pub corner: Point2,
    /// The area's extent to the east and to the north.
    pub area: (Metres, Metres),
    /// The passage to the second area.
    pub passage: Passage,
    /// Whether the second area is surveyed, too. It is as large as the first one, and lies as that one does
    /// when it is turned by half a turn about the middle of the passage.
    pub both: bool,
    /// The speed over ground.
    pub speed: MetresPerSecond,
    /// The speed of a swarm that comes home, by the way of the drone that is farthest: with the time to
    /// gather before the passage, to go through it one behind the other, and to land.
    pub homeward: MetresPerSecond,
    /// The rate at which a drone turns all the time, so that its four beams see all directions: with beams
    /// that keep their directions it meets corners that lie between them.
    pub turn: RadiansPerSecond,
    /// The error of a position that is allowed for, in standard deviations along an axis: two of each
    /// of two drones are 2.8 of their distance's, and that is within them in 99.5 % of cases.
    pub deviations: f32,
    /// The least error that is allowed for, however well a position is said to be known.
    pub least_error: Metres,
    /// A position with a larger standard deviation counts as lost.
    pub largest_deviation: Metres,
    /// How long a drone hovers without its position before it lands.
    pub patience: Duration,
}

impl SwarmConfig {
    /// On board drones keep less away from obstacles than the points of the paper, which know all of them: at
    /// flight level the cones of rangers bring walls nearer. With the points' 0.391 m none of ten swarms of two
    /// or six passed a pillar there, with 0.36 m two of eight, with 0.33 m four of four. All that flew with
    /// 0.34 m did, but drones that go to and fro also let go of links by then. Measured in this project's
    /// simulator.
    const GUARD: Guard = Guard { obstacles: Metres(0.34), ..Guard::OURS };

    /// Six drones, the area of the paper and its passage c, which begins at the origin. At 0.3 m/s a
    /// drone is carried on by 9 cm through the lag of its velocity loop, less than the 10 cm of a
    /// step. A drone that hovers by its optic flow drifts by a few centimetres a second, so that one
    /// without its position is near another after 10 s (the formation's 0.75 m). In the simulator six drones
    /// come home from 17 m in 86 s and from 21 m in 121 s, of which the reckoning allows for 122 s and
    /// 146 s. At a turn of 0.4 rad/s they touched pillars and doors in a quarter to a half of the missions,
    /// at 0.8 rad/s in none.
    pub const DEFAULT: Self = Self {
        forces: Config { guard: Some(Self::GUARD), ..Config::OURS },
        drones: 6,
        corner: Point2::new(-9.75, -3.75),
        area: (Metres(9.0), Metres(7.5)),
        passage: Passage {
            entrance: Point2::new(0.0, 0.0),
            width: Metres(2.26),
            way: Point2::new(1.0, 0.0),
            length: Metres(6.0),
        },
        both: false,
        speed: MetresPerSecond(0.3),
        homeward: MetresPerSecond(0.25),
        turn: RadiansPerSecond(0.8),
        deviations: 2.0,
        least_error: Metres(0.02),
        largest_deviation: Metres(0.15),
        patience: Duration::from_secs(10),
    };

    /// The speed at which the way home is reckoned: [`homeward`](Self::homeward), and as much less as the
    /// drones fly more slowly than by default.
    #[must_use]
    pub fn pace_home(&self) -> MetresPerSecond {
        self.homeward * (self.speed.0 / Self::DEFAULT.speed.0).min(1.0)
    }

    /// The largest error of a position with a standard deviation; that of none is twice the error of
    /// the worst that still counts.
    #[must_use]
    pub fn error_of(&self, deviation: Option<Metres>) -> Metres {
        let deviation = deviation.unwrap_or(Metres(2.0 * self.largest_deviation.0));
        Metres((self.deviations * deviation.0).max(self.least_error.0))
    }

    /// The south-western corner of the second area.
    #[must_use]
    pub fn second_corner(&self) -> Point2 {
        let Passage { entrance, way, length, .. } = self.passage;
        let (east, north) = self.area;
        let turned = |entrance: f32, way: f32, corner: f32, extent: Metres| {
            2.0 * entrance + length.0 * way - corner - extent.0
        };
        Point2::new(
            turned(entrance.x, way.x, self.corner.x, east),
            turned(entrance.y, way.y, self.corner.y, north),
        )
    }

    /// The plan as the virtual forces take it.
    #[must_use]
    pub fn plan(&self) -> Plan {
        let survey = |corner, area| Survey::new(&self.forces, corner, area, self.drones);
        let second = if self.both { self.area } else { (Metres::ZERO, Metres::ZERO) };
        let surveys = [survey(self.corner, self.area), survey(self.second_corner(), second)];
        Plan { drones: self.drones, surveys, passage: self.passage }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drones of a scenario that are slow set out for home too late by the pace of usual ones.
    #[test]
    fn slow_drones_reckon_with_a_slower_way_home() {
        let pace_at = |speed| {
            SwarmConfig { speed: MetresPerSecond(speed), ..SwarmConfig::DEFAULT }.pace_home().0
        };
        assert!((pace_at(0.1) - 0.25 / 3.0).abs() < 1e-6);
        assert_eq!([pace_at(0.3), pace_at(0.5)], [0.25; 2]);
    }
}
