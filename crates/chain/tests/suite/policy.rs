//! Algorithm 1 by its claims: which way a relay flies, that the rule is the same seen from either
//! end, that the constant part of a loss means nothing to it, and that no input makes it fly
//! faster than it may.

use chain::filter::Slope;
use chain::policy::{LinkEnd, PolicyConfig, SlopeOf, SpeedLaw};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Db, DbPerMetre, Dbm, MetresPerSecond};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

const ALL: [(&str, PolicyConfig); 5] = [
    ("t0", PolicyConfig::T0),
    ("t5", PolicyConfig::T5),
    ("k", PolicyConfig::K),
    ("authors", PolicyConfig::AUTHORS),
    ("k-tuned", PolicyConfig::K_TUNED),
];

fn still(policy: &PolicyConfig, front: f32, back: f32) -> f32 {
    policy.velocity(LinkEnd::still(Dbm(front)), LinkEnd::still(Dbm(back))).0
}

/// Between neighbours at rest, by hand from v = κ·e/g limited to 0.4 m/s. The slopes at 60 and
/// 57 dB under exponent 3 and 40 dB at 1 m: 30/ln 10 over 10^(20/30) and 10^(17/30) metres.
#[test]
fn the_speeds_are_those_of_equation_11() {
    // The paper's own gain is 1.67 1/s: 3 dB over 2.807 dB/m asks for 1.78 m/s.
    assert_eq!(still(&PolicyConfig::T0, -60.0, -57.0), 0.4);
    assert_eq!(still(&PolicyConfig::T0, -57.0, -60.0), -0.4);
    // A quarter of a decibel is below the limit: 1.667 × 0.25 / 2.80.
    assert!((still(&PolicyConfig::T0, -60.0, -59.75) - 0.148).abs() < 0.002);
    // Within the tolerance nothing moves; its end counts to it.
    assert_eq!(still(&PolicyConfig::T5, -60.0, -55.0), 0.0);
    assert_eq!(still(&PolicyConfig::T5, -60.0, -54.9), 0.4);
    // What flew: all or nothing outside a dead zone of 1.5 dB.
    assert_eq!(still(&PolicyConfig::AUTHORS, -60.0, -58.5), 0.0);
    assert_eq!(still(&PolicyConfig::AUTHORS, -60.0, -58.0), 0.3);
    assert_eq!(still(&PolicyConfig::AUTHORS, -58.0, -60.0), -0.3);
    // Too near to the one in front: away from it.
    assert_eq!(still(&PolicyConfig::AUTHORS, -39.0, -35.0), -0.2);
    assert_eq!(still(&PolicyConfig::AUTHORS, -70.0, -35.0), 0.2);
}

/// The slope of the weaker link lets the stronger one, which is steeper, change by more than was
/// meant; that of the steeper link does not.
#[test]
fn the_steeper_link_asks_for_less() {
    let with = |of| PolicyConfig {
        law: SpeedLaw::Proportional {
            gain: 0.1,
            slope: Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) },
            of,
            follow: 0.0,
        },
        ..PolicyConfig::T0
    };
    let weaker = still(&with(SlopeOf::WeakerLink), -60.0, -54.0);
    let steeper = still(&with(SlopeOf::SteeperLink), -60.0, -54.0);
    assert!(weaker > steeper && steeper > 0.0, "{weaker} and {steeper}");
    // 6 dB apart at exponent 3 is a ratio of 10^(6/30) in distance and so in slope.
    assert!((weaker / steeper - 1.585).abs() < 0.001);
}

