//! Chooses the direction of a drone in a passage: section 4.3 of the paper, and a variant that looks
//! for a clear way.

use core::f32::consts::FRAC_1_SQRT_2;

use units::{Metres, Point2};

use crate::force::{attraction_to_goal, between_drones, from_obstacle};
use crate::geometry::{along, left_of, moved, turned};
use crate::{Config, Formation, Guard, Obstacles, Passage, Resultant};

/// The angles by which a drone turns from the direction that it wants, nearest first and to the left before
/// to the right: multiples of 22.5° up to 135°, as cosine and sine.
pub(crate) const TURNS: [(f32, f32); 13] = [
    (1.0, 0.0),
    (0.923_88, 0.382_68),
    (0.923_88, -0.382_68),
    (FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    (FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
    (0.382_68, 0.923_88),
    (0.382_68, -0.923_88),
    (0.0, 1.0),
    (0.0, -1.0),
    // A drone that came too near to a wall slides along it by these.
    (-0.382_68, 0.923_88),
    (-0.382_68, -0.923_88),
    (-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    (-FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
];

/// How many of them turn by 90° or less.
pub(crate) const FORWARD: usize = 9;

/// The side to which a drone turns where the way ahead of it is not clear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// How many multiples of 22.5° a drone turns farther to the side to which it turned last than it would to
/// the other one. Before a wall it then goes on to one end of it: of both sides the one that is clear changes
/// with what its beams meet. A way past an obstacle that is nearly straight ahead is still taken.
const FARTHER: u8 = 2;

/// Returns the direction of a drone at `here` in a passage, as a vector of 1 m, from the forces of
/// the target, of the drones in radio range at `others` and of the obstacles. Returns nothing when
/// they are in balance. `side` is where it turned last, and becomes that to which it turns now.
pub(crate) fn direction(
    config: &Config,
    passage: &Passage,
    formation: Formation,
    here: Point2,
    others: impl Iterator<Item = Point2>,
    obstacles: &Obstacles,
    side: &mut Option<Side>,
) -> Option<Point2> {
    let way = passage.way;
    let wanted = config.distance_in(formation);
    let mut sum = Resultant::new(config.weight);
    if let Some((target, magnitude)) = pull_ahead(config, passage, here, obstacles, side) {
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
    side: &mut Option<Side>,
) -> Option<(Point2, f32)> {
    if let Some(guard) = &config.guard {
        let wanted = way_in(guard, passage, here);
        let clear = clear_way(config, guard, wanted, here, obstacles, side)?;
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
/// sees with that clearance to spare, or as much of it as it has now. Of those to both sides it is the one to
/// the side to which the drone turned last, unless that turns much farther; and before it has turned to any,
/// the one with more clearance where both turn alike.
fn clear_way(
    config: &Config,
    guard: &Guard,
    way: Point2,
    here: Point2,
    obstacles: &Obstacles,
    last: &mut Option<Side>,
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
    if let Some((heading, _)) = spare(straight) {
        return Some(heading);
    }
    let [left, right] = [0, 1].map(|first| {
        let turns = (0_u8..).zip(sideways.iter().skip(first).step_by(2));
        turns.filter_map(|(turn, by)| Some((turn, spare(by)?))).next()
    });
    let (side, heading) = match (left, right) {
        (Some((left, (to_left, on_left))), Some((right, (to_right, on_right)))) => {
            let goes_left = match *last {
                Some(Side::Left) => left <= right + FARTHER,
                Some(Side::Right) => left + FARTHER < right,
                None if left == right => on_left > on_right,
                None => left < right,
            };
            if goes_left { (Side::Left, to_left) } else { (Side::Right, to_right) }
        }
        (Some((_, (heading, _))), None) => (Side::Left, heading),
        (None, Some((_, (heading, _)))) => (Side::Right, heading),
        (None, None) => return None,
    };
    *last = Some(side);
    Some(heading)
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
        let to = |obstacles: &Obstacles| pull_ahead(&paper, &PASSAGE, HERE, obstacles, &mut None);
        assert!(to(&face(0.3)).is_some() && to(&face(0.1)).is_none());
        let behind = Point2::new(-1.0, 0.0);
        assert!(let_go(&paper, HERE, behind, Metres(1.0), &face(-0.2)));
        assert!(!let_go(&paper, HERE, behind, Metres(1.0), &face(0.2)));
    }

    #[test]
    fn a_guarded_drone_goes_round_the_open_side_of_an_obstacle() {
        let way = direction(
            &Config::OURS,
            &PASSAGE,
            ROWS,
            HERE,
            core::iter::empty(),
            &face(0.42),
            &mut None,
        );
        let way = way.expect("the forces are not in balance");
        assert!(way.y < -0.3, "{way:?}");
    }

    /// It went to and fro before a block at one side of the passage until its battery was empty.
    #[test]
    fn a_drone_before_a_wall_goes_on_to_the_end_to_which_it_turned() {
        let mut side = None;
        let mut way = |obstacles: &Obstacles| {
            let others = core::iter::empty();
            direction(&Config::OURS, &PASSAGE, ROWS, HERE, others, obstacles, &mut side)
        };
        let to_the_right = Some(true);
        assert_eq!(way(&face(0.42)).map(|way| way.y < -0.3), to_the_right);
        let wall = (Point2::new(0.42, 0.05), Point2::new(0.42, -2.0));
        let other_end = Obstacles::seen(HERE, Metres(0.5), [wall]);
        assert_eq!(way(&other_end).map(|way| way.y < -0.3), to_the_right);
        let mut fresh = None;
        let others = core::iter::empty();
        let way = direction(&Config::OURS, &PASSAGE, ROWS, HERE, others, &other_end, &mut fresh);
        assert_eq!((way.map(|way| way.y > 0.3), fresh), (Some(true), Some(Side::Left)));
    }

    #[test]
    fn a_lonely_drone_in_the_open_goes_straight_ahead() {
        for config in [Config::PAPER, Config::OURS] {
            let open = Obstacles::default();
            let way =
                direction(&config, &PASSAGE, ROWS, HERE, core::iter::empty(), &open, &mut None);
            assert_eq!(way, Some(PASSAGE.way));
        }
    }
}
