use super::*;

/// A trail of `metres` straight ahead, then of as many to the left.
fn right_angle(metres: usize) -> Trail {
    let mut trail = Trail::new();
    for heading in [0.0, core::f32::consts::FRAC_PI_2] {
        for _ in 0..20 * metres {
            trail.advance([0.05, 0.0], Radians(heading), Flies::NoseFirst);
        }
    }
    trail
}

#[test]
fn ground_is_known_once_flown_and_forgotten_far_away() {
    let mut trail = Trail::new();
    trail.advance([0.0, 0.0], Radians(1.5), Flies::NoseFirst);
    assert!(trail.knows(0.0) && !trail.knows(0.1) && !trail.knows(-0.1));
    for _ in 0..20 {
        trail.advance([0.05, 0.0], Radians(1.5), Flies::NoseFirst);
    }
    assert!(trail.knows(-0.7) && !trail.knows(0.2));
    for _ in 0..2_600 {
        trail.advance([0.05, 0.0], Radians(1.5), Flies::NoseFirst);
    }
    assert!(trail.knows(-119.0) && !trail.knows(-121.0));
}

#[test]
fn a_drone_that_comes_back_by_any_motion_finds_its_headings() {
    let mut trail = right_angle(3);
    assert!(!trail.bends());
    // Tail first, sideways round the corner, and tail first again.
    for _ in 0..60 {
        trail.advance([-0.05, 0.0], Radians(core::f32::consts::FRAC_PI_2), Flies::TailFirst);
    }
    assert!(trail.bends());
    for _ in 0..40 {
        trail.advance([0.0, 0.05], Radians(core::f32::consts::FRAC_PI_2), Flies::TailFirst);
    }
    let off = trail.off(0.0).0;
    assert!((off + core::f32::consts::FRAC_PI_2).abs() < 0.01, "{off}");
    assert!(trail.knows(-0.8) && !trail.knows(-1.5));
}

#[test]
fn a_drone_on_its_way_home_keeps_its_path_beside_it_and_points_its_tail_to_it() {
    let mut trail = right_angle(3);
    let heading = Radians(core::f32::consts::FRAC_PI_2);
    for (rounds, moved) in [(20, [-0.05, 0.0]), (20, [0.0, 0.1]), (10, [-0.05, 0.0])] {
        for _ in 0..rounds {
            trail.advance(moved, heading, Flies::Home);
        }
    }
    assert!(trail.aside() > 1.1 && trail.knows(-3.0), "{}", trail.aside());
    let off = trail.pursues().unwrap().0;
    assert!((0.3..1.3).contains(&off), "the tail turns to the right: {off}");
    // One that flies tail first for another reason has left it.
    trail.advance([-0.05, 0.0], heading, Flies::TailFirst);
    assert!(!trail.knows(-1.0) && trail.pursues().is_none());
}

#[test]
fn a_drone_on_its_way_home_that_is_metres_from_its_path_is_not_where_it_reckons_to_be() {
    let mut trail = right_angle(3);
    for moved in [[-0.05, 0.0]; 20].into_iter().chain([[0.0, -0.2]; 20]) {
        trail.advance(moved, Radians(core::f32::consts::FRAC_PI_2), Flies::Home);
    }
    assert!(!trail.knows(-1.0));
}

#[test]
fn a_drone_that_turned_round_is_back_on_its_path() {
    let mut trail = right_angle(3);
    // A narrow bow to the right, and back.
    for step in 0..70 {
        let turned = core::f32::consts::PI * (step as f32 / 10.0).min(1.0);
        let heading = wrapped(core::f32::consts::FRAC_PI_2 - turned);
        trail.advance([0.05, 0.0], Radians(heading), Flies::NoseFirst);
    }
    let off = trail.off(0.0).0;
    assert!(off.abs() > 2.9, "the nose points back along the path: {off}");
}

/// The drone backs up by less than a leg and flies on aslant, so that the end of its path lies
/// behind the crumb before it; then the next point of the path stayed that crumb for ever.
#[test]
fn a_path_that_folds_back_at_its_end_grows_on() {
    let mut trail = right_angle(2);
    let at = trail.crumb(trail.last).at;
    trail.last += 1;
    let folded = plus(at, [0.16, -0.2], 1.0);
    trail.put(trail.last, Crumb { at: folded, heading: core::f32::consts::FRAC_PI_2 });
    for _ in 0..40 {
        trail.advance([0.05, 0.0], Radians(core::f32::consts::FRAC_PI_2), Flies::NoseFirst);
    }
    assert!(trail.knows(-1.5) && !trail.knows(0.2));
    assert!(dot(minus(trail.crumb(trail.last).at, trail.at), [0.0, 1.0]).abs() < SPACING);
}

/// The last leg of the path lies across the way on, as where a drone was pushed aside in a bend; the walls
/// of the gallery then held the place there, and the path did not grow any more.
#[test]
fn a_path_that_leads_across_at_its_end_grows_on_between_walls() {
    let mut trail = right_angle(2);
    let ahead = Radians(core::f32::consts::FRAC_PI_2);
    let at = trail.crumb(trail.last).at;
    trail.last += 1;
    trail.put(trail.last, Crumb { at: plus(at, [-0.21, 0.01], 1.0), heading: ahead.0 });
    (trail.near, trail.part) = (trail.last - 1, 1.0);
    trail.at = plus(at, [-0.21, 0.02], 1.0);
    for _ in 0..100 {
        trail.advance([0.02, 0.0], ahead, Flies::NoseFirst);
        trail.correct(Radians(0.0), 0.0);
    }
    assert!(trail.knows(-1.5) && !trail.knows(0.3), "{:?}", trail.at);
    assert!(dot(minus(trail.at, at), [0.0, 1.0]) > 1.8, "{:?}", trail.at);
}

