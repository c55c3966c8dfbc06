//! Evidence and rays.

use grid_map::{Area, Cell, CellState, Frame, FrameError, GridMap, RayEnd, TooManyCells};
use proptest::prelude::*;
use units::{Metres, Point2};

use super::{Map, draw, frame};

#[test]
fn a_wall_stands_two_rays_that_graze_it_and_an_error_is_gone_after_three() {
    let mut map = Map::new(frame(20, 1)).unwrap();
    let at = |column| map.frame().centre(Cell::new(column, 0));
    let (sensor, wall, beyond) = (at(0), at(9), at(15));
    let mut states = Vec::new();
    map.trace(sensor, wall, RayEnd::Obstacle);
    states.push(map.state(Cell::new(9, 0)));
    for _ in 0..3 {
        map.trace(sensor, beyond, RayEnd::Clear);
        states.push(map.state(Cell::new(9, 0)));
    }
    map.trace(sensor, wall, RayEnd::Obstacle);
    states.push(map.state(Cell::new(9, 0)));
    use CellState::{Free, Occupied, Unknown};
    assert_eq!(states, [Occupied, Occupied, Unknown, Free, Occupied]);
}

#[test]
fn a_ray_that_leaves_the_grid_frees_the_cells_on_its_way() {
    let mut map = Map::new(frame(8, 5)).unwrap();
    let from = map.frame().centre(Cell::new(1, 1));
    map.trace(from, Point2::new(from.x + 40.0, from.y + 20.0), RayEnd::Obstacle);
    let expected = "
??????..
????...?
??...???
?..?????
????????
";
    assert_eq!(draw(&map, |_| None), expected.trim_start());
}

#[test]
fn rays_from_outside_and_rays_that_are_no_numbers_change_nothing() {
    let empty = Map::new(frame(8, 5)).unwrap();
    let inside = empty.frame().centre(Cell::new(3, 3));
    for (from, to) in [
        (Point2::new(-9.0, 1.0), inside),
        (Point2::new(f32::NAN, 1.0), inside),
        (inside, Point2::new(f32::INFINITY, 1.0)),
        (inside, Point2::new(1.0, f32::NAN)),
    ] {
        let mut map = empty.clone();
        map.trace(from, to, RayEnd::Obstacle);
        assert_eq!(map, empty, "{from:?} to {to:?}");
    }
}

#[test]
fn impossible_frames_and_maps_are_refused() {
    let at = Point2::default();
    assert_eq!(Frame::new(at, Metres(0.1), 0, 3), Err(FrameError::Empty));
    assert_eq!(Frame::new(at, Metres(0.0), 3, 3), Err(FrameError::NotANumber));
    assert_eq!(Frame::new(at, Metres(f32::NAN), 3, 3), Err(FrameError::NotANumber));
    assert_eq!(Frame::new(at, Metres(0.1), Frame::MOST + 1, 3), Err(FrameError::TooLong));
    let refused = GridMap::<2>::new(frame(3, 3));
    assert_eq!(refused, Err(TooManyCells { cells: 9, room: 8 }));
}

/// A place in a frame of 32 by 32 cells, or somewhat outside.
fn point() -> impl Strategy<Value = Point2> {
    (-0.5..3.7f32, -0.5..3.7f32).prop_map(|(x, y)| Point2::new(x - 1.3, y + 0.7))
}

proptest! {
    /// The cells of a ray are those that the straight line crosses, each beside the one before.
    #[test]
    fn a_ray_frees_the_cells_on_the_line_and_no_others(from in point(), to in point()) {
        let mut map = Map::new(frame(32, 32)).unwrap();
        map.trace(from, to, RayEnd::Clear);
        let is_free = |cell: &Cell| map.state(*cell) == CellState::Free;
        for cell in map.frame().cells().filter(is_free) {
            let centre = map.frame().centre(cell);
            let off = distance_to_line(centre, from, to);
            prop_assert!(off <= 0.05 * 2f32.sqrt() + 1e-4, "{cell:?} lies {off} m off");
        }
        if let (Some(first), Some(last)) = (map.frame().cell_at(from), map.frame().cell_at(to)) {
            let apart = first.row.abs_diff(last.row) + first.column.abs_diff(last.column);
            prop_assert!(is_free(&first) && is_free(&last));
            prop_assert_eq!(map.count(CellState::Free), usize::from(apart) + 1);
        }
    }

    /// Beyond the rectangle that a ray returns no cell has another state than before, and both its rows and
    /// its columns at the edge have one.
    #[test]
    fn a_ray_tells_where_it_changed_states(rays in prop::collection::vec((point(), point(), any::<bool>()), 1..20)) {
        let mut map = Map::new(frame(32, 32)).unwrap();
        for (from, to, strikes) in rays {
            let before = map.clone();
            let end = if strikes { RayEnd::Obstacle } else { RayEnd::Clear };
            let area = map.trace(from, to, end);
            let is_other = |cell: &Cell| map.state(*cell) != before.state(*cell);
            let changed = map.frame().cells().filter(is_other).map(Area::of).reduce(Area::and);
            prop_assert_eq!(area, changed);
        }
    }

    /// The map is a clamped sum for each cell.
    #[test]
    fn evidence_is_a_clamped_sum(readings in prop::collection::vec((0..12u16, 0..12u16, any::<bool>()), 0..60)) {
        let mut map = Map::new(frame(12, 1)).unwrap();
        let mut sums = [0i8; 12];
        for (from, to, strikes) in readings {
            let end = if strikes { RayEnd::Obstacle } else { RayEnd::Clear };
            let at = |column| map.frame().centre(Cell::new(column, 0));
            map.trace(at(from), at(to), end);
            for column in from.min(to)..=from.max(to) {
                let by = if column == to && strikes { 2 } else { -1 };
                let sum = &mut sums[usize::from(column)];
                *sum = (*sum + by).clamp(-1, 2);
            }
        }
        for (column, sum) in sums.into_iter().enumerate() {
            let expected = match sum {
                0 => CellState::Unknown,
                ..0 => CellState::Free,
                1.. => CellState::Occupied,
            };
            prop_assert_eq!(map.state(Cell::new(column as u16, 0)), expected, "{}", column);
        }
    }

    /// No point is lost between two cells, and a cell's middle lies in it.
    #[test]
    fn cells_and_points_agree(point in point()) {
        let frame = frame(32, 32);
        if let Some(cell) = frame.cell_at(point) {
            let centre = frame.centre(cell);
            prop_assert!((centre.x - point.x).abs() <= 0.0501 && (centre.y - point.y).abs() <= 0.0501);
            prop_assert_eq!(frame.cell_at(centre), Some(cell));
        }
    }
}

fn distance_to_line(point: Point2, from: Point2, to: Point2) -> f32 {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length_squared = dx * dx + dy * dy;
    let along = if length_squared > 0.0 {
        (((point.x - from.x) * dx + (point.y - from.y) * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    Point2::new(from.x + along * dx, from.y + along * dy).distance(point).0
}
