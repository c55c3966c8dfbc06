//! Chooses the direction of a drone in a passage: section 4.3 of the paper, and a variant that looks
//! for a clear way.

use core::f32::consts::FRAC_1_SQRT_2;

use units::{Metres, Point2};

use crate::force::{attraction_to_goal, between_drones, from_obstacle};
use crate::geometry::{along, left_of, moved, turned};
use crate::{Config, Formation, Guard, Obstacles, Passage, Resultant};

/// The angles by which a drone turns from the direction that it wants, nearest first: multiples of
/// 22.5° up to 90°, as cosine and sine.
pub(crate) const TURNS: [(f32, f32); 9] = [
    (1.0, 0.0),
    (0.923_88, 0.382_68),
    (0.923_88, -0.382_68),
    (FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    (FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
    (0.382_68, 0.923_88),
    (0.382_68, -0.923_88),
    (0.0, 1.0),
    (0.0, -1.0),
];

/// Returns the direction of a drone at `here` in a passage, as a vector of 1 m, from the forces of
/// the target, of the drones in radio range at `others` and of the obstacles. Returns nothing when
/// they are in balance.
pub(crate) fn direction(
    config: &Config,
    passage: &Passage,
    formation: Formation,
    here: Point2,
    others: impl Iterator<Item = Point2>,
    obstacles: &Obstacles,
) -> Option<Point2> {
    let way = passage.way;
    let wanted = config.distance_in(formation);
    let mut sum = Resultant::new(config.weight);
    if let Some((target, magnitude)) = pull_ahead(config, passage, here, obstacles) {
        sum.add(here, target, here.distance(target), magnitude);
    }
    for other in others {
        let distance = here.distance(other);
        let force = between_drones(wanted, distance);
        let behind = along(way, here, other) < 0.0;
        if force < 0.0 || !(behind && let_go(config, here, other, distance, obstacles)) {
            sum.add(here, other, distance, force);
        }
    }
    for obstacle in obstacles.nearest_by_quadrant(here, way).into_iter().flatten() {
        let distance = here.distance(obstacle);
        sum.add(here, obstacle, distance, from_obstacle(config, distance));
    }
    sum.direction()
}

/// Says whether a drone is not pulled towards another one behind it: on paper where an obstacle is
/// between them.
fn let_go(
    config: &Config,
    here: Point2,
    behind: Point2,
    distance: Metres,
    obstacles: &Obstacles,
) -> bool {
    let near = config.guard.is_some_and(|guard| distance < guard.no_pull_back_within);
    near || obstacles.block(here, behind)
}

/// Returns the target of a drone in a passage and the attraction to it. On paper the target is
/// D_int / 4 ahead, and there is none where an obstacle is before it. A guarded drone is pulled with
/// the full force along the clear way that turns the least.
fn pull_ahead(
    config: &Config,
    passage: &Passage,
    here: Point2,
    obstacles: &Obstacles,
) -> Option<(Point2, f32)> {
    if let Some(guard) = &config.guard {
        let wanted = way_in(guard, passage, here);
        let clear = clear_way(config, guard, wanted, here, obstacles)?;
        let far = config.wanted_distance();
        return Some((moved(here, clear, far.0), attraction_to_goal(config, far)));
    }
    let ahead = Metres(0.25 * config.wanted_distance().0);
    let target = moved(here, passage.way, ahead.0);
    (!obstacles.block(here, target)).then(|| (target, attraction_to_goal(config, ahead)))
}

/// Returns the direction that leads on where nothing is in the way: that of the passage, or to its
/// entrance for a drone that is beside it and would meet the wall.
fn way_in(guard: &Guard, passage: &Passage, here: Point2) -> Point2 {
    let behind = along(passage.way, here, passage.entrance);
    let beside = along(left_of(passage.way), here, passage.entrance).abs();
    if behind < 0.0 || beside < 0.5 * passage.width.0 - guard.obstacles.0 {
        return passage.way;
    }
    let far = here.distance(passage.entrance).0;
    let (x, y) = (passage.entrance.x - here.x, passage.entrance.y - here.y);
    if far > 0.0 { Point2::new(x / far, y / far) } else { passage.way }
}

/// Returns the direction nearest to `way` in which a drone keeps its clearance as far ahead as it
/// sees with that clearance to spare, or as much of it as it has now. Of two that turn alike it is
/// the one with more clearance.
fn clear_way(
    config: &Config,
    guard: &Guard,
    way: Point2,
    here: Point2,
    obstacles: &Obstacles,
) -> Option<Point2> {
    let least = (guard.obstacles.0 * guard.obstacles.0).min(obstacles.squared_clearance(here));
    // A way that is not clear is given up at the first place where it is not.
    let spare = |turn: &(f32, f32)| {
        let heading = turned(way, *turn);
        let room = LOOK_AHEAD.iter().try_fold(f32::INFINITY, |room: f32, steps| {
            let ahead = moved(here, heading, steps * config.longest_step.0);
            Some(room.min(obstacles.squared_clearance_from(ahead, least)?))
        });
        room.map(|room| (heading, room))
    };
    let (straight, sideways) = TURNS.split_first()?;
    let clear = spare(straight).or_else(|| {
        sideways.chunks_exact(2).find_map(|pair| {
            pair.iter().filter_map(spare).max_by(|one, other| one.1.total_cmp(&other.1))
        })
    });
    clear.map(|(heading, _)| heading)
}

/// The distances at which a way is tried, in longest steps: up to 0.3 m with the paper's step.
const LOOK_AHEAD: [f32; 3] = [1.0, 2.0, 3.0];

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);
    const ROWS: Formation = Formation::TwoRows;
    const PASSAGE: Passage = Passage {
        entrance: Point2::new(-1.0, 0.0),
        width: Metres(1.51),
        way: Point2::new(1.0, 0.0),
        length: Metres(6.0),
    };

    fn face(x: f32) -> Obstacles {
        let wall = (Point2::new(x, -0.1), Point2::new(x, 2.0));
        Obstacles::seen(HERE, Metres(0.5), [wall])
    }

    #[test]
    fn the_paper_lets_go_of_a_target_behind_an_obstacle_and_of_a_drone_behind_one() {
        let paper = Config::PAPER;
        let to = |obstacles: &Obstacles| pull_ahead(&paper, &PASSAGE, HERE, obstacles);
        assert!(to(&face(0.3)).is_some() && to(&face(0.1)).is_none());
        let behind = Point2::new(-1.0, 0.0);
        assert!(let_go(&paper, HERE, behind, Metres(1.0), &face(-0.2)));
        assert!(!let_go(&paper, HERE, behind, Metres(1.0), &face(0.2)));
    }

    #[test]
    fn a_guarded_drone_goes_round_the_open_side_of_an_obstacle() {
        let way = direction(&Config::OURS, &PASSAGE, ROWS, HERE, core::iter::empty(), &face(0.42));
        let way = way.expect("the forces are not in balance");
        assert!(way.y < -0.3, "{way:?}");
    }

    #[test]
    fn a_lonely_drone_in_the_open_goes_straight_ahead() {
        for config in [Config::PAPER, Config::OURS] {
            let open = Obstacles::default();
            let way = direction(&config, &PASSAGE, ROWS, HERE, core::iter::empty(), &open);
            assert_eq!(way, Some(PASSAGE.way));
        }
    }
}
