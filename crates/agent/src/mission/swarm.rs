//! The swarm mission: drones that survey an area, gather into a formation, and cross a passage, by
//! the virtual forces of Falomir et al. ([`virtual_forces`]).
//!
//! | module | holds |
//! |---|---|
//! | `config` | the plan of the mission, and the rules by which it is flown |
//! | `duty` | the duties of a drone in the air, and the transitions between them |
//! | `news` | what the drones tell each other, and what one remembers of it |
//! | `walls` | the walls around a drone, by what its side beams have hit |

mod config;
mod duty;
mod news;
mod walls;

pub use config::SwarmConfig;
pub use duty::SwarmDuty;

use core::f32::consts::{FRAC_PI_4, PI, TAU};

use units::{Metres, MetresPerSecond, NODES, Phase, Point2, Radians, RadiansPerSecond};
use virtual_forces::{Member, Task};

use super::{Next, Outbox, Round, Wish};
use crate::{AgentConfig, Inputs, Located};
use news::{News, Own};
use walls::Walls;

/// What a drone of a swarm knows.
#[derive(Clone, Debug)]
pub(crate) struct Swarm {
    /// The drone's state in the mission, once it has begun.
    member: Option<Member<NODES>>,
    /// Where the drone is, while it knows.
    located: Option<Located>,
    /// Where the drone was when it last knew.
    last: Option<Point2>,
    /// The largest error of what it knows or tells of its place.
    error: Metres,
    /// Where the drone goes in this round.
    goal: Option<Point2>,
    news: News,
    walls: Walls,
}

impl Swarm {
    /// A drone that has not heard any other.
    pub(crate) const fn new() -> Self {
        Self {
            member: None,
            located: None,
            last: None,
            error: Metres::ZERO,
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
            let others = &self.news;
            let is_drone = |point| others.is_drone(round.now, point);
            self.walls.look(round.now, pose, &inputs.ranges, is_drone);
        }
    }

    /// Whether the drone knows where it is; it does not take off before.
    pub(crate) const fn is_located(&self) -> bool {
        self.located.is_some()
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
        duty.next(&config.swarm, round, task)
    }

    /// One round of the virtual forces, from `here`.
    fn step(&mut self, config: &AgentConfig, round: &Round, here: Point2) -> Task {
        let SwarmConfig { forces, .. } = config.swarm;
        let number = u16::from(round.id.0);
        let member = self
            .member
            .get_or_insert_with(|| Member::on_the_way(forces, config.swarm.plan(), number));
        let obstacles = self.walls.seen(round.now, here, forces.obstacle_range);
        let heard = self.news.take(round.now, &config.swarm);
        self.goal = Some(member.step(here, self.error, heard, &obstacles, forces.longest_step));
        member.task()
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(&self, config: &AgentConfig) -> Wish {
        let SwarmConfig { speed, forces, passage, .. } = config.swarm;
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
        // A beam of the diagonals then looks along the passage, and two look at its walls.
        let wanted = libm::atan2f(passage.way.y, passage.way.x) - FRAC_PI_4;
        let turn = config.swarm.turn_gain * within_half_a_turn(wanted - pose.yaw.0);
        Wish::Over {
            east: along(pose.at.x, goal.x),
            north: along(pose.at.y, goal.y),
            yaw: pose.yaw,
            yaw_rate: RadiansPerSecond(turn).limited_to(config.swarm.turn_limit),
            height,
        }
    }

    /// Puts what the drone tells the others into `outbox`: in the air, once it has known its place.
    pub(crate) fn tell(&mut self, round: &Round, outbox: &mut Outbox) {
        if !matches!(round.phase, Phase::Transit | Phase::Linked) {
            return;
        }
        let Some(at) = self.last else { return };
        let progress = self.member.as_ref().map_or(0, Member::progress);
        self.news.tell(round.now, Own { at, error: self.error, progress }, outbox);
    }
}

/// The same angle within half a turn.
fn within_half_a_turn(angle: f32) -> f32 {
    angle - TAU * libm::floorf((angle + PI) / TAU)
}
