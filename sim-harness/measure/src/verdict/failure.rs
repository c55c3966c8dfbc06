//! The failures of a mission, each with its data.

use std::fmt;

use agent::LandReason;
use flight::Cause;
use units::Branch;

use super::Short;
use mission::trace::Node;

/// One reason why a mission failed. It displays as a line for the operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// Drones touched a wall so many times.
    TouchedWall(u32),
    /// Two flying drones touched so many times.
    TouchedDrone(u32),
    /// A drone, flying or landed, touched one that stood on the ground so many times.
    TouchedStanding(u32),
    /// Two drones stand on each other at the end.
    StandsOn(Standing),
    /// A drone stands in another's place at the end.
    StandsInPlace(Standing),
    /// Neighbours of the chain had changed places in so many rounds.
    OrderLost(u32),
    /// Neighbours of the chain have changed places at the end.
    OutOfOrder,
    /// A drone flies at the end, although it was called down.
    StillFlying(Node),
    /// A drone landed for loss of the base, and was not called home.
    LostBase(Node),
    /// A drone came down on its way home.
    LeftInside {
        /// The drone.
        drone: Node,
        /// The distance from where it took off, m.
        apart_m: f32,
        /// Why it came down.
        why: Down,
    },
    /// The flight code brought a drone down.
    BroughtDown(Node),
    /// A drone never reached its height.
    TakeOffFailed(Node),
    /// A drone restarted by itself.
    Restarted(Node),
    /// A drone landed because it did not know its position.
    PositionLost(Node),
    /// A relay hears no drone in front at the end.
    NoFront(Node),
    /// The head came less far than it could and was ordered to.
    DepthMissed {
        /// The farthest place of the head on the way that was ordered, m from the base.
        came_m: f32,
        /// The place to which it could have come by then, m from the base.
        could_m: f32,
    },
    /// The head took another branch than the one that was ordered.
    BranchMissed {
        /// The branch that was ordered.
        ordered: Branch,
        /// The junction, m from the base.
        at_m: f32,
        /// The gallery into which the head flew.
        gallery: String,
    },
    /// There was no chain in a part of the ordered hold.
    HoldMissed {
        /// The time without a chain, s.
        missing_s: f32,
        /// The ordered hold, s.
        of_s: f32,
    },
    /// The pilot pushed, a relay waited, and the head neither advanced nor was a relay called.
    Stuck {
        /// The place of the head, m from the base.
        at_m: f32,
        /// The time for which it stood, s.
        for_s: f32,
    },
    /// So many drones of a swarm or of explorers did not finish.
    Unfinished(u32),
    /// Explorers have not seen enough of what they can come to.
    Unexplored {
        /// What was found and what was asked.
        found: String,
        /// Why they saw no more.
        why: Short,
    },
    /// A swarm has not flown over enough of its area.
    Uncovered {
        /// What was found and what was asked.
        found: String,
        /// The number of drones that the scenario took away.
        lost: usize,
    },
    /// A criterion of the scenario is not met.
    Criterion {
        /// The metric.
        name: &'static str,
        /// What was found and what was asked.
        found: String,
    },
}

/// A drone that stands at another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// The drone that came there.
    pub drone: Node,
    /// The drone that it stands at.
    pub other: Node,
    /// The distance of their middles, m.
    pub apart_m: f32,
}

/// Why a drone came down before it was home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Down {
    /// Its battery was empty.
    Battery,
    /// It lost its link.
    Link,
    /// It was ordered to land.
    Order,
    /// It took the place for its home.
    Home,
    /// It was no longer needed.
    Retired,
    /// It stayed on its perch.
    Perched,
    /// A fault brought it down.
    Fault,
}

impl Down {
    /// Why a drone came down whose agent says this.
    #[must_use]
    pub const fn of(why: LandReason) -> Self {
        match why {
            LandReason::Unfit(Cause::Battery) => Self::Battery,
            LandReason::LinkLost => Self::Link,
            LandReason::Ordered => Self::Order,
            LandReason::Home | LandReason::Done => Self::Home,
            LandReason::Retired => Self::Retired,
            LandReason::Perched => Self::Perched,
            LandReason::Unfit(_)
            | LandReason::Restarted
            | LandReason::PositionLost
            | LandReason::TakeOffFailed => Self::Fault,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Battery => "its battery was empty",
            Self::Link => "it lost its link",
            Self::Order => "it was ordered to land",
            Self::Home => "it took the place for its home",
            Self::Retired => "it was no longer needed",
            Self::Perched => "it stayed on its perch",
            Self::Fault => "a fault brought it down",
        }
    }
}

