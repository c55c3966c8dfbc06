//! Defines a drone's constants, and changes them by the settings that the drone has stored.

use agent::{AgentConfig, ConfigError, SwarmConfig};
use airlink::LinkConfig;
use chain::policy::Policy;
use storage::settings::{Limits, Settings, SwarmPlan};
use units::{Duration, Point2, PolicyCode};

/// The constants of a drone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The constants of the agent.
    pub agent: AgentConfig,
    /// The constants of the radio link.
    pub link: LinkConfig,
    /// The time that reports and orders stay in the mailbox before the agent may take them. It is
    /// zero in the firmware; the simulator uses it to study delays.
    pub mailbox_delay: Duration,
}

impl Config {
    /// The default constants of the firmware.
    pub const DEFAULT: Self = Self {
        agent: AgentConfig::DEFAULT,
        link: LinkConfig::DEFAULT,
        mailbox_delay: Duration::ZERO,
    };

    /// Returns these constants with the settings that the drone has stored. `complain` is called
    /// for each setting that cannot be used; the constant is used in its place.
    #[must_use]
    pub fn with_settings(
        mut self,
        settings: &Settings,
        mut complain: impl FnMut(Unusable),
    ) -> Self {
        if let Some(height) = settings.height {
            self.agent.flight.height = height;
        }
        match settings.policy.map(|code| (code, Policy::with_code(code))) {
            None => {}
            Some((_, Some(policy))) => self.agent.policy = policy.config,
            Some((code, None)) => complain(Unusable::Policy(code)),
        }
        if let Some(plan) = &settings.swarm {
            self.agent.swarm = with_plan(self.agent.swarm, plan);
        }
        self.agent.flight.keeps_way_home &= !settings.fetched;
        let Limits { launch, retreat } = settings.limits;
        let limited = self.agent.with_limits(launch, retreat);
        match limited.check() {
            Ok(()) => self.agent = limited,
            Err(why) => complain(Unusable::Limits(why)),
        }
        self
    }
}

/// The constants of a swarm, with the plan that a drone has stored.
fn with_plan(mut swarm: SwarmConfig, plan: &SwarmPlan) -> SwarmConfig {
    let (sin, cos) = plan.direction.sin_cos();
    swarm.passage.entrance = plan.entrance;
    swarm.passage.width = plan.width;
    swarm.passage.way = Point2::new(cos, sin);
    swarm.passage.length = plan.length;
    let SwarmPlan { drones, corner, area, both, .. } = *plan;
    SwarmConfig { drones: drones.into(), corner, area, both, ..swarm }
}

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unusable {
    /// The limits contradict each other.
    Limits(ConfigError),
    /// There is no movement policy of this code.
    Policy(PolicyCode),
}

impl Default for Config {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drones_that_are_fetched_keep_no_charge_for_the_way_home() {
        for fetched in [false, true] {
            let settings = Settings { fetched, ..Settings::DEFAULT };
            let config = Config::DEFAULT.with_settings(&settings, |_| {});
            assert_eq!(config.agent.flight.keeps_way_home, !fetched);
        }
    }
}
