//! What every flight of a swarm without trouble must do.

use swarms::{Flight, Mission, Phase, Place, TooMany, Trouble, fly};
use virtual_forces::Config;

fn mission(config: Config, drones: u16, place: Place, until: Phase) -> Mission {
    Mission { config, drones, place, until, trouble: Trouble::NONE }
}

fn flown(mission: &Mission, seed: u64) -> Flight {
    fly(mission, seed).expect("a swarm has at most 64 drones")
}

/// The paper's rule in JBotSim, an independent simulator: mean rounds with 1 to 6 drones.
const JBOTSIM: [f32; 6] = [1187.0, 652.0, 463.0, 362.0, 352.0, 249.0];

#[test]
fn the_literal_rule_takes_as_long_as_on_jbotsim() {
    for (drones, expected) in (1..).zip(JBOTSIM) {
        let mission = mission(Config::PAPER, drones, Place::B, Phase::Survey);
        let rounds: u32 = (200_000..200_060)
            .map(|seed| flown(&mission, seed).legs[0].rounds.expect("no survey is stuck"))
            .sum();
        let mean = rounds as f32 / 60.0;
        assert!((mean / expected - 1.0).abs() < 0.02, "{drones} drones: {mean} rounds");
    }
}

#[test]
fn our_rule_keeps_clear_and_connected_in_every_phase() {
    // 1.3 safety distances, which the paper reports (section 6.3.1).
    const CLEAR: f32 = 1.3 * 0.30;
    for place in Place::ALL {
        for drones in [1, 2, 3, 4, 5, 6, 12] {
            let mission = mission(Config::OURS, drones, place, Phase::Crossing);
            for seed in 200_000..200_004 {
                for leg in flown(&mission, seed).legs {
                    let what = format!("{} with {drones}, seed {seed}: {leg:?}", place.name());
                    assert!(leg.rounds.is_some() && leg.connected, "{what}");
                    assert!(leg.closest_drones.0 >= CLEAR && leg.closest_wall.0 >= CLEAR, "{what}");
                }
            }
        }
    }
}

/// A drone took one step more after its neighbour behind the passage had begun to land, and was cut off by it.
#[test]
fn the_last_step_out_of_a_passage_cuts_no_link() {
    let mission = mission(Config::OURS, 24, Place::E, Phase::Crossing);
    for seed in 3_400_000..3_400_008 {
        for leg in flown(&mission, seed).legs {
            assert!(leg.rounds.is_some() && leg.connected, "seed {seed}: {leg:?}");
        }
    }
}

/// A drone that was done pushed no other one any more, and the next one flew into it.
#[test]
fn a_drone_of_the_paper_that_is_done_keeps_the_others_off() {
    for place in [Place::A, Place::D, Place::E] {
        let mission = mission(Config::PAPER, 4, place, Phase::Crossing);
        for seed in 3_500_000..3_500_020 {
            let legs = flown(&mission, seed).legs;
            let crossing = legs.last().filter(|leg| leg.phase == Phase::Crossing);
            let closest = crossing.map(|leg| leg.closest_drones);
            assert!(closest > Some(mission.config.size), "{}, seed {seed}: {legs:?}", place.name());
        }
    }
}

#[test]
fn the_same_seed_flies_the_same_mission() {
    let mission = mission(Config::PAPER, 6, Place::D, Phase::Crossing);
    assert_eq!(flown(&mission, 7), flown(&mission, 7));
}

#[test]
fn a_swarm_of_none_or_of_too_many_is_refused() {
    for drones in [0, 65] {
        let mission = mission(Config::PAPER, drones, Place::A, Phase::Survey);
        assert_eq!(fly(&mission, 1), Err(TooMany(drones)));
    }
}
