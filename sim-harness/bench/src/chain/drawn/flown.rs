//! Tells how one mission in a drawn place went, and what went wrong first.

mod observer;
mod push;
mod rest;

use serde_json::{Value, json};

pub use observer::fly;
pub(crate) use observer::{Case, Observer};

/// A head is deep enough that comes to this part of the oracle's depth: our own bound.
pub const DEEP: f32 = 0.95;
/// It is quick enough within so many times the oracle's time: our own bound.
pub const QUICK: f32 = 1.5;
/// A chain is strong enough whose weakest link is below the limit for no larger part of the
/// exploration: our own bound.
pub const WEAK: f32 = 0.05;
/// Drones that have landed stand apart from this distance on, m: our own bound.
const APART_M: f32 = 0.25;
/// What went wrong, in the order in which causes at the same moment count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// A drone touched a wall.
    Wall,
    /// Two drones touched in the air.
    Drones,
    /// Two drones changed places.
    Order,
    /// The pilot pushed, relays waited, the head stood, and none was called.
    Deadlock,
    /// A drone landed because the base's side stayed silent.
    LinkLost,
    /// A drone was brought down, or never came up.
    BroughtDown,
    /// The head did not come as far as it could.
    Short,
    /// The head came there late.
    Late,
    /// A link was below the limit for too long.
    Weak,
    /// A drone flew when the mission ended.
    Flying,
    /// A drone came down away from home.
    Inside,
    /// Two drones ended on the ground in one another's place.
    Together,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 12] = [
        Self::Wall,
        Self::Drones,
        Self::Order,
        Self::Deadlock,
        Self::LinkLost,
        Self::BroughtDown,
        Self::Short,
        Self::Late,
        Self::Weak,
        Self::Flying,
        Self::Inside,
        Self::Together,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wall => "wall-touched",
            Self::Drones => "drones-touched",
            Self::Order => "order-lost",
            Self::Deadlock => "deadlock",
            Self::LinkLost => "landed-link-lost",
            Self::BroughtDown => "brought-down",
            Self::Short => "short",
            Self::Late => "late",
            Self::Weak => "weak-links",
            Self::Flying => "still-flying",
            Self::Inside => "left-inside",
            Self::Together => "not-apart",
        }
    }
}

/// A drone that is not at home at the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Left {
    /// The drone's number.
    pub drone: usize,
    /// How far from the base it is, m along the way.
    pub way_m: f32,
    /// Its last state, or why it landed.
    pub why: String,
}

/// How a policy flew in a drawn place.
#[derive(Clone, Debug)]
pub struct Flown {
    /// The seed.
    pub seed: u64,
    /// The policy.
    pub policy: String,
    /// Where the head's way ends by the oracle, and when it is there, m and s.
    pub oracle_m: f32,
    /// When the oracle's head is at 95 % of its depth, s since the first order.
    pub oracle_s: f32,
    /// Why the oracle's head got no farther.
    pub ended: &'static str,
    /// The relays that there are, and the least with which the oracle's head gets there.
    pub relays: [usize; 2],
    /// How far the head came along the way, m.
    pub depth_m: f32,
    /// When the head was at 95 % of the oracle's depth, s since the first order; infinite if it
    /// never was.
    pub deep_s: f32,
    /// How many relays took off.
    pub launched: usize,
    /// For how long the pilot pushed, relays waited, and the head stood, s.
    pub stood_s: f32,
    /// How often a drone touched a wall.
    pub walls: u32,
    /// How often two drones touched in the air.
    pub drones: u32,
    /// The rounds in which two drones had changed places.
    pub disordered: u32,
    /// The part of the exploration in which a link was below the limit.
    pub weak: f32,
    /// Relays in the chain at the end of the hold, less those that its head's place takes.
    pub surplus: Option<i32>,
    /// What a relay flew in the hold, mean, m.
    pub rest_m: f32,
    /// By how much a link swings in the hold within 10 s, 95 % of the time, dB.
    pub swing_db: f32,
    /// The drones that are not at home at the end.
    pub left: Vec<Left>,
    /// The least distance between two drones that flew and are down, m.
    pub closest_m: f32,
    /// Whether the head came farther than the oracle's, or was there earlier, without a link below the
    /// limit: the oracle is wrong then.
    pub beats_oracle: bool,
    /// What went wrong, and when, s; the first first.
    pub wrong: Vec<(f32, Cause)>,
}

impl Flown {
    /// Whether the head came as far as the oracle's.
    #[must_use]
    pub fn is_deep(&self) -> bool {
        self.deep_s.is_finite()
    }

    /// Whether it did, in time.
    #[must_use]
    pub fn is_quick(&self) -> bool {
        self.deep_s <= QUICK * self.oracle_s
    }

    /// Whether this went wrong.
    #[must_use]
    pub fn has(&self, cause: Cause) -> bool {
        self.wrong.iter().any(|(_, wrong)| *wrong == cause)
    }

    /// Whether all drones came home by themselves and stand apart.
    #[must_use]
    pub fn is_home(&self) -> bool {
        self.left.is_empty() && self.closest_m >= APART_M
    }

    /// What went wrong first.
    #[must_use]
    pub fn first_wrong(&self) -> Option<(f32, Cause)> {
        self.wrong.first().copied()
    }

    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let number = |value: f32| {
            if value.is_finite() {
                json!((f64::from(value) * 1e3).round() / 1e3)
            } else {
                Value::Null
            }
        };
        let left = self.left.iter().map(
            |left| json!({ "drone": left.drone, "way_m": number(left.way_m), "why": left.why }),
        );
        let wrong = self
            .wrong
            .iter()
            .map(|(at, cause)| json!({ "at_s": number(*at), "what": cause.name() }));
        json!({
            "seed": self.seed,
            "policy": self.policy,
            "relays": self.relays[0],
            "least_relays": self.relays[1],
            "oracle_m": number(self.oracle_m),
            "oracle_t95_s": number(self.oracle_s),
            "oracle_ended": self.ended,
            "depth_m": number(self.depth_m),
            "depth_ratio": number(self.depth_m / self.oracle_m),
            "t95_s": number(self.deep_s),
            "time_ratio": number(self.deep_s / self.oracle_s),
            "launched": self.launched,
            "stood_s": number(self.stood_s),
            "wall_contacts": self.walls,
            "drone_contacts": self.drones,
            "order_lost": self.disordered,
            "below_limit": number(self.weak),
            "relays_beyond_need": self.surplus,
            "rest_m": number(self.rest_m),
            "swing_p95_db": number(self.swing_db),
            "left": left.collect::<Vec<_>>(),
            "closest_m": number(self.closest_m),
            "beats_oracle": self.beats_oracle,
            "wrong": wrong.collect::<Vec<_>>(),
        })
    }
}
