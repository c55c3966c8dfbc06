//! When a waiting relay takes off: what no launch policy may do, whatever the chain does, and how
//! the orders and spans travel that it listens to. (The rules one by one are tested beside the
//! code.)

use chain::launch::{LaunchConfig, LaunchWatch};
use chain::retreat::RetreatConfig;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Db, Dbm, Duration, Instant, LinkSpan};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// The watch's inputs of one round: the last link, and the span ahead of it.
type Seen = (Option<f32>, Option<(f32, f32)>);

fn seen() -> impl Strategy<Value = Vec<Seen>> {
    let link = prop::option::weighted(0.9, -75.0f32..-45.0);
    let ahead = prop::option::weighted(0.8, (-75.0f32..-45.0, 0.0f32..8.0));
    prop::collection::vec((link, ahead), 1..150)
}

fn span(ahead: Option<(f32, f32)>) -> Option<LinkSpan> {
    ahead.map(|(weakest, spread)| LinkSpan {
        weakest: Dbm(weakest),
        strongest: Dbm(weakest + spread),
    })
}

proptest! {
    #![proptest_config(seeded())]

    /// No relay is launched while the last link is good, nor before it has been bad for as long as
    /// the shorter of hold and patience.
    #[test]
    fn no_launch_without_a_weak_last_link(seen in seen()) {
        for config in [LaunchConfig::AT_ONCE, LaunchConfig::WHEN_SETTLED] {
            let mut watch = LaunchWatch::new();
            let mut weak_since = None;
            for (n, (link, ahead)) in seen.iter().enumerate() {
                let now = Instant::from_millis(200 * n as u64);
                let weak = link.is_none_or(|link| Dbm(link) < config.limit);
                if weak {
                    weak_since.get_or_insert(now);
                } else {
                    weak_since = None;
                }
                let launched = watch.step(now, &config, link.map(Dbm), span(*ahead));
                let least = config.hold.min(config.patience);
                let long = weak_since.is_some_and(|since| now.since(since) >= least);
                prop_assert!(!launched || long, "launched at {now:?} with {link:?}");
                // And none is put off for longer than the patience.
                let overdue = weak_since.is_some_and(|since| now.since(since) >= config.patience);
                prop_assert!(launched || !overdue, "put off at {now:?} with {link:?}");
            }
        }
    }

    /// "At once" looks at nothing but the last link of this very round.
    #[test]
    fn at_once_remembers_nothing(seen in seen()) {
        let config = LaunchConfig::AT_ONCE;
        let mut watch = LaunchWatch::new();
        for (n, (link, ahead)) in seen.iter().enumerate() {
            let now = Instant::from_millis(200 * n as u64);
            let launched = watch.step(now, &config, link.map(Dbm), span(*ahead));
            prop_assert_eq!(launched, link.is_none_or(|link| Dbm(link) < config.limit));
        }
    }

    /// A chain whose links differ by more than the spread is not settled, so it is held for the
    /// whole of the patience.
    #[test]
    fn an_unequal_chain_takes_all_of_the_patience(
        link in -75.0f32..-61.0, spread in 4.1f32..30.0, round_ms in 50u64..400,
    ) {
        let config = LaunchConfig::WHEN_SETTLED;
        let ahead = span(Some((link, spread)));
        let mut watch = LaunchWatch::new();
        for n in 0.. {
            let now = Instant::from_millis(n * round_ms);
            if watch.step(now, &config, Some(Dbm(link)), ahead) {
                prop_assert!(now.since(Instant::ZERO) >= config.patience);
                break;
            }
            prop_assert!(now.since(Instant::ZERO) < config.patience);
        }
    }

    /// Any bits and any clock are borne.
    #[test]
    fn any_bits_are_borne(
        rounds in prop::collection::vec(
            (any::<u64>(), prop::option::of(any::<f32>()), any::<f32>(), any::<f32>()), 0..50,
        ),
    ) {
        for config in [LaunchConfig::AT_ONCE, LaunchConfig::WHEN_SETTLED] {
            let mut watch = LaunchWatch::new();
            for &(us, link, weakest, strongest) in &rounds {
                let ahead = LinkSpan { weakest: Dbm(weakest), strongest: Dbm(strongest) };
                let _ = watch.step(Instant::from_micros(us), &config, link.map(Dbm), Some(ahead));
            }
        }
    }

    /// The span of a run of links is that of its links, in whatever order they are told.
    #[test]
    fn a_span_is_the_least_and_the_most_of_its_links(
        links in prop::collection::vec(-100.0f32..-30.0, 1..16),
    ) {
        let told = links.iter().fold(None, |run, &link| Some(LinkSpan::extended(run, Dbm(link))));
        let least = links.iter().copied().fold(f32::INFINITY, f32::min);
        let most = links.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        prop_assert_eq!(told, Some(LinkSpan { weakest: Dbm(least), strongest: Dbm(most) }));
    }

    /// The part of the pilot's speed that the head keeps is a part, whatever the link reads, and
    /// the weaker the link the smaller it is.
    #[test]
    fn a_weaker_link_never_frees_the_head(
        one in -120.0f32..0.0, other in -120.0f32..0.0, ease in 0.0f32..10.0,
    ) {
        let config = RetreatConfig { ease: Db(ease), ..RetreatConfig::DEFAULT };
        let (weak, strong) = (one.min(other), one.max(other));
        let (less, more) = (config.freedom(Some(Dbm(weak))), config.freedom(Some(Dbm(strong))));
        prop_assert!((0.0..=1.0).contains(&less) && less <= more && more <= 1.0);
        prop_assert_eq!(config.freedom(None), 0.0);
        prop_assert!(weak > config.limit.0 || less == 0.0);
    }

    /// A retreat that is under way asks for more than one that is not: it cannot flutter.
    #[test]
    fn a_retreat_has_hysteresis(
        front in prop::option::of(-100.0f32..-30.0), back in prop::option::of(-100.0f32..-30.0),
    ) {
        let config = RetreatConfig::DEFAULT;
        let wanted = |backing| config.wanted(front.map(Dbm), back.map(Dbm), backing);
        prop_assert!(wanted(true) || !wanted(false));
        if back.is_none() {
            prop_assert!(wanted(false));
        }
        if back.is_some_and(|back| front.is_some_and(|front| front < back)) {
            prop_assert!(!wanted(true), "the weaker link is in front");
        }
    }
}

/// Whatever a packet reads, the head keeps a part of its speed between none and all.
#[test]
fn the_freedom_of_the_head_is_a_part_for_any_bits() {
    for ease in [0.0, 4.0] {
        let config = RetreatConfig { ease: Db(ease), ..RetreatConfig::DEFAULT };
        for rssi in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 0.0] {
            let freedom = config.freedom(Some(Dbm(rssi)));
            assert!((0.0..=1.0).contains(&freedom), "{freedom} of the speed at {rssi} dBm");
        }
    }
}

/// A clock that runs backwards launches no relay early.
#[test]
fn a_clock_that_jumps_back_begins_no_launch() {
    let config = LaunchConfig::WHEN_SETTLED;
    let mut watch = LaunchWatch::new();
    let weak = Some(Dbm(-61.0));
    assert!(!watch.step(Instant::from_millis(100_000), &config, weak, None));
    assert!(!watch.step(Instant::from_millis(50_000), &config, weak, None));
    assert!(!watch.step(Instant::from_millis(101_999), &config, weak, None));
    assert!(watch.step(Instant::from_millis(102_000), &config, weak, None));
    assert_eq!(config.hold, Duration::from_secs(2));
}
