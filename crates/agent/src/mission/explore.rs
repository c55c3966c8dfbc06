//! The mission explore: drones that explore a place together, each with a map of its own, and tell each
//! other frontiers and never maps ([`frontier`]).
//!
//! | module | holds |
//! |---|---|
//! | `config` | the area that is explored, and how the drones fly there |
//! | `duty` | the duties of a drone in the air, and the transitions between them |
//! | `looks` | what the side beams of a drone that turns show |
//! | `clearance` | the distance that a drone keeps from what its side beams hit |

mod clearance;
mod config;
mod duty;
mod looks;

pub use config::ExploreConfig;
pub use duty::ExploreDuty;

use frontier::{Atlas160, Config, Explorer, Ground, Inputs as Perceived, Motion};
use grid_map::{CellState, Frame};
use heapless::Vec;
use tunnel_nav::Diagonals;
use units::{
    Instant, Metres, MetresPerSecond, NodeId, Order, Payload, Phase, Point2, Pose2, Radians,
    RadiansPerSecond,
};

use super::battery::Charge;
use super::{Call, Next, Outbox, Round, Wish};
use crate::odometry::odometer_deviation;
use crate::{AgentConfig, Inputs};
use clearance::off_walls;
use duty::Doing;
use looks::{Looks, Sight};

/// The most drones that explore together: those with the numbers below this.
pub const MOST_EXPLORERS: usize = 6;
/// The tiles on which a drone remembers marks, its own and all drones': 16 kB. Of the 2,916 tiles of
/// the largest map those count that are a frontier, that were one and are settled, and that were one as
/// not all drones know yet; when half of the room is taken, marks that no drone needs are taken back.
const RECORDS: usize = 800;
/// The packets of others that a drone takes in a round: as many as its mailbox holds.
const MOST_PACKETS: usize = 24;
/// A frontier has so many unknown cells around it, of 48. Our own number: gaps of one or two cells that beams leave in
/// walls are none. Drones of the simulator knew as much with 6 and with 10.
const LEAST_GAIN: u8 = 8;
/// Frontiers with an obstacle within so many cells do not count: robots flew back through a whole plan for single
/// cells beside walls. With two cells a fifth of the simulator's missions at flight level, and more, stopped early.
const FRONTIER_ROOM: u8 = 1;
/// A search of ways that visits more cells goes on in the next round.
const SEARCH_CELLS: u16 = 8_000;
/// So many marks are compared with the map in a round: eleven rows of the 54 by 54 tiles of the largest
/// area, so that all are compared within the five rounds of a second.
const COMPARED_TILES: u16 = 594;
/// What a beam hits within this of another drone is that drone: half its width, and how far it flies at
/// 0.3 m/s until it tells its place again, with half as much again for a packet that is lost, m.
const DRONE: f32 = 0.53;
/// A drone without fixes lands so far ahead of where it took off, m: behind it are the base and the drones of the row,
/// which lands it on one of them in a sixth of the missions of `explore-flow` otherwise.
const STOPS_AHEAD: f32 = 0.35;
/// The part of its speed that a drone makes good on its way home, which slows down beside walls: in the simulator
/// 0.2 of 0.3 m/s through six rooms.
const HOMEWARD: f32 = 0.65;
/// Without fixes drones keep apart by so many standard deviations more, and by more on their way home,
/// which leads all of them to one place.
const DEVIATIONS: f32 = 2.0;
const DEVIATIONS_HOMEWARD: f32 = 3.0;

/// The memory of a drone that explores: its map with the planner of ways in it, the marks of all drones,
/// and its part in the team. It is too large for an agent on a stack, and so its caller's, who lends it
/// at each step ([`Agent::step_exploring`](crate::Agent::step_exploring)).
#[derive(Clone, Debug)]
pub struct Exploration(Explorer<Atlas160, MOST_EXPLORERS, RECORDS>);

impl Exploration {
    /// The memory before a mission.
    pub const NEW: Self = {
        // The frame is that of no area; `begin` replaces it.
        let Ok(frame) = Frame::new(Point2::new(0.0, 0.0), ExploreConfig::RESOLUTION, 1, 1) else {
            panic!("one cell is a grid")
        };
        let Ok(ground) = Atlas160::new(frame) else { panic!("there is room for one cell") };
        Self(Explorer::new(config_of(NodeId::HEAD, &ExploreConfig::DEFAULT, false), ground))
    };

