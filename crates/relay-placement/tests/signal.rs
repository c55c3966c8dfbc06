//! What must be true of a map of signal strength that readings refine.

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use proptest::prelude::*;
use relay_placement::{
    Belief, Correction, Curve, Demand, Ground, Network, NotFinite, Readings, RefineConfig,
};
use units::{Db, Metres, Point2};

const ORIGIN: Point2 = Point2::new(0.0, 0.0);

fn read(points: &[(Point2, f32)]) -> Readings<8> {
    let mut readings = Readings::new(RefineConfig::DEFAULT);
    for &(at, over) in points {
        readings.add(at, Db(over)).unwrap();
    }
    readings
}

#[test]
fn a_reading_that_is_no_number_is_refused_and_changes_nothing() {
    let before = read(&[(ORIGIN, 3.0)]);
    let mut after = before.clone();
    for (x, over) in [(0.0, f32::NAN), (f32::NAN, 0.0), (0.0, f32::INFINITY)] {
        assert_eq!(after.add(Point2::new(x, 0.0), Db(over)), Err(NotFinite));
    }
    assert_eq!(before, after);
}

#[test]
fn without_readings_the_correction_is_nothing_and_its_spread_that_of_the_configuration() {
    let correction = read(&[]).fit().at(ORIGIN);
    let RefineConfig { offset, shadowing, .. } = RefineConfig::DEFAULT;
    assert_eq!(correction.over, Db(0.0));
    let none = Correction::NONE;
    assert!((correction.deviation - none.deviation).0.abs() < 1e-4);
    assert!((correction.reading_deviation - none.reading_deviation).0.abs() < 1e-4);
    assert!((correction.deviation.0 - offset.0.hypot(shadowing.0)).abs() < 1e-3);
}

/// Near the readings the correction is theirs. Far away the shadowing is unknown again, but not the
/// offset.
#[test]
fn readings_tell_of_their_place_most_and_of_the_offset_everywhere() {
    let readings = read(&[(ORIGIN, -12.0); 200]);
    let refined = readings.fit();
    let (here, far) = (refined.at(ORIGIN), refined.at(Point2::new(500.0, 0.0)));
    assert!((here.over.0 + 12.0).abs() < 0.5, "{here:?}");
    assert!(far.over.0 < -4.0 && far.over.0 > here.over.0, "{far:?}");
    assert!(here.deviation < far.deviation, "{here:?} {far:?}");
}

#[test]
fn a_relay_that_is_weaker_than_its_curve_covers_less() {
    let frame = Frame::new(ORIGIN, Metres(0.5), 100, 4).unwrap();
    let mut map = GridMap::<100>::new(frame).unwrap();
    for cell in frame.cells() {
        map.set(cell, CellState::Free);
    }
    let mut planner = Planner::<200, 600>::new();
    let ground = Ground::<400>::new(&map, &mut planner, Cell::new(0, 0)).unwrap();
    let weak = [(Point2::new(5.0, 1.0), -6.0), (Point2::new(10.0, 1.0), -6.0)];
    let covered = |deviations: f32| {
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add_refined(&ground, ORIGIN, &read(&weak).fit(), deviations);
        network.covered(&ground)
    };
    let mut network = Network::new(&ground, Curve::DEFAULT);
    network.add(&ground, ORIGIN);
    assert!(covered(0.0) < network.covered(&ground));
    assert!(covered(1.28) < covered(0.0));
}

/// A strip of 50 m with the base at its western end.
fn strip(rows: u16) -> (Ground<1200>, Point2) {
    let frame = Frame::new(ORIGIN, Metres(0.5), 100, rows).unwrap();
    let mut map = GridMap::<300>::new(frame).unwrap();
    for cell in frame.cells() {
        let is_wall = cell.row == 0 || cell.row + 1 == rows;
        map.set(cell, if is_wall { CellState::Occupied } else { CellState::Free });
    }
    let (mut planner, base) = (Planner::<600, 1200>::new(), Cell::new(0, rows / 2));
    (Ground::new(&map, &mut planner, base).unwrap(), frame.centre(base))
}

