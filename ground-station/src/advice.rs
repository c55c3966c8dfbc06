//! Recommends the operator's next action. The first rule that applies counts.

use units::{Dbm, Duration, Instant};

use crate::battery::seconds_to_turning_back;
use crate::chain_view::{ChainView, Drone, Trend};
use crate::fleet::Fleet;
use crate::session::Facts;
use crate::stopping::{Sending, Stop, Stopping, is_stopped};
use crate::words;

/// With less time until a drone turns back by itself, in seconds, the operator is told to recall
/// the chain: long enough to read it and to choose the moment (chosen for the display; no drone acts
/// by it).
const TURNS_BACK_SOON: f32 = 60.0;
/// A drone that was silent for longer is shown as silent: relays send telemetry once a second, and
/// a fade may lose some packets in a row.
pub const SILENT: Duration = Duration::from_secs(5);

/// Whether a recommendation can wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Urgency {
    /// The operator may act when it suits.
    Calm,
    /// The operator should act now.
    Urgent,
}

/// A recommendation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Advice {
    /// Whether it can wait.
    pub urgency: Urgency,
    /// What to do, and why.
    pub text: String,
}

/// All that the rules look at.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The present time.
    pub now: Instant,
    /// Whether a page steers; without one the station says nothing to the base.
    pub is_steered: bool,
    /// Whether the base was heard just now.
    pub hears_base: bool,
    /// What is known about the base.
    pub facts: Option<Facts>,
    /// The chain.
    pub chain: &'a ChainView,
    /// The emergency stop.
    pub stopping: &'a Stopping,
    /// The fleet, which names the drones; without drones where there is no fleet file.
    pub fleet: &'a Fleet,
}

/// Returns the next recommended action.
#[must_use]
pub fn advise(of: &Situation<'_>) -> Advice {
    if let Stopping::Ordered(stop) = of.stopping {
        return after_stop(stop, of.fleet);
    }
    if !of.is_steered {
        return urgent(
            "Nobody steers: the station says nothing to the base, and drones in the air hover by \
             themselves. Take over on the page that is to steer."
                .to_owned(),
        );
    }
    let Some(facts) = of.facts.filter(|_| of.hears_base) else {
        return urgent(
            "The base does not answer. Check that it is switched on and that the address is its \
             own. Drones in the air hover by themselves; no order reaches them now."
                .to_owned(),
        );
    };
    trouble(of, facts.retreat_limit).unwrap_or_else(|| calm(next_step(of.chain)))
}

fn urgent(text: String) -> Advice {
    Advice { urgency: Urgency::Urgent, text }
}

fn calm(text: &str) -> Advice {
    Advice { urgency: Urgency::Calm, text: text.to_owned() }
}

fn after_stop(stop: &Stop, fleet: &Fleet) -> Advice {
    let missing: Vec<String> = stop
        .drones
        .iter()
        .filter(|(_, answer)| answer.is_none())
        .map(|(node, _)| fleet.name(*node))
        .collect();
    match stop.sending {
        Sending::Answered => {
            calm("Every drone has stopped. Switch each drone off before you touch its propellers.")
        }
        Sending::Repeating | Sending::GivenUp if missing.is_empty() => urgent(
            "The base has not answered the stop. Carry the base nearer, or use its button."
                .to_owned(),
        ),
        Sending::Repeating | Sending::GivenUp => urgent(format!(
            "No answer to the stop from {}. Take its motors for running until you see it.",
            missing.join(", ")
        )),
    }
}

/// What is wrong somewhere in the chain, head first.
fn trouble(of: &Situation<'_>, retreat_limit: Dbm) -> Option<Advice> {
    of.chain.drones.iter().find_map(|(node, drone)| {
        trouble_of(of.now, drone, retreat_limit)
            .map(|what| urgent(format!("{}{what}", words::capital(&of.fleet.name(*node)))))
    })
}

