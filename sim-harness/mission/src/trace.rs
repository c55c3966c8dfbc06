//! Records a mission five times a second; all pictures, tables and files are made from this record.

use std::fmt;

use agent::{State, SwarmTarget};
use units::{Branch, Course, Dbm, MissionKind, NodeId, Order, Point2, Pose2, Role};
use world::{FloorPlan, SkeletonPlace};

pub use crate::team_links::TeamLink;
pub use crate::team_map::{Change, Ground, Lattice, TeamMap};

/// A whole mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The scenario's name.
    pub scenario: String,
    /// The seed of the mission; `None` for a recording of real time, which has none.
    pub seed: Option<u64>,
    /// The mission that was flown.
    pub mission: MissionKind,
    /// The tunnel.
    pub floor_plan: FloorPlan,
    /// The members, head first, base last; every frame lists them in this order.
    pub nodes: Vec<Node>,
    /// The launch limit: when a link is weaker, the next relay takes off.
    pub launch_limit: Dbm,
    /// The corners of the passage that a swarm crosses, in order around it.
    pub passage: Option<[Point2; 4]>,
    /// What the drones of an exploration know of their area together, as it grows.
    pub team_map: TeamMap,
    /// The frames, in order of time, one per 0.2 s.
    pub frames: Vec<Frame>,
}

/// One member of a mission. It displays by the name that it has there: `head`, `explorer 1`, `relay 2` or `base` in a
/// chain, `drone 1` in a swarm, `explorer 1` in an exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// The member's number.
    pub id: NodeId,
    /// The member's role.
    pub role: Role,
    /// The mission that it flies: a swarm and an exploration have no head and no relays.
    pub mission: MissionKind,
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.mission, self.role) {
            (_, Role::Base) => f.write_str("base"),
            (MissionKind::Swarm, _) => write!(f, "drone {}", self.id),
            (MissionKind::Chain, Role::Head) if self.id == NodeId::HEAD => f.write_str("head"),
            (MissionKind::Chain, Role::Relay) => write!(f, "relay {}", self.id),
            (MissionKind::Explore, _) | (MissionKind::Chain, Role::Head) => {
                write!(f, "explorer {}", self.id)
            }
        }
    }
}

/// The mission at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Microseconds since the start of the mission.
    pub time_us: u64,
    /// The operator's order at the base.
    pub order: Order,
    /// The members, one for each of [`Trace::nodes`].
    pub drones: Vec<DroneFrame>,
    /// The pairs of members of a swarm or an exploration that hear each other.
    pub team_links: Vec<TeamLink>,
}

/// One drone at one moment, in metres, m/s and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DroneFrame {
    /// The true place on the floor plan, and the heading of the nose.
    pub pose: Pose2,
    /// The drone's height above the ground.
    pub height: f32,
    /// The drone's place on the skeleton.
    pub place: SkeletonPlace,
    /// The length of the shortest way to it from the base (the paper's x).
    pub way: f32,
    /// The velocity of the set-point, in body axes: forward, left.
    pub commanded: [f32; 2],
    /// The yaw rate of the set-point, counter-clockwise.
    pub yaw_rate: f32,
    /// The four beams, NW, NE, SW, SE; infinite where nothing was seen, NaN where not measured.
    pub ranges: [f32; 4],
    /// The state of its agent.
    pub state: State,
    /// Where a drone that explores is flying to, by its own estimate.
    pub goal: Option<Point2>,
    /// Where a drone of a swarm is to be; `None` in the passage, which has no places.
    pub target: Option<SwarmTarget>,
    /// The voltage of its battery; NaN for the base, and for points, which have none.
    pub battery_v: f32,
    /// The drone's link towards the head, while it has one.
    pub front: Option<LinkFrame>,
    /// The drone's link towards the base, while it has one.
    pub back: Option<LinkFrame>,
}

/// One link at one moment, by the drone at one end of it, and its true strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkFrame {
    /// The drone at the other end.
    pub peer: NodeId,
    /// The last packet's RSSI.
    pub raw: Dbm,
    /// The strength by the on-board filter.
    pub filtered: Dbm,
    /// The true strength at which the drone receives the other one, without noise and rounding:
    /// with shadows and fades of the place, the loss on the ground, and the gains of both antennas.
    pub truth: Dbm,
}

