//! The link filter of section IV-C through its public door: what it believes, and how sure it is,
//! whatever comes in. Shows that the variance stays positive and bounded, that a lost packet costs
//! certainty and nothing else, that the constant part of a loss moves nothing, and that bad
//! numbers leave no trace.

use chain::filter::{Kalman, LinkFilter, Slope, Smoothing};
use chain::policy::PolicyConfig;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Db, DbPerMetre, Dbm, Duration, MetresPerSecond};

/// One round of the 5 Hz loop.
const ROUND: Duration = Duration::from_millis(200);

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// The Kalman filter of a policy that has one.
fn kalman_of(policy: &PolicyConfig) -> Kalman {
    match policy.smoothing {
        Smoothing::Kalman(kalman) => kalman,
        other => panic!("no Kalman filter but {other:?}"),
    }
}

/// The filters that fly: the paper's and the one that is flashed.
fn kalmans() -> [Kalman; 2] {
    [&PolicyConfig::K, &PolicyConfig::K_TUNED].map(kalman_of)
}

/// P, which the filter tells as part of what it expects of the next packet.
fn variance(link: &LinkFilter, kalman: &Kalman) -> f32 {
    let expected = link.expectation(&Smoothing::Kalman(*kalman)).unwrap();
    expected.variance.unwrap() - kalman.measurement_variance
}

/// The events of a link in one round.
#[derive(Clone, Copy, Debug)]
struct Round {
    separating: f32,
    packet: Option<f32>,
}

fn rounds() -> impl Strategy<Value = Vec<Round>> {
    let packet = prop::option::weighted(0.8, -100.0f32..-30.0);
    let round =
        (-0.8f32..0.8, packet).prop_map(|(separating, packet)| Round { separating, packet });
    prop::collection::vec(round, 1..200)
}

