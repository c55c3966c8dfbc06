//! What must hold for `ours` when packets are lost, clusters part, and a robot fails.

use explorers::{Outcome, Setup, WORLDS, run};
use frontier::RULES;

const SEED: u64 = 1;

fn setup() -> Setup {
    let rule = RULES.iter().find(|entry| entry.name == "ours").expect("the rule").rule;
    Setup { world: WORLDS[0], rule, robots: 3, seed: SEED, loss: 0.3, death_s: None, apart_s: None }
}

fn is_complete(outcome: &Outcome) -> bool {
    outcome.t99_s.is_some() && outcome.stopped_s.is_some() && !outcome.premature_stop
}

#[test]
fn all_is_explored_though_three_packets_of_ten_are_lost() {
    let outcome = run(&setup());
    assert!(is_complete(&outcome), "{outcome:?}");
    assert_eq!(outcome, run(&setup()), "the same seed gives the same run");
}

#[test]
fn all_is_explored_though_the_last_robot_fails() {
    let outcome = run(&Setup { death_s: Some(10.0), ..setup() });
    assert!(is_complete(&outcome), "{outcome:?}");
}

#[test]
fn all_is_explored_though_the_clusters_part_for_a_minute() {
    let outcome = run(&Setup { apart_s: Some([5.0, 65.0]), ..setup() });
    assert!(is_complete(&outcome), "{outcome:?}");
}
