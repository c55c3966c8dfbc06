//! Plans of relays: as few as the radio needs, and no link weaker than was asked for.

use std::path::Path;
use world::Spot;

use maps::MapChoice;
use sim_harness::planning::plan::{Demand, Limit, MOST_RELAYS, Reach, relays};
use sim_harness::scenario::Scenario;
use units::{Db, MetresPerSecond};
use world::SkeletonPlace;

fn demand(margin: f32) -> Demand {
    Demand { margin: Db(margin), speed: MetresPerSecond(0.2), depth_m: None }
}

/// In a straight gallery a link of −60 dBm is 10 m long by L = 40 dB + 20·log₁₀ d, and one that is
/// 6 dB stronger 5 m.
#[test]
fn a_straight_gallery_takes_as_many_relays_as_links_of_the_limits_length() {
    let scenario = Scenario::open("straight-n8").unwrap();
    let limit = scenario.agent.launch.limit.0;
    for margin in [0.0, 3.0, 6.0] {
        let plan = relays(&scenario, demand(margin));
        if plan.limit_fetched() == Limit::Radio {
            continue;
        }
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
            let plan = relays(&scenario, demand(margin));
            if plan.limit_fetched() == Limit::Radio {
                continue;
            }
            let weakest = plan.links.iter().map(|link| link.strength.0).fold(0.0, f32::min);
            assert!(weakest >= plan.least.0 - 0.05, "{name}: {weakest} for {:?}", plan.least);
            let ways: Vec<f32> = plan.stands.iter().map(|stand| stand.along_m).collect();
            assert!(ways.is_sorted() && ways[0] == 0.0, "{name}: {ways:?}");
            assert!((ways[ways.len() - 1] - plan.way_m).abs() < 1e-3, "{name}: {ways:?}");
            // A chain with more margin never takes fewer relays.
            let more = relays(&scenario, demand(margin + 3.0));
            let more = match more.limit_fetched() {
                Limit::Radio => MOST_RELAYS + 2,
                _ => more.links.len(),
            };
            assert!(more >= plan.links.len(), "{name}: {more} links at {margin} dB more");
        }
    }
}

#[test]
fn a_way_that_no_chain_covers_has_a_plan_as_far_as_one_reaches() {
    let mut scenario = Scenario::open("meander-105").unwrap();
    scenario.agent.launch.limit = units::Dbm(-45.0);
    let plan = relays(&scenario, demand(0.0));
    assert_eq!(plan.limit_fetched(), Limit::Radio);
    assert!(plan.reached_m > 1.0 && plan.reached_m < plan.way_m, "{plan:?}");
    assert_eq!(
        (plan.stands.len(), plan.needed.last().unwrap().relays),
        (MOST_RELAYS + 2, MOST_RELAYS)
    );
    assert!(plan.links.iter().all(|link| link.strength >= plan.least), "{:?}", plan.links);
}

/// The head's battery ends the plan where the agent's own rule, asked metre by metre, turns it back.
#[test]
fn the_battery_ends_a_plan_where_the_agents_rule_does() {
    let scenario = Scenario::open("straight-n8").unwrap();
    let flight = &scenario.agent.flight;
    for speed in [0.1, 0.2, 0.4] {
        let Reach { endurance_s, farthest_m, stay_s } =
            relays(&scenario, Demand { speed: MetresPerSecond(speed), ..demand(0.0) }).reach;
        // The climb to 0.3 m at 0.2 m/s, and a second to settle.
        let left = |way: f32| endurance_s - 2.5 - way / speed;
        let turns = |way: f32| left(way) < flight.turns_back_below(way / flight.return_speed.0);
        let first = (0..10_000).map(|n| 0.01 * n as f32).find(|way| turns(*way)).unwrap();
        assert!((first - farthest_m).abs() < 0.02, "{first} {farthest_m}");
        let plan = relays(&scenario, demand(0.0));
        assert_eq!(stay_s < 0.0, turns(plan.reached_m), "{stay_s}");
    }
}

/// A base that stands within the gallery is nearer to its end than the gallery is long.
#[test]
fn a_plan_begins_at_the_base_wherever_that_stands() {
    let mut scenario = Scenario::open("straight-n8").unwrap();
    scenario.agent.launch.limit = units::Dbm(-60.0);
    scenario.drones.base = Spot::on(scenario.tunnel.skeleton(), SkeletonPlace::main(12.0));
    let ends = |plan: &sim_harness::planning::plan::RelayPlan| {
        [plan.stands[0].at.x, plan.stands[plan.stands.len() - 1].at.x]
    };
    for (depth_m, way_m) in [(None, 28.0), (Some(6.0), 6.0)] {
        let plan = relays(&scenario, Demand { depth_m, ..demand(0.0) });
        assert_eq!(plan.limit_fetched(), Limit::Way, "{plan:?}");
        assert!((plan.way_m - way_m).abs() < 1e-3, "{plan:?}");
        let off = ends(&plan).into_iter().zip([12.0, 12.0 + way_m]).map(|(x, is)| (x - is).abs());
        assert!(off.fold(0.0, f32::max) < 0.01, "{plan:?}");
    }
}

#[test]
fn a_plan_says_where_relays_stand_by_station_and_what_ends_the_route() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/caves/crooked.svx");
    let map = MapChoice { file, ..MapChoice::default() };
    let scenario = Scenario::of_map(map, None, Vec::new()).unwrap();
    let route = scenario.route.as_ref().unwrap();
    assert_eq!(route.by_station(0.0).unwrap(), "at crooked.1");
    assert_eq!(route.by_station(10.2).unwrap(), "2 m past crooked.2");
    let words = "crooked.7 to crooked.8 is a shaft of 12.0 m at 90°";
    assert_eq!(route.ended.to_string(), words);
    let plan = relays(&scenario, Demand { depth_m: Some(20.0), ..demand(3.0) });
    assert_eq!((plan.way_m, plan.limit()), (20.0, Limit::Way));
    let whole = relays(&scenario, demand(3.0));
    assert_eq!((whole.limit(), whole.limit_fetched()), (Limit::Battery, Limit::Way));
    let depths: Vec<_> = whole.needed.iter().map(|it| it.depth_m).collect();
    assert_eq!(depths[..4], [10.0, 20.0, 30.0, 40.0]);
    assert!(whole.needed.is_sorted_by(|a, b| a.relays <= b.relays), "{:?}", whole.needed);
}