/// With a strength that is known the relay is put down as far out as there is a link. The less is known,
/// the nearer it stays; but it is put down also where no place is sure.
#[test]
fn the_place_of_the_largest_expected_coverage_is_the_surer_the_less_is_known() {
    let (ground, base) = strip(10);
    let demand = Demand { within: Metres(60.0), ..Demand::DEFAULT };
    let choose = |deviation: f32, over: f32| {
        let mut belief = Belief::new(&ground, Curve::DEFAULT);
        let correction =
            Correction { over: Db(over), deviation: Db(deviation), ..Correction::NONE };
        belief.add(&ground, base, |_| correction);
        belief.choose(&ground, base, &demand, Db(6.0)).unwrap()
    };
    let [known, read, unread] = [0.0, 2.0, 7.0].map(|deviation| choose(deviation, 0.0));
    assert!(known.link == 1.0 && (18.0..=20.1).contains(&known.at.x), "{known:?}");
    assert!(read.at.x < known.at.x && unread.at.x < known.at.x, "{read:?} {unread:?}");
    assert!(read.link > 0.8 && read.link > unread.link, "{read:?} {unread:?}");
    assert!(known.gain_cells > read.gain_cells && read.gain_cells > unread.gain_cells);
    let weak = choose(5.0, -40.0);
    assert!(weak.link < 0.9 && weak.gain_cells > 0.0, "{weak:?}");
}

/// Several relays go on along the strip, and are less surely linked than the first, because none of them
/// is read; by the way it is the same as in a straight line, but for squares of 2 m.
#[test]
fn relays_that_are_planned_together_are_less_sure_than_the_first() {
    let (ground, base) = strip(10);
    let correction = |_| Correction { deviation: Db(2.0), ..Correction::NONE };
    let mut belief = Belief::new(&ground, Curve::DEFAULT);
    belief.add(&ground, base, correction);
    let straight = belief.plan(&ground, &Demand::DEFAULT, Db(6.0), 3);
    let mut planner = Planner::<600, 1200>::new();
    let mut belief = Belief::new(&ground, Curve::DEFAULT);
    let cell = ground.frame().cell_at(base).unwrap();
    belief.add_by_way(&ground, &mut planner, cell, correction).unwrap();
    let by_way = belief.plan_by_way(&ground, &mut planner, &Demand::DEFAULT, Db(6.0), 3);
    for plan in [&straight, &by_way] {
        assert!(plan.len() > 1, "{plan:?}");
        assert!(plan.is_sorted_by(|a, b| a.gain_cells > b.gain_cells), "{plan:?}");
        assert!(plan[1..].iter().all(|place| place.link < plan[0].link), "{plan:?}");
        let expected: f32 = plan.iter().map(|place| place.gain_cells).sum();
        assert!(expected <= ground.reached().count() as f32, "{expected}");
    }
    for (a, b) in straight.iter().zip(&by_way) {
        assert!((a.at.x - b.at.x).abs() <= 4.0, "{a:?} {b:?}");
    }
}

/// Where a place adds less than a cell, no relay is put down.
#[test]
fn no_relay_is_planned_where_all_is_covered() {
    let (ground, base) = strip(10);
    let mut belief = Belief::new(&ground, Curve::DEFAULT);
    belief.add(&ground, base, |_| Correction { over: Db(60.0), ..Correction::NONE });
    assert_eq!(belief.plan(&ground, &Demand::DEFAULT, Db(6.0), 8).len(), 0);
}

/// A cell is covered with the probability that a normal number is not negative.
#[test]
fn a_belief_is_a_probability() {
    let (ground, base) = strip(10);
    let mut belief = Belief::new(&ground, Curve::DEFAULT);
    let at_edge = Cell::new(40, 5);
    belief.add(&ground, base, |_| Correction { deviation: Db(3.0), ..Correction::NONE });
    assert!((belief.covers(at_edge) - 0.5).abs() < 0.02, "{}", belief.covers(at_edge));
    belief.add(&ground, base, |_| Correction { deviation: Db(3.0), ..Correction::NONE });
    assert!((belief.covers(at_edge) - 0.75).abs() < 0.02, "{}", belief.covers(at_edge));
    assert_eq!(belief.covers(Cell::new(100, 5)), 0.0, "outside the map");
}

proptest! {
    /// More readings than there are places for, and any number of them at one place.
    #[test]
    fn a_correction_is_finite_and_readings_only_make_it_surer(
        points in proptest::collection::vec(((-50i8..50, -5i8..5), -60.0f32..60.0), 0..60),
        (x, y) in (-60.0f32..60.0, -10.0f32..10.0),
    ) {
        let points: Vec<_> = points
            .into_iter()
            .map(|((x, y), over)| (Point2::new(f32::from(x), f32::from(y)), over))
            .collect();
        let readings = read(&points);
        let correction = readings.fit().at(Point2::new(x, y));
        let unread = read(&[]).fit().at(ORIGIN);
        prop_assert!(correction.over.0.is_finite());
        prop_assert!(correction.deviation.0 <= unread.deviation.0 + 1e-3);
        prop_assert!(correction.deviation <= correction.reading_deviation);
        prop_assert!(correction.over.0.abs() <= 120.0);
    }
}
