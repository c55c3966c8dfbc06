//! The radios that a scenario and `bench chain` can choose.

use std::path::Path;
use world::World;

use sim_harness::scenario::Scenario;
use sim_harness::scenario::{PRESETS, RadioPreset};
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
