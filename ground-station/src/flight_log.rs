//! Tells the story of a flight: when drones take off and land, what they do that is not their usual work,
//! and when their links become weak, in one sentence each; and keeps the flight's clock.

use std::collections::BTreeMap;

use units::{Dbm, Duration, Instant, NodeId};

use crate::advice::SILENT;
use crate::chain_view::{ChainView, Drone};
use crate::fleet::Fleet;
use crate::grade::Grade;
use crate::session::Facts;
use crate::words;

/// A link has another grade when its reports have said so for so long: three telemetry packets of a relay.
/// Our own number; a link at a limit changes its grade with every packet.
const LASTS: Duration = Duration::from_secs(3);

/// The flight that goes on or was the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flight {
    /// When the first drone took off.
    pub began: Instant,
    /// When the last drone was down.
    pub ended: Option<Instant>,
}

impl Flight {
    /// The time since the first drone took off, or until the last one was down.
    #[must_use]
    pub fn lasts(&self, now: Instant) -> Duration {
        self.ended.unwrap_or(now).since(self.began)
    }
}

/// What was told of one drone.
#[derive(Clone, Copy, Debug)]
struct Told {
    state: u8,
    fault: u8,
    is_silent: bool,
    link: Grade,
    /// Since when the link has had another grade than the one that was told.
    other_since: Option<Instant>,
}

/// The story so far.
#[derive(Clone, Debug, Default)]
pub struct FlightLog {
    drones: BTreeMap<NodeId, Told>,
    flight: Option<Flight>,
}

impl FlightLog {
    /// The flight that goes on or was the last; `None` before the first take-off.
    #[must_use]
    pub const fn flight(&self) -> Option<Flight> {
        self.flight
    }

    /// Looks at the chain, and returns a sentence for each thing that has changed. Links have grades once
    /// the `base` is known.
    pub fn step(
        &mut self,
        now: Instant,
        chain: &ChainView,
        base: Option<Facts>,
        fleet: &Fleet,
    ) -> Vec<String> {
        self.keep_clock(now, chain);
        let mut told = Vec::new();
        for (node, drone) in &chain.drones {
            let name = || words::capital(&fleet.name(*node));
            let (is_first, before) = match self.drones.get(node) {
                Some(before) => (false, *before),
                None => (true, Told::on_the_ground(drone)),
            };
            let mut next = before;
            let report = &drone.report;
            told.extend(
                next.change_state(report.state, is_first).map(|what| format!("{} {what}.", name())),
            );
            told.extend(next.change_fault(report.fault).map(|what| format!("{}: {what}.", name())));
            told.extend(next.change_silence(now, drone).map(|what| format!("{} {what}.", name())));
            if let (Some((to, rssi)), Some(base)) = (report.back, base)
                && let Some(what) = next.change_link(now, rssi, base)
            {
                let to = if to == base.node { "the base".to_owned() } else { fleet.name(to) };
                told.push(format!("The link of {} to {to} {what}.", fleet.name(*node)));
            }
            self.drones.insert(*node, next);
        }
        told
    }

    fn keep_clock(&mut self, now: Instant, chain: &ChainView) {
        let is_flying = chain.drones.values().any(|drone| words::is_airborne(drone.report.state));
        match &mut self.flight {
            Some(flight) if flight.ended.is_none() => {
                flight.ended = (!is_flying).then_some(now);
            }
            Some(_) | None if is_flying => {
                self.flight = Some(Flight { began: now, ended: None });
            }
            Some(_) | None => {}
        }
    }
}

impl Told {
    /// What is taken for told of a drone that is heard for the first time.
    fn on_the_ground(drone: &Drone) -> Self {
        Self {
            state: if words::is_airborne(drone.report.state) { 0 } else { drone.report.state },
            fault: 0,
            is_silent: false,
            link: Grade::Good,
            other_since: None,
        }
    }

    fn change_state(&mut self, state: u8, is_first: bool) -> Option<String> {
        let before = std::mem::replace(&mut self.state, state);
        let [was_up, is_up] = [before, state].map(words::is_airborne);
        match state {
            _ if state == before => None,
            _ if is_up && is_first => Some(format!("is in the air, {}", words::state(state))),
            _ if is_up && !was_up => Some("takes off".to_owned()),
            LANDING => Some("lands".to_owned()),
            STOPPED => Some("has stopped its motors".to_owned()),
            _ if was_up && !is_up => Some("is down".to_owned()),
            _ if words::is_news(state) => Some(format!("is {}", words::state(state))),
            _ => None,
        }
    }

