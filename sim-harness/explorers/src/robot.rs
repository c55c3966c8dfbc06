//! One robot: its map, its sensors, and its way to the goal that it was given.

use std::ops::ControlFlow;

use frontier::{Candidate, Candidates, SPACING, extract};
use grid_map::{Cell, CellState, Clearance, GridMap, Planner, RayEnd, STRAIGHT_COST};
use units::{Metres, Point2};

use crate::world::World;

/// Fastest flight and turn, and the camera's field of view and range (thesis, table 3.1).
const SPEED: f32 = 0.3;
const TURN: f32 = 0.3;
const VIEW: f32 = std::f32::consts::FRAC_PI_3;
const REACH: f32 = 4.0;
const RAYS: u16 = 90;
/// The seconds that a robot takes for a goal beyond twice those of the straight flight there: the
/// time-out of progress of explore_lite.
const PATIENCE: f32 = 30.0;
/// The least clearance, in squares of cells: 0.2 m.
const CLEAR: u8 = 4;
/// A goal lies at most so many cells beside the candidate.
const BESIDE: i16 = 4;

/// A robot as a point.
pub(crate) struct Robot {
    pub(crate) position: Point2,
    pub(crate) yaw: f32,
    pub(crate) map: Box<GridMap<1600>>,
    clearance: Box<Clearance<6400>>,
    planner: Box<Planner<3200, 4096>>,
    costs: Vec<Option<u32>>,
    pub(crate) goal: Option<Candidate>,
    way: Vec<Cell>,
    /// The seconds after which the robot gives the goal up.
    patience: f32,
    pub(crate) flown: f32,
    /// Candidates that could not be reached or were of no use, and until when.
    barred: Vec<(Point2, f32)>,
}

impl Robot {
    pub(crate) fn new(position: Point2, yaw: f32) -> Self {
        let frame = World::frame();
        let mut map = GridMap::new(frame).expect("room for 6400 cells");
        for cell in frame.cells().filter(|&c| frame.centre(c).distance(position).0 < 0.35) {
            map.set(cell, CellState::Free);
        }
        Self {
            position,
            yaw,
            map: Box::new(map),
            clearance: Box::new(Clearance::new(frame).expect("room for 6400 cells")),
            planner: Box::new(Planner::new()),
            costs: vec![None; frame.cell_count()],
            goal: None,
            way: Vec::new(),
            patience: 0.0,
            flown: 0.0,
            barred: Vec::new(),
        }
    }

    /// Looks with the camera ahead and the ranger to four sides.
    pub(crate) fn sense(&mut self, world: &World) {
        let fan = (0..=RAYS).map(|n| (f32::from(n) / f32::from(RAYS) - 0.5) * VIEW);
        let sides = (1..4).map(|n| n as f32 * std::f32::consts::FRAC_PI_2);
        for off in fan.chain(sides) {
            let (end, is_wall) = world.ray(self.position, self.yaw + off, REACH);
            let what = if is_wall { RayEnd::Obstacle } else { RayEnd::Clear };
            self.map.trace(self.position, end, what);
        }
    }

    pub(crate) fn candidates(&self) -> Candidates {
        extract(&self.map, SPACING)
    }

    /// Computes the ways to all cells.
    pub(crate) fn plan(&mut self) {
        let frame = World::frame();
        let _ = self.clearance.update(&self.map);
        self.costs.fill(None);
        let Some(start) = frame.cell_at(self.position) else { return };
        let Self { map, clearance, planner, costs, .. } = self;
        // A robot that stands too near a wall may leave it.
        let own = clearance.squared(start).unwrap_or(CLEAR).min(CLEAR);
        let factor = |cell| {
            let is_clear = clearance.squared(cell).is_none_or(|square| square >= own.max(1));
            (map.state(cell) == CellState::Free && is_clear).then_some(1)
        };
        let _ = planner.search(&frame, start, factor, |visit| {
            costs[place(visit.cell)] = Some(visit.cost);
            ControlFlow::Continue(())
        });
    }