proptest! {
    #![proptest_config(seeded())]

    /// A relay flies towards its weaker link, and not at all within the tolerance.
    #[test]
    fn a_relay_flies_towards_its_weaker_link(front in -100.0f32..-45.0, back in -100.0f32..-45.0) {
        for (name, policy) in ALL {
            let v = still(&policy, front, back);
            let e = back - front;
            if e.abs() <= policy.tolerance.0 {
                prop_assert_eq!(v, 0.0, "{}", name);
            } else {
                prop_assert!(v * e > 0.0, "{name}: {v} m/s for {front} and {back} dBm");
            }
        }
    }

    /// Seen from the other end of the tunnel the same rule gives the same flight.
    #[test]
    fn the_rule_is_the_same_from_either_end(
        front in -100.0f32..-45.0, back in -100.0f32..-45.0,
        v_f in -0.4f32..0.4, v_b in -0.4f32..0.4,
    ) {
        let end = |rssi, v| LinkEnd { rssi: Dbm(rssi), velocity: MetresPerSecond(v) };
        for (name, policy) in ALL {
            let there = policy.velocity(end(front, v_f), end(back, v_b)).0;
            let back_again = policy.velocity(end(back, -v_b), end(front, -v_f)).0;
            prop_assert!((there + back_again).abs() < 1e-5, "{name}: {there} and {back_again}");
        }
    }

    /// No bits make a policy fly faster than it may, or not a number.
    #[test]
    fn the_limit_holds_for_any_bits(
        front in any::<f32>(), back in any::<f32>(), v_f in any::<f32>(), v_b in any::<f32>(),
    ) {
        let end = |rssi, v| LinkEnd { rssi: Dbm(rssi), velocity: MetresPerSecond(v) };
        for (name, policy) in ALL {
            let v = policy.velocity(end(front, v_f), end(back, v_b)).0;
            prop_assert!(v.abs() <= policy.max_speed.0, "{name}: {v}");
        }
    }

    /// Decibels lost over the first metre, known to the policy, move nothing.
    #[test]
    fn the_loss_of_the_first_metre_moves_nothing(
        front in -100i16..-30, back in -100i16..-30, shift in -40i16..60,
        v_f in -0.4f32..0.4, v_b in -0.4f32..0.4,
    ) {
        let end = |rssi: i16, v| LinkEnd { rssi: Dbm(f32::from(rssi)), velocity: MetresPerSecond(v) };
        for (name, policy) in ALL {
            let here = policy.velocity(end(front, v_f), end(back, v_b));
            let other = policy.for_loss_at_1m(Db(40.0 + f32::from(shift)));
            let there = other.velocity(end(front - shift, v_f), end(back - shift, v_b));
            prop_assert!((here - there).abs().0 < 1e-4, "{name}: {here} and {there}");
        }
    }

    /// Between two neighbours that fly as one, a relay whose links are equal flies no faster than
    /// they and not the other way: feed-forward leads no relay astray.
    #[test]
    fn with_equal_links_a_relay_follows_but_never_overtakes(
        rssi in -90.0f32..-45.0, v in -0.4f32..0.4,
    ) {
        let end = LinkEnd { rssi: Dbm(rssi), velocity: MetresPerSecond(v) };
        for (name, policy) in ALL {
            let own = policy.velocity(end, end).0;
            prop_assert!(own * v >= 0.0 && own.abs() <= v.abs() + 1e-6, "{name}: {own} of {v}");
        }
    }

    /// A constant slope makes the rule linear in the imbalance.
    #[test]
    fn with_a_constant_slope_the_rule_is_linear(
        back in -90.0f32..-50.0, e in -3.0f32..3.0, gain in 0.01f32..0.2, slope in 0.5f32..5.0,
    ) {
        let policy = PolicyConfig {
            law: SpeedLaw::Proportional {
                gain, slope: Slope::Constant(DbPerMetre(slope)), of: SlopeOf::WeakerLink, follow: 0.0,
            },
            max_speed: MetresPerSecond(10.0),
            ..PolicyConfig::T0
        };
        let v = still(&policy, back - e, back);
        prop_assert!((v - gain * e / slope).abs() < 1e-5 + 1e-4 * v.abs(), "{v}");
    }
}

/// −37 dBm is too near. Drones that stand close together must not push each other: between two that
/// are too near a relay stays, unless one of them is clearly nearer.
#[test]
fn between_two_near_neighbours_a_relay_stays_or_leaves_the_nearer() {
    let policy = &PolicyConfig::CHAIN;
    assert_eq!(still(policy, -35.0, -60.0), -0.2);
    assert_eq!(still(policy, -60.0, -35.0), 0.2);
    assert_eq!(still(policy, -35.0, -35.0), 0.0);
    assert_eq!(still(policy, -36.0, -33.0), 0.0);
    assert_eq!(still(policy, -36.0, -31.0), 0.2);
    assert_eq!(still(policy, -31.0, -36.0), -0.2);
}
