//! What is watched while robots explore, for figures 3.14 to 3.17, 3.20 and 3.24: maps, candidates, ways,
//! and the targets that would be assigned half-way.

use explorers::{Glance, Outcome, Setup, World};
use frontier::{Distances, Place, Rule, assign};
use grid_map::{CellState, Frame, GridMap, TooManyCells};
use input::InputError;
use units::{Metres, Point2};

/// Bytes of a map of the thesis' room, four cells each.
const MAP: usize = 1_600;
/// The share that is known when targets are assigned for figure 3.17.
const HALF: f32 = 0.5;
/// Candidates are so far apart (thesis, table 3.1).
const SPACING: Metres = Metres(0.3);
/// The robots to which targets are assigned.
const PAIR: usize = 2;

/// A map of the room.
pub type Map = GridMap<MAP>;

/// One exploration, second by second.
#[derive(Clone, Debug)]
pub struct Watched {
    /// The candidates: free cells that border on what no robot knows.
    pub candidates: Vec<usize>,
    /// The frontiers of each robot's own map.
    pub frontiers: Vec<Vec<usize>>,
    /// The way of each robot, m.
    pub flown_m: Vec<Vec<f32>>,
    /// The distance between the first two robots, m.
    pub apart_m: Vec<f32>,
    /// The targets when half of the room was known, where two robots fly.
    pub targets: Option<Targets>,
}

/// What the first two robots are sent to, by the thesis' utility in three ways.
#[derive(Clone, Debug)]
pub struct Targets {
    /// The map of both robots.
    pub map: Map,
    /// Where the robots are.
    pub robots: [Point2; PAIR],
    /// The candidates, with the unknown cells around each.
    pub places: Vec<Place>,
    /// The first robot's target.
    pub first: Point2,
    /// The second robot's, where nothing keeps it from the first one's.
    pub alike: Point2,
    /// The second robot's, where the first one's is removed.
    pub removed: Point2,
    /// The second robot's, where the gains of candidates near the first one's are reduced, too.
    pub scheduled: Point2,
}

/// The pictures of one exploration: what all robots were and knew at each second.
pub type Film = Vec<Glance>;

impl Watched {
    /// Flies one exploration; returns what came of it, what was watched, and its pictures.
    pub(super) fn fly(setup: &Setup<'_>) -> (Outcome, Self, Film) {
        let mut film = Vec::new();
        let outcome = explorers::watch(setup, &mut |glance| film.push(glance));
        let mut watched = Self {
            candidates: Vec::new(),
            frontiers: Vec::new(),
            flown_m: Vec::new(),
            apart_m: Vec::new(),
            targets: None,
        };
        for (glance, known) in film.iter().zip(&outcome.curve) {
            watched.note(setup, glance, known.last().copied().unwrap_or(0.0));
        }
        (outcome, watched, film)
    }

    fn note(&mut self, setup: &Setup<'_>, glance: &Glance, known: f32) {
        // The room is no larger than a map.
        let Ok(union) = united(setup.world, &glance.maps) else { return };
        self.candidates.push(union.frontiers().count());
        let own = glance.maps.iter().map(|map| united(setup.world, std::slice::from_ref(map)));
        self.frontiers.push(own.map(|map| map.map_or(0, |map| map.frontiers().count())).collect());
        self.flown_m.push(glance.flown_m.clone());
        if let [one, other, ..] = glance.poses.as_slice() {
            self.apart_m.push(one.at.distance(other.at).0);
            if self.targets.is_none() && known >= HALF {
                self.targets = Targets::of(&setup.rule, union, [one.at, other.at]);
            }
        }
    }
}

/// The map of all robots: occupied where one says so, or else free where one says so.
pub fn united(world: &World, maps: &[Vec<CellState>]) -> Result<Map, TooManyCells> {
    let frame: Frame = *world.frame();
    let mut union = Map::new(frame)?;
    for (n, cell) in frame.cells().enumerate() {
        let states = || maps.iter().filter_map(|map| map.get(n)).copied();
        for state in [CellState::Free, CellState::Occupied] {
            if states().any(|it| it == state) {
                union.set(cell, state);
            }
        }
    }
    Ok(union)
}