    /// The frame of the drone's map.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.0.ground().frame()
    }

    /// What the drone's map knows of a cell.
    #[must_use]
    pub fn state(&self, cell: grid_map::Cell) -> CellState {
        self.0.ground().state(cell)
    }

    /// Where the drone is flying to, by its own estimate, while it is on its way to a goal.
    #[must_use]
    pub fn goal(&self) -> Option<Point2> {
        self.0.goal()
    }

    /// Begins the mission of a drone; says whether the area fits the memory.
    fn begin(&mut self, id: NodeId, config: &ExploreConfig, by_fixes: bool) -> bool {
        let Ok(frame) = config.frame() else { return false };
        self.0.begin(config_of(id, config, by_fixes), frame).is_ok()
    }
}

/// The robot that the drone is for `frontier`.
const fn config_of(id: NodeId, config: &ExploreConfig, by_fixes: bool) -> Config {
    Config {
        number: id.0,
        rule: config.rule,
        limits: config.limits(),
        least_gain: LEAST_GAIN,
        frontier_room: FRONTIER_ROOM,
        compared_tiles: COMPARED_TILES,
        search_cells: SEARCH_CELLS,
        forwards: true,
        returns: true,
        stops_ahead: if by_fixes { 0.0 } else { STOPS_AHEAD },
        stands: false,
    }
}

/// What a drone that explores knows beside its [`Exploration`].
#[derive(Clone, Debug)]
pub(crate) struct Explore {
    /// Whether the drone was lent the memory, and has a number that may explore.
    is_able: bool,
    /// Whether a positioning system told the drone its place before take-off; it then relies on it.
    by_fixes: bool,
    /// When the drone began to explore; from then on the memory is that of this flight.
    begun: Option<Instant>,
    /// Where the drone is, while it knows.
    pose: Option<Pose2>,
    /// How far the drone has flown since take-off, in whatever direction.
    flown: Metres,
    /// The velocity over ground to the east and to the north, m/s, and the rate of turn, rad/s.
    velocity: [f32; 2],
    yaw_rate: f32,
    doing: Doing,
    looks: Looks,
    charge: Charge,
    /// Whether the drone flies home because its battery carries it there and not much farther.
    is_short: bool,
    messages: Outbox,
}