fn trouble_of(now: Instant, drone: &Drone, retreat_limit: Dbm) -> Option<String> {
    let report = &drone.report;
    let is_airborne = words::is_airborne(report.state);
    if is_stopped(report.state, report.fault) {
        return Some(" has stopped its motors. Recall the others, then fetch it.".to_owned());
    }
    if let Some(fault) = words::fault(report.fault) {
        return Some(format!(": {fault}. Recall the chain."));
    }
    if is_airborne && drone.age(now) > SILENT {
        let silence = drone.age(now).as_secs_f32();
        return Some(format!(" has been silent for {silence:.0} s. Hold, or recall the chain."));
    }
    if is_airborne
        && let Some(spare) = seconds_to_turning_back(report)
        && spare < TURNS_BACK_SOON
    {
        let spare = spare.max(0.0);
        return Some(format!(
            " turns back in {spare:.0} s, for its battery. Recall the chain now."
        ));
    }
    match report.back {
        Some((_, rssi))
            if is_airborne && rssi < retreat_limit && drone.trend() == Trend::Falling =>
        {
            Some(format!(
                ": its link of {:.0} dBm is too weak and falls. Fly back, or hold.",
                rssi.0
            ))
        }
        _ => None,
    }
}

/// The next step of a mission in which nothing is wrong.
fn next_step(chain: &ChainView) -> &'static str {
    let states = || chain.drones.values().map(|drone| drone.report.state);
    let airborne = states().filter(|state| words::is_airborne(*state)).count();
    match chain.task {
        _ if chain.drones.is_empty() => "Switch the drones on, each at its place in the row.",
        Some(1) if airborne > 0 => "Explore, choose a way at the next junction, or recall.",
        Some(1) => "The order is on its way: the head takes off.",
        Some(2) if airborne > 0 => "The chain flies home. Keep the mouth of the tunnel free.",
        Some(2 | 3) if airborne == 0 => "All drones are down. Order wait before the next flight.",
        Some(3) => "The drones are landing.",
        Some(5) => "The chain relays from the ground. Explore or recall calls it up.",
        _ if airborne > 0 => "Drones are in the air. Hold or recall gives them an order.",
        _ if states().any(|state| state == 8) => "Order wait, so that landed drones may fly again.",
        _ => "Ready. Take off when the tunnel is free of people.",
    }
}

#[cfg(test)]
mod tests {
    use units::{Metres, NodeId};

    use super::*;
    use crate::blocks::DroneReport;

    const FACTS: Facts =
        Facts { node: NodeId(4), launch_limit: Dbm(-70.0), retreat_limit: Dbm(-76.0) };
    const NOW: Instant = Instant::from_millis(20_000);

    fn report(state: u8) -> DroneReport {
        DroneReport {
            state,
            fault: 0,
            age: Duration::ZERO,
            battery: None,
            endurance: None,
            back: None,
            odometer: Metres(0.0),
        }
    }

    fn advice(reports: &[DroneReport], task: u8, stopping: &Stopping) -> Advice {
        let mut chain = ChainView { task: Some(task), ..ChainView::default() };
        for (node, report) in (0..).zip(reports) {
            chain.hear(NOW, NodeId(node), *report);
        }
        let facts = Some(FACTS);
        let fleet = &Fleet::default();
        advise(&Situation {
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
    fn a_drone_without_an_answer_to_the_stop_comes_before_everything() {
        let mut stopping = Stopping::default();
        stopping.order(NOW, [NodeId(0), NodeId(2)].into_iter());
        stopping.hear(NodeId(0), NOW, 9, 2);
        let ill = DroneReport { fault: 20, ..report(4) };
        let advice = advice(&[report(9), ill], 4, &stopping);
        assert_eq!(advice.urgency, Urgency::Urgent);
        assert!(advice.text.contains("relay 2") && !advice.text.contains("the head"), "{advice:?}");
    }

    #[test]
    fn a_low_battery_in_the_air_calls_for_the_way_home() {
        let low = DroneReport {
            endurance: Some(Duration::from_secs(90)),
            odometer: Metres(4.0),
            ..report(4)
        };
        let in_air = advice(&[report(3), low], 1, &Stopping::NotOrdered);
        assert_eq!(in_air.urgency, Urgency::Urgent);
        assert!(in_air.text.starts_with("Relay 1 turns back in 40 s"), "{in_air:?}");
        let on_ground = DroneReport { state: 0, ..low };
        let waits = advice(&[report(3), on_ground], 1, &Stopping::NotOrdered);
        assert_eq!(waits.urgency, Urgency::Calm);
    }

    #[test]
    fn a_chain_that_is_ready_is_told_to_take_off() {
        let advice = advice(&[report(0), report(0)], 0, &Stopping::NotOrdered);
        assert!(advice.text.starts_with("Ready"), "{advice:?}");
    }
}