proptest! {
    #![proptest_config(seeded())]

    /// P is never negative, never above what one packet alone leaves right after one, and no
    /// larger between packets than Q and the doubt about the way flown can have made it.
    #[test]
    fn the_variance_stays_positive_and_bounded(rounds in rounds()) {
        for kalman in kalmans() {
            let smoothing = Smoothing::Kalman(kalman);
            let mut link = LinkFilter::new();
            link.update(&smoothing, Dbm(-60.0));
            let mut most = kalman.measurement_variance;
            for round in &rounds {
                let before = link.rssi().unwrap();
                link.predict(&smoothing, MetresPerSecond(round.separating), ROUND);
                let doubt = kalman.motion_doubt * (link.rssi().unwrap() - before).0;
                most += kalman.process_variance * 0.2 + doubt * doubt;
                let coasting = variance(&link, &kalman);
                prop_assert!(coasting > -1e-4 && coasting <= most * 1.001 + 1e-3,
                    "{coasting} of {most}");
                if let Some(rssi) = round.packet {
                    link.update(&smoothing, Dbm(rssi));
                    let known = variance(&link, &kalman);
                    prop_assert!(known > -1e-4 && known <= kalman.measurement_variance + 1e-3,
                        "{known}");
                    most = known;
                }
            }
        }
    }

    /// The estimate lies between what was believed and what was measured: a filter interpolates.
    #[test]
    fn a_packet_pulls_the_estimate_towards_itself(
        rounds in rounds(), first in -100.0f32..-30.0,
    ) {
        for policy in [PolicyConfig::T0, PolicyConfig::K, PolicyConfig::AUTHORS,
            PolicyConfig::K_TUNED]
        {
            let mut link = LinkFilter::new();
            link.update(&policy.smoothing, Dbm(first));
            for round in &rounds {
                link.predict(&policy.smoothing, MetresPerSecond(round.separating), ROUND);
                let before = link.rssi().unwrap().0;
                let Some(packet) = round.packet else { continue };
                link.update(&policy.smoothing, Dbm(packet));
                let after = link.rssi().unwrap().0;
                let (low, high) = (before.min(packet), before.max(packet));
                prop_assert!(after >= low - 1e-3 && after <= high + 1e-3,
                    "{after} of {low} to {high}");
            }
        }
    }

    /// Without a Kalman filter velocity means nothing: T0 and T5 are the last packet, whatever
    /// the drones did since.
    #[test]
    fn raw_is_the_last_packet(rounds in rounds()) {
        let raw = PolicyConfig::T0.smoothing;
        let mut link = LinkFilter::new();
        let mut last = None;
        for round in &rounds {
            link.predict(&raw, MetresPerSecond(round.separating), ROUND);
            if let Some(rssi) = round.packet {
                link.update(&raw, Dbm(rssi));
                last = Some(rssi);
            }
            match (link.rssi(), last) {
                (Some(is), Some(was)) => prop_assert!((is.0 - was).abs() < 1e-4),
                (is, was) => prop_assert!(is.is_none() && was.is_none()),
            }
            prop_assert!(link.expectation(&raw).is_none_or(|e| e.variance.is_none()));
        }
    }

    /// Radios that lose so many decibels more over the first metre, known to the filter, shift
    /// what it believes by as much and change nothing else.
    #[test]
    fn the_loss_of_the_first_metre_only_shifts(rounds in rounds(), shift in -40i8..40) {
        let shift = Db(f32::from(shift));
        for policy in [PolicyConfig::K, PolicyConfig::K_TUNED] {
            let shifted_policy = policy.for_loss_at_1m(Db(40.0) + shift);
            let (here, there) = (policy.smoothing, shifted_policy.smoothing);
            let (mut link, mut shifted) = (LinkFilter::new(), LinkFilter::new());
            link.update(&here, Dbm(-60.0));
            shifted.update(&there, Dbm(-60.0) - shift);
            for round in &rounds {
                link.predict(&here, MetresPerSecond(round.separating), ROUND);
                shifted.predict(&there, MetresPerSecond(round.separating), ROUND);
                if let Some(rssi) = round.packet {
                    link.update(&here, Dbm(rssi));
                    shifted.update(&there, Dbm(rssi) - shift);
                }
                let apart = link.rssi().unwrap() - shifted.rssi().unwrap();
                prop_assert!((apart - shift).abs() < Db(0.01), "{apart} for {shift}");
            }
        }
    }

    /// What is not a number, and what has no end, is as if it had not been: for velocities and
    /// for packets, before the first good one and after.
    #[test]
    fn bad_numbers_change_nothing(
        rounds in rounds(),
        bad in prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ) {
        for policy in [PolicyConfig::T0, PolicyConfig::K, PolicyConfig::AUTHORS,
            PolicyConfig::K_TUNED]
        {
            let smoothing = &policy.smoothing;
            let (mut link, mut disturbed) = (LinkFilter::new(), LinkFilter::new());
            for round in &rounds {
                disturbed.update(smoothing, Dbm(bad));
                disturbed.predict(smoothing, MetresPerSecond(bad), ROUND);
                for filter in [&mut link, &mut disturbed] {
                    filter.predict(smoothing, MetresPerSecond(round.separating), ROUND);
                    if let Some(rssi) = round.packet {
                        filter.update(smoothing, Dbm(rssi));
                    }
                }
                prop_assert_eq!(link, disturbed);
            }
        }
    }

    /// A finite velocity or packet, however absurd (a neighbour's report is only a claim), must
    /// leave a filter that still knows a number and still listens: after a minute of good packets
    /// it is back where they say.
    #[test]
    fn an_absurd_number_is_survived(
        velocity in any::<f32>().prop_filter("finite", |v| v.is_finite()),
        packet in any::<f32>().prop_filter("finite", |v| v.is_finite() && v.abs() < 1e4),
    ) {
        for policy in [PolicyConfig::K, PolicyConfig::K_TUNED] {
            let smoothing = &policy.smoothing;
            let mut link = LinkFilter::new();
            link.update(smoothing, Dbm(-60.0));
            link.predict(smoothing, MetresPerSecond(velocity), ROUND);
            link.update(smoothing, Dbm(packet));
            for _ in 0..300 {
                link.predict(smoothing, MetresPerSecond::ZERO, ROUND);
                link.update(smoothing, Dbm(-60.0));
            }
            let rssi = link.rssi().unwrap().0;
            prop_assert!(rssi.is_finite(), "{rssi} dBm after {velocity} m/s and {packet} dBm");
        }
    }
}

