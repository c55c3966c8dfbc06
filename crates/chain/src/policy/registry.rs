//! The registry of movement policies: scenarios, the command line, the replay, benchmarks, a
//! drone's settings and the firmware all choose a policy from this table.

use units::PolicyCode;

use super::PolicyConfig;

/// A movement policy with its names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// The name by which a user chooses the policy.
    pub name: &'static str,
    /// The code that stands for the policy in a drone's settings. It is never given to another
    /// policy, even after this one is removed.
    pub code: PolicyCode,
    /// The constants of the policy and of its filter.
    pub config: PolicyConfig,
    /// One line that describes the policy.
    pub summary: &'static str,
}

/// Every movement policy.
pub static REGISTRY: [Policy; 6] = [
    Policy {
        name: "t0",
        code: const { PolicyCode::new(1).unwrap() },
        config: PolicyConfig::T0,
        summary: "the paper's T0: compares the last packets and always moves",
    },
    Policy {
        name: "t5",
        code: const { PolicyCode::new(2).unwrap() },
        config: PolicyConfig::T5,
        summary: "the paper's T5: as t0, and hovers while the links differ by at most 5 dB",
    },
    Policy {
        name: "k",
        code: const { PolicyCode::new(3).unwrap() },
        config: PolicyConfig::K,
        summary: "the paper's K: as t0, and compares links that a Kalman filter estimates",
    },
    Policy {
        name: "authors",
        code: const { PolicyCode::new(4).unwrap() },
        config: PolicyConfig::AUTHORS,
        summary: "the rule of the authors' published firmware: averaged links, one speed, a dead zone",
    },
    Policy {
        name: "k-tuned",
        code: const { PolicyCode::new(5).unwrap() },
        config: PolicyConfig::K_TUNED,
        summary: "k with a small gain, feed-forward and clearance: stable with lag and at corners",
    },
    Policy {
        name: "chain",
        code: const { PolicyCode::new(6).unwrap() },
        config: PolicyConfig::CHAIN,
        summary: "all links at once by sums in the reports, slopes estimated in flight",
    },
];

/// The names of all policies, in the order of [`REGISTRY`].
pub const NAMES: [&str; REGISTRY.len()] = {
    let mut names = [""; REGISTRY.len()];
    let mut at = 0;
    while at < names.len() {
        names[at] = REGISTRY[at].name;
        at += 1;
    }
    names
};

impl Policy {
    /// The policy with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        REGISTRY.iter().find(|policy| policy.name == name)
    }

    /// The policy that this code of a drone's settings stands for.
    #[must_use]
    pub fn with_code(code: PolicyCode) -> Option<&'static Self> {
        REGISTRY.iter().find(|policy| policy.code == code)
    }
}
