//! Notices that a head stands although the pilot pushes and relays wait.
//!
//! While a relay waits and the pilot pushes, the head must advance or a relay must be called within
//! the time that a relay needs to come: its arming, the launch policy's patience, its climb, and its
//! flight to the head at the speed of the way home, which relays that keep their links can be
//! expected to reach.

use agent::State;
use units::Order;

use super::observer::{ROUND_S, waits};
use mission::Mission;
use scenario::Scenario;

/// A head has advanced that is farther than ever before by this, m.
const ADVANCED_M: f32 = 0.3;
/// A head stands that has not advanced for this long, s.
const STANDS_S: f32 = 5.0;

/// What is seen of a head that is pushed.
pub(super) struct Push {
    scenario: Scenario,
    /// The farthest place that counted as an advance, m; less where the pilot has flown the head back
    /// from it.
    best_m: f32,
    /// For how long the pilot has pushed, relays have waited, and nothing has happened, s.
    since_s: f32,
    stood_s: f32,
    grounded: usize,
}

impl Push {
    pub(super) fn of(scenario: &Scenario) -> Self {
        Self {
            scenario: scenario.clone(),
            best_m: 0.0,
            since_s: 0.0,
            stood_s: 0.0,
            grounded: usize::MAX,
        }
    }

    /// For how long the head stood, s.
    pub(super) const fn stood_s(&self) -> f32 {
        self.stood_s
    }

    /// Takes in one round; says whether the head and the relays wait for each other. A head that has
    /// come to `reach` has nothing to wait for.
    pub(super) fn look(
        &mut self,
        mission: &Mission<'_>,
        states: &[State],
        head_m: f32,
        reach: f32,
    ) -> bool {
        let waiting = states.iter().enumerate();
        let waiting = waiting.filter(|(drone, state)| waits(&self.scenario, *drone, state)).count();
        let called = waiting < self.grounded;
        self.grounded = waiting;
        let stick = match mission.task() {
            Order::Explore(course) => course.speed.0,
            _ => 0.0,
        };
        if stick < 0.0 {
            self.best_m = self.best_m.min(head_m);
        }
        let advances = head_m > self.best_m + ADVANCED_M;
        if advances {
            self.best_m = head_m;
        }
        let leads = matches!(states.first(), Some(State::OnMission(_)));
        let is_there = head_m.max(self.best_m) >= reach;
        if called || advances || waiting == 0 || !leads || is_there || stick < 0.0 {
            self.since_s = 0.0;
            return false;
        }
        if stick > 0.0 {
            self.since_s += ROUND_S;
            self.stood_s += if self.since_s > STANDS_S { ROUND_S } else { 0.0 };
        }
        self.since_s > self.comes_in_s(head_m)
    }

    /// The time that a relay needs to come to a head here, s.
    fn comes_in_s(&self, head_m: f32) -> f32 {
        let agent = &self.scenario.agent;
        let climb = agent.flight.height.0 / agent.flight.climb.0;
        agent.launch.arm_delay.as_secs_f32()
            + agent.launch.patience.as_secs_f32()
            + climb
            + agent.flight.settle.as_secs_f32()
            + head_m / agent.flight.return_speed.0
    }
}