impl Explore {
    /// A drone that has not heard any other.
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            is_able: false,
            by_fixes: false,
            begun: None,
            pose: None,
            flown: Metres::ZERO,
            velocity: [0.0; 2],
            yaw_rate: 0.0,
            doing: Doing::NONE,
            looks: Looks::NONE,
            charge: Charge::new(),
            is_short: false,
            messages: Outbox::new(),
        }
    }

    /// Takes in where the drone is, what its side beams see, and what the others told since the last
    /// round, and lets the exploration decide.
    pub(crate) fn listen(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        inputs: &Inputs<'_>,
        exploration: Option<&mut Exploration>,
    ) {
        self.messages.clear();
        self.is_able = exploration.is_some() && usize::from(round.id.0) < MOST_EXPLORERS;
        match (round.phase, exploration) {
            (Phase::Linked, Some(exploration)) => {
                let before = self.pose;
                self.pose = self.located(config, round, inputs);
                if let (Some(from), Some(to)) = (before, self.pose) {
                    self.flown += from.at.distance(to.at);
                }
                self.explore(config, round, inputs, exploration);
            }
            (Phase::Waiting | Phase::Out, _) => {
                self.begun = None;
                self.pose = None;
                self.flown = Metres::ZERO;
                (self.charge, self.is_short) = (Charge::new(), false);
                self.by_fixes = inputs.located.is_some();
            }
            _ => {}
        }
    }

    /// Where the drone is: by the positioning system, where it had one before take-off, or by its own
    /// motion, while the flow sees it.
    fn located(&self, config: &AgentConfig, round: &Round, inputs: &Inputs<'_>) -> Option<Pose2> {
        let explore = &config.explore;
        if self.by_fixes {
            let limit = explore.largest_deviation;
            return inputs.located.filter(|it| it.deviation <= limit).map(|it| it.pose);
        }
        inputs.velocity.map(|_| explore.pose(round.id.0, round.here.pose))
    }

    /// One step of the exploration, if the drone knows where it is.
    fn explore(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        inputs: &Inputs<'_>,
        exploration: &mut Exploration,
    ) {
        let explore = &config.explore;
        if self.begun.is_none() && exploration.begin(round.id, explore, self.by_fixes) {
            self.begun = Some(round.now);
        }
        let Some((pose, begun)) = self.pose.zip(self.begun) else {
            (self.velocity, self.yaw_rate) = ([0.0; 2], 0.0);
            return;
        };
        let Exploration(explorer) = exploration;
        let reach = Metres(explore.reach.0.min(config.nav.reach.0));
        let clear = Metres(explore.clear.0.min(reach.0));
        let sight = Sight { reach, clear, cone: explore.cone };
        let is_drone = |point: Point2| {
            let mut others = explorer.others(round.now);
            others.any(|(_, at)| at.distance(point).0 < DRONE)
        };
        let beams = self.looks.take(pose, &inputs.ranges, sight, is_drone);
        let mut packets = Vec::<&[u8], MOST_PACKETS>::new();
        for told in inputs.told {
            // What has no room is lost, as on the air.
            let _ = packets.push(told.payload.as_bytes());
        }
        let perceived = Perceived { pose, beams: &beams, packets: &packets };
        let drifts = !self.by_fixes && round.now.since(begun) > explore.longest_reckoning;
        let is_short = self.is_short(config, round.now, inputs, |most| {
            explorer.is_within(round.now, pose.at, most)
        });
        let is_called = round.order() == Some(Order::Return);
        explorer.recall(round.now, drifts || is_short || is_called);
        let outputs = explorer.step(round.now, &perceived);
        for packet in &outputs.packets {
            // A packet fits a payload, and the outbox has room for those of a step.
            let _ = Payload::new(packet).map(|payload| self.messages.push(payload));
        }
        self.doing = Doing {
            activity: explorer.activity(),
            goal: explorer.goal(),
            is_recalled: explorer.is_recalled(),
            has_seen_all: explorer.has_seen_all(),
        };
        self.fly(explore, round, pose, (outputs.motion, &inputs.ranges), explorer);
    }

    /// Whether the battery has little more than the way home takes, which is within the length that
    /// `is_within` is asked for; once it has, the drone stays on its way home.
    fn is_short(
        &mut self,
        config: &AgentConfig,
        now: Instant,
        inputs: &Inputs<'_>,
        is_within: impl FnOnce(Metres) -> bool,
    ) -> bool {
        if self.is_short || !config.flight.keeps_way_home {
            return self.is_short;
        }
        let Some(left) = self.charge.left(now, inputs.endurance) else { return false };
        let most = config.flight.carried_home(left);
        self.is_short = !is_within(Metres(most * HOMEWARD * config.explore.speed.0));
        self.is_short
    }

    /// Takes the motion that the exploration wants, but for what would lead to another drone or a wall.
    fn fly<G: Ground, const ROBOTS: usize, const RECORDS: usize>(
        &mut self,
        explore: &ExploreConfig,
        round: &Round,
        pose: Pose2,
        (motion, ranges): (Motion, &Diagonals),
        explorer: &mut Explorer<G, ROBOTS, RECORDS>,
    ) {
        let apart = explorer.apart(round.now, pose, motion, self.distance(explore));
        let kept_off = explorer.off_known_walls(pose.at, apart);
        self.velocity = off_walls(kept_off, pose.yaw, ranges, explore.speed.0);
        self.yaw_rate = motion.yaw_rate;
    }

    /// Within which distance of another drone, by the place that it tells, this one gives way. Places by
    /// the drones' own motion are off by what their odometers are.
    fn distance(&self, explore: &ExploreConfig) -> Metres {
        if self.by_fixes {
            return explore.distance;
        }
        let deviations = if self.doing.is_recalled { DEVIATIONS_HOMEWARD } else { DEVIATIONS };
        Metres(explore.distance.0 + deviations * odometer_deviation(self.flown).0)
    }

    /// Whether the mission calls for the drone: it flies as soon as it is ordered to.
    pub(crate) const fn call(&self) -> Call {
        Call { arms: self.is_able, stays_armed: self.is_able, takes_off: self.is_able }
    }

    /// The duty after a round of `duty`, or the landing that ends it.
    pub(crate) fn next_duty(
        &self,
        config: &AgentConfig,
        round: &Round,
        duty: ExploreDuty,
    ) -> Next<ExploreDuty> {
        let knows = self.pose.is_some() && self.begun.is_some();
        duty.next(&config.explore, round, knows.then_some(self.doing))
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(&self, config: &AgentConfig) -> Wish {
        let height = config.flight.height;
        let yaw = self.pose.map_or(Radians::ZERO, |pose| pose.yaw);
        let [east, north] = self.velocity.map(MetresPerSecond);
        Wish::Over { east, north, yaw, yaw_rate: RadiansPerSecond(self.yaw_rate), height }
    }

    /// Puts what the drone tells the others into `outbox`.
    pub(crate) fn tell(&self, outbox: &mut Outbox) {
        // Both have the same room.
        let _ = outbox.extend_from_slice(&self.messages);
    }
}
