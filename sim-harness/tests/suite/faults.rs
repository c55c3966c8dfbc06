//! Regression: flights of the bench of faults that ended uncontrolled.
//!
//! | row | place | seed | why |
//! |---|---|---|---|
//! | battery of 0.1 Ω, full | hover | 51 | the estimator did not believe the calibrated accelerometer |
//! | down-ranger lying 2 s | hover | 51 | the same drone, before the fault began |
//! | flow lying for good | hover | 183 | judged while it sank through the last millimetres |
//! | flow lying for good | tunnel | 252 | the same |

use sim_harness::bench::faults::measure::{Place, Places, cases};

#[test]
fn no_flight_that_once_ended_uncontrolled_does() {
    let places = Places::new().unwrap();
    for (fault, place, seed) in [
        ("battery of 0.1 Ω, full", Place::Hover, 51),
        ("down-ranger lying 2 s", Place::Hover, 51),
        ("flow lying for good", Place::Hover, 183),
        ("flow lying for good", Place::Tunnel, 252),
    ] {
        let case = cases().into_iter().find(|case| case.name == fault && case.place == place);
        let row = places.run(&case.unwrap(), 1, seed, || {});
        assert_eq!(row.uncontrolled, 0, "{fault}, {place:?}, seed {seed}: {row:?}");
    }
}
