//! Checks a chain on the ground before its flight.

use agent::FlightConfig;
use units::NodeId;

use crate::advice::{SILENT, Situation};
use crate::chain_view::Drone;
use crate::fleet::Fleet;
use crate::session::Facts;
use crate::words;

/// The code of the base's radio link when it is a member of the chain.
const MEMBER: u8 = 2;
/// The code of the state of a drone that has landed.
const LANDED: u8 = 8;

/// Two limits that differ by less are the same, dB: a drone stores them in finer steps.
const SAME_LIMIT: f32 = 0.05;

/// One line of the checklist.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Check {
    /// Whether it is as it must be.
    pub good: bool,
    /// What must be so, or what is not.
    pub text: String,
}

impl Check {
    /// A check that is good where nothing is missing.
    fn of(wanted: &str, missing: &[String]) -> Self {
        let text = match missing {
            [] => format!("{wanted}."),
            missing => format!("{wanted}, but not {}.", missing.join(", ")),
        };
        Self { good: missing.is_empty(), text }
    }

    fn whether(good: bool, wanted: &str, else_do: &str) -> Self {
        Self { good, text: if good { wanted } else { else_do }.to_owned() }
    }
}

/// The checklist; empty while a drone is in the air.
#[must_use]
pub fn checks(of: &Situation<'_>) -> Vec<Check> {
    let drones = &of.chain.drones;
    if drones.values().any(|drone| words::is_airborne(drone.report.state)) {
        return Vec::new();
    }
    let Some(facts) = of.facts.filter(|_| of.hears_base) else {
        return vec![Check::whether(false, "", "The base does not answer.")];
    };
    let is_member = of.chain.base.is_some_and(|base| base.link == MEMBER);
    let not = |is_good: &dyn Fn(&Drone) -> bool| -> Vec<String> {
        drones
            .iter()
            .filter(|(_, drone)| !is_good(drone))
            .map(|(node, _)| of.fleet.name(*node))
            .collect()
    };
    let unheard = |nodes: &mut dyn Iterator<Item = NodeId>| -> Vec<String> {
        nodes
            .filter(|node| drones.get(node).is_none_or(|drone| drone.age(of.now) > SILENT))
            .map(|node| of.fleet.name(node))
            .collect()
    };
    let heard = if of.fleet.drones.is_empty() {
        let missing = unheard(&mut (0..facts.node.0).map(NodeId));
        Check::of("Every number before the base's is heard", &missing)
    } else {
        Check::of("Every drone of the fleet file is heard", &unheard(&mut of.fleet.flying()))
    };
    let mut checks = vec![
        Check::whether(
            is_member,
            "The base's radio is a member of the chain.",
            "The base's radio is not a member of the chain yet.",
        ),
        heard,
        Check::of("Every drone is without a fault", &not(&|drone| drone.report.fault == 0)),
        Check::of("Every drone may take off", &not(&|drone| drone.report.state != LANDED)),
        Check::of("Every battery that is known lasts for 90 s", &not(&lasts)),
        Check::of(
            "Every link is stronger than the launch limit",
            &not(&|drone| drone.report.back.is_some_and(|(_, rssi)| rssi > facts.launch_limit)),
        ),
    ];
    checks.extend(limits(of.fleet, facts));
    checks
}

/// Whether the base's limits are those of the fleet file, where it has any.
fn limits(fleet: &Fleet, facts: Facts) -> Option<Check> {
    let limits = &fleet.limits;
    let pairs = [(limits.launch, facts.launch_limit), (limits.retreat, facts.retreat_limit)];
    let mut told = pairs.iter().filter_map(|(wanted, own)| Some(((*wanted)?, *own))).peekable();
    told.peek()?;
    let agree = told.all(|(wanted, own)| (wanted.0 - own.0).abs() <= SAME_LIMIT);
    Some(Check::whether(
        agree,
        "The base's limits are those of the fleet file.",
        "The base's limits are not those of the fleet file: check it with --check.",
    ))
}

/// Whether a drone would be launched with its battery; an unknown one counts as enough, as for the
/// drone itself.
fn lasts(drone: &Drone) -> bool {
    const { assert!(FlightConfig::DEFAULT.least_endurance.as_micros() == 90_000_000) };
    drone.report.endurance.is_none_or(|left| left >= FlightConfig::DEFAULT.least_endurance)
}

