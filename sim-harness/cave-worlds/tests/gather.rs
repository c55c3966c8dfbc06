//! What gathering readings before a relay is dropped gains.

use cave_worlds::{Chooses, Knows, World, gather};

/// Over some caves: a robot that has gathered readings knows the strength better than by the curve, in
/// each pattern, and the truth is known best.
#[test]
fn readings_make_the_map_truer() {
    let mut sums = [0.0_f32; Knows::ALL.len()];
    for seed in 0..4 {
        for dropped in gather(&World::dig(seed), seed).unwrap() {
            let knows = Knows::ALL.iter().position(|knows| *knows == dropped.knows).unwrap();
            // The error is that of the knowledge, however the robot chooses.
            if dropped.chooses == Chooses::Margin {
                sums[knows] += dropped.error_db.unwrap_or(0.0);
            }
            let is_read = matches!(dropped.knows, Knows::Readings(_));
            assert_eq!(dropped.way_m > 0.0, is_read, "{dropped:?}");
            assert!(dropped.way_m <= 60.0, "two minutes at half a metre a second: {dropped:?}");
        }
    }
    let [curve, patterns @ .., truth] = sums;
    assert!(patterns.iter().all(|error| *error < curve), "{sums:?}");
    assert!(truth < 1e-3, "{sums:?}");
}

#[test]
fn a_relay_without_a_link_covers_nothing() {
    for dropped in gather(&World::dig(5), 5).unwrap() {
        let is_linked = dropped.margin_db.is_some_and(|margin| margin >= 0.0);
        assert!(is_linked || dropped.gained_m2 == 0.0, "{dropped:?}");
        assert!(dropped.knows != Knows::Truth || is_linked, "{dropped:?}");
    }
}
