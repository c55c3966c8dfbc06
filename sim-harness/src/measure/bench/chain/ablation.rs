//! The policy `chain` with one ingredient removed at a time.
//!
//! Each variant is the policy's own constants with some of them changed, so that an ingredient that
//! no constant switches off is not among them: the memory of steps, the strengths that the other
//! end of a link measures, and the feed-forward of the head's velocity.

use chain::chain_wide::Caution;
use chain::filter::Smoothing;
use chain::policy::{PolicyConfig, SpeedLaw};
use units::{Db, Metres};

/// A variant of the policy.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// The ingredient that is removed.
    pub name: &'static str,
    /// The constants.
    pub config: PolicyConfig,
}

/// The scenarios that the variants fly.
pub const SCENARIOS: [&str; 4] = ["s-turns-5", "zigzag-5", "winding-5", "spiral"];

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
    let mut deaf = filter;
    deaf.noise_weight = 0.0;
    let mut local = law;
    local.gain = 0.0;
    let mut global = law;
    global.local_gain = 0.0;
    let mut rash = law;
    rash.caution = Caution { least: 1.0, down: 1.0, up: 1.0 };
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
        variant("caution", moved(rash)),
        variant("dead zones", moved(restless)),
    ]
}
