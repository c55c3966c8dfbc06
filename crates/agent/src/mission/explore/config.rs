//! The area that drones explore together, and how they fly there.

use frontier::{Cone, Gaze, Limits, Rule};
use grid_map::{Frame, FrameError};
use units::{Duration, Metres, MetresPerSecond, Point2, Pose2, Radians, RadiansPerSecond};

/// The area that drones explore together, and how they fly there. All drones of a team must have the
/// same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExploreConfig {
    /// The south-western corner of the area. What lies outside it is not explored.
    pub corner: Point2,
    /// The area's extent to the east and to the north, at most [`MOST_EXTENT`](Self::MOST_EXTENT).
    pub area: (Metres, Metres),
    /// The rule by which drones are assigned where to look next.
    pub rule: Rule,
    /// Where drone 0 takes off. Without a positioning system a drone knows its place by this and by its
    /// own motion alone.
    pub start: Pose2,
    /// How far behind the drone with the next lower number each one takes off.
    pub apart: Metres,
    /// The fastest flight over ground.
    pub speed: MetresPerSecond,
    /// The rate at which a drone turns all the time, so that its four beams see all directions.
    pub turn: RadiansPerSecond,
    /// A longer range of a side beam counts as no obstacle up to here.
    pub reach: Metres,
    /// How far a side beam that meets nothing shows the place to be free. It is shorter than the reach:
    /// a dark wall, or one that is hit at a slant, sends too little light back from farther away.
    pub clear: Metres,
    /// The cone that a side beam sees; `None` for a ray.
    pub cone: Option<Cone>,
    /// A drone nearer to another one gives way.
    pub distance: Metres,
    /// A position with a larger standard deviation counts as lost.
    pub largest_deviation: Metres,
    /// A drone without fixes flies home after so long: what it draws by then is out of place, and walls
    /// that it draws anew have frontiers behind them.
    pub longest_reckoning: Duration,
    /// How long a drone hovers without its position before it lands.
    pub patience: Duration,
}

impl ExploreConfig {
    /// The side of a cell of the map: `frontier` has its tiles of three cells for the thesis' 0.3 m
    /// between two frontiers.
    pub const RESOLUTION: Metres = Metres(0.1);
    /// The longest area for which there is memory: 160 cells.
    pub const MOST_EXTENT: Metres = Metres(16.0);

    /// The cone of a VL53L1x: 27° in all (UM2555, table of regions of interest: 16 by 16). The vendor's estimator reckons
    /// with half of 15° (`mm_tof.c`), within which every surface is taken to give a reading. Tangents of 7.5° and 13.5°.
    pub const CONE: Cone = Cone { sure: 0.131_65, whole: 0.240_08 };

    /// A rule as drones follow it, without looks from afar: a mission asks for what a drone's body can come
    /// to, and a search of places from which to look tests a line of sight in each cell, which was not
    /// timed on the chip.
    #[must_use]
    pub const fn on_board(rule: Rule) -> Rule {
        Rule { looks_from_afar: false, ..rule }
    }

    /// The largest area, with drone 0 in its middle and the others in a row behind it, as they stand
    /// before the base. The fastest flight is the thesis' (table 3.1). The rate of turn is our own number:
    /// two looks of a beam, a fifth of a second apart, are then 0.2 m apart at the reach of 2 m, two cells of the
    /// map; at the thesis' 0.3 rad/s drones needed a sixth more time in the simulator, at 0.8 rad/s as much as at 0.5. A position
    /// may be off by one and a half cells. A beam that meets nothing shows 1.2 m to be free: ST's data
    /// sheet of the VL53L1X has 1.7 m on 17 % grey in the dark with a budget of 100 ms, and a third of
    /// that time, as the drones have, takes a root of √3 off; that leaves twelve whole cells. The
    /// distance, the patience and the 150 s without fixes, after which places were off by up to a
    /// metre in the simulator, are our own numbers; drones tell each other their places once a second, and
    /// two of them come 0.6 m nearer to each other meanwhile.
    pub const DEFAULT: Self = Self {
        corner: Point2::new(-8.0, -8.0),
        area: (Self::MOST_EXTENT, Self::MOST_EXTENT),
        rule: Self::on_board(Rule::OURS),
        start: Pose2 { at: Point2::new(0.0, 0.0), yaw: Radians::ZERO },
        apart: Metres(0.35),
        speed: MetresPerSecond(0.3),
        turn: RadiansPerSecond(0.5),
        reach: Metres(2.0),
        clear: Metres(1.2),
        cone: Some(Self::CONE),
        distance: Metres(0.8),
        largest_deviation: Metres(0.15),
        longest_reckoning: Duration::from_secs(150),
        patience: Duration::from_secs(10),
    };

    /// The frame of the map.
    ///
    /// # Errors
    /// [`FrameError`] where the area is none.
    pub fn frame(&self) -> Result<Frame, FrameError> {
        // The conversion clamps.
        let cells = |extent: Metres| libm::roundf(extent.0 / Self::RESOLUTION.0) as u16;
        let (east, north) = self.area;
        Frame::new(self.corner, Self::RESOLUTION, cells(east), cells(north))
    }

    /// The limits of the flight, as `frontier` takes them.
    pub(super) const fn limits(&self) -> Limits {
        Limits { speed: self.speed.0, turn: self.turn.0, reach: self.clear.0, gaze: Gaze::Around }
    }

    /// The pose of the drone with this number, by its pose in the frame of its take-off.
    pub(super) fn pose(&self, number: u8, flown: Pose2) -> Pose2 {
        let Pose2 { at: first, yaw } = self.start;
        let (sin, cos) = yaw.sin_cos();
        let forward = flown.at.x - self.apart.0 * f32::from(number);
        let left = flown.at.y;
        Pose2 {
            at: Point2::new(
                first.x + forward * cos - left * sin,
                first.y + forward * sin + left * cos,
            ),
            yaw: (yaw + flown.yaw).wrapped(),
        }
    }
}
