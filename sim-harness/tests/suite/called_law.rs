//! Missions by a speed law that the caller of the simulator gives.

use chain::policy::PolicyConfig;
use sim_harness::measure::metrics::{Reference, watched};
use sim_harness::mission::{Mission, with_called_law};
use sim_harness::scenario::Scenario;
use units::MetresPerSecond;

#[test]
fn a_law_that_copies_a_policy_flies_its_missions() {
    let scenario = Scenario::open("straight").unwrap().with_policy("k-tuned").unwrap();
    let scenario = Scenario { duration_us: 60_000_000, ..scenario };
    let (world, policy) = (scenario.world(), scenario.agent.policy);
    let reference = Reference::of(&scenario, &world);
    let metrics = |scenario: &Scenario, mission: &mut Mission<'_>| {
        format!("{:?}", watched(scenario, &world, &reference, mission))
    };
    let own = metrics(&scenario, &mut Mission::new(&scenario, &world, 5));
    let called = with_called_law(&scenario);
    let fly = |policy: PolicyConfig| {
        let law = move |_: usize, front, back| policy.velocity(front, back);
        metrics(&called, &mut Mission::new(&called, &world, 5).by_law(Box::new(law)))
    };
    assert_eq!(fly(policy), own);
    assert_ne!(fly(PolicyConfig { max_speed: MetresPerSecond(0.01), ..policy }), own);
}

/// The demonstration's own policy launches by sums over the chain, which a called law does not report.
#[test]
fn a_law_in_place_of_a_chain_wide_one_flies_by_the_rule_without_sums() {
    let scenario = Scenario::open("demo").unwrap();
    let scenario = Scenario { duration_us: 120_000_000, ..scenario };
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let tuned = scenario.with_policy("k-tuned").unwrap();
    let metrics = |scenario: &Scenario, mission: &mut Mission<'_>| {
        format!("{:?}", watched(scenario, &world, &reference, mission))
    };
    let own = metrics(&tuned, &mut Mission::new(&tuned, &world, 5));
    let policy = tuned.agent.policy;
    let law = move |_: usize, front, back| policy.velocity(front, back);
    let called = with_called_law(&scenario);
    let flown = metrics(&called, &mut Mission::new(&called, &world, 5).by_law(Box::new(law)));
    assert_eq!(flown, own);
}
