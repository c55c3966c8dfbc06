//! The radios that a scenario and `bench chain` can choose.

use std::path::Path;
use world::World;

use sim_harness::scenario::{Changes, PRESETS, RadioPreset, Scenario};
use world::SkeletonPlace;

fn world_of(preset: &RadioPreset, place_seed: u64) -> World {
    let mut scenario = Scenario::open("right-angles").unwrap();
    scenario.radio = preset.applied(&scenario.radio);
    scenario.radio.place.seed = place_seed;
    scenario.world()
}

fn at(along: f32) -> SkeletonPlace {
    SkeletonPlace { edge: 0, along }
}

#[test]
fn a_link_is_as_strong_in_one_direction_as_in_the_other() {
    for preset in &PRESETS {
        let world = world_of(preset, 1);
        for (a, b) in [(0.0, 3.0), (4.0, 7.5), (2.0, 13.0), (20.0, 5.0)] {
            let [there, back] = [(a, b), (b, a)].map(|(a, b)| world.radio.strength(at(a), at(b)).0);
            assert!((there - back).abs() < 1e-3, "{}: {there} and {back} dBm", preset.name);
        }
    }
}

#[test]
fn a_place_keeps_its_shadows_and_another_place_has_others() {
    for name in ["shadowed", "rician", "rayleigh"] {
        let preset = RadioPreset::named(name).unwrap();
        let strengths = |seed| {
            let world = world_of(preset, seed);
            [1.0, 4.0, 9.0, 16.0].map(|along| world.radio.strength(at(0.0), at(along)).0)
        };
        assert_eq!(strengths(1), strengths(1), "{name}");
        assert_ne!(strengths(1), strengths(2), "{name}");
    }
}

/// A table of losses is the law between its distances, and the whole scenario keeps it.
#[test]
fn a_law_can_be_a_table_of_losses() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios");
    let text = std::fs::read_to_string(folder.join("measured-radio.toml")).unwrap();
    let read = |text: &str| Scenario::of_text_with("table", text, &Changes::default());
    let scenario = read(&text).unwrap();
    let strength =
        |scenario: &Scenario, to: f32| scenario.world().radio.strength(at(0.0), at(to)).loss().0;
    assert_eq!([1.0, 10.0, 20.0].map(|to| strength(&scenario, to)), [40.0, 60.0, 68.0]);
    let again = read(&scenario.resolved()).unwrap();
    assert_eq!(strength(&again, 7.0), strength(&scenario, 7.0));
    for (from, to, part) in [
        ("loss_db = [[40, 60, 68],", "loss_db = [[40, 60],", "as many as distance_m has"),
        ("55, 75", "-5, 75", "give losses from 0 to 400"),
        ("[1, 10, 20]", "[1, 10, 9]", "each greater than the one before"),
        ("[1, 10, 20]", "[1]", "give 2 to 2000"),
        ("distance_m = [1, 10, 20]", "", "give distance_m, and loss_db"),
        ("law = \"table\"", "law = \"table\"\nexponent = 2", "this law has no exponent"),
    ] {
        let error = read(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(part) && !error.contains('\n'), "{error}");
    }
}

/// The keys of a file make the radio that they name.
#[test]
fn a_file_can_ask_for_all_of_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios");
    let scenario = Scenario::read(&folder.join("another-radio.toml")).unwrap();
    let radio = &scenario.radio;
    assert!(matches!(radio.place.path_loss, radio_model::PathLoss::Waveguide(_)));
    assert_eq!(radio.place.fading_k, Some(4.0));
    assert_eq!(radio.place.seed, 7);
    assert!(
        radio.place.shadowing.is_some() && radio.antenna.is_some() && radio.gain_error.0 == 1.5
    );
}
