//! The metrics of drones that explore a place together.

use agent::{Exploration, LandReason, State};
use grid_map::{CellState, Frame};
use units::MissionKind;

use super::swarm::closest;
use crate::mission::{Mission, World};
use crate::scenario::Scenario;

/// The part of the cells that counts as explored.
const DONE: f32 = 0.99;
/// Cells whose middle is nearer to a wall are not counted: whether they are known depends on the noise
/// of the rangers, m.
const WALL: f32 = 0.05;

/// The metrics of an exploration. A time that was never reached is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExploreMetrics {
    /// The part of the free cells of the place that a drone knows at the end.
    pub explored: f32,
    /// When half of them were known, s.
    pub t50_s: f32,
    /// When 99 % of them were known, s.
    pub t99_s: f32,
    /// When the last drone had ended and began to land, s.
    pub ended_s: f32,
    /// The least distance of two flying drones, five times a second, m.
    pub closest_drones_m: f32,
    /// The number of drones that did not end, without those that the scenario loses.
    pub unfinished: u32,
}

/// Collects the metrics of an exploration, round by round.
pub(super) struct ExploreRecord {
    drones: usize,
    /// The frame of the drones' maps, and which of its cells are free.
    frame: Frame,
    free: Vec<bool>,
    metrics: ExploreMetrics,
}

impl ExploreRecord {
    /// A record without samples, where the drones of the scenario explore.
    pub(super) fn of(scenario: &Scenario, world: &World) -> Option<Self> {
        if scenario.mission != MissionKind::Explore {
            return None;
        }
        let frame = scenario.agent.explore.frame().ok()?;
        let is_free = |cell| {
            let at = frame.centre(cell);
            world.tunnel.is_free(at) && world.tunnel.clearance(at) > WALL
        };
        let free = frame.cells().map(is_free).collect();
        let never = f32::INFINITY;
        let metrics = ExploreMetrics {
            explored: 0.0,
            t50_s: never,
            t99_s: never,
            ended_s: never,
            closest_drones_m: never,
            unfinished: 0,
        };
        Some(Self { drones: scenario.drones.flying(), frame, free, metrics })
    }

    /// Takes one sample, at the end of a round.
    pub(super) fn look(&mut self, mission: &Mission<'_>) {
        let now_s = (mission.time_us() as f64 * 1e-6) as f32;
        let states = mission.states().take(self.drones).enumerate();
        let states: Vec<_> =
            states.filter_map(|(n, state)| (!mission.is_lost(n)).then_some(state)).collect();
        let has_ended = |state: &State| {
            use State::{Landed, Landing};
            matches!(state, Landing { why, .. } | Landed { why } if *why == LandReason::Done)
        };
        let explored = self.explored(mission);
        let metrics = &mut self.metrics;
        let note = |time: &mut f32, reached: bool| {
            if reached && time.is_infinite() {
                *time = now_s;
            }
        };
        metrics.explored = explored;
        note(&mut metrics.t50_s, explored >= 0.5);
        note(&mut metrics.t99_s, explored >= DONE);
        note(&mut metrics.ended_s, states.iter().all(has_ended));
        metrics.unfinished = states.iter().filter(|state| !has_ended(state)).count() as u32;
        metrics.closest_drones_m = metrics.closest_drones_m.min(closest(mission, self.drones));
    }

    /// The part of the free cells that a drone knows.
    fn explored(&self, mission: &Mission<'_>) -> f32 {
        let maps: Vec<&Exploration> =
            mission.explorations().filter(|map| *map.frame() == self.frame).collect();
        let is_known = |cell| maps.iter().any(|map| map.state(cell) != CellState::Unknown);
        let free = self.frame.cells().zip(&self.free).filter(|(_, is_free)| **is_free);
        let (known, all) = free.fold((0_u32, 0_u32), |(known, all), (cell, _)| {
            (known + u32::from(is_known(cell)), all + 1)
        });
        known as f32 / all.max(1) as f32
    }

    /// The metrics of what was sampled.
    pub(super) const fn metrics(&self) -> ExploreMetrics {
        self.metrics
    }
}
