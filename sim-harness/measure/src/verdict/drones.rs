//! Judges where each drone is at the end of a mission, and how it came down.

use agent::{ChainDuty, Duty, LandReason, State};
use units::{Metres, MissionKind, Order, Role};
use world::World;

use super::evidence::{DroneEnd, Evidence};
use super::failure::{Down, Failure, Standing};
use scenario::Scenario;

/// A drone that was called home is at home within this distance of where it took off, m: an arm's
/// length for the operator at the mouth, and three places of the row. Ours; the drones' own measure
/// is 0.3 m by odometer ([`FlightConfig::home`](agent::FlightConfig)), which is off by up to 0.7 m.
const HOME_M: f32 = 1.0;

/// The row in which the drones of a chain land may be so much longer for each drone that flew than the row
/// in which they stood, m. Our own bound: they stand 0.35 m apart, and land 0.65 m before the outermost drone that is
/// down (`crates/agent/src/mission/chain/homing.rs`).
pub const WIDER_M: f32 = 0.2;

/// The distance from where it took off within which a drone is at home, m: in a gallery wider than
/// 2 m half its width, since a drone there comes home along a wall. The drones of a chain land one before
/// the other, in a row that is longer than that in which they stood.
pub(super) fn home_m(scenario: &Scenario, world: &World, drones: &[DroneEnd]) -> f32 {
    let Metres(width) = world.skeleton().edge(world.base.on.edge).width();
    let wider = match scenario.mission {
        MissionKind::Chain => {
            WIDER_M * drones.iter().filter(|drone| drone.has_flown).count() as f32
        }
        MissionKind::Swarm | MissionKind::Explore => 0.0,
    };
    HOME_M.max(0.5 * width) + wider
}

/// A drone stands in another's place within this distance, m: two radii with guards and a hand's
/// breadth, so that it can take off again without a touch. Our own bound.
const APART_M: f32 = 0.25;

/// How the drones were called from the air, if they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Called {
    /// They were not.
    Not,
    /// Down, where they are.
    Down,
    /// Home; whether the operator did so with the last order or the last but an order to land, and
    /// not a battery.
    Home { by_operator: bool },
    /// To stop where they are.
    Stop,
    /// They were not, and each flies home when nothing is left, or its own battery or place calls for it.
    EachByItself,
}

impl Called {
    /// The call of the scenario's last order, or of a battery.
    pub(super) fn of(scenario: &Scenario, evidence: &Evidence) -> Self {
        let mut orders = scenario.pilot.iter().rev().map(|step| step.task);
        let is_recalled = evidence.is_recalled;
        match (orders.next(), orders.next()) {
            (Some(Order::Return), _) | (Some(Order::Land), Some(Order::Return)) => {
                Self::Home { by_operator: true }
            }
            (Some(Order::Land), _) => Self::Down,
            (Some(Order::Stop), _) => Self::Stop,
            _ if is_recalled => Self::Home { by_operator: false },
            _ if scenario.mission == MissionKind::Explore => Self::EachByItself,
            _ => Self::Not,
        }
    }

    /// What is wrong with a drone at the end, that is at home within `home_m`.
    pub(super) fn failure(self, end: &DroneEnd, home_m: f32) -> Option<Failure> {
        let drone = end.node;
        if end.is_lost || drone.role == Role::Base {
            return None;
        }
        let is_ordered = matches!(self, Self::Down | Self::Home { by_operator: true });
        if is_ordered && end.state.is_airborne() {
            return Some(Failure::StillFlying(drone));
        }
        let comes_home = matches!(self, Self::Home { .. } | Self::EachByItself);
        let down = Down::of_end(end).filter(|_| comes_home);
        if let (Some(why), Some(apart_m)) = (down, end.distance_from_home())
            && apart_m > home_m
        {
            return Some(Failure::LeftInside { drone, apart_m, why });
        }
        match end.state {
            State::Landing { why, .. } | State::Landed { why } => match why {
                LandReason::LinkLost => Some(Failure::LostBase(drone)),
                LandReason::TakeOffFailed => Some(Failure::TakeOffFailed(drone)),
                LandReason::Unfit(_) => Some(Failure::BroughtDown(drone)),
                LandReason::Restarted => Some(Failure::Restarted(drone)),
                LandReason::PositionLost => Some(Failure::PositionLost(drone)),
                LandReason::Ordered
                | LandReason::Perched
                | LandReason::Home
                | LandReason::Done
                | LandReason::Retired => None,
            },
            State::Stopped if self != Self::Stop => Some(Failure::BroughtDown(drone)),
            State::OnMission(Duty::Chain(ChainDuty::Reconnecting { .. })) => {
                Some(Failure::NoFront(drone))
            }
            State::OnMission(Duty::Chain(ChainDuty::Homing)) if self == Self::Not => {
                Some(Failure::LostBase(drone))
            }
            _ => None,
        }
    }
}

