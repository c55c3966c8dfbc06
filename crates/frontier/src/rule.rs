//! The rules by which candidates are assigned, with their constants.

use units::{Duration, Metres};

use crate::overlap::Shape;

/// When the leader assigns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Each time after so long.
    Every(Duration),
    /// As soon as a robot has no goal.
    OnEvent,
}

/// How far a candidate is from a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// The straight line, which a leader without maps knows.
    Straight,
    /// The way in the robot's own map, with the turn at its beginning, which the robot tells the
    /// leader as a bid.
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

/// How gain and distance make a utility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Utility {
    /// I·exp(−λ·(d + (n−1)/D)), with the gain I, the distance d, the number n of robots, and the sum
    /// D of the others' distances (thesis, equation of the utility; its text has n/D).
    Exponential {
        /// λ, per metre.
        lambda: f32,
        /// Whether the term (n−1)/D is counted.
        crowd: bool,
    },
    /// −d: the nearest candidate.
    Nearest,
    /// weight·I − d, where I is in square metres.
    Linear {
        /// The weight of a square metre against a metre of way.
        weight: f32,
    },
}

/// How candidates are found that lie in what another robot has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// Robots tell points of their walls; the leader tests candidates against the points of each
    /// other robot.
    Points(Shape),
    /// Each robot that hears of a frontier looks into its own map and says where it knows what lies
    /// beyond.
    Asked,
    /// Robots tell each other nothing, and each chooses for itself.
    Alone,
}

/// Where a robot with a camera looks on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// Ahead on its way: it flies nose first, and turns on the spot before.
    Way,
    /// At the unknown for which it flies, or at the farthest point of its way that it can see: it flies
    /// sideways or backwards over cells that it knows to be free.
    Goal,
}

/// A rule of exploration. Each field can be changed alone, so that its share can be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// When the leader assigns.
    pub pace: Pace,
    /// Whether a robot under way keeps its goal when the leader assigns.
    pub keeps_goals: bool,
    /// The robots' order.
    pub order: Order,
    /// How distances are measured.
    pub distance: Distance,
    /// How gain and distance make a utility.
    pub utility: Utility,
    /// How candidates within another robot's area are found.
    pub overlap: Overlap,
    /// Whether candidates that a robot cannot reach are kept from it.
    pub reachability: bool,
    /// The width σ of the discount of gains around an assigned candidate; `None` for no discount.
    pub discount: Option<Metres>,
    /// The least frontier that counts, in cells that lie together: one that is smaller is no opening
    /// for a robot. An odd number; 1 counts all.
    pub least_frontier: u8,
    /// Where a robot with a camera looks on its way.
    pub facing: Facing,
    /// Whether a goal ends as soon as it is no frontier any more, and not on arrival alone.
    pub ends_when_seen: bool,
    /// Whether the leader stops only when each robot has said that it can reach none of all
    /// candidates.
    pub confirmed_stop: bool,
    /// Whether a robot looks at candidates from afar where no way leads beside any of those that it has
    /// looked for ways to.
    pub looks_from_afar: bool,
    /// How long a candidate that could not be reached is not tried again; zero for not at all.
    pub blacklist: Duration,
}

impl Rule {
    /// Our rule, which the drones follow.
    pub const OURS: Self = OURS;
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

impl RuleEntry {
    /// The rule of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        RULES.iter().find(|entry| entry.name == name)
    }
}

/// The thesis' rule, with the constants of its table 3.1. The reachability that it does not speak of
/// is off.
const THESIS: Rule = Rule {
    pace: Pace::Every(Duration::from_millis(20_000)),
    keeps_goals: false,
    order: Order::ByNumber,
    distance: Distance::Straight,
    utility: Utility::Exponential { lambda: 0.2, crowd: true },
    overlap: Overlap::Points(Shape::Concave),
    reachability: false,
    discount: Some(Metres(3.0)),
    least_frontier: 1,
    facing: Facing::Way,
    ends_when_seen: false,
    confirmed_stop: false,
    looks_from_afar: false,
    blacklist: Duration::ZERO,
};

/// `progress_timeout` of `explore_lite`.
const PROGRESS_TIMEOUT: Duration = Duration::from_millis(30_000);

/// Our rule.
const OURS: Rule = Rule {
    pace: Pace::OnEvent,
    keeps_goals: true,
    order: Order::BestPair,
    distance: Distance::Path,
    // The thesis has .2: with it, and with .4 and more, two robots fly 2 to 5 % more (40 seeds from
    // 100000 on in five plans), which is hardly more than the spread.
    utility: Utility::Exponential { lambda: 0.3, crowd: false },
    overlap: Overlap::Asked,
    reachability: true,
    discount: Some(Metres(3.0)),
    // Our own number: with 1 and 5, two robots need 13 and 6 % more time (6 seeds from 100000 on in
    // five plans), and with 1 a robot in a recorded map flies half as long again until it stops.
    least_frontier: 3,
    facing: Facing::Goal,
    ends_when_seen: true,
    confirmed_stop: true,
    looks_from_afar: true,
    blacklist: PROGRESS_TIMEOUT,
};

/// All rules.
pub const RULES: [RuleEntry; 7] = [
    RuleEntry {
        name: "thesis",
        description: "Each robot in turn takes its best candidate, every 20 s, as printed.",
        rule: THESIS,
    },
    RuleEntry {
        name: "thesis-event",
        description: "The thesis' rule, with an assignment whenever a robot has arrived.",
        rule: Rule { pace: Pace::OnEvent, ..THESIS },
    },
    RuleEntry {
        name: "thesis-reach",
        description: "The thesis' rule every 20 s, without candidates that a robot cannot reach.",
        rule: Rule { reachability: true, blacklist: PROGRESS_TIMEOUT, ..THESIS },
    },
    RuleEntry {
        name: "nearest",
        description: "Each robot in turn takes its nearest candidate whenever it has none.",
        rule: Rule {
            order: Order::ByNumber,
            utility: Utility::Nearest,
            discount: None,
            facing: Facing::Way,
            looks_from_afar: false,
            ..OURS
        },
    },
    RuleEntry {
        name: "greedy-pair",
        description: "The pair of the best revenue first, as rrt_exploration's assigner.",
        rule: Rule {
            distance: Distance::Straight,
            // `info_multiplier` 3; `info_radius` 1 m is the reach of the discount.
            utility: Utility::Linear { weight: 3.0 },
            discount: Some(Metres(1.0)),
            facing: Facing::Way,
            looks_from_afar: false,
            ..OURS
        },
    },
    RuleEntry {
        name: "explore-lite",
        description: "Each robot for itself: gain minus three times the way, as explore_lite.",
        rule: Rule {
            // `potential_scale` 3 and `gain_scale` 1.
            utility: Utility::Linear { weight: 1.0 / 3.0 },
            overlap: Overlap::Alone,
            discount: None,
            // `min_frontier_size` 0.75 m.
            least_frontier: 7,
            facing: Facing::Way,
            confirmed_stop: false,
            looks_from_afar: false,
            ..OURS
        },
    },
    RuleEntry {
        name: "ours",
        description: "The best pair first, by the way's length, as soon as a robot has no goal.",
        rule: OURS,
    },
];