/// Hovering, packet after packet, P settles at the solution of the Riccati equation: with q = Q·dt
/// per round the variance before an update is M = (q + √(q² + 4·q·R)) / 2.
#[test]
fn the_variance_of_a_hovering_pair_is_riccatis() {
    for kalman in kalmans() {
        let smoothing = Smoothing::Kalman(kalman);
        let mut link = LinkFilter::new();
        for _ in 0..2_000 {
            link.predict(&smoothing, MetresPerSecond::ZERO, ROUND);
            link.update(&smoothing, Dbm(-60.0));
        }
        link.predict(&smoothing, MetresPerSecond::ZERO, ROUND);
        let (q, r) = (kalman.process_variance * 0.2, kalman.measurement_variance);
        let riccati = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        let is = variance(&link, &kalman);
        assert!((is - riccati).abs() < 0.01 * riccati, "{is} for {riccati}");
    }
}

/// "A lost packet costs nothing but certainty": coasting for 2 s without one packet along a link
/// that obeys the filter's own law stays within a fifth of a decibel, and P grows all the way.
#[test]
fn a_link_is_known_through_two_seconds_of_silence() {
    let law = |metres: f32| Dbm(-(40.0 + 30.0 * metres.log10()));
    for kalman in kalmans() {
        let smoothing = Smoothing::Kalman(kalman);
        for velocity in [-0.4, -0.1, 0.0, 0.1, 0.4] {
            let mut distance = 4.0;
            let mut link = LinkFilter::new();
            link.update(&smoothing, law(distance));
            let mut before = variance(&link, &kalman);
            for _ in 0..10 {
                link.predict(&smoothing, MetresPerSecond(velocity), ROUND);
                distance += velocity * 0.2;
                let now = variance(&link, &kalman);
                assert!(now > before, "{now} after {before}");
                before = now;
            }
            let error = (link.rssi().unwrap() - law(distance)).0;
            assert!(error.abs() < 0.2, "{error} dB off at {distance} m");
        }
    }
}

/// A is in dB per metre: two half rounds are one round, so the tuning does not depend on how many
/// packets or rounds there are.
#[test]
fn the_prediction_does_not_depend_on_the_rate() {
    let slope = Slope::Constant(DbPerMetre(2.0));
    let smoothing = Smoothing::Kalman(Kalman { slope, ..kalman_of(&PolicyConfig::K) });
    let coast = |rounds: u64| {
        let mut link = LinkFilter::new();
        link.update(&smoothing, Dbm(-60.0));
        for _ in 0..rounds {
            let dt = Duration::from_millis(2_000 / rounds);
            link.predict(&smoothing, MetresPerSecond(0.3), dt);
        }
        link.rssi().unwrap().0
    };
    for rounds in [1, 2, 10, 100] {
        assert!((coast(rounds) - (-61.2)).abs() < 1e-3, "{rounds} rounds: {}", coast(rounds));
    }
}

/// The exponential average that the authors flew: 0.27 of each packet.
#[test]
fn the_average_weighs_as_it_says() {
    let smoothing = Smoothing::Average { weight: 0.27 };
    let mut link = LinkFilter::new();
    assert_eq!(link.rssi(), None);
    link.update(&smoothing, Dbm(-60.0));
    link.update(&smoothing, Dbm(-70.0));
    assert!((link.rssi().unwrap() - Dbm(-62.7)).abs() < Db(1e-4));
    link.reset();
    assert_eq!(link.rssi(), None);
    assert_eq!(link.expectation(&smoothing), None);
}

/// The slope is the derivative of its law where the law is believed, and always positive.
#[test]
fn the_slope_is_the_derivative_of_the_law() {
    let slope = Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) };
    let loss = |d: f32| 40.0 + 30.0 * d.log10();
    for distance in [0.5, 1.0, 3.0, 10.0, 25.0] {
        let numeric = (loss(distance * 1.01) - loss(distance * 0.99)) / (distance * 0.02);
        let is = slope.at(Db(loss(distance))).0;
        assert!((is - numeric).abs() < 0.01 * numeric, "{is} for {numeric} at {distance} m");
    }
    for loss in [-1e30, -100.0, 0.0, 300.0, 1e30, f32::INFINITY, f32::NEG_INFINITY] {
        let is = slope.at(Db(loss)).0;
        assert!(is > 0.0 && is.is_finite(), "{is} at {loss} dB");
    }
}