    fn change_fault(&mut self, fault: u8) -> Option<&'static str> {
        let before = std::mem::replace(&mut self.fault, fault);
        if fault == before { None } else { words::fault(fault) }
    }

    /// A drone on the ground may be switched off; one in the air that says nothing is missed.
    fn change_silence(&mut self, now: Instant, drone: &Drone) -> Option<&'static str> {
        let is_silent = drone.age(now) > SILENT && words::is_airborne(drone.report.state);
        let was_silent = std::mem::replace(&mut self.is_silent, is_silent);
        match (was_silent, is_silent) {
            (false, true) => Some("is silent"),
            (true, false) => Some("is heard again"),
            _ => None,
        }
    }

    /// The antenna of a drone on the ground loses 10 dB, of which nothing is told.
    fn change_link(&mut self, now: Instant, rssi: Dbm, base: Facts) -> Option<String> {
        if !words::is_airborne(self.state) || self.is_silent {
            (self.link, self.other_since) = (Grade::Good, None);
            return None;
        }
        let grade = Grade::of(rssi, base);
        if grade == self.link {
            self.other_since = None;
            return None;
        }
        let since = *self.other_since.get_or_insert(now);
        if now.since(since) < LASTS {
            return None;
        }
        (self.link, self.other_since) = (grade, None);
        let rssi = rssi.0;
        Some(match grade {
            Grade::Good => format!("is good again: {rssi:.0} dBm"),
            Grade::Weak => {
                format!(
                    "is weak: {rssi:.0} dBm, below the launch limit of {:.0}",
                    base.launch_limit.0
                )
            }
            Grade::TooWeak => format!(
                "is too weak: {rssi:.0} dBm, below the retreat limit of {:.0}",
                base.retreat_limit.0
            ),
        })
    }
}

const LANDING: u8 = 7;
const STOPPED: u8 = 9;

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;
    use crate::blocks::DroneReport;

    const BASE: Facts =
        Facts { node: NodeId(3), launch_limit: Dbm(-67.0), retreat_limit: Dbm(-72.0) };

    /// A report of relay 1, whose link towards the base leads to the base.
    fn report(state: u8, rssi: f32) -> DroneReport {
        DroneReport {
            state,
            fault: 0,
            age: Duration::ZERO,
            battery: None,
            endurance: None,
            back: Some((NodeId(3), Dbm(rssi))),
            odometer: Metres(1.0),
        }
    }

    /// What is told where relay 1 reports these states and strengths, one each second.
    fn told(reports: impl IntoIterator<Item = (u8, f32)>) -> (Vec<String>, FlightLog) {
        let (mut chain, mut log) = (ChainView::default(), FlightLog::default());
        let mut story = Vec::new();
        for (second, (state, rssi)) in reports.into_iter().enumerate() {
            let now = Instant::from_millis(1_000 * second as u64 + 5_000);
            chain.hear(now, NodeId(1), report(state, rssi));
            let tell = |text: String| format!("{second} {text}");
            story
                .extend(log.step(now, &chain, Some(BASE), &Fleet::default()).into_iter().map(tell));
        }
        (story, log)
    }

    #[test]
    fn a_flight_is_told_from_take_off_to_landing() {
        let states = [0, 2, 4, 4, 6, 4, 24, 7, 8, 8];
        let (story, log) = told(states.map(|state| (state, -60.0)));
        assert_eq!(
            story,
            [
                "1 Relay 1 takes off.",
                "4 Relay 1 is backing up: a link is too weak.",
                "6 Relay 1 is flying home.",
                "7 Relay 1 lands.",
                "8 Relay 1 is down.",
            ]
        );
        let flight = log.flight().expect("it flew");
        assert_eq!(flight.lasts(Instant::from_millis(99_000)), Duration::from_secs(7));
    }

    #[test]
    fn a_link_is_told_once_it_has_been_weak_for_three_seconds() {
        let weak =
            [-60.0, -68.0, -60.0, -68.0, -68.0, -69.0, -68.0, -68.0, -74.0, -74.0, -74.0, -75.0];
        let (story, _) = told(weak.map(|rssi| (4, rssi)));
        assert_eq!(
            story,
            [
                "0 Relay 1 is in the air, relaying.",
                "6 The link of relay 1 to the base is weak: -68 dBm, below the launch limit of -67.",
                "11 The link of relay 1 to the base is too weak: -75 dBm, below the retreat limit of -72.",
            ]
        );
    }

    #[test]
    fn the_clock_of_a_second_flight_begins_anew() {
        let states = [0, 2, 4, 8, 8, 2, 4, 4];
        let (_, log) = told(states.map(|state| (state, -60.0)));
        let flight = log.flight().expect("it flies");
        assert_eq!(
            (flight.lasts(Instant::from_millis(12_000)), flight.ended),
            (Duration::from_secs(2), None)
        );
    }

    #[test]
    fn nothing_is_told_of_a_drone_on_the_ground() {
        let (story, log) = told([(0, -90.0), (1, -90.0), (1, -90.0), (1, -90.0), (1, -90.0)]);
        assert!(story.is_empty() && log.flight().is_none(), "{story:?}");
    }
}
