//! Says why explorers have not seen all that they can come to.

use agent::{LandReason, State};
use flight::Cause;

use super::evidence::{DroneEnd, Evidence, TurnedBack};

/// Why explorers have not seen all that they can come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Short {
    /// A drone still flies: the mission's time is over.
    Time,
    /// A drone turned back while its battery carried it home, or came down on an empty one.
    Battery,
    /// A drone turned back because its place had become too uncertain.
    Drift,
    /// The operator called the drones back, or down.
    Order,
    /// A fault brought a drone down, or the scenario took it away.
    Fallen,
    /// The drones had told each other that nothing was left.
    Early,
}

impl Short {
    /// Why the drones of this evidence saw no more. What keeps any drone from its part comes before the
    /// word of those that have ended.
    #[must_use]
    pub fn of(evidence: &Evidence) -> Self {
        let all = evidence.drones.iter().filter(|drone| drone.node.role != units::Role::Base);
        let causes: Vec<_> = all.map(Self::of_drone).collect();
        let order = [Self::Time, Self::Battery, Self::Drift, Self::Order, Self::Fallen];
        order.into_iter().find(|cause| causes.contains(cause)).unwrap_or(Self::Early)
    }

    /// Why one drone saw no more.
    fn of_drone(drone: &DroneEnd) -> Self {
        if drone.is_lost {
            return Self::Fallen;
        }
        match (drone.turned_back, drone.state) {
            (_, State::Landing { why, .. } | State::Landed { why }) => match why {
                LandReason::Unfit(Cause::Battery) => Self::Battery,
                LandReason::Ordered => Self::Order,
                LandReason::Done => Self::Early,
                LandReason::Home => match drone.turned_back {
                    Some(TurnedBack::ForDrift) => Self::Drift,
                    Some(TurnedBack::ForBattery) | None => Self::Battery,
                },
                _ => Self::Fallen,
            },
            (Some(TurnedBack::ForBattery), state) if state.is_airborne() => Self::Battery,
            (_, state) if state.is_airborne() => Self::Time,
            _ => Self::Fallen,
        }
    }

    /// The name under which a campaign counts it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time-over",
            Self::Battery => "battery",
            Self::Drift => "drift",
            Self::Order => "called-off",
            Self::Fallen => "drone-down",
            Self::Early => "stopped-early",
        }
    }

    /// The reason in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Time => "the time was over",
            Self::Battery => "a battery had no more than the way home",
            Self::Drift => "a drone's place had become too uncertain",
            Self::Order => "the drones were called back or down",
            Self::Fallen => "a drone came down",
            Self::Early => "the drones stopped early, by their own word that nothing was left",
        }
    }
}

#[cfg(test)]
mod tests {
    use units::{Instant, MissionKind, NodeId, Point2, Role};

    use super::*;
    use mission::trace::Node;

    fn drone(number: u8, state: State, turned_back: Option<TurnedBack>) -> DroneEnd {
        DroneEnd {
            node: Node { id: NodeId(number), role: Role::Relay, mission: MissionKind::Explore },
            state,
            at: Point2::new(0.0, 0.0),
            home: Some(Point2::new(0.0, 0.0)),
            is_up: state.is_airborne(),
            has_flown: true,
            is_lost: false,
            turned_back,
        }
    }

    fn why(drones: &[DroneEnd]) -> &'static str {
        let evidence = Evidence {
            drones: drones.to_vec(),
            is_disordered: false,
            hold_s: [0.0; 2],
            is_recalled: false,
            head: None,
        };
        Short::of(&evidence).name()
    }

    #[test]
    fn what_kept_one_drone_from_its_part_is_told_before_the_word_of_the_others() {
        let landed = |why| State::Landed { why };
        let done = drone(0, landed(LandReason::Done), None);
        assert_eq!(why(&[done, drone(1, landed(LandReason::Done), None)]), "stopped-early");
        let flies = State::Landing { since: Instant::ZERO, why: LandReason::Done };
        assert_eq!(why(&[done, drone(1, flies, None)]), "stopped-early");
        let rises = State::TakingOff { since: Instant::ZERO };
        assert_eq!(why(&[done, drone(1, rises, None)]), "time-over");
        let home = |why| drone(1, landed(LandReason::Home), Some(why));
        assert_eq!(why(&[done, home(TurnedBack::ForBattery)]), "battery");
        assert_eq!(why(&[done, home(TurnedBack::ForDrift)]), "drift");
        let empty = landed(LandReason::Unfit(Cause::Battery));
        assert_eq!(why(&[done, drone(1, empty, None)]), "battery");
        assert_eq!(why(&[done, drone(1, landed(LandReason::Ordered), None)]), "called-off");
        assert_eq!(why(&[done, drone(1, State::Stopped, None)]), "drone-down");
        let lost = DroneEnd { is_lost: true, ..drone(1, rises, None) };
        assert_eq!(why(&[done, lost]), "drone-down");
    }
}
