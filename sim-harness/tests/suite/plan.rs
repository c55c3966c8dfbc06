//! Plans of relays: as few as the radio needs, and no link weaker than was asked for.

use sim_harness::measure::plan::{Demand, MOST_RELAYS, relays};
use sim_harness::scenario::Scenario;
use units::{Db, MetresPerSecond};

fn demand(margin: f32) -> Demand {
    Demand { margin: Db(margin), speed: MetresPerSecond(0.2) }
}

/// In a straight gallery a link of −60 dBm is 10 m long by L = 40 dB + 20·log₁₀ d, and one that is
/// 6 dB stronger 5 m.
#[test]
fn a_straight_gallery_takes_as_many_relays_as_links_of_the_limits_length() {
    let scenario = Scenario::open("straight-n8").unwrap();
    let limit = scenario.agent.launch.limit.0;
    for margin in [0.0, 3.0, 6.0] {
        let Ok(plan) = relays(&scenario, demand(margin)) else { continue };
        let longest = 10_f32.powf((-limit - margin - 40.0) / 20.0);
        let links = (plan.way_m / longest).ceil() as usize;
        assert_eq!(plan.links.len(), links, "{margin} dB: {} m", plan.way_m);
    }
}

#[test]
fn no_link_is_weaker_than_asked_for_and_one_relay_less_does_not_do() {
    for name in ["demo", "right-angles", "paper-circuit", "spiral", "t-junction"] {
        let mut scenario = Scenario::open(name).unwrap();
        // A limit at which the corridors of the other benchmarks need some relays.
        scenario.agent.launch.limit = units::Dbm(-72.0);
        for margin in [-3.0, 0.0, 3.0] {
            let Ok(plan) = relays(&scenario, demand(margin)) else { continue };
            let weakest = plan.links.iter().map(|link| link.strength.0).fold(0.0, f32::min);
            assert!(weakest >= plan.least.0 - 0.05, "{name}: {weakest} for {:?}", plan.least);
            let ways: Vec<f32> = plan.stands.iter().map(|stand| stand.along_m).collect();
            assert!(ways.is_sorted() && ways[0] == 0.0, "{name}: {ways:?}");
            assert!((ways[ways.len() - 1] - plan.way_m).abs() < 1e-3, "{name}: {ways:?}");
            // A chain with more margin never takes fewer relays.
            let more = relays(&scenario, demand(margin + 3.0));
            let more = more.map_or(MOST_RELAYS + 2, |plan| plan.links.len());
            assert!(more >= plan.links.len(), "{name}: {more} links at {margin} dB more");
        }
    }
}

#[test]
fn a_way_that_no_chain_covers_says_how_far_one_reaches() {
    let mut scenario = Scenario::open("meander-105").unwrap();
    scenario.agent.launch.limit = units::Dbm(-45.0);
    let why = relays(&scenario, demand(0.0)).unwrap_err();
    assert!(why.reached_m > 1.0 && why.reached_m < why.way_m, "{why:?}");
}
