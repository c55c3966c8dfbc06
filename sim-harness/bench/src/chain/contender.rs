//! The policies that are compared: built-in ones, and speed laws of the caller's.

use std::fmt;
use std::sync::Arc;

use chain::policy::NAMES;
use input::{InputError, suggest};
use mission::{Law, Mission, with_called_law};
use scenario::Scenario;

/// Makes the speed law of the mission of a seed.
pub type MakeLaw = dyn Fn(u64) -> Box<Law> + Send + Sync;

/// A policy that takes part in a comparison.
#[derive(Clone)]
pub enum Contender {
    /// A built-in one, by its name.
    BuiltIn(&'static str),
    /// A speed law of the caller's. The filter, the clearance and the largest speed are those of each
    /// scenario's own policy.
    Called {
        /// The name of its rows.
        name: String,
        /// Makes the law.
        law: Arc<MakeLaw>,
    },
}

impl Contender {
    /// The built-in policy of this name.
    ///
    /// # Errors
    /// [`InputError`] where there is none.
    pub fn named(name: &str) -> Result<Self, InputError> {
        let found = NAMES.into_iter().find(|known| *known == name);
        found.map(Self::BuiltIn).ok_or_else(|| unknown(name))
    }

    /// The built-in policies of these names.
    ///
    /// # Errors
    /// [`InputError`] where there is none of a name.
    pub fn all(names: &[String]) -> Result<Vec<Self>, InputError> {
        names.iter().map(|name| Self::named(name)).collect()
    }

    /// The name of its rows.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::BuiltIn(name) => name,
            Self::Called { name, .. } => name,
        }
    }

    /// The same scenario under this policy.
    ///
    /// # Errors
    /// [`InputError`] for a policy that there is not.
    pub(super) fn flies(&self, plain: &Scenario) -> Result<Scenario, InputError> {
        match self {
            Self::BuiltIn(name) => plain.with_policy(name).ok_or_else(|| unknown(name)),
            Self::Called { .. } => Ok(with_called_law(plain)),
        }
    }

    /// A mission of a scenario that [it flies](Self::flies), before its first round.
    pub(super) fn begin<'a>(&self, mission: Mission<'a>, seed: u64) -> Mission<'a> {
        match self {
            Self::BuiltIn(_) => mission,
            Self::Called { law, .. } => mission.by_law(law(seed)),
        }
    }
}

fn unknown(name: &str) -> InputError {
    let wrong = format!("there is no policy \"{name}\"");
    InputError::new(wrong, suggest::one_of(name, &NAMES))
}

impl fmt::Debug for Contender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
