//! Puts a speed law that the caller of the simulator gives in place of the movement policy's, for
//! policies that are written in another language, such as Python.
//!
//! The agents know a plain function, which is the same for all drones of all missions. While a drone
//! has its turn, that function finds the law of the drone's mission in a variable of the thread.

use std::cell::RefCell;

use chain::policy::{CalledLaw, LinkEnd, PolicyConfig, SpeedLaw};
use units::MetresPerSecond;

use super::Mission;
use scenario::Scenario;

/// A speed law: it is given the number of the relay and the ends of its front link and of its back
/// link, and returns the relay's forward velocity.
pub type Law = dyn FnMut(usize, LinkEnd, LinkEnd) -> MetresPerSecond + Send;

thread_local! {
    /// The law of the drone that has its turn, and the drone's number.
    static LAW: RefCell<Option<(usize, Box<Law>)>> = const { RefCell::new(None) };
}

fn call(front: LinkEnd, back: LinkEnd) -> MetresPerSecond {
    // The law may fly a mission of its own.
    let Some((drone, mut law)) = LAW.take() else { return MetresPerSecond::ZERO };
    let speed = law(drone, front, back);
    LAW.set(Some((drone, law)));
    speed
}

/// Carries out a drone's turn with this law.
pub(super) fn with<T>(drone: usize, law: &mut Option<Box<Law>>, turn: impl FnOnce() -> T) -> T {
    let Some(own) = law.take() else { return turn() };
    let before = LAW.replace(Some((drone, own)));
    let done = turn();
    *law = LAW.replace(before).map(|(_, law)| law);
    done
}

/// The same scenario with the speed law that [`Mission::by_law`] is given. The filter, the clearance and
/// the largest speed are those of its movement policy; where that is chain-wide, those of
/// [`PolicyConfig::K_TUNED`], which is its rule without sums. Drones by a called law report no sums, and
/// with the filter of a chain-wide policy a head comes to rest at the very limit at which a relay would be
/// launched, so that none is.
#[must_use]
pub fn with_called_law(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    if let SpeedLaw::ChainWide(_) = scenario.agent.policy.law {
        scenario.agent.policy = PolicyConfig::K_TUNED.for_loss_at_1m(scenario.assumed_loss_at_1m);
    }
    scenario.agent.policy.law = SpeedLaw::Called(CalledLaw(call));
    scenario
}

impl Mission<'_> {
    /// This mission with a speed law that the caller gives, of a scenario
    /// [with a called law](with_called_law).
    #[must_use]
    pub fn by_law(self, law: Box<Law>) -> Self {
        Self { law: Some(law), ..self }
    }
}
