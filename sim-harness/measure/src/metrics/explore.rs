//! The metrics of drones that explore a place together.

use agent::{Duty, Exploration, ExploreDuty, LandReason, State};
use grid_map::{Cell, CellState};
use units::MissionKind;
use world::World;

use super::swarm::closest;
use crate::truth::{Truth, near};
use mission::Mission;
use scenario::Scenario;

/// The part of the cells that counts as explored.
const DONE: f32 = 0.99;

/// The metrics of an exploration. A time that was never reached is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExploreMetrics {
    /// The part that a drone knows at the end of the cells of the area to which a drone's body can come
    /// from where the drones started.
    pub explored: f32,
    /// The part of the walls beside those cells of which a map has a wall within a cell.
    pub walls_found: f32,
    /// The part of the walls that maps have which are more than a cell from any true one.
    pub false_walls: f32,
    /// The part of the cells that maps have as free which lie in the rock, more than a cell deep.
    pub false_free: f32,
    /// When half of the cells were known, s.
    pub t50_s: f32,
    /// When 99 % of them were known, s.
    pub t99_s: f32,
    /// When the last drone explored no more, s: it flew home since nothing was left, or began to land.
    pub ended_s: f32,
    /// The least distance of two flying drones, five times a second, m.
    pub closest_drones_m: f32,
    /// The number of drones that did not end, without those that the scenario loses.
    pub unfinished: u32,
}

/// Collects the metrics of an exploration, round by round.
pub(super) struct ExploreRecord {
    drones: usize,
    /// The true plan in the cells of the drones' maps; `None` before the first sample.
    truth: Option<Truth>,
    metrics: ExploreMetrics,
}

impl ExploreRecord {
    /// A record without samples, where the drones of the scenario explore.
    pub(super) fn of(scenario: &Scenario) -> Option<Self> {
        let (none, never) = (f32::NAN, f32::INFINITY);
        let metrics = ExploreMetrics {
            explored: 0.0,
            walls_found: none,
            false_walls: none,
            false_free: none,
            t50_s: never,
            t99_s: never,
            ended_s: never,
            closest_drones_m: never,
            unfinished: 0,
        };
        let drones = scenario.drones.flying();
        let explores = scenario.mission == MissionKind::Explore;
        explores.then_some(Self { drones, truth: None, metrics })
    }

    /// Takes one sample, at the end of a round.
    pub(super) fn look(&mut self, scenario: &Scenario, world: &World, mission: &Mission<'_>) {
        if self.truth.is_none() {
            let bodies = mission.bodies().take(self.drones);
            let starts: Vec<_> = bodies.map(|body| body.position()).collect();
            let frame = scenario.agent.explore.frame().ok();
            let radius = scenario.vehicle.radius;
            self.truth = frame.map(|frame| Truth::new(frame, world, radius, &starts));
        }
        let now_s = (mission.time_us() as f64 * 1e-6) as f32;
        let states = mission.states().take(self.drones).enumerate();
        let states: Vec<_> =
            states.filter_map(|(n, state)| (!mission.is_lost(n)).then_some(state)).collect();
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
        let is_over = |state: &State| {
            let returns = Duty::Explore(ExploreDuty::Returning { has_seen_all: true });
            *state == State::OnMission(returns) || has_ended(state)
        };
        note(&mut metrics.ended_s, states.iter().all(is_over));
        metrics.unfinished = states.iter().filter(|state| !has_ended(state)).count() as u32;
        metrics.closest_drones_m = metrics.closest_drones_m.min(closest(mission, self.drones));
    }

    /// The part that a drone knows of the cells to which a drone can come.
    fn explored(&self, mission: &Mission<'_>) -> f32 {
        let Some(truth) = &self.truth else { return 0.0 };
        let maps = maps(truth, mission);
        let is_known = |cell| maps.iter().any(|map| map.state(cell) != CellState::Unknown);
        part(truth.reached(), is_known).unwrap_or(0.0)
    }

    /// The metrics of what was sampled, with how right the maps are at the end.
    pub(super) fn metrics(&self, mission: &Mission<'_>) -> ExploreMetrics {
        let Some(truth) = &self.truth else { return self.metrics };
        let maps = maps(truth, mission);
        let is_in_a_map = |cell, state| maps.iter().any(|map| map.state(cell) == state);
        let frame = *truth.frame();
        let drawn = |state| frame.cells().filter(move |cell| is_in_a_map(*cell, state));
        let has_wall = |cell| is_in_a_map(cell, CellState::Occupied);
        let is_found = |cell: Cell| near(frame, cell, 1).any(has_wall);
        let or_none = |part: Option<f32>| part.unwrap_or(f32::NAN);
        ExploreMetrics {
            walls_found: or_none(part(truth.walls(), is_found)),
            false_walls: or_none(part(drawn(CellState::Occupied), |cell| truth.is_open(cell))),
            false_free: or_none(part(drawn(CellState::Free), |cell| truth.is_rock(cell))),
            ..self.metrics
        }
    }
}

/// Whether a drone has ended: it was stopped because nothing was left, or has flown home by itself.
fn has_ended(state: &State) -> bool {
    use State::{Landed, Landing};
    matches!(
        state,
        Landing { why: LandReason::Done | LandReason::Home, .. }
            | Landed { why: LandReason::Done | LandReason::Home }
    )
}

/// The maps of all drones in the cells of the true plan.
fn maps<'a>(truth: &Truth, mission: &'a Mission<'_>) -> Vec<&'a Exploration> {
    mission.explorations().filter(|map| map.frame() == truth.frame()).collect()
}

/// The part of some cells for which something is true; `None` where there are no cells.
fn part(cells: impl Iterator<Item = Cell>, is: impl Fn(Cell) -> bool) -> Option<f32> {
    let (mut those, mut all) = (0_u32, 0_u32);
    for cell in cells {
        those += u32::from(is(cell));
        all += 1;
    }
    (all > 0).then(|| those as f32 / all as f32)
}
