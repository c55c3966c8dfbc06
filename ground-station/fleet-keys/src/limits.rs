//! Checks the limits of links that a page is to bring to a drone, as the drone itself does.

use agent::AgentConfig;
use input::InputError;
use storage::settings::Limits;
use units::Dbm;

/// Refuses what is no limit, and two that do not fit each other.
pub(super) fn check([launch, retreat]: [Dbm; 2]) -> Result<(), InputError> {
    let [weakest, strongest] = Limits::RANGE;
    let is_limit = |limit: &Dbm| limit.0 >= weakest.0 && limit.0 <= strongest.0;
    let given = format!("--limits {},{}", launch.0, retreat.0);
    if ![launch, retreat].iter().all(is_limit) {
        let remedy = format!("give two from {} to {}", weakest.0, strongest);
        return Err(InputError::new(format!("{given} is out of range"), remedy));
    }
    AgentConfig::DEFAULT.with_limits(Some(launch), Some(retreat)).check().map_err(|_| {
        let wrong = format!("{given}: the two do not fit each other");
        InputError::new(wrong, "give a launch limit that is at least 1 dB above the retreat limit")
    })
}
