//! The drone's part of a replay: a request in, an answer out.

use airlink::Seal;
use chain::filter::Smoothing;
use heapless::Vec;

use super::launch::LaunchRule;
use super::record::{Answer, Begin, Refusal, Request, Step, Stepped};
use crate::{Config, Drone, Outputs, Sensed, Setup, Start};

/// A count of the processor's cycles.
pub trait Stopwatch {
    /// Runs a round, and returns its result and the cycles that it took.
    fn time<R>(&self, round: impl FnOnce() -> R) -> (R, u32);
}

/// A host has no such count: every round takes no cycle.
#[derive(Clone, Copy, Debug)]
pub struct NoStopwatch;

impl Stopwatch for NoStopwatch {
    fn time<R>(&self, round: impl FnOnce() -> R) -> (R, u32) {
        (round(), 0)
    }
}

/// The state of a replay between two requests. The drone itself is its caller's.
#[derive(Debug, Default)]
pub struct Session {
    /// `None` before a replay has begun.
    launch: Option<LaunchRule>,
}

impl Session {
    /// A session in which no replay has begun.
    #[must_use]
    pub const fn new() -> Self {
        Self { launch: None }
    }

    /// Carries out a request on `drone`, which runs nothing else from the first [`Request::Begin`]
    /// on: the drone is then another one, without keys, that neither sends nor receives packets.
    /// `stopwatch` counts the cycles of a round.
    #[inline(never)]
    pub fn answer<S: Seal>(
        &mut self,
        drone: &mut Drone<S>,
        request: &Request,
        stopwatch: &impl Stopwatch,
    ) -> Answer {
        match request {
            Request::Begin(begin) => match self.begin(drone, begin) {
                Ok(()) => Answer::Begun,
                Err(why) => Answer::Refused(why),
            },
            Request::Step(step) => match self.step(drone, step, stopwatch) {
                Ok(stepped) => Answer::Stepped(stepped),
                Err(why) => Answer::Refused(why),
            },
        }
    }

    fn begin<S: Seal>(&mut self, drone: &mut Drone<S>, begin: &Begin) -> Result<(), Refusal> {
        let policy = begin.policy()?;
        let mut config = Config::DEFAULT;
        config.agent.policy = policy.config;
        if begin.is_filtered {
            config.agent.policy.smoothing = Smoothing::Raw;
        }
        let start = begin
            .in_air
            .map_or(Start::OnGround, |at| Start::InAir { at, flown: units::Metres::ZERO });
        drone.begin(config, &Setup { start, ..Setup::new(begin.node, begin.role) });
        self.launch = Some(LaunchRule::new(begin.links.into()));
        Ok(())
    }

    fn step<S: Seal>(
        &mut self,
        drone: &mut Drone<S>,
        step: &Step,
        stopwatch: &impl Stopwatch,
    ) -> Result<Stepped, Refusal> {
        let launch = self.launch.as_mut().ok_or(Refusal::NotBegun)?;
        let agent = drone.config().agent;
        let strengths = step.strengths.iter().map(|(link, rssi)| (usize::from(*link), *rssi));
        let launches = launch.step(step.now, &agent.launch, agent.retreat.lost_after, strengths);
        for heard in &step.heard {
            drone.hear(step.now, *heard);
        }
        if let Some(order) = step.order {
            drone.heed(step.now, order);
        }
        let Step { velocity, ranges, height, .. } = *step;
        let sensed = Sensed { velocity, ranges, height, ..Sensed::NONE };
        let (outputs, cycles) = stopwatch.time(|| drone.step(step.now, &sensed));
        let Outputs { agent: outputs, .. } = outputs;
        let mut estimates = Vec::new();
        for estimate in drone.estimates() {
            // There is room for all: the drone keeps a table of as many.
            let _ = estimates.push(estimate);
        }
        Ok(Stepped { cycles, launches, outputs, estimates })
    }
}
