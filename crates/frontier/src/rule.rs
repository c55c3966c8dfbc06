//! The rules by which candidates are assigned, with their constants.

use units::{Duration, Metres};

/// How far a candidate is from a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// The straight line, which a leader without maps knows.
    Straight,
    /// The way that the robot itself has found, and has told the leader.
    Path,
}

/// In which order robots get their candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// One robot after the other, by number (thesis, algorithm 5).
    ByNumber,
    /// The pair of robot and candidate with the largest utility first.
    BestPair,
}

/// A rule of assignment. Each field can be changed alone, so that its share can be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// The time between two assignments.
    pub period: Duration,
    /// Whether a robot that has arrived, or cannot arrive, causes an assignment at once.
    pub on_event: bool,
    /// The robots' order.
    pub order: Order,
    /// How distances are measured.
    pub distance: Distance,
    /// Whether candidates that a robot cannot reach are kept from it.
    pub reachability: bool,
    /// Whether the gain of candidates near an assigned one is discounted.
    pub discount: bool,
    /// The weight of distance against gain, λ, per metre. An infinite weight takes the nearest.
    pub lambda: f32,
    /// The width of the discount, σ.
    pub sigma: Metres,
    /// Whether the leader stops only after a round in which each robot says that it has none left.
    pub confirmed_stop: bool,
    /// How long a candidate that could not be reached is not assigned again; zero for not at all.
    pub blacklist: Duration,
}

/// A rule with its name.
#[derive(Clone, Copy, Debug)]
pub struct RuleEntry {
    /// The name.
    pub name: &'static str,
    /// What the rule does, in one sentence.
    pub description: &'static str,
    /// The constants.
    pub rule: Rule,
}

/// The thesis' rule, with the constants of its table 3.1. The reachability that it does not speak of
/// is off.
const THESIS: Rule = Rule {
    period: Duration::from_millis(20_000),
    on_event: false,
    order: Order::ByNumber,
    distance: Distance::Straight,
    reachability: false,
    discount: true,
    lambda: 0.2,
    sigma: Metres(3.0),
    confirmed_stop: false,
    blacklist: Duration::ZERO,
};

/// All rules.
pub const RULES: [RuleEntry; 5] = [
    RuleEntry {
        name: "thesis",
        description: "Each robot in turn takes its best candidate, every 20 s, as printed.",
        rule: THESIS,
    },
    RuleEntry {
        name: "thesis-event",
        description: "The thesis' rule, with an assignment whenever a robot has arrived.",
        rule: Rule { on_event: true, ..THESIS },
    },
    RuleEntry {
        name: "thesis-reach",
        description: "The thesis' rule every 20 s, without candidates that a robot cannot reach.",
        rule: Rule {
            reachability: true,
            // The time-out of progress of explore_lite.
            blacklist: Duration::from_millis(30_000),
            ..THESIS
        },
    },
    RuleEntry {
        name: "nearest",
        description: "Each robot in turn takes its nearest candidate whenever one has arrived.",
        rule: Rule {
            on_event: true,
            distance: Distance::Path,
            reachability: true,
            discount: false,
            lambda: f32::INFINITY,
            blacklist: Duration::from_millis(30_000),
            ..THESIS
        },
    },
    RuleEntry {
        name: "ours",
        description: "The best pair first, by the way's length, whenever a robot has arrived.",
        rule: Rule {
            on_event: true,
            order: Order::BestPair,
            distance: Distance::Path,
            reachability: true,
            confirmed_stop: true,
            // The time-out of progress of explore_lite.
            blacklist: Duration::from_millis(30_000),
            ..THESIS
        },
    },
];
