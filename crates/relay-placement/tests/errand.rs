//! The phases of an errand: a robot that does as it is told stays near its goal, and ends by dropping
//! its relay.

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use proptest::prelude::*;
use relay_placement::{Act, Errand, ErrandConfig, Ground, Pattern, Tour};
use units::{Duration, Instant, Metres, Point2};

const SIDE: u16 = 40;
const CELLS: usize = 1600;
const GOAL: Cell = Cell::new(20, 20);
const WITHIN: f32 = 6.0;

/// The cells of a map of 40 by 40 cells of 0.5 m, some of which are walls.
fn grounds() -> impl Strategy<Value = Ground<CELLS>> {
    proptest::collection::vec(proptest::bool::weighted(0.15), CELLS).prop_map(|walls| {
        let frame = Frame::new(Point2::new(-3.0, 7.0), Metres(0.5), SIDE, SIDE).unwrap();
        let mut map = GridMap::<400>::new(frame).unwrap();
        for (cell, wall) in frame.cells().zip(walls) {
            let is_wall = wall && cell != GOAL;
            map.set(cell, if is_wall { CellState::Occupied } else { CellState::Free });
        }
        Ground::new(&map, &mut Planner::<800, 2000>::new(), GOAL).unwrap()
    })
}

fn patterns() -> impl Strategy<Value = Pattern> {
    prop::sample::select(Pattern::ALL.to_vec())
}

fn off_goal(ground: &Ground<CELLS>, cell: Cell) -> f32 {
    let (at, goal) = (ground.frame().centre(cell), ground.frame().centre(GOAL));
    (at.x - goal.x).hypot(at.y - goal.y)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_tour_stays_near_its_goal(ground in grounds(), pattern in patterns(), seed: u64) {
        let goal = ground.frame().centre(GOAL);
        let mut tour = Tour::new(pattern, goal, Metres(WITHIN), seed);
        let mut at = GOAL;
        for _ in 0..200 {
            let Some(next) = tour.next(&ground, at) else { break };
            prop_assert!(ground.is_reached(next));
            prop_assert!(off_goal(&ground, next) <= WITHIN + 1e-3, "{pattern:?}");
            at = next;
        }
    }

    /// A robot that needs 20 s for each way ends within the time for gathering and two ways.
    #[test]
    fn an_errand_ends_with_a_drop(ground in grounds(), pattern in patterns(), seed: u64) {
        let config = ErrandConfig { within: Metres(WITHIN), ..ErrandConfig::DEFAULT };
        let mut errand = Errand::new(config, &ground, GOAL, pattern, seed);
        let start = ground.reached().next().unwrap();
        let place = ground.reached().last().unwrap();
        let (mut at, mut now) = (start, Instant::ZERO);
        let mut was_at_goal = false;
        loop {
            was_at_goal |= at == GOAL;
            match errand.step(now, &ground, at) {
                Act::Drive(to) => at = to,
                Act::Choose => errand.choose(place),
                Act::Drop => break,
            }
            now = now + Duration::from_secs(20);
            prop_assert!(now.since(Instant::ZERO) <= config.gathering + Duration::from_secs(120));
        }
        prop_assert!(was_at_goal && at == place);
    }
}

/// In the open a zig-zag and a spiral come to an end, and see all parts of the area.
#[test]
fn planned_patterns_cover_the_area() {
    let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.5), SIDE, SIDE).unwrap();
    let mut map = GridMap::<400>::new(frame).unwrap();
    frame.cells().for_each(|cell| {
        map.set(cell, CellState::Free);
    });
    let ground = Ground::<CELLS>::new(&map, &mut Planner::<800, 2000>::new(), GOAL).unwrap();
    for pattern in [Pattern::ZigZag, Pattern::Spiral] {
        let mut tour = Tour::new(pattern, frame.centre(GOAL), Metres(WITHIN), 1);
        let mut targets = Vec::new();
        while let Some(cell) = tour.next(&ground, GOAL) {
            targets.push(cell);
            assert!(targets.len() < 200, "{pattern:?} goes on");
        }
        for (east, north) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
            let side = |cell: &&Cell| {
                (i32::from(cell.column) - 20) * east >= 0 && (i32::from(cell.row) - 20) * north >= 0
            };
            assert!(targets.iter().filter(side).count() >= 3, "{pattern:?} {east} {north}");
        }
    }
}