impl Down {
    /// Why a drone that has flown is on the ground.
    fn of_end(end: &DroneEnd) -> Option<Self> {
        let why = match end.state {
            State::Landing { why, .. } | State::Landed { why } => Self::of(why),
            State::Idle | State::Armed { .. } => Self::Retired,
            State::Perched => Self::Perched,
            State::Stopped => Self::Fault,
            State::TakingOff { .. } | State::OnMission(_) | State::Rising { .. } => return None,
        };
        end.has_flown.then_some(why)
    }
}

impl DroneEnd {
    /// The distance from where it took off, m; `None` where it began in the air.
    fn distance_from_home(&self) -> Option<f32> {
        self.home.map(|home| self.at.distance(home).0)
    }
}

/// The drones on the ground that stand on each other, nearer than `touch` metres, or in another's
/// place. At least one of both has flown; drones that the scenario has lost do not count.
pub(super) fn on_each_other(drones: &[DroneEnd], touch: f32) -> Vec<Failure> {
    let down: Vec<_> = drones.iter().filter(|drone| !drone.is_up && !drone.is_lost).collect();
    let mut found = Vec::new();
    for (n, one) in down.iter().enumerate() {
        for other in down.iter().skip(n + 1).filter(|other| one.has_flown || other.has_flown) {
            let Metres(apart_m) = one.at.distance(other.at);
            if apart_m >= APART_M {
                continue;
            }
            let strays = |drone: &DroneEnd| match drone.has_flown {
                true => drone.distance_from_home().unwrap_or(f32::INFINITY),
                false => f32::NEG_INFINITY,
            };
            let (drone, other) =
                if strays(one) >= strays(other) { (one, other) } else { (other, one) };
            let standing = Standing { drone: drone.node, other: other.node, apart_m };
            found.push(match apart_m < touch {
                true => Failure::StandsOn(standing),
                false => Failure::StandsInPlace(standing),
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use flight::Cause;
    use units::{Instant, NodeId, Point2};

    use super::*;
    use crate::verdict::evidence::TurnedBack;
    use mission::trace::Node;

    /// Relay 1, which took off at 0.7 m and has landed here.
    fn landed(x: f32, why: LandReason) -> DroneEnd {
        DroneEnd {
            node: Node { id: NodeId(1), role: Role::Relay, mission: MissionKind::Chain },
            state: State::Landed { why },
            at: Point2::new(x, 0.0),
            home: Some(Point2::new(0.7, 0.0)),
            is_up: false,
            has_flown: true,
            is_lost: false,
            turned_back: None,
        }
    }

    /// Relay 2, which waits at 0.35 m.
    fn waiting() -> DroneEnd {
        DroneEnd {
            node: Node { id: NodeId(2), role: Role::Relay, mission: MissionKind::Chain },
            state: State::Idle,
            at: Point2::new(0.35, 0.0),
            home: Some(Point2::new(0.35, 0.0)),
            has_flown: false,
            ..landed(0.0, LandReason::Home)
        }
    }

    const HOME: Called = Called::Home { by_operator: true };

    fn name(failure: Option<Failure>) -> &'static str {
        failure.as_ref().map_or("", Failure::name)
    }

    #[test]
    fn a_drone_that_was_called_home_and_came_down_elsewhere_was_left_inside() {
        let judged = |x, why| name(HOME.failure(&landed(x, why), HOME_M));
        assert_eq!(judged(1.2, LandReason::Home), "");
        assert_eq!(judged(8.0, LandReason::LinkLost), "left-inside-link");
        assert_eq!(judged(8.0, LandReason::Unfit(Cause::Battery)), "left-inside-battery");
        assert_eq!(judged(8.0, LandReason::Unfit(Cause::Overload)), "left-inside-fault");
        assert_eq!(judged(8.0, LandReason::Home), "left-inside-home");
        assert_eq!(judged(8.0, LandReason::Ordered), "left-inside-order");
        assert_eq!(judged(0.9, LandReason::LinkLost), "lost-base");
        let perched = DroneEnd { state: State::Perched, ..landed(8.0, LandReason::Home) };
        assert_eq!(name(HOME.failure(&perched, HOME_M)), "left-inside-perched");
    }

    #[test]
    fn the_row_in_which_a_chain_lands_may_be_longer_than_the_one_in_which_it_stood() {
        let scenario = scenario::builtin::find("straight").unwrap().unwrap();
        let world = scenario.world();
        let flown = landed(0.7, LandReason::Home);
        assert!((home_m(&scenario, &world, &[flown; 6]) - 2.2).abs() < 1e-6);
        assert!((home_m(&scenario, &world, &[flown, waiting(), waiting()]) - 1.2).abs() < 1e-6);
        let swarm = Scenario { mission: MissionKind::Swarm, ..scenario };
        assert_eq!(home_m(&swarm, &world, &[flown; 6]), HOME_M);
    }

    #[test]
    fn a_drone_that_was_called_down_and_not_home_may_land_anywhere() {
        let judged = |why| name(Called::Down.failure(&landed(8.0, why), HOME_M));
        assert_eq!(judged(LandReason::Ordered), "");
        assert_eq!(judged(LandReason::LinkLost), "lost-base");
        assert_eq!(
            name(Called::Not.failure(&landed(8.0, LandReason::LinkLost), HOME_M)),
            "lost-base"
        );
    }

    #[test]
    fn an_explorer_must_come_home_whether_it_has_seen_all_or_has_turned_back() {
        let judged = |drone| name(Called::EachByItself.failure(&drone, HOME_M));
        let done = landed(8.0, LandReason::Done);
        assert_eq!(judged(done), "left-inside-home");
        assert_eq!(judged(DroneEnd { at: Point2::new(1.2, 0.0), ..done }), "");
        let back = DroneEnd { turned_back: Some(TurnedBack::ForBattery), ..done };
        assert_eq!(
            judged(DroneEnd { state: landed(8.0, LandReason::Home).state, ..back }),
            "left-inside-home"
        );
        assert_eq!(judged(DroneEnd { at: Point2::new(1.2, 0.0), ..back }), "");
        assert_eq!(judged(landed(8.0, LandReason::Unfit(Cause::Battery))), "left-inside-battery");
    }

    #[test]
    fn a_drone_that_flies_on_when_it_was_called_down_is_told_of() {
        let flies = State::Landing { since: Instant::ZERO, why: LandReason::Ordered };
        let drone = DroneEnd { state: flies, is_up: true, ..landed(8.0, LandReason::Home) };
        assert_eq!(name(Called::Down.failure(&drone, HOME_M)), "still-flying");
        assert_eq!(name(HOME.failure(&drone, HOME_M)), "still-flying");
        assert_eq!(name(Called::Not.failure(&drone, HOME_M)), "");
        assert_eq!(name(HOME.failure(&DroneEnd { is_lost: true, ..drone }, HOME_M)), "");
    }

    #[test]
    fn a_drone_that_stopped_by_itself_was_brought_down() {
        let stopped = DroneEnd { state: State::Stopped, ..landed(0.7, LandReason::Home) };
        assert_eq!(name(Called::Not.failure(&stopped, HOME_M)), "brought-down");
        assert_eq!(name(Called::Stop.failure(&stopped, HOME_M)), "");
    }

    fn found(drones: &[DroneEnd]) -> Vec<(&'static str, u8)> {
        let drone = |failure: &Failure| match failure {
            Failure::StandsOn(standing) | Failure::StandsInPlace(standing) => standing.drone.id.0,
            _ => u8::MAX,
        };
        on_each_other(drones, 0.16).iter().map(|f| (f.name(), drone(f))).collect()
    }

    #[test]
    fn drones_that_end_at_each_other_are_told_of() {
        let at = |x| landed(x, LandReason::Home);
        assert_eq!(found(&[at(0.7), waiting()]), []);
        assert_eq!(found(&[at(0.55), waiting()]), [("stands-in-anothers-place", 1)]);
        assert_eq!(found(&[at(0.4), waiting()]), [("stands-on-drone", 1)]);
        let second = DroneEnd {
            node: Node { id: NodeId(3), role: Role::Relay, mission: MissionKind::Chain },
            ..at(1.4)
        };
        assert_eq!(found(&[at(1.5), second]), [("stands-on-drone", 1)]);
        let above = DroneEnd { is_up: true, ..at(0.4) };
        assert_eq!(found(&[above, waiting()]), []);
    }

    #[test]
    fn drones_that_wait_side_by_side_have_not_come_there() {
        let near = DroneEnd {
            node: Node { id: NodeId(3), role: Role::Relay, mission: MissionKind::Chain },
            at: Point2::new(0.45, 0.0),
            ..waiting()
        };
        assert_eq!(found(&[waiting(), near]), []);
    }
}
