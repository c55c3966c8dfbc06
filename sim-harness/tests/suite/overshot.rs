//! A head that the pilot pushes over an edge, behind which the chain cannot bear it, comes back to where its
//! links do. It used to stand there for as long as the pilot pushed, with a link below the limit, and to come
//! back when the pilot released the stick: in drawn place 150000 for half of the exploration.

use sim_harness::bench::chain::Contender;
use sim_harness::bench::chain::drawn::drawing::Drawn;
use sim_harness::bench::chain::drawn::flown::fly;
use sim_harness::scenario::Fidelity;

/// Places with one relay, in which heads stood behind an edge.
const PLACES: [u64; 4] = [150_000, 150_005, 150_023, 150_026];

#[test]
fn a_head_that_is_pushed_comes_back_from_where_its_links_are_too_weak() {
    let weak = PLACES.map(|seed| {
        let drawn = Drawn::of(seed, Fidelity::Point).expect("the place is drawn");
        fly(&drawn, &Contender::BuiltIn("chain")).expect("the policy flies").weak
    });
    // The parts were 0.49, 0.29, 0.24 and 0.12.
    let mean = weak.iter().sum::<f32>() / weak.len() as f32;
    assert!(mean <= 0.13, "the parts of the exploration with a weak link: {weak:?}");
    assert!(weak.iter().all(|part| *part <= 0.2), "{weak:?}");
}
