//! Runs the whole `onboard::Drone` of each relay over a recorded flight, with the strengths of the
//! log, by the [`plan`] of a replay on the chip.

use chain::policy::Policy;
use onboard::{ChainDuty, Duty, State};
use serde::Serialize;
use units::Instant;

use super::chip::Host;
use super::plan::{self, Run};
use recordings::recording::Recording;

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
    let policy = Policy::named("k-tuned").expect("the registry has it");
    plan::of_flight(recording, policy).iter().map(report).collect()
}

fn report(run: &Run) -> AgentReport {
    let mut host = Host::new();
    host.begin(run);
    let mut tally = Tally::default();
    for step in &run.steps {
        if let Some(stepped) = host.step(step) {
            tally.add(step.now, stepped.outputs.status.state);
        }
    }
    tally.report(run.begin.node.0.into())
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
            State::OnMission(Duty::Swarm(_) | Duty::Explore(_)) => {}
            State::OnMission(Duty::Chain(duty)) => match duty {
                ChainDuty::Relaying { .. } => self.relaying += 1,
                ChainDuty::Reconnecting { .. } => self.reconnecting += 1,
                ChainDuty::BackingUp { .. } => self.backing_up += 1,
                ChainDuty::Leading { .. }
                | ChainDuty::Searching { .. }
                | ChainDuty::Retiring
                | ChainDuty::Homing
                | ChainDuty::Rejoining { .. }
                | ChainDuty::Siting { .. } => {}
            },
            State::Landing { .. } | State::Landed { .. } => {
                self.landed_s.get_or_insert(now.as_micros() as f64 / 1e6);
            }
            State::Idle
            | State::Armed { .. }
            | State::TakingOff { .. }
            | State::Perched
            | State::Rising { .. }
            | State::Stopped => {}
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
