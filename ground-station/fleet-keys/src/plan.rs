//! The plan of a swarm's mission, as a drone stores it.

use agent::SwarmConfig;
use onboard::Config;
use storage::Record;
use storage::settings::{Settings, SwarmPlan};
use units::Radians;

/// Returns the plan that a drone has to store to fly this swarm's mission; `None` where no stored plan
/// makes it fly just that.
#[must_use]
pub fn stored_plan(swarm: &SwarmConfig) -> Option<SwarmPlan> {
    let SwarmConfig { drones, corner, area, passage, both, .. } = *swarm;
    let plan = SwarmPlan {
        drones: u8::try_from(drones).ok()?,
        corner,
        area,
        entrance: passage.entrance,
        width: passage.width,
        direction: Radians(libm::atan2f(passage.way.y, passage.way.x)),
        length: passage.length,
        both,
    };
    let settings = Settings { swarm: Some(plan), ..Settings::DEFAULT };
    let (stored, _) = settings.encode(1).and_then(|bytes| Settings::decode(&bytes)).ok()?;
    let flown = Config::DEFAULT.with_settings(&stored, |_| {}).agent.swarm;
    (flown == *swarm).then_some(plan)
}