impl Targets {
    /// The targets, where there are candidates for both robots.
    fn of(rule: &Rule, map: Map, robots: [Point2; PAIR]) -> Option<Self> {
        let mut places: Vec<Place> = Vec::new();
        for cell in map.frontiers() {
            let position = map.frame().centre(cell);
            if places.iter().all(|place| place.position.distance(position) >= SPACING) {
                places.push(Place { position, gain: f32::from(map.gain(cell)) });
            }
        }
        // The robot with the number `asked` is asked after the other one by this rule; with `alone`, as
        // if it were the first.
        let target = |rule: &Rule, asked: usize, alone: bool| {
            let mut left = places.clone();
            let order = if alone { [asked, 1 - asked] } else { [1 - asked, asked] };
            let robots = order.map(|n| robots[n]);
            let places = places.iter().map(|place| place.position).collect();
            let assigned = assign::<PAIR>(rule, &mut left, &Straight { robots, places });
            let at = usize::from(!alone);
            let own = assigned.iter().find(|it| it.robot == at)?;
            left.get(own.place).map(|place| place.position)
        };
        let removing = Rule { discount: None, ..*rule };
        Some(Self {
            first: target(rule, 0, true)?,
            alike: target(rule, 1, true)?,
            removed: target(&removing, 1, false)?,
            scheduled: target(rule, 1, false)?,
            map,
            robots,
            places,
        })
    }
}

/// Robots to which no way is barred.
struct Straight {
    robots: [Point2; PAIR],
    places: Vec<Point2>,
}

impl Distances for Straight {
    fn robots(&self) -> usize {
        PAIR
    }

    fn distance(&self, robot: usize, place: usize) -> Option<Metres> {
        Some(self.robots.get(robot)?.distance(*self.places.get(place)?))
    }
}

/// A quantity of one run at each second.
pub type Curve<'a> = &'a dyn Fn(&Watched) -> Vec<f32>;

/// The mean of a quantity at each second over all runs; a run that has ended keeps its last value.
#[must_use]
pub fn mean_curve(runs: &[Watched], curve: Curve<'_>) -> Vec<f32> {
    let curves: Vec<Vec<f32>> = runs.iter().map(curve).collect();
    let longest = curves.iter().map(Vec::len).max().unwrap_or(0);
    let value = |curve: &Vec<f32>, second: usize| {
        curve.get(second).or(curve.last()).copied().unwrap_or(0.0)
    };
    let mean = |second| {
        curves.iter().map(|curve| value(curve, second)).sum::<f32>() / curves.len().max(1) as f32
    };
    (0..longest).map(mean).collect()
}

/// All watched runs of one rule with one number of robots.
#[derive(Clone, Debug)]
pub struct WatchedRow {
    /// The name of the rule.
    pub rule: &'static str,
    /// The number of robots.
    pub robots: usize,
    /// The runs, in the order of their seeds.
    pub runs: Vec<Watched>,
    /// The pictures of the first run.
    pub film: Film,
}

/// Explores with so many seeds from that of the setup on.
pub(super) fn fly_all(
    rule: &'static str,
    setup: &Setup<'_>,
    seeds: usize,
    after_each: &(impl Fn() + Sync),
) -> Result<(Vec<Outcome>, WatchedRow), InputError> {
    let flown = super::measure::each_seed(setup, seeds, |again| {
        let (outcome, watched, film) = Watched::fly(again);
        after_each();
        // Only the first run is drawn.
        (outcome, watched, if again.seed == setup.seed { film } else { Vec::new() })
    })?;
    let mut row = WatchedRow { rule, robots: setup.robots, runs: Vec::new(), film: Vec::new() };
    let mut outcomes = Vec::new();
    for (outcome, watched, film) in flown {
        outcomes.push(outcome);
        row.runs.push(watched);
        row.film.extend(film);
    }
    Ok((outcomes, row))
}
