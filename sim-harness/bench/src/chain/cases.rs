//! The scenarios of the benchmark, the figures that matter in each, and the targets.

use scenario::Fidelity;

/// One scenario of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// The name of the row.
    pub name: &'static str,
    /// The built-in scenario.
    pub scenario: &'static str,
    /// Whether the operator calls the drones home at a moment that is another one in each run.
    pub is_recalled: bool,
    /// When the operator lets the chain hold and when the drones are called home, s, where that is
    /// not when the scenario says.
    pub holds_s: Option<[u64; 2]>,
    /// Whether all policies fly it unless others are asked for, and not only [`COMPARED`].
    pub is_for_all: bool,
    /// The figures of its rows, in their order.
    pub figures: &'static [&'static str],
    /// The values that the policy `chain` is to reach.
    pub targets: &'static [Target],
}

/// The policies that fly a scenario that is not for all.
pub const COMPARED: [&str; 2] = ["k-tuned", "chain"];

/// A value that a figure is to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The figure's name.
    pub figure: &'static str,
    /// The bound of its value.
    pub bound: Bound,
}

/// A bound of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The figure is to be no larger.
    Most(f64),
    /// The figure is to be no smaller.
    Least(f64),
}

impl Bound {
    /// Whether a value is within the bound; an infinite one, `None`, is not.
    #[must_use]
    pub fn is_met_by(self, value: Option<f64>) -> bool {
        value.is_some_and(|value| match self {
            Self::Most(most) => value <= most,
            Self::Least(least) => value >= least,
        })
    }
}

const fn most(figure: &'static str, bound: f64) -> Target {
    Target { figure, bound: Bound::Most(bound) }
}

const fn least(figure: &'static str, bound: f64) -> Target {
    Target { figure, bound: Bound::Least(bound) }
}

/// The head rests in the air from the beginning: how equal, how fast, how calm.
const EQUAL: &[&str] = &[
    "c3",
    "c1",
    "t3_median_s",
    "gap_db",
    "difference_db",
    "swing_p95_db",
    "position_sd_m",
    "touched",
    "order_lost",
];
/// The same for chains of any length: how long, beside what distance alone takes.
const LENGTH: &[&str] = &[
    "c_gap1",
    "t_gap1_median_s",
    "t_gap1_over_bound",
    "gap_db",
    "swing_p95_db",
    "position_sd_m",
    "touched",
    "order_lost",
];
/// The head flies on and on.
const CRUISE: &[&str] = &["cruise_gap_db", "gap_db", "touched", "order_lost"];
/// Relays are launched, and the head rests at the end.
const LAUNCH: &[&str] = &[
    "c3",
    "gap_db",
    "swing_p95_db",
    "position_sd_m",
    "violation",
    "hold_violation",
    "launched",
    "needed",
    "false_launch",
    "relays_beyond_need",
    "farthest_m",
    "t_farthest_median_s",
    "touched",
    "order_lost",
];
/// A relay is lost.
const REPAIR: &[&str] = &[
    "c_repair",
    "t_repair_median_s",
    "t_repair_p95_s",
    "gap_db",
    "all_down",
    "touched",
    "order_lost",
];
/// Equal links are not the best ones.
const STUCK: &[&str] = &["stuck", "gap_db", "difference_db", "touched", "order_lost"];
/// A whole mission that is too short for a chain to settle.
const WHOLE: &[&str] =
    &["launched", "needed", "farthest_m", "violation", "all_down", "touched", "order_lost"];
/// The drones are called home.
const RECALL: &[&str] = &["all_down", "touched", "order_lost"];

const CALM: [Target; 4] = [
    most("swing_p95_db", 2.0),
    most("position_sd_m", 0.02),
    most("touched", 0.0),
    most("order_lost", 0.0),
];
const SAFE: [Target; 2] = [CALM[2], CALM[3]];

/// Continuous losses, five links.
const CONTINUOUS: &[Target] =
    &[least("c3", 1.0), least("c1", 0.99), most("gap_db", 0.3), CALM[0], CALM[1], CALM[2], CALM[3]];
/// Losses that jump by the wall.
const STEPS: &[Target] = &[most("gap_db", 1.0), CALM[0], CALM[1], CALM[2], CALM[3]];
const SPIRAL: &[Target] =
    &[least("c3", 1.0), most("gap_db", 3.0), CALM[0], CALM[1], CALM[2], CALM[3]];
