//! What must be true of every place that is drawn.

use units::{Branch, Metres};
use world::SkeletonPlace;

use super::*;

/// Seeds that no tuning uses, and few: each takes an oracle or two.
const SEEDS: std::ops::Range<u64> = 900_000..900_040;

/// The beams end at a wall at 0.2 m (`NavConfig::DEFAULT`).
const DANGER_M: f32 = 0.2;

fn check(drawn: &Drawn, fidelity: Fidelity) {
    let Drawn { scenario, world, oracle, seed, .. } = drawn;
    let bounds = Bounds::of(fidelity);
    let drones = &scenario.drones;
    assert!((1..=bounds.relays as usize).contains(&drones.relays), "{seed}");
    assert!(scenario.duration_s() <= bounds.whole_s + 1.0, "{seed}");
    let (launch, retreat) = (scenario.agent.launch.limit, scenario.agent.retreat.limit);
    assert!((4.0..=10.0).contains(&(launch - retreat).0), "{seed}");
    assert!(scenario.radio.reception.sensitivity <= retreat - units::Db(10.0), "{seed}");
    assert!((0.0..=0.4).contains(&scenario.radio.reception.loss_rate), "{seed}");
    assert!((1.0..=20.0).contains(&scenario.radio.reception.noise_variance), "{seed}");
    assert!(matches!(scenario.pilot.last().map(|step| step.task), Some(Order::Return)), "{seed}");
    let hold = scenario.hold().map(|hold| (hold.until_us - hold.from_us) / 1_000_000);
    assert!(hold >= Some(bounds.holds_s as u64 - 1), "{seed}: {hold:?}");
    let row = Start::SPACING * drones.flying() as f32;
    assert!(oracle.depth_m >= row + LEAST_DEPTH_M - 0.5, "{seed}: {oracle:?}");
    assert!(oracle.least_relays <= drones.relays, "{seed}");
    assert!(oracle.time_to(oracle.depth_m) <= oracle.at_s + 0.1, "{seed}");

    // A drone fits everywhere on the way, and the way is all in one piece.
    let main = world.skeleton().edge(0);
    let length = main.line().length();
    assert!(length > row, "{seed}");
    for n in 0..=(length / 0.1) as usize {
        let place = SkeletonPlace { edge: 0, along: n as f32 * 0.1 };
        let (at, _) = world.skeleton().at(place);
        assert!(world.tunnel.is_free(at), "{seed}: {at:?}");
        assert!(world.tunnel.bump(at, DANGER_M).is_none(), "{seed}: {at:?}");
    }
    let Metres(main_width) = main.width();
    assert!((0.8..=3.0).contains(&main_width), "{seed}");
}

#[test]
fn every_place_is_sound_and_has_room_for_its_drones() {
    for seed in SEEDS {
        check(&Drawn::of(seed, Fidelity::Point).unwrap(), Fidelity::Point);
    }
    for seed in SEEDS.take(10) {
        check(&Drawn::of(seed, Fidelity::Flight).unwrap(), Fidelity::Flight);
    }
}

#[test]
fn a_seed_draws_the_same_text_and_a_saved_one_is_the_same_mission() {
    for seed in SEEDS.take(5) {
        let [one, other] = [0, 1].map(|_| Drawn::of(seed, Fidelity::Point).unwrap());
        assert_eq!(one.text, other.text);
        let read = Scenario::of_text(Path::new("saved.toml"), &one.text).unwrap();
        assert_eq!(format!("{:?}", read.pilot), format!("{:?}", one.scenario.pilot));
        assert_eq!(read.duration_us, one.scenario.duration_us);
    }
}

/// Issue 31 asks for all of these.
#[test]
fn all_kinds_of_places_and_radios_are_drawn() {
    let texts: Vec<_> = SEEDS.map(|seed| Drawn::of(seed, Fidelity::Point).unwrap().text).collect();
    for what in [
        "[[tunnel.branch]]",
        "[[tunnel.room]]",
        "\"wall-count\"",
        "\"rock-depth\"",
        "\"log-distance\"",
        "\"waveguide\"",
        "\"subt\"",
        "fade_share",
        "[radio.shadowing]",
        "[radio.fading]",
        "gain_error_db",
        "speed_mps = -",
        "branch = \"left\"",
        "branch = \"right\"",
        "branch = \"straight\"",
    ] {
        assert!(texts.iter().any(|text| text.contains(what)), "{what}");
    }
}

/// The pilot chooses the dead end first, and then the way on.
#[test]
fn a_changed_choice_has_its_dead_end_and_its_detour() {
    let changed = SEEDS.filter_map(|seed| {
        let drawn = Drawn::of(seed, Fidelity::Point).unwrap();
        drawn.commanded.detour.map(|detour| (drawn, detour))
    });
    let mut count = 0;
    for (drawn, detour) in changed {
        count += 1;
        let branch_at = |us: u64| {
            let step = drawn.scenario.pilot.iter().take_while(|step| step.at_us <= us).last();
            step.and_then(|step| match step.task {
                Order::Explore(course) => course.branch,
                _ => None,
            })
        };
        let (before, after) =
            (branch_at(detour.until_us - 1_000_000), branch_at(detour.until_us + 100_000));
        assert!(matches!(
            (before, after),
            (Some(Branch::Left), Some(Branch::Right)) | (Some(Branch::Right), Some(Branch::Left))
        ));
        assert!(drawn.oracle.depth_m > detour.at_m, "{}: {:?}", drawn.seed, drawn.oracle);
    }
    assert!(count >= 2, "{count}");
}

/// The last pause of this pilot ended in the same tenth of a second as the exploration, and the
/// scenario that was drawn was refused.
#[test]
fn a_pilot_who_pauses_until_the_end_is_drawn_in_order_of_time() {
    assert!(Drawn::of(720_063, Fidelity::Point).is_ok());
}