#[cfg(test)]
mod tests {
    use units::{Dbm, Duration, Instant, Metres, Role};

    use super::*;
    use crate::blocks::{BaseReport, DroneReport};
    use crate::chain_view::ChainView;
    use crate::fleet::FleetDrone;
    use crate::stopping::Stopping;

    const NOW: Instant = Instant::from_millis(20_000);
    const READY: DroneReport = DroneReport {
        state: 0,
        fault: 0,
        age: Duration::ZERO,
        battery: None,
        endurance: None,
        back: Some((NodeId(2), Dbm(-40.0))),
        odometer: Metres(0.0),
    };

    fn checked(reports: [DroneReport; 2]) -> Vec<Check> {
        let base = BaseReport { link: MEMBER, recalled: false, refused: 0 };
        let mut chain = ChainView { base: Some(base), ..ChainView::default() };
        for (node, report) in (0..).map(NodeId).zip(reports) {
            chain.hear(NOW, node, report);
        }
        let (launch_limit, retreat_limit) = (Dbm(-70.0), Dbm(-76.0));
        let facts = Some(Facts { node: NodeId(2), launch_limit, retreat_limit });
        let stopping = &Stopping::NotOrdered;
        let fleet = &Fleet::default();
        checks(&Situation {
            now: NOW,
            is_steered: true,
            hears_base: true,
            facts,
            chain: &chain,
            stopping,
            fleet,
        })
    }

    #[test]
    fn a_row_of_drones_that_are_ready_passes() {
        assert!(checked([READY; 2]).iter().all(|check| check.good));
    }

    #[test]
    fn each_thing_that_is_wrong_fails_one_check_and_names_the_drone() {
        let wrong = [
            DroneReport { age: Duration::from_secs(6), ..READY },
            DroneReport { fault: 17, ..READY },
            DroneReport { state: LANDED, ..READY },
            DroneReport { endurance: Some(Duration::from_secs(89)), ..READY },
            DroneReport { back: Some((NodeId(2), Dbm(-71.0))), ..READY },
            DroneReport { back: None, ..READY },
        ];
        for report in wrong {
            let checks = checked([READY, report]);
            let bad: Vec<_> = checks.iter().filter(|check| !check.good).collect();
            assert_eq!(bad.len(), 1, "{report:?}: {checks:?}");
            assert!(bad[0].text.ends_with("but not relay 1."), "{bad:?}");
        }
    }

    /// A fleet of the head and a base 15, as `uchain keys` numbers bases.
    #[test]
    fn a_fleet_file_says_which_drones_are_missing_and_which_limits_count() {
        let base = BaseReport { link: MEMBER, recalled: false, refused: 0 };
        let mut chain = ChainView { base: Some(base), ..ChainView::default() };
        chain.hear(NOW, NodeId(0), READY);
        let facts = |launch: f32| {
            let (launch_limit, retreat_limit) = (Dbm(launch), Dbm(-76.0));
            Some(Facts { node: NodeId(15), launch_limit, retreat_limit })
        };
        let address = |text: &str| text.parse().unwrap();
        let drone =
            |address, role| FleetDrone { name: "Ada".to_owned(), address, role, decks: Vec::new() };
        let mut fleet = Fleet::default();
        fleet.limits.launch = Some(Dbm(-70.0));
        fleet.drones.insert(NodeId(0), drone(address("udp://a:1"), Role::Head));
        fleet.drones.insert(NodeId(15), drone(address("udp://a:2"), Role::Base));
        let bad = |fleet: &Fleet, launch| -> Vec<String> {
            let (facts, stopping) = (facts(launch), &Stopping::NotOrdered);
            let of = Situation {
                now: NOW,
                is_steered: true,
                hears_base: true,
                facts,
                chain: &chain,
                stopping,
                fleet,
            };
            checks(&of).into_iter().filter(|check| !check.good).map(|check| check.text).collect()
        };
        assert_eq!(bad(&fleet, -70.0), [""; 0]);
        assert!(bad(&fleet, -75.0)[0].contains("limits are not those"));
        fleet.drones.insert(NodeId(1), drone(address("udp://a:3"), Role::Relay));
        assert!(bad(&fleet, -70.0)[0].contains("but not relay 1 (Ada)."));
    }

    #[test]
    fn in_the_air_there_is_no_checklist() {
        assert_eq!(checked([READY, DroneReport { state: 4, ..READY }]), []);
    }
}
