//! Sends the head of a mission as deep as is asked for, with the time that this takes.

use input::InputError;
use units::Order;

use crate::{PilotStep, Scenario, as_in_a_file};

/// An exploration may take this much longer than the pilot's speed allows. Our own bound.
pub const SLOWER: f32 = 1.5;
/// The time until a relay that is needed takes off, s: it is armed for 3 s, and links must have been
/// too weak for 2 s ([`LaunchConfig::WHEN_SETTLED`](chain::launch::LaunchConfig)).
const HELD_S: f32 = 5.0;
/// The time after the last drone's way home, s. Our own number.
const AFTER_S: f32 = 60.0;

impl Scenario {
    /// The time until a relay that is needed is up, s.
    pub fn call_s(&self) -> f32 {
        HELD_S + self.agent.flight.rise_s()
    }

    /// Lets the pilot fly the head this far from the base, by its odometer, with as much time as it
    /// needs for that, and so much longer for the way home.
    ///
    /// # Errors
    /// [`InputError`] where no order sends the head forward and another one ends that.
    pub fn explore_to(&mut self, depth_m: f32) -> Result<(), InputError> {
        let speed = |step: &PilotStep| match step.task {
            Order::Explore(course) => course.speed.0,
            _ => 0.0,
        };
        let push = self.pilot.iter().position(|step| speed(step) > 0.0);
        let Some((n, next)) = push.and_then(|n| Some((n, *self.pilot.get(n + 1)?))) else {
            let wrong = "--depth is for a mission whose pilot sends the head forward, and stops it";
            return Err(InputError::new(wrong, "leave it out, or name another scenario"));
        };
        let out_s =
            SLOWER * depth_m / speed(&self.pilot[n]) + self.call_s() * self.drones.relays as f32;
        let stops_us = self.pilot[n].at_us + (1e6 * out_s) as u64;
        for step in self.pilot.iter_mut().skip(n + 1) {
            step.at_us = as_in_a_file(stops_us + (step.at_us - next.at_us));
        }
        let home_s = SLOWER * depth_m / self.agent.flight.return_speed.0 + AFTER_S;
        let last_us = self.pilot.last().map_or(0, |step| step.at_us);
        self.duration_us = self.duration_us.max(as_in_a_file(last_us + (1e6 * home_s) as u64));
        self.depth_m = Some(depth_m);
        Ok(())
    }
}
