//! The metrics of a swarm's mission.

use agent::{Duty, LandReason, State, SwarmConfig, SwarmDuty};
use units::{Metres, MissionKind, Point2};
use world::World;

use crate::truth::{Reached, frame_about};
use bodies::Body;
use mission::Mission;
use scenario::Scenario;

/// The metrics of a swarm's mission. A time that was never reached is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmMetrics {
    /// The part of the areas within the sensors' range of which a drone has flown, where a drone's body can
    /// come to.
    pub covered: f32,
    /// The number of drones that the scenario has taken from the swarm.
    pub lost: u32,
    /// When the last drone had surveyed its rows, s.
    pub surveyed_s: f32,
    /// When the first drone set out into the passage, s.
    pub gathered_s: f32,
    /// When the last drone had flown the whole plan, with the second area where it is surveyed, and began to
    /// land, s.
    pub across_s: f32,
    /// The least distance of two flying drones, five times a second, m.
    pub closest_drones_m: f32,
    /// The number of drones that neither finished nor came home when they were called, without those that
    /// the scenario loses.
    pub unfinished: u32,
}

/// Collects the metrics of a swarm's mission, round by round.
pub(super) struct SwarmRecord {
    drones: usize,
    /// What drones have not been near of the area; `None` before the first sample.
    area: Option<Uncovered>,
    metrics: SwarmMetrics,
}

impl SwarmRecord {
    /// A record without samples, where the scenario is that of a swarm.
    pub(super) fn of(scenario: &Scenario) -> Option<Self> {
        let never = f32::INFINITY;
        let metrics = SwarmMetrics {
            covered: 0.0,
            lost: 0,
            surveyed_s: never,
            gathered_s: never,
            across_s: never,
            closest_drones_m: never,
            unfinished: 0,
        };
        let drones = scenario.drones.flying();
        (scenario.mission == MissionKind::Swarm).then_some(Self { drones, area: None, metrics })
    }

    /// Takes one sample, at the end of a round.
    pub(super) fn look(&mut self, scenario: &Scenario, world: &World, mission: &Mission<'_>) {
        self.cover(scenario, world, mission);
        let now_s = (mission.time_us() as f64 * 1e-6) as f32;
        let states: Vec<_> = mission
            .states()
            .take(self.drones)
            .enumerate()
            .filter_map(|(drone, state)| (!mission.is_lost(drone)).then_some(state))
            .collect();
        let metrics = &mut self.metrics;
        let note = |time: &mut f32, reached: bool| {
            if reached && time.is_infinite() {
                *time = now_s;
            }
        };
        let lands = |state: &State, reason: LandReason| {
            use State::{Landed, Landing};
            matches!(state, Landing { why, .. } | Landed { why } if *why == reason)
        };
        let finished = |state: &State| lands(state, LandReason::Done);
        let crosses = |state: &State| {
            matches!(state, State::OnMission(Duty::Swarm(SwarmDuty::Crossing))) || finished(state)
        };
        let gathers =
            |state: &State| matches!(state, State::OnMission(Duty::Swarm(SwarmDuty::Gathering)));
        let has_surveyed = |state: &State| gathers(state) || crosses(state);
        note(&mut metrics.surveyed_s, states.iter().all(has_surveyed));
        note(&mut metrics.gathered_s, states.iter().any(crosses));
        note(&mut metrics.across_s, states.iter().all(finished));
        let is_over = |state: &&State| finished(state) || lands(state, LandReason::Home);
        metrics.unfinished = states.iter().filter(|state| !is_over(state)).count() as u32;
        metrics.closest_drones_m = metrics.closest_drones_m.min(closest(mission, self.drones));
    }

    /// Notes what of the area the flying drones are near.
    fn cover(&mut self, scenario: &Scenario, world: &World, mission: &Mission<'_>) {
        let bodies = || mission.bodies().take(self.drones);
        let area = self.area.get_or_insert_with(|| {
            let starts: Vec<_> = bodies().map(Body::position).collect();
            area_of(scenario, world, &starts)
        });
        let near = scenario.agent.swarm.forces.obstacle_range;
        for body in bodies().filter(|body| body.height() > 0.0) {
            let at = body.position();
            area.left.retain(|cell| cell.distance(at) > near);
        }
        let covered = area.cells - area.left.len();
        self.metrics.covered = covered as f32 / area.cells.max(1) as f32;
        let numbers = 0..self.drones;
        self.metrics.lost = numbers.filter(|drone| mission.is_lost(*drone)).count() as u32;
    }

    /// The metrics of what was sampled.
    pub(super) const fn metrics(&self) -> SwarmMetrics {
        self.metrics
    }
}

/// The cells of an area that no drone has been near.
struct Uncovered {
    left: Vec<Point2>,
    /// The number of all cells of the area.
    cells: usize,
}

/// The areas that are surveyed, in cells to which drones can come that start at these places, none of them
/// covered.
fn area_of(scenario: &Scenario, world: &World, starts: &[Point2]) -> Uncovered {
    let swarm = scenario.agent.swarm;
    let SwarmConfig { corner, area, passage, both, .. } = swarm;
    let areas = [(corner, area), (swarm.second_corner(), area)];
    let areas = areas.into_iter().take(if both { 2 } else { 1 });
    // The way from one area to the other leads through the passage.
    let far = |(at, (east, north)): (Point2, (Metres, Metres))| {
        [at, Point2::new(at.x + east.0, at.y + north.0)]
    };
    let places: Vec<_> =
        areas.clone().flat_map(far).chain([passage.entrance]).chain(starts.to_vec()).collect();
    let Some(frame) = frame_about((corner, area), &places) else {
        return Uncovered { left: Vec::new(), cells: 0 };
    };
    let reached = Reached::new(frame, world, scenario.vehicle.radius, starts);
    let is_within = |at: &Point2| {
        areas.clone().any(|(corner, (east, north))| {
            let (x, y) = (at.x - corner.x, at.y - corner.y);
            (0.0..=east.0).contains(&x) && (0.0..=north.0).contains(&y)
        })
    };
    let centres = reached.cells().map(|cell| frame.centre(cell));
    let left: Vec<_> = centres.filter(is_within).collect();
    Uncovered { cells: left.len(), left }
}

/// The least distance of two of the first `drones` members that fly, m; infinite without two.
pub(super) fn closest(mission: &Mission<'_>, drones: usize) -> f32 {
    let flying: Vec<_> = mission
        .bodies()
        .take(drones)
        .filter(|body| body.height() > 0.0)
        .map(Body::position)
        .collect();
    let mut closest = f32::INFINITY;
    for (n, one) in flying.iter().enumerate() {
        for other in flying.iter().skip(n + 1) {
            let Metres(apart) = one.distance(*other);
            closest = closest.min(apart);
        }
    }
    closest
}