    /// The reachable cell nearest to a candidate, and the length of the way there.
    pub(crate) fn way_to(&self, candidate: Point2) -> Option<(Cell, Metres)> {
        let frame = World::frame();
        let middle = frame.cell_at(candidate)?;
        let around = (-BESIDE..=BESIDE).flat_map(|n| (-BESIDE..=BESIDE).map(move |e| (e, n)));
        let (cell, cost) = around
            .filter_map(|(east, north)| frame.beside(middle, east, north))
            .filter_map(|cell| Some((cell, self.costs[place(cell)]?)))
            .min_by(|a, b| {
                let off = |cell| frame.centre(cell).distance(candidate).0;
                off(a.0).total_cmp(&off(b.0))
            })?;
        Some((cell, Metres(cost as f32 / STRAIGHT_COST as f32 * frame.resolution().0)))
    }

    /// Takes a goal, to which [`plan`](Self::plan) has just found the way; says whether it has.
    pub(crate) fn take(&mut self, goal: Candidate) -> bool {
        let Some((cell, length)) = self.way_to(goal.position) else { return false };
        self.patience = PATIENCE + 2.0 * length.0 / SPEED;
        self.way = self.planner.way_back(cell).collect();
        self.goal = Some(goal);
        true
    }

    /// Flies on for `dt` seconds; says whether the goal is reached and looked at.
    pub(crate) fn fly(&mut self, dt: f32) -> bool {
        let Some(goal) = self.goal else { return false };
        let frame = World::frame();
        self.patience -= dt;
        if self.patience <= 0.0 {
            return true;
        }
        // A robot that has cut a corner is nearer to the cell after next, and has passed the next.
        let off = |cell: &Cell| frame.centre(*cell).distance(self.position).0;
        while match self.way.as_slice() {
            [.., after, next] => off(next) < 0.1 || off(after) <= off(next),
            [next] => off(next) < 0.1,
            [] => false,
        } {
            self.way.pop();
        }
        if let Some(cell) = self.way.last() {
            if self.map.state(*cell) == CellState::Occupied {
                return true;
            }
            // Looking ahead by three cells smooths the way of a grid.
            let ahead = self.way[self.way.len().saturating_sub(3)];
            let to = frame.centre(ahead);
            if self.turn_to(to, dt).abs() < 0.5 {
                let step = (SPEED * dt).min(self.position.distance(to).0);
                self.position.x += step * self.yaw.cos();
                self.position.y += step * self.yaw.sin();
                self.flown += step;
            }
            return false;
        }
        self.turn_to(goal.position, dt).abs() < 0.1 || !self.is_worth(goal.position)
    }

    /// Whether a place is still a frontier of this map.
    pub(crate) fn is_worth(&self, at: Point2) -> bool {
        World::frame().cell_at(at).is_some_and(|cell| self.map.is_frontier(cell))
    }

    /// Bars a place until then; the third time for good.
    pub(crate) fn bar(&mut self, at: Point2, until: f32) {
        let times = self.barred.iter().filter(|(other, _)| is_same(*other, at)).count();
        self.barred.push((at, if times < 2 { until } else { f32::INFINITY }));
    }

    /// Until when a place is barred.
    pub(crate) fn barred_until(&self, at: Point2) -> f32 {
        let bars = self.barred.iter().filter(|(other, _)| is_same(*other, at));
        bars.map(|(_, until)| *until).fold(0.0, f32::max)
    }

    /// Turns toward a point, and returns the angle that is left.
    fn turn_to(&mut self, to: Point2, dt: f32) -> f32 {
        let wanted = (to.y - self.position.y).atan2(to.x - self.position.x);
        let off = (wanted - self.yaw + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU)
            - std::f32::consts::PI;
        let step = off.clamp(-TURN * dt, TURN * dt);
        self.yaw += step;
        off - step
    }
}

fn place(cell: Cell) -> usize {
    usize::from(cell.row) * usize::from(crate::world::SIDE) + usize::from(cell.column)
}

fn is_same(a: Point2, b: Point2) -> bool {
    a.distance(b).0 < 0.2
}
