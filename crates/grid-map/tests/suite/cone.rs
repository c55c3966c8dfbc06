//! What readings of cones show, against the true plan.

use grid_map::{Beam, Cell, CellState, Cone, Frame, GridMap, RayEnd, Side};
use proptest::prelude::*;
use units::{Metres, Point2, Radians};

use super::{Map, frame};

/// Half the cone of a VL53L1X as a whole, and where every surface is taken to give a reading.
const HALF: f32 = 13.5;
const CONE: Cone = Cone { sure: 0.131_65, whole: 0.240_08 };
/// How far the sensor sees, m.
const REACH: f32 = 2.0;

/// A wall from one point to another.
type Wall = [(f32, f32); 2];

/// The distance along a ray to the nearest wall.
fn ray(walls: &[Wall], from: Point2, angle: f32) -> Option<f32> {
    let (sin, cos) = Radians(angle).sin_cos();
    let hit = |[(ax, ay), (bx, by)]: &Wall| {
        let (ex, ey) = (bx - ax, by - ay);
        let cross = cos * ey - sin * ex;
        let (dx, dy) = (ax - from.x, ay - from.y);
        let along = (dx * ey - dy * ex) / cross;
        let part = (dx * sin - dy * cos) / cross;
        (along > 0.0 && (0.0..=1.0).contains(&part)).then_some(along)
    };
    walls.iter().filter_map(hit).filter(|along| *along <= REACH).min_by(f32::total_cmp)
}

/// What a sensor tells that sees the nearest of all surfaces in its cone.
fn reading(walls: &[Wall], from: Point2, angle: f32) -> (f32, RayEnd) {
    let rays = (-27..=27).map(|n| angle + (f32::from(n as i8) * 0.5 * HALF / 13.5).to_radians());
    let nearest = rays.filter_map(|angle| ray(walls, from, angle)).min_by(f32::total_cmp);
    nearest.map_or((1.2, RayEnd::Clear), |distance| (distance, RayEnd::Obstacle))
}

fn beam(from: Point2, angle: f32, (distance, end): (f32, RayEnd), cone: Option<Cone>) -> Beam {
    let (sin, cos) = Radians(angle).sin_cos();
    let to = Point2::new(from.x + distance * cos, from.y + distance * sin);
    Beam { cone, ..Beam::ray(to, end) }
}

/// The map of a sensor that turns once at each of these points, a tenth of a radian at a time.
fn look(walls: &[Wall], places: &[Point2], cone: Option<Cone>) -> GridMap<1600> {
    let frame = Frame::new(Point2::new(-4.0, -4.0), Metres(0.1), 80, 80).unwrap();
    let mut map = GridMap::new(frame).unwrap();
    for &from in places {
        for n in 0..63_u8 {
            let angle = f32::from(n) * 0.1;
            map.sense(from, &beam(from, angle, reading(walls, from, angle), cone));
        }
    }
    map
}

/// A wall with a door of 0.8 m, and a wall 1.5 m behind it.
const DOOR: [Wall; 3] =
    [[(-3.0, 1.02), (-0.42, 1.02)], [(0.42, 1.02), (3.0, 1.02)], [(-3.0, 2.52), (3.0, 2.52)]];

/// How many of the cells in the door are occupied.
fn closed(map: &GridMap<1600>) -> usize {
    let frame = *map.frame();
    let cells = (-3..=3).map(|n| Point2::new(f32::from(n as i8) * 0.1 + 0.02, 1.05));
    cells
        .filter_map(|at| frame.cell_at(at))
        .filter(|&at| map.state(at) == CellState::Occupied)
        .count()
}

#[test]
fn a_door_that_is_seen_from_two_places_is_open_by_its_cones_and_closed_by_their_middles() {
    let places = [Point2::new(-0.6, 0.0), Point2::new(0.0, 0.2)];
    let (cones, rays) = (look(&DOOR, &places, Some(CONE)), look(&DOOR, &places, None));
    assert!(closed(&cones) <= 1 && closed(&rays) >= 3, "{} and {}", closed(&cones), closed(&rays));
}

