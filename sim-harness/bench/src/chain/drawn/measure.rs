//! Flies the chain in places drawn at random: each seed draws a place, a radio, limits and a
//! pilot, and an [oracle](measure::oracle) says what can be reached there.

use input::InputError;
use rayon::prelude::*;

use super::drawing::Drawn;
use super::flown::{self, Flown};
use crate::chain::Contender;
use scenario::Fidelity;

/// What to fly.
#[derive(Clone, Debug)]
pub struct Choice {
    /// How many places.
    pub places: usize,
    /// The first seed.
    pub seed: u64,
    /// How closely the drones are simulated.
    pub fidelity: Fidelity,
    /// The policies.
    pub policies: Vec<Contender>,
}

/// One drawn place and how each policy flew there.
pub struct Row {
    /// The seed.
    pub seed: u64,
    /// The scenario as a file.
    pub text: String,
    /// By policy, in the order of [`Choice::policies`].
    pub flown: Vec<Flown>,
}

/// Draws the places and flies every policy in them.
///
/// # Errors
/// That of `after_each`, which is called after each mission.
pub fn run(
    choice: &Choice,
    after_each: impl Fn() -> Result<(), InputError> + Sync,
) -> Result<Vec<Row>, InputError> {
    let seeds = (0..choice.places as u64).into_par_iter().map(|n| choice.seed.wrapping_add(n));
    let rows = seeds.map(|seed| {
        let drawn = Drawn::of(seed, choice.fidelity)?;
        let fly = |policy: &Contender| {
            let flown = flown::fly(&drawn, policy)?;
            after_each()?;
            Ok(flown)
        };
        let flown: Result<Vec<_>, InputError> = choice.policies.iter().map(fly).collect();
        Ok(Row { seed, flown: flown?, text: drawn.text })
    });
    rows.collect()
}