/// The last leg of the path lies across the way on; a drone that has flown on beside it and comes
/// back then lost all of its path but that leg, and read that leg the wrong way round.
#[test]
fn a_drone_that_comes_back_beyond_the_end_keeps_its_path() {
    let mut trail = right_angle(2);
    let ahead = Radians(core::f32::consts::FRAC_PI_2);
    let at = trail.crumb(trail.last).at;
    trail.last += 1;
    trail.put(trail.last, Crumb { at: plus(at, [-0.21, 0.01], 1.0), heading: ahead.0 });
    trail.at = plus(at, [-0.18, 0.01], 1.0);
    for _ in 0..8 {
        trail.advance([0.045, 0.0], ahead, Flies::NoseFirst);
    }
    for _ in 0..4 {
        trail.advance([0.045, 0.0], ahead, Flies::TailFirst);
    }
    assert!(trail.knows(-3.0), "{} to {}, {}", trail.first, trail.last, trail.near);
    assert!(trail.off(-2.5).0 < -1.0, "the path behind bends to the right");
}

/// A drone that trembles beside its path near the end, as in a corner, keeps the way back.
#[test]
fn a_drone_that_drifts_off_its_path_keeps_the_longer_part() {
    let mut trail = right_angle(2);
    let ahead = Radians(core::f32::consts::FRAC_PI_2);
    for _ in 0..10 {
        trail.advance([-0.05, 0.0], ahead, Flies::TailFirst);
    }
    for _ in 0..30 {
        trail.advance([0.0, 0.02], ahead, Flies::Hovering);
    }
    assert!(trail.knows(-3.0), "{} to {}, {}", trail.first, trail.last, trail.near);
}

#[test]
fn a_drone_far_from_its_path_begins_it_anew() {
    let mut trail = right_angle(2);
    let ahead = Radians(core::f32::consts::FRAC_PI_2);
    // The end's heading says that the drone comes from there.
    trail.put(trail.last, Crumb { heading: -ahead.0, ..trail.crumb(trail.last) });
    for _ in 0..60 {
        trail.advance([0.05, 0.0], ahead, Flies::NoseFirst);
    }
    assert!(trail.knows(-1.0) && trail.off(0.0).0.abs() < 0.01);
}

#[test]
fn the_end_of_the_path_turns_with_the_nose_but_not_right_round() {
    let mut trail = right_angle(2);
    let ahead = core::f32::consts::FRAC_PI_2;
    let turned = |trail: &mut Trail, degrees: i32| {
        let heading = wrapped(ahead + (degrees as f32).to_radians());
        trail.advance([0.0, 0.0], Radians(heading), Flies::NoseFirst);
        trail.turn(true, true)
    };
    assert!((0..155).all(|degrees| turned(&mut trail, degrees)));
    assert!(!(155..165).all(|degrees| turned(&mut trail, degrees)));
    assert!((trail.crumb(trail.last).heading - ahead).abs() < 0.2);
}

#[test]
fn walls_correct_the_drift_of_the_gyro_but_not_a_turn() {
    let mut trail = right_angle(4);
    for _ in 0..20 {
        trail.advance([-0.05, 0.0], Radians(core::f32::consts::FRAC_PI_2), Flies::TailFirst);
    }
    let drift = |trail: &mut Trail, rounds| {
        for _ in 0..rounds {
            let heading = Radians(core::f32::consts::FRAC_PI_2 + 0.3);
            trail.advance([0.0, 0.0], heading, Flies::NoseFirst);
            trail.correct(Radians(0.0), 0.0);
        }
    };
    // A gyro drifts slowly: for a while the walls may be those of another gallery.
    drift(&mut trail, 150);
    assert!(trail.off(0.0).0.abs() > 0.2);
    drift(&mut trail, 850);
    assert!(trail.off(0.0).0.abs() < 0.01, "{:?}", trail.off(0.0));
    for _ in 0..100 {
        trail.advance([0.0, 0.0], Radians(core::f32::consts::FRAC_PI_2 + 1.8), Flies::NoseFirst);
        trail.correct(Radians(0.0), 0.0);
    }
    assert!(trail.off(0.0).0.abs() > 1.0);
}

#[test]
fn walls_correct_a_place_beside_the_path_and_not_one_at_its_end() {
    let mut trail = right_angle(4);
    let heading = Radians(core::f32::consts::FRAC_PI_2);
    let aside = |trail: &mut Trail| {
        for _ in 0..500 {
            trail.advance([0.0, 0.0], heading, Flies::Hovering);
            trail.correct(Radians(0.0), -0.2);
        }
        trail.at()[0]
    };
    // The gallery leads along y, at x = 4 m; the walls say that the drone is 0.2 m to the right of its middle.
    let at_end = aside(&mut trail);
    assert!((at_end - 4.0).abs() < 0.02, "{at_end}");
    for _ in 0..30 {
        trail.advance([-0.05, 0.0], heading, Flies::TailFirst);
    }
    let beside = aside(&mut trail);
    assert!((4.1..4.25).contains(&beside), "{beside}");
}

#[test]
fn any_bits_are_borne() {
    let mut trail = Trail::new();
    for way in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX] {
        for forward in [true, false] {
            let flies = if forward { Flies::NoseFirst } else { Flies::Hovering };
            trail.advance([way, -way], Radians(way), flies);
            trail.correct(Radians(way), way);
            trail.shift(way);
            trail.turn(forward, true);
            let _ = (trail.off(way), trail.knows(way), trail.is_straight(), trail.aside());
        }
    }
}
