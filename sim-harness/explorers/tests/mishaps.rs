//! What must hold for `ours` when packets are lost, clusters part, and a robot fails, and in networks
//! without a way over other robots.

use explorers::{Air, Network, Outcome, PLANS, Senses, Setup, World, run};
use frontier::RuleEntry;
use units::Metres;

const SEED: u64 = 1;

fn setup(world: &World) -> Setup<'_> {
    let rule = RuleEntry::named("ours").expect("the rule").rule;
    Setup {
        world,
        rule,
        robots: 3,
        seed: SEED,
        air: Air::losing(0.3),
        senses: Senses::default(),
        radius: Metres(0.08),
        death_s: None,
        apart_s: None,
        longest_s: 900.0,
    }
}

/// Half of what a drone measures from rotor tip to rotor tip is 0.065 m: two that are nearer touch.
const TOUCH_M: f32 = 0.13;

/// Flies in each plan; each exploration must be complete and end, and no robot may touch anything. Robots
/// that do not hear each other do not know where the others are, and may touch.
fn all_are_complete(change: impl Fn(Setup<'_>) -> Setup<'_>) {
    all_are_complete_and(|outcome| outcome.closest_m.is_some_and(|m| m > TOUCH_M), change);
}

fn all_are_complete_and(
    is_apart: impl Fn(&Outcome) -> bool,
    change: impl Fn(Setup<'_>) -> Setup<'_>,
) {
    for (name, _) in PLANS {
        let world = World::plan(name).expect("a built-in plan");
        let (outcome, _) = run(&change(setup(&world)));
        assert!(is_complete(&outcome), "{name}: {}", summary(&outcome));
        assert_eq!(outcome.into_walls, 0, "{name}: a robot flies against a wall");
        assert!(is_apart(&outcome), "{name}: two robots come within {:?} m", outcome.closest_m);
    }
}

fn is_complete(outcome: &Outcome) -> bool {
    outcome.t99_s.is_some() && outcome.stopped_s.is_some() && !outcome.premature_stop
}

fn summary(outcome: &Outcome) -> String {
    let Outcome { explored, t99_s, stopped_s, .. } = outcome;
    format!("explored {explored}, 99 % at {t99_s:?}, stopped at {stopped_s:?}")
}

#[test]
fn all_is_explored_though_three_packets_of_ten_are_lost() {
    all_are_complete(|setup| setup);
}

#[test]
fn all_is_explored_though_the_last_robot_fails() {
    all_are_complete(|setup| Setup { death_s: Some(20.0), ..setup });
}

#[test]
fn all_is_explored_though_the_clusters_part_for_a_minute() {
    all_are_complete_and(|_| true, |setup| Setup { apart_s: Some([5.0, 65.0]), ..setup });
}

#[test]
fn all_is_explored_though_no_packet_ever_arrives() {
    all_are_complete_and(|_| true, |setup| Setup { air: Air::losing(1.0), ..setup });
}

#[test]
fn all_is_explored_where_robots_hear_each_other_directly_alone() {
    let air = Air { network: Network::AdHoc, ..Air::losing(0.3) };
    all_are_complete(|setup| Setup { air, ..setup });
}

#[test]
fn all_is_explored_through_an_access_point() {
    let air = Air { network: Network::AccessPoint, ..Air::losing(0.3) };
    all_are_complete(|setup| Setup { air, ..setup });
    all_are_complete(|setup| Setup { air, death_s: Some(20.0), ..setup });
    all_are_complete_and(|_| true, |setup| Setup { air, apart_s: Some([5.0, 65.0]), ..setup });
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let world = World::plan("rooms").expect("a built-in plan");
    assert_eq!(run(&setup(&world)), run(&setup(&world)));
}