/// The most frames of a record of bounded size: 20 minutes of 0.2 s.
pub const MOST_FRAMES: usize = 6000;

/// Keeps a record at a bounded size: all frames of a mission of up to [`MOST_FRAMES`], and of a
/// longer one every second, fourth, eighth, … and the last.
#[derive(Clone, Debug)]
pub struct Thinning {
    /// One of so many frames is kept.
    step: usize,
    /// The number of frames that were given.
    count: usize,
}

impl Default for Thinning {
    fn default() -> Self {
        Self { step: 1, count: 0 }
    }
}

impl Thinning {
    /// Adds the next frame.
    pub fn add(&mut self, frames: &mut Vec<Frame>, frame: Frame) {
        // The frame before was the last, and is one of those that are kept, or not.
        if !self.count.saturating_sub(1).is_multiple_of(self.step) {
            frames.pop();
        }
        if frames.len() >= MOST_FRAMES {
            let mut place = 0;
            frames.retain(|_| {
                place += 1;
                !usize::is_multiple_of(place, 2)
            });
            self.step *= 2;
        }
        frames.push(frame);
        self.count += 1;
    }
}

/// An order in words: `explore at 0.20 m/s`.
#[must_use]
pub fn order_words(order: Order) -> String {
    match order {
        Order::Wait => "wait".to_owned(),
        Order::Explore(Course { speed, branch }) => {
            let branch = match branch {
                None => "",
                Some(Branch::Left) => ", left at junctions",
                Some(Branch::Right) => ", right at junctions",
                Some(Branch::Straight) => ", straight at junctions",
            };
            format!("explore at {:.2} m/s{branch}", speed.0)
        }
        Order::Return => "return".to_owned(),
        Order::Land => "land".to_owned(),
        Order::Perch => "perch".to_owned(),
        Order::Stop => "stop".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_record_has_the_first_frame_and_the_last_and_equal_steps_between() {
        let frame = |n: u64| Frame {
            time_us: n,
            order: Order::Wait,
            drones: Vec::new(),
            team_links: Vec::new(),
        };
        let (mut frames, mut thinning) = (Vec::new(), Thinning::default());
        for n in 0..50_000 {
            thinning.add(&mut frames, frame(n));
            let times: Vec<u64> = frames.iter().map(|frame| frame.time_us).collect();
            assert!(times.len() <= MOST_FRAMES);
            assert_eq!((times[0], times.last()), (0, Some(&n)));
            if n < MOST_FRAMES as u64 {
                assert_eq!(times.len() as u64, n + 1);
            } else if n % 997 == 0 {
                let (last, before) = times.split_last().unwrap();
                let step = before[1];
                assert!(before.windows(2).all(|pair| pair[1] - pair[0] == step), "{n}");
                assert!(last - before[before.len() - 1] <= step, "{n}");
            }
        }
    }

    #[test]
    fn a_swarm_has_no_head_and_no_relay() {
        let names = |mission| {
            [(0, Role::Head), (1, Role::Relay), (2, Role::Base)]
                .map(|(n, role)| Node { id: NodeId(n), role, mission }.to_string())
        };
        assert_eq!(names(MissionKind::Swarm), ["drone 0", "drone 1", "base"]);
        assert_eq!(names(MissionKind::Explore), ["explorer 0", "explorer 1", "base"]);
        assert_eq!(names(MissionKind::Chain), ["head", "relay 1", "base"]);
    }

    #[test]
    fn of_two_explorers_one_alone_is_called_the_head() {
        let roles = [Role::Head, Role::Head, Role::Relay, Role::Base];
        let mission = MissionKind::Chain;
        let name = |(n, role)| Node { id: NodeId(n), role, mission }.to_string();
        let names: Vec<_> = (0..).zip(roles).map(name).collect();
        assert_eq!(names, ["head", "explorer 1", "relay 2", "base"]);
    }
}
