//! The swarm mission: drones that survey an area, gather into a formation, cross a passage and survey
//! what lies behind it, by the virtual forces of Falomir et al. ([`virtual_forces`]).
//!
//! | module | holds |
//! |---|---|
//! | `config` | the plan of the mission, and the rules by which it is flown |
//! | `drift` | by how much a turning drone flies beside the direction that it is told |
//! | `duty` | the duties of a drone in the air, and the transitions between them |
//! | `news` | what the drones tell each other, and what one remembers of it |
//! | `target` | where a drone is to be, for observers |
//! | `walls` | the walls around a drone, by what its side beams have hit |

mod config;
mod drift;
mod duty;
mod news;
mod target;
mod walls;

pub use config::SwarmConfig;
pub use duty::SwarmDuty;

use units::{
    Duration, Metres, MetresPerSecond, NODES, Order, Phase, Point2, Radians, RadiansPerSecond,
};
use virtual_forces::{DOWN, Member, Task};

use super::battery::Charge;
use super::{Next, Outbox, Round, Wish};
use crate::{AgentConfig, Inputs, Located};
use drift::Drift;
use news::{News, Own};
use walls::Walls;

/// How much later a drone flies as it is told, at first: half a round, and half of 0.3 s, since the lag of a
/// velocity loop counts only where that loop turns with the drone. The rest is learnt.
const LAG: Duration = Duration::from_millis(250);

/// What a drone of a swarm knows.
#[derive(Clone, Debug)]
pub(crate) struct Swarm {
    /// The drone's state in the mission, once it has begun.
    member: Option<Member<NODES>>,
    /// Where the drone is, while it knows.
    located: Option<Located>,
    /// Where the drone was when it last knew.
    last: Option<Point2>,
    /// Where the drone stood before it took off, if it knew.
    home: Option<Point2>,
    charge: Charge,
    /// The largest error of what it knows or tells of its place.
    error: Metres,
    drift: Drift,
    /// Where the drone goes in this round.
    goal: Option<Point2>,
    news: News,
    walls: Walls,
}

impl Swarm {
    /// A drone that has not heard any other.
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self {
            member: None,
            located: None,
            last: None,
            home: None,
            charge: Charge::new(),
            error: Metres::ZERO,
            drift: Drift::new(),
            goal: None,
            news: News::new(),
            walls: Walls::new(),
        }
    }

    /// Takes in where the drone is, what its side beams see, and what the others told since the last
    /// round.
    pub(crate) fn listen(&mut self, config: &AgentConfig, round: &Round, inputs: &Inputs<'_>) {
        let limit = config.swarm.largest_deviation;
        self.located = inputs.located.filter(|located| located.deviation <= limit);
        let deviation = inputs.located.map(|located| located.deviation);
        self.error = config.swarm.error_of(deviation);
        self.news.listen(round.now, round.id, inputs.told);
        if let Some(Located { pose, .. }) = self.located {
            self.last = Some(pose.at);
            if round.phase == Phase::Waiting {
                (self.home, self.member, self.charge) = (self.last, None, Charge::new());
                (self.goal, self.drift) = (None, Drift::new());
            }
            let others = &self.news;
            let is_drone = |point| others.is_drone(round.now, point);
            self.walls.look(round.now, pose, &inputs.ranges, is_drone);
        }
    }

    /// Whether the drone knows where it is; it does not take off before.
    pub(crate) const fn is_located(&self) -> bool {
        self.located.is_some()
    }

    /// Whether the battery has little more than the way home takes, through the passage where the drone is
    /// behind it.
    pub(crate) fn must_turn_back(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        inputs: &Inputs<'_>,
    ) -> bool {
        let left = self.charge.left(round.now, inputs.endurance);
        let (Some(left), Some(here), Some(home)) = (left, self.last, self.home) else {
            return false;
        };
        let way = config.swarm.passage.way_home(here, home);
        config.flight.carried_home(left) < way.0 / config.swarm.pace_home().0
    }

    /// The duty after a round of `duty`, or the landing that ends it.
    pub(crate) fn next_duty(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: SwarmDuty,
    ) -> Next<SwarmDuty> {
        let task = self.located.map(|located| self.step(config, round, located.pose.at));
        if task.is_none() {
            self.goal = None;
        }
        let is_recalled = self.member.as_ref().is_some_and(Member::is_recalled);
        duty.next(&config.swarm, round, task, is_recalled)
    }

    /// One round of the virtual forces, from `here`.
    fn step(&mut self, config: &AgentConfig, round: &Round, here: Point2) -> Task {
        self.drift.learn(here, self.goal);
        let SwarmConfig { forces, .. } = config.swarm;
        let number = u16::from(round.id.0);
        let member = self
            .member
            .get_or_insert_with(|| Member::on_the_way(forces, config.swarm.plan(), number));
        if round.order() == Some(Order::Return) {
            member.recall(here, self.home.unwrap_or(here));
        }
        let obstacles = self.walls.seen(round.now, here, forces.obstacle_range);
        let heard = self.news.take(round.now, &config.swarm);
        self.goal = Some(member.step(here, self.error, heard, &obstacles, forces.longest_step));
        member.task()
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(&self, config: &AgentConfig) -> Wish {
        let SwarmConfig { speed, forces, turn, .. } = config.swarm;
        let height = config.flight.height;
        let (Some(Located { pose, .. }), Some(goal)) = (self.located, self.goal) else {
            return Wish::Over {
                east: MetresPerSecond::ZERO,
                north: MetresPerSecond::ZERO,
                yaw: Radians::ZERO,
                yaw_rate: RadiansPerSecond::ZERO,
                height,
            };
        };
        // A whole step is flown at full speed, and a part of one at a part of it.
        let gain = speed.0 / forces.longest_step.0;
        let along = |from: f32, to: f32| MetresPerSecond(gain * (to - from));
        Wish::Over {
            east: along(pose.at.x, goal.x),
            north: along(pose.at.y, goal.y),
            // The drone turns on until it has come to the velocity that it is told, for how long is learnt.
            yaw: pose.yaw + turn * LAG + self.drift.angle(),
            yaw_rate: turn,
            height,
        }
    }

    /// Puts what the drone tells the others into `outbox`: in the air, once it has known its place, and
    /// where it has landed at the end of the mission.
    pub(crate) fn tell(&mut self, round: &Round, outbox: &mut Outbox) {
        let progress = self.member.as_ref().map_or(0, Member::progress);
        if !matches!(round.phase, Phase::Transit | Phase::Linked) && progress != DOWN {
            return;
        }
        let Some(at) = self.last else { return };
        self.news.tell(round.now, Own { at, error: self.error, progress }, outbox);
    }
}
