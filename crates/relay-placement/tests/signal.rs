//! What must be true of a map of signal strength that readings refine.

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use proptest::prelude::*;
use relay_placement::{Curve, Ground, Network, NotFinite, Readings, RefineConfig};
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
