//! Runs the whole `onboard::Drone` of each relay over a recorded flight, with the strengths of the
//! log.
//!
//! A log has no packets, so the drone's link stays shut, and the reports come to it as they do from
//! an ideal link: each neighbour is given the simplest report of a link of the chain, and the base
//! that of a base. The order is to explore. The logged strengths were filtered on board already, so
//! the drone does not filter them again.

use airlink::Sealed;
use chain::filter::Smoothing;
use chain::neighbours::Heard;
use chain::policy::PolicyConfig;
use chain::report::Report;
use onboard::{ChainDuty, Config, Drone, Duty, Sensed, Setup, Start, State};
use serde::Serialize;
use units::{Instant, LinkSum, Metres, MetresPerSecond, NodeId, Order, Phase, Role};

use super::recording::{Recording, Sample};

/// The states of one relay's agent, as parts of the rows, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AgentReport {
    /// The relay's number; the head is 0.
    pub relay: usize,
    /// The number of rows of the log.
    pub rows: usize,
    /// The part of the rows in which the relay makes its links equal.
    pub relaying: f64,
    /// The part of the rows in which the relay searches for the drone in front, or waits for it.
    pub reconnecting: f64,
    /// The part of the rows in which the relay flies back towards the base.
    pub backing_up: f64,
    /// The time at which the relay landed, in seconds of the log; `None` if it did not land.
    pub landed_s: Option<f64>,
}

/// The states of the agents of all relays of the flight.
pub(super) fn agents(recording: &Recording) -> Vec<AgentReport> {
    (1..recording.links.len()).map(|relay| report(recording, relay)).collect()
}

fn report(recording: &Recording, relay: usize) -> AgentReport {
    let mut drone = drone(relay);
    let last = recording.links.len();
    let height = Some(drone.config().agent.flight.height);
    let sensed = Sensed { height, ..Sensed::NONE };
    let mut tally = Tally::default();
    for (n, row) in recording.samples.chunk_by(|a, b| a.line == b.line).enumerate() {
        let Some(now) = row.first().map(|sample| sample.time) else { continue };
        let sequence = n as u16;
        for report in row.iter().filter_map(|sample| heard(sample, relay, last, sequence)) {
            drone.hear(now, report);
        }
        drone.heed(now, Order::Explore(MetresPerSecond::ZERO));
        drone.step(now, &sensed);
        tally.add(now, drone.state());
    }
    tally.report(relay)
}

/// A relay in the air at the start of the log, without keys: it sends no packet.
fn drone(relay: usize) -> Drone<Sealed> {
    let mut config = Config::DEFAULT;
    config.agent.policy = PolicyConfig { smoothing: Smoothing::Raw, ..PolicyConfig::K_TUNED };
    let start = Start::InAir(Instant::ZERO);
    // A chain of more than 256 drones does not come out of a checked flight.
    let setup = Setup { start, ..Setup::new(number(relay), Role::Relay) };
    Drone::new(config, &setup)
}

/// The rows of the log by the agent's state.
#[derive(Default)]
struct Tally {
    rows: usize,
    relaying: usize,
    reconnecting: usize,
    backing_up: usize,
    landed_s: Option<f64>,
}

impl Tally {
    fn add(&mut self, now: Instant, state: State) {
        self.rows += 1;
        match state {
            State::OnMission(Duty::Chain(duty)) => match duty {
                ChainDuty::Relaying { .. } => self.relaying += 1,
                ChainDuty::Reconnecting { .. } => self.reconnecting += 1,
                ChainDuty::BackingUp { .. } => self.backing_up += 1,
                ChainDuty::Leading { .. } | ChainDuty::Searching { .. } | ChainDuty::Retiring => {}
            },
            State::Landing { .. } | State::Landed { .. } => {
                self.landed_s.get_or_insert(now.as_micros() as f64 / 1e6);
            }
            State::Idle | State::Armed { .. } | State::TakingOff { .. } | State::Stopped => {}
        }
    }

    fn report(self, relay: usize) -> AgentReport {
        let part =
            |count: usize| if self.rows == 0 { 0.0 } else { count as f64 / self.rows as f64 };
        AgentReport {
            relay,
            rows: self.rows,
            relaying: part(self.relaying),
            reconnecting: part(self.reconnecting),
            backing_up: part(self.backing_up),
            landed_s: self.landed_s,
        }
    }
}

/// The report that this relay hears with one sample: link n joins drones n and n + 1.
fn heard(sample: &Sample, relay: usize, last: usize, sequence: u16) -> Option<Heard> {
    let from = match sample.link {
        link if link + 1 == relay => link,
        link if link == relay => link + 1,
        _ => return None,
    };
    let report = Report {
        from: number(from),
        sequence,
        phase: if from == last { Phase::Base } else { Phase::Linked },
        velocity: MetresPerSecond::ZERO,
        odometer: Metres::ZERO,
        links: None,
        sums: [LinkSum::NONE; 2],
        waiting: 0,
        head_velocity: MetresPerSecond::ZERO,
        recall: false,
    };
    Some(Heard { report, rssi: sample.rssi, reverse: None })
}

fn number(drone: usize) -> NodeId {
    NodeId(u8::try_from(drone).unwrap_or(u8::MAX))
}
