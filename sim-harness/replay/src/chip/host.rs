//! Runs a replay on the host, by the type that the chip runs.

use airlink::Sealed;
use onboard::Drone;
use onboard::replay::{Answer, NoStopwatch, Request, Session, Step, Stepped};

use crate::plan::Run;

/// A drone on the host that replays.
pub(crate) struct Host {
    session: Session,
    drone: Box<Drone<Sealed>>,
}

impl Host {
    /// A drone that replays nothing yet.
    pub(crate) fn new() -> Self {
        Self { session: Session::new(), drone: Box::new(Drone::switched_off()) }
    }

    /// Begins a run.
    pub(crate) fn begin(&mut self, run: &Run) -> Answer {
        self.session.answer(&mut self.drone, &Request::Begin(run.begin), &NoStopwatch)
    }

    /// Runs a round; `None` where no run has begun.
    pub(crate) fn step(&mut self, step: &Step) -> Option<Stepped> {
        let request = Request::Step(step.clone());
        match self.session.answer(&mut self.drone, &request, &NoStopwatch) {
            Answer::Stepped(stepped) => Some(stepped),
            Answer::Begun | Answer::Refused(_) => None,
        }
    }
}
