//! Runs the `agent::Agent` of each relay over a recorded flight, with the strengths of the log.
//!
//! A log has no reports, so each neighbour is given the simplest report of a link of the chain, and
//! the base that of a base. The order is to explore. The logged strengths were filtered on board
//! already, so the agent takes them as they are.

use agent::{Agent, AgentConfig, Fitness, Inputs, State};
use chain::filter::Smoothing;
use chain::neighbours::Heard;
use chain::policy::PolicyConfig;
use chain::report::Report;
use serde::Serialize;
use tunnel_nav::Diagonals;
use units::{LinkSum, Metres, MetresPerSecond, NodeId, Order, Phase, Role};

use super::recording::{Recording, Sample};

/// The states of one relay's agent, as parts of the rows, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AgentReport {
    /// The relay's number; the head is 0.
    pub relay: usize,
    /// Rows of the log.
    pub rows: usize,
    /// The part in which it makes its links equal.
    pub relaying: f64,
    /// The part in which it looks for the drone in front, or waits for it.
    pub reconnecting: f64,
    /// The part in which it flies back towards the base's side.
    pub backing_up: f64,
    /// When it landed, in seconds of the log.
    pub landed_s: Option<f64>,
}

/// The agents of all relays of the flight.
pub(super) fn agents(recording: &Recording) -> Vec<AgentReport> {
    (1..recording.links.len()).map(|relay| report(recording, relay)).collect()
}

fn report(recording: &Recording, relay: usize) -> AgentReport {
    let policy = PolicyConfig { smoothing: Smoothing::Raw, ..PolicyConfig::K_TUNED };
    let config = AgentConfig { policy, ..AgentConfig::DEFAULT };
    // A chain of more than 256 drones does not come out of a checked flight.
    let mut agent = Agent::new_linked(number(relay), Role::Relay, units::Instant::ZERO);
    let mut report = AgentReport { relay, ..AgentReport::default() };
    let (mut relaying, mut reconnecting, mut backing_up) = (0_usize, 0_usize, 0_usize);
    for (n, row) in recording.samples.chunk_by(|a, b| a.line == b.line).enumerate() {
        let Some(now) = row.first().map(|sample| sample.time) else { continue };
        let sequence = n as u16;
        let last = recording.links.len();
        let heard: Vec<Heard> =
            row.iter().filter_map(|sample| heard(sample, relay, last, sequence)).collect();
        let outputs = agent.step(
            &config,
            now,
            &Inputs {
                ranges: Diagonals::default(),
                velocity: None,
                heading: None,
                height: Some(Metres(config.flight.height.0)),
                heard: &heard,
                order: Some(Order::Explore(MetresPerSecond::ZERO)),
                fitness: Fitness::Fit,
                endurance: None,
            },
        );
        report.rows += 1;
        match outputs.status.state {
            State::Relaying { .. } => relaying += 1,
            State::Reconnecting { .. } => reconnecting += 1,
            State::BackingUp { .. } => backing_up += 1,
            State::Landing { .. } | State::Landed { .. } => {
                report.landed_s.get_or_insert(now.as_micros() as f64 / 1e6);
            }
            State::Idle
            | State::Armed { .. }
            | State::TakingOff { .. }
            | State::Leading { .. }
            | State::Stopped => {}
        }
    }
    let part =
        |count: usize| if report.rows == 0 { 0.0 } else { count as f64 / report.rows as f64 };
    AgentReport {
        relaying: part(relaying),
        reconnecting: part(reconnecting),
        backing_up: part(backing_up),
        ..report
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