/// The cells that are drawn as occupied and lie more than two cells before the walls of a room, which may be
/// the inside of a wall but not the free space.
fn wrong(map: &GridMap<1600>, (half_x, half_y): (f32, f32)) -> Vec<Cell> {
    let frame = *map.frame();
    let is_inside = |cell: &Cell| {
        let at = frame.centre(*cell);
        at.x.abs() < half_x - 0.2 && at.y.abs() < half_y - 0.2
    };
    let occupied = frame.cells().filter(|&cell| map.state(cell) == CellState::Occupied);
    occupied.filter(is_inside).collect()
}

/// The rooms, by half of their extent, and the first of three places at which the sensor turns there.
fn rooms() -> impl Iterator<Item = ((f32, f32), (f32, f32))> {
    let halves = [0.71, 0.83, 0.92, 0.99];
    let sizes = halves.into_iter().flat_map(move |x| halves.map(|y| (x, y)));
    sizes.flat_map(|size| [(0.31, 0.12), (-0.37, 0.28), (0.05, -0.33)].map(|at| (size, at)))
}

/// A sensor that turns in a room finds its walls, and draws a tenth of the false ones of a sensor that sees a ray.
#[test]
fn the_walls_of_a_room_are_drawn_where_they_are() {
    let (mut by_cones, mut by_rays) = (0, 0);
    for ((e, n), (x, y)) in rooms() {
        let walls =
            [[(-e, -n), (e, -n)], [(e, -n), (e, n)], [(e, n), (-e, n)], [(-e, n), (-e, -n)]];
        let places = [Point2::new(x, y), Point2::new(-x, 0.5 * y), Point2::new(0.0, -y)];
        let map = look(&walls, &places, Some(CONE));
        by_cones += wrong(&map, (e, n)).len();
        by_rays += wrong(&look(&walls, &places, None), (e, n)).len();
        // Each wall, sought in the cells about its middle.
        for (x, y) in [(e, 0.0), (-e, 0.0), (0.0, n), (0.0, -n)] {
            let steps = [-0.1, 0.0, 0.1];
            let near = steps.into_iter().flat_map(|a| steps.map(|b| Point2::new(x + a, y + b)));
            let mut cells = near.filter_map(|at| map.frame().cell_at(at));
            assert!(cells.any(|cell| map.state(cell) == CellState::Occupied), "{e} {n}: {x} {y}");
        }
    }
    assert!(10 * by_cones < by_rays, "{by_cones} and {by_rays}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// One reading shows no cell beyond its distance to be free, and none but on its arc to be occupied.
    #[test]
    fn a_reading_tells_nothing_of_what_lies_behind_it(
        (x, y) in (-1.2_f32..1.8, 0.8_f32..3.8),
        angle in 0.0_f32..6.3,
        distance in 0.05_f32..2.0,
        side in prop_oneof![Just(Side::Unknown), Just(Side::Left), Just(Side::Right)],
    ) {
        let from = Point2::new(x, y);
        let mut map = Map::new(frame(32, 32)).unwrap();
        let beam = beam(from, angle, (distance, RayEnd::Obstacle), Some(CONE));
        let area = map.sense(from, &Beam { side, ..beam });
        for cell in map.frame().cells() {
            let off = map.frame().centre(cell).distance(from).0;
            match map.state(cell) {
                CellState::Unknown => continue,
                CellState::Free => prop_assert!(off < distance, "{cell:?}"),
                CellState::Occupied => {
                    prop_assert!(off > distance - 0.08 && off < distance + 0.28, "{cell:?}: {off}");
                }
            }
            let is_told = area.is_some_and(|area| area.rows().contains(&cell.row) && area.columns().contains(&cell.column));
            prop_assert!(is_told, "{cell:?}");
        }
    }

    /// Readings from outside the grid, of no length, and of no number change nothing.
    #[test]
    fn impossible_readings_change_nothing(x in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(-90.0), Just(0.0)]) {
        let (inside, empty) = (Point2::new(0.0, 2.0), Map::new(frame(32, 32)).unwrap());
        let outside = Point2::new(x, if x == 0.0 { 2.0 } else { 90.0 });
        for (from, to) in [(inside, outside), (outside, inside)] {
            let mut map = empty.clone();
            map.sense(from, &Beam { to, end: RayEnd::Obstacle, cone: Some(CONE), side: Side::Left });
            prop_assert_eq!(&map, &empty);
        }
    }
}