const DEMO: &[Target] = &[
    least("c3", 1.0),
    most("gap_db", 3.0),
    CALM[0],
    CALM[1],
    most("violation", 0.10),
    CALM[2],
    CALM[3],
];
const CIRCUIT: &[Target] = &[CALM[0], CALM[1], most("violation", 0.01), CALM[2], CALM[3]];
const PAPER: &[Target] = &[most("violation", 0.08), most("false_launch", 0.0), SAFE[0], SAFE[1]];
const CLUMPED: &[Target] = &[most("t_gap1_over_bound", 1.1), CALM[0], CALM[1], CALM[2], CALM[3]];
const RANDOM: &[Target] = &[most("t_gap1_over_bound", 1.2), CALM[0], CALM[1], CALM[2], CALM[3]];
const LOSSY: &[Target] = &[most("t_gap1_over_bound", 1.4), CALM[0], CALM[1], CALM[2], CALM[3]];
const TRACKING: &[Target] = &[most("cruise_gap_db", 0.6), SAFE[0], SAFE[1]];
/// The head needs 525 s for 105 m.
const MEANDER: &[Target] = &[
    most("violation", 0.10),
    most("launched", 14.0),
    least("farthest_m", 104.0),
    most("t_farthest_median_s", 1.5 * 525.0),
    SAFE[0],
    SAFE[1],
];
const LEAKY: &[Target] = &[most("stuck", 0.02), SAFE[0], SAFE[1]];
const REPAIR_6: &[Target] =
    &[least("c_repair", 1.0), most("t_repair_median_s", 10.0), SAFE[0], SAFE[1]];
const REPAIR_CORNERS: &[Target] =
    &[least("c_repair", 1.0), most("t_repair_median_s", 18.0), SAFE[0], SAFE[1]];
const REPAIR_15: &[Target] =
    &[least("c_repair", 1.0), most("t_repair_median_s", 30.0), SAFE[0], SAFE[1]];
const CUT: &[Target] = &[least("c_repair", 1.0), least("all_down", 1.0), SAFE[0], SAFE[1]];
const HOP: &[Target] = &[least("launched", 1.0), least("all_down", 1.0), SAFE[0], SAFE[1]];
const RECALLED: &[Target] = &[least("all_down", 1.0), SAFE[0], SAFE[1]];

const fn case(
    scenario: &'static str,
    figures: &'static [&'static str],
    targets: &'static [Target],
) -> Case {
    Case {
        name: scenario,
        scenario,
        is_recalled: false,
        holds_s: None,
        is_for_all: false,
        figures,
        targets,
    }
}

const fn for_all(scenario: &'static str, targets: &'static [Target]) -> Case {
    Case { is_for_all: true, ..case(scenario, EQUAL, targets) }
}

/// The cases at a fidelity, in the order of the table.
#[must_use]
pub const fn at(fidelity: Fidelity) -> &'static [Case] {
    match fidelity {
        Fidelity::Point => &CASES,
        Fidelity::Flight => &FLOWN,
        Fidelity::Virtual => &EMULATED,
    }
}

/// The cases that rigid bodies fly. In the demonstration their batteries call them home before it
/// lets the chain hold, so it holds earlier.
const FLOWN: [Case; 6] = [
    case("s-turns-5", EQUAL, CONTINUOUS),
    case("zigzag-5", EQUAL, CONTINUOUS),
    case("winding-5", EQUAL, CONTINUOUS),
    case("right-angles", EQUAL, CONTINUOUS),
    Case { holds_s: Some([110, 170]), ..case("demo", LAUNCH, DEMO) },
    case("paper-circuit", LAUNCH, CIRCUIT),
];

/// The case that virtual drones fly: they start on the ground, and a second of one takes seconds.
const EMULATED: [Case; 1] = [case("short-hop", WHOLE, HOP)];

/// The cases at point level.
const CASES: [Case; 26] = [
    for_all("s-turns-5", CONTINUOUS),
    for_all("zigzag-5", CONTINUOUS),
    for_all("winding-5", CONTINUOUS),
    for_all("s-turns-5-step", STEPS),
    for_all("zigzag-5-step", STEPS),
    for_all("winding-5-step", STEPS),
    case("right-angles", EQUAL, CONTINUOUS),
    case("spiral", EQUAL, SPIRAL),
    case("demo", LAUNCH, DEMO),
    case("paper-circuit", LAUNCH, CIRCUIT),
    case("paper-z10", LAUNCH, PAPER),
    case("paper-u10", LAUNCH, PAPER),
    case("paper-wave10", LAUNCH, PAPER),
    case("straight-n4", LENGTH, CLUMPED),
    case("straight-n8", LENGTH, CLUMPED),
    case("straight-n15", LENGTH, CLUMPED),
    case("random-n15", LENGTH, RANDOM),
    case("loss-70-n15", LENGTH, LOSSY),
    case("tracking-n15", CRUISE, TRACKING),
    case("meander-105", LAUNCH, MEANDER),
    case("leaky-u", STUCK, LEAKY),
    case("repair-6", REPAIR, REPAIR_6),
    case("repair-corners", REPAIR, REPAIR_CORNERS),
    case("repair-15", REPAIR, REPAIR_15),
    case("cut", REPAIR, CUT),
    Case { name: "recall", is_recalled: true, ..case("demo", RECALL, RECALLED) },
];
