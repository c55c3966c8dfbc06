//! The policy `chain` with one ingredient removed at a time: the policy's own constants with some of
//! them changed.

use chain::chain_wide::Caution;
use chain::filter::{Smoothing, Wandering};
use chain::policy::{PolicyConfig, SpeedLaw};
use units::{Db, Metres, MetresPerSecond};

/// A variant of the policy.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// The ingredient that is removed.
    pub name: &'static str,
    /// The constants.
    pub config: PolicyConfig,
}

/// The scenarios that the variants fly.
pub const SCENARIOS: [&str; 6] =
    ["s-turns-5", "zigzag-5", "winding-5", "spiral", "zigzag-5-step", "tracking-n15"];

/// The whole policy, and then the policy without each ingredient.
#[must_use]
pub fn variants() -> Vec<Variant> {
    let whole = PolicyConfig::CHAIN;
    let Smoothing::Slopes(filter) = whole.smoothing else { return Vec::new() };
    let SpeedLaw::ChainWide(law) = whole.law else { return Vec::new() };
    let filtered = |filter| PolicyConfig { smoothing: Smoothing::Slopes(filter), ..whole };
    let moved = |law| PolicyConfig { law: SpeedLaw::ChainWide(law), ..whole };
    let mut certain = filter;
    // Without doubt about the slopes they stay those of the law at the first packet.
    (certain.prior_doubt, certain.bending) = (0.0, 0.0);
    let mut rigid = filter;
    (rigid.motion_doubt, rigid.way_variance) = (0.0, 0.0);
    // The noise of the simulator's radio.
    let mut deaf = filter;
    (deaf.noise, deaf.noise_at_first) = ([3.0, 3.0], 3.0);
    let mut steady = filter;
    steady.wandering = Wandering { at_first: 1.0, most: 1.0, ..filter.wandering };
    let mut forgetful = filter;
    forgetful.least_step = Db(f32::INFINITY);
    let mut one_sided = filter;
    one_sided.hears_both_ends = false;
    let mut local = law;
    local.gain = 0.0;
    let mut global = law;
    global.local_gain = 0.0;
    let mut late = law;
    late.follow = 0.0;
    let mut rash = law;
    rash.caution = Caution { least: 1.0, down: 1.0, up: 1.0, ..law.caution };
    let mut unmoved = law;
    unmoved.caution.whole_gain_from = MetresPerSecond(f32::INFINITY);
    let mut restless = law;
    (restless.tolerance, restless.near) = (Db(0.0), Metres(0.0));
    let variant = |name, config| Variant { name, config };
    vec![
        variant("whole", whole),
        variant("way to its place", moved(local)),
        variant("own imbalance", moved(global)),
        variant("slope estimation", filtered(certain)),
        variant("noise of motion", filtered(rigid)),
        variant("learned noise", filtered(deaf)),
        variant("learned wandering", filtered(steady)),
        variant("memory of steps", filtered(forgetful)),
        variant("strengths at the other end", filtered(one_sided)),
        variant("head's velocity", moved(late)),
        variant("caution", moved(rash)),
        variant("whole gain under way", moved(unmoved)),
        variant("dead zones", moved(restless)),
    ]
}