impl Failure {
    /// The name under which a campaign counts it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::TouchedWall(_) => "touched-wall",
            Self::TouchedDrone(_) => "touched-drone",
            Self::TouchedStanding(_) => "touched-standing-drone",
            Self::StandsOn(_) => "stands-on-drone",
            Self::StandsInPlace(_) => "stands-in-anothers-place",
            Self::OrderLost(_) => "order-lost",
            Self::OutOfOrder => "out-of-order-at-end",
            Self::StillFlying(_) => "still-flying",
            Self::LostBase(_) => "lost-base",
            Self::LeftInside { why, .. } => match why {
                Down::Battery => "left-inside-battery",
                Down::Link => "left-inside-link",
                Down::Order => "left-inside-order",
                Down::Home => "left-inside-home",
                Down::Retired => "left-inside-retired",
                Down::Perched => "left-inside-perched",
                Down::Fault => "left-inside-fault",
            },
            Self::BroughtDown(_) => "brought-down",
            Self::TakeOffFailed(_) => "take-off-failed",
            Self::Restarted(_) => "restarted",
            Self::PositionLost(_) => "position-lost",
            Self::NoFront(_) => "no-front",
            Self::DepthMissed { .. } => "depth-missed",
            Self::BranchMissed { .. } => "branch-missed",
            Self::HoldMissed { .. } => "hold-missed",
            Self::Stuck { .. } => "stuck",
            Self::Unfinished(_) => "unfinished",
            Self::Unexplored { why, .. } => why.name(),
            Self::Uncovered { .. } => "uncovered",
            Self::Criterion { name: "false_walls", .. } => "false-walls",
            Self::Criterion { name: "false_free", .. } => "false-free",
            Self::Criterion { .. } => "criterion",
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TouchedWall(n) => write!(f, "{n} touches of a wall"),
            Self::TouchedDrone(n) => write!(f, "{n} touches between drones"),
            Self::TouchedStanding(n) => write!(f, "{n} touches of a drone on the ground"),
            Self::StandsOn(Standing { drone, other, apart_m }) => {
                write!(f, "{drone} stands on {other}, {apart_m:.2} m apart")
            }
            Self::StandsInPlace(Standing { drone, other, apart_m }) => {
                write!(f, "{drone} stands in the place of {other}, {apart_m:.2} m apart")
            }
            Self::OrderLost(n) => write!(f, "{n} rounds in which the order of the chain was lost"),
            Self::OutOfOrder => f.write_str("the chain is out of order at the end"),
            Self::StillFlying(drone) => {
                write!(f, "{drone} still flew when the mission ended, although it was ordered down")
            }
            Self::LostBase(drone) => write!(f, "{drone} lost the base, and left its place"),
            Self::LeftInside { drone, apart_m, why } => write!(
                f,
                "{drone} was left inside, {apart_m:.1} m from where it took off: {}",
                why.words()
            ),
            Self::BroughtDown(drone) => write!(f, "{drone} was brought down by a fault"),
            Self::TakeOffFailed(drone) => {
                write!(f, "{drone} landed because it never reached its height")
            }
            Self::Restarted(drone) => write!(f, "{drone} restarted by itself and stays down"),
            Self::PositionLost(drone) => {
                write!(f, "{drone} landed because it did not know its position")
            }
            Self::NoFront(drone) => write!(f, "{drone} heard no drone in front at the end"),
            Self::DepthMissed { came_m, could_m } => {
                write!(f, "the head came to {came_m:.1} m of {could_m:.1} m that it could reach")
            }
            Self::BranchMissed { ordered, at_m, gallery } => {
                let ordered = match ordered {
                    Branch::Left => "left",
                    Branch::Right => "right",
                    Branch::Straight => "straight on",
                };
                write!(f, "the head was ordered {ordered} at {at_m:.1} m and flew into {gallery}")
            }
            Self::HoldMissed { missing_s, of_s } => write!(
                f,
                "there was no chain for {missing_s:.0} s of the {of_s:.0} s that it was to hold"
            ),
            Self::Stuck { at_m, for_s } => write!(
                f,
                "the head stood at {at_m:.1} m for {for_s:.0} s while a relay waited that nobody \
                 called"
            ),
            Self::Unfinished(n) => write!(f, "{n} drones that did not finish"),
            Self::Unexplored { found, why } => write!(f, "{found}: {}", why.words()),
            Self::Uncovered { found, lost: 0 } => f.write_str(found),
            Self::Uncovered { found, lost } => write!(f, "{found}: drones lost: {lost}"),
            Self::Criterion { found, .. } => f.write_str(found),
        }
    }
}
