//! The filter that estimates a link's two slopes, on simulated links whose slopes are known: that
//! both slopes are found, that the filter's errors are as large as it says, that outliers move it
//! by no more than Huber's estimator allows, and that no input breaks it.

use chain::filter::{LinkFilter, LinkState, Separation, Slope, SlopeFilter, Smoothing};
use chain::policy::PolicyConfig;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Db, DbPerMetre, Dbm, Duration, Metres, MetresPerSecond};

use crate::noise::Noise;

/// One round of the 5 Hz loop.
const ROUND: Duration = Duration::from_millis(200);
const DT: f32 = 0.2;

/// The error, in standard deviations, from which on a packet is an outlier.
const OUTLIER: f32 = 3.0;
/// R of the simulated packets, dB².
const NOISE: f32 = 3.0;

/// The filter that flies.
fn config() -> SlopeFilter {
    match PolicyConfig::CHAIN.smoothing {
        Smoothing::Slopes(config) => config,
        other => panic!("no filter of slopes but {other:?}"),
    }
}

/// A filter and its constants.
#[derive(Clone, Copy)]
struct Filter {
    link: LinkFilter,
    config: SlopeFilter,
}

impl Filter {
    /// The filter after a first packet of this loss.
    fn of(config: SlopeFilter, loss: f32) -> Self {
        let mut filter = Self { link: LinkFilter::new(), config };
        filter.hear(loss);
        filter
    }

    fn smoothing(&self) -> Smoothing {
        Smoothing::Slopes(self.config)
    }

    /// A round in which the own motion and the neighbour's separate the ends by these metres.
    fn fly(&mut self, own: f32, peer: f32) {
        let smoothing = self.smoothing();
        self.link.predict(&smoothing, MetresPerSecond::ZERO, ROUND);
        self.link.separate(&smoothing, Separation { own: Metres(own), peer: Metres(peer) });
    }

    fn hear(&mut self, loss: f32) {
        let smoothing = self.smoothing();
        self.link.update(&smoothing, Dbm::after_loss(Db(loss)));
    }

    /// Hovers for so many rounds of packets without noise.
    fn rest(&mut self, rounds: usize, loss: f32) {
        for _ in 0..rounds {
            self.fly(0.0, 0.0);
            self.hear(loss);
        }
    }

    fn state(&self) -> LinkState {
        self.link.state().unwrap()
    }

    fn loss(&self) -> f32 {
        self.state().loss.0
    }

    fn slopes(&self) -> [f32; 2] {
        self.state().slopes.map(|slope| slope.0)
    }

    /// The variance of the next packet's RSSI.
    fn expected(&self) -> f32 {
        self.link.expectation(&self.smoothing()).unwrap().variance.unwrap()
    }

    /// R, as far as it has been learned.
    fn noise(&self) -> f32 {
        self.expected() - self.state().variance
    }
}

/// A motion such as that of two drones: a velocity each, that changes every few seconds.
struct Motion {
    velocities: [f32; 2],
}

impl Motion {
    fn new() -> Self {
        Self { velocities: [0.0; 2] }
    }

    /// The way of both ends in a round.
    fn round(&mut self, noise: &mut Noise) -> [f32; 2] {
        for velocity in &mut self.velocities {
            *velocity += 0.2 * (-*velocity + 0.6 * noise.next());
            *velocity = velocity.clamp(-0.4, 0.4);
        }
        self.velocities.map(|velocity| velocity * DT)
    }
}

/// Neither the law nor the motion of the other end tells a drone its slope: only the packets do.
#[test]
fn both_slopes_are_found() {
    for (own, peer) in [(1.5, 1.5), (3.0, 8.0), (8.0, 3.0), (12.0, 12.0), (20.0, 6.0)] {
        let mut off = [0.0f32; 2];
        let seeds = 20;
        for seed in 1..=seeds {
            let mut noise = Noise::new(seed);
            let (mut motion, mut loss) = (Motion::new(), 60.0);
            let mut filter = Filter::of(config(), loss);
            let mut seen = [0.0; 2];
            let rounds = 600;
            for round in 0..rounds {
                let [p, q] = motion.round(&mut noise);
                loss += own * p + peer * q;
                filter.fly(p, q);
                filter.hear(loss + NOISE.sqrt() * noise.next());
                if round >= rounds / 2 {
                    for (seen, slope) in seen.iter_mut().zip(filter.slopes()) {
                        *seen += slope / (rounds / 2) as f32;
                    }
                }
            }
            for (off, (seen, truth)) in off.iter_mut().zip(seen.into_iter().zip([own, peer])) {
                *off += (seen / truth - 1.0) / seeds as f32;
            }
        }
        assert!(off.iter().all(|off| off.abs() < 0.2), "{off:?} of {own} and {peer} dB/m");
    }
}

/// The slopes of two ends that only ever move together in time cannot be told apart, but their sum
/// can, and the prior splits it.
#[test]
fn of_ends_that_part_alike_the_sum_of_slopes_is_found() {
    let mut noise = Noise::new(1);
    let (truth, mut loss, mut length) = (16.0, 60.0, 0.0f32);
    let mut filter = Filter::of(config(), loss);
    for round in 0..400 {
        let way = 0.06 * (round as f32 * 0.2).sin();
        length += 2.0 * way;
        loss += truth * way;
        filter.fly(way, way);
        filter.hear(loss + NOISE.sqrt() * noise.next());
    }
    let [own, peer] = filter.slopes();
    assert!(length.abs() < 2.0);
    assert!((own + peer - truth).abs() < 0.3 * truth, "{own} and {peer} dB/m");
    assert!((own - peer).abs() < 0.25 * truth, "{own} and {peer} dB/m");
}

/// A link that obeys the filter's own model: the normalised innovations squared have mean 1, and
/// their share of outliers is that of a normal distribution.
#[test]
fn the_errors_are_as_large_as_the_filter_says() {
    let modelled = SlopeFilter {
        prior: Slope::Constant(DbPerMetre(8.0)),
        prior_doubt: 0.2,
        bending: 0.1,
        ..config()
    };
    let (mut sum, mut count, mut outliers) = (0.0, 0u32, 0u32);
    for seed in 1..=100 {
        let mut noise = Noise::new(seed);
        let correlated = |noise: &mut Noise, deviation: f32| {
            let (one, other) = (noise.next(), noise.next());
            // Correlated by ½, as the prior and the bending of the two slopes.
            [deviation * one, deviation * (0.5 * one + 0.75f32.sqrt() * other)]
        };
        let mut slopes = correlated(&mut noise, 0.2 * 8.0).map(|off| 8.0 + off);
        let mut loss = 60.0;
        let mut filter = Filter::of(modelled, loss + NOISE.sqrt() * noise.next());
        let mut motion = Motion::new();
        for _ in 0..200 {
            let [p, q] = motion.round(&mut noise);
            let way = p.abs() + q.abs();
            let change = slopes[0] * p + slopes[1] * q;
            let wandered = modelled.still_variance * DT
                + modelled.way_variance * way
                + (modelled.motion_doubt * change).powi(2);
            loss += change + wandered.sqrt() * noise.next();
            let bent = correlated(&mut noise, modelled.bending * 8.0 * way.sqrt());
            slopes = [slopes[0] + bent[0], slopes[1] + bent[1]];
            filter.fly(p, q);
            let packet = loss + NOISE.sqrt() * noise.next();
            let squared = (packet - filter.loss()).powi(2) / filter.expected();
            sum += f64::from(squared);
            count += 1;
            outliers += u32::from(squared > OUTLIER * OUTLIER);
            filter.hear(packet);
        }
    }
    let mean = sum / f64::from(count);
    let share = f64::from(outliers) / f64::from(count);
    assert!((0.9..1.1).contains(&mean), "{mean}");
    assert!(share < 0.01, "{share}");
}

/// The same at rest, for the constants that fly and any noise that they allow.
#[test]
fn the_errors_at_rest_are_as_large_as_the_filter_says() {
    for noise_variance in [2.5, 5.0, 10.0, 20.0f32] {
        let (mut sum, mut count) = (0.0, 0u32);
        for seed in 1..=20 {
            let mut noise = Noise::new(seed);
            let mut filter = Filter::of(config(), 60.0);
            for round in 0..900 {
                filter.fly(0.0, 0.0);
                let packet = 60.0 + noise_variance.sqrt() * noise.next();
                if round >= 300 {
                    sum += f64::from((packet - filter.loss()).powi(2) / filter.expected());
                    count += 1;
                }
                filter.hear(packet);
            }
        }
        let mean = sum / f64::from(count);
        assert!((0.85..1.15).contains(&mean), "{mean} with {noise_variance} dB²");
    }
}

/// R comes from the packets of a hovering pair, whatever it was before.
#[test]
fn the_noise_of_a_hovering_pair_is_learned() {
    for truth in [2.5, 5.0, 10.0, 20.0f32] {
        for seed in 1..=10 {
            let mut noise = Noise::new(seed);
            let mut filter = Filter::of(config(), 60.0);
            let (mut learned, rounds) = (0.0, 1_500);
            for round in 0..rounds {
                filter.fly(0.0, 0.0);
                filter.hear(60.0 + truth.sqrt() * noise.next());
                if round >= 500 {
                    learned += filter.noise() / (rounds - 500) as f32;
                }
            }
            assert!((learned / truth - 1.0).abs() < 0.3, "{learned} for {truth} dB², seed {seed}");
        }
    }
    // It stays between its limits, and the errors of moving ends do not count to it.
    let [least, most] = config().noise;
    let mut filter = Filter::of(config(), 60.0);
    filter.rest(3_000, 60.0);
    assert!((filter.noise() - least).abs() < 1e-3, "{}", filter.noise());
    let mut noise = Noise::new(1);
    for _ in 0..3_000 {
        filter.fly(0.0, 0.0);
        filter.hear(60.0 + 2.0 * most.sqrt() * noise.next());
    }
    assert!(filter.noise() <= most * 1.001, "{}", filter.noise());
    let mut filter = Filter::of(config(), 60.0);
    filter.rest(300, 60.0);
    let before = filter.noise();
    for round in 0..300 {
        let way = if round % 2 == 0 { 0.06 } else { -0.06 };
        filter.fly(way, way);
        filter.hear(60.0 + 4.0 * noise.next());
    }
    assert!((filter.noise() - before).abs() < 0.3, "{} after {before}", filter.noise());
}

/// The loss of a link that wanders by this variance a second, and packets that scatter by that one,
/// at rest: the root mean square of the filter's error, and the mean square of the packets' in the
/// variances that it expects.
fn errors_of_a_wandering_link(wandering: f32, scatter: f32) -> (f32, f32) {
    let (mut squares, mut scaled, mut count) = (0.0, 0.0, 0.0);
    for seed in 1..=10 {
        let mut noise = Noise::new(seed);
        let mut truth = 60.0;
        let mut filter = Filter::of(config(), truth);
        for round in 0..1_500 {
            truth += (wandering * DT).sqrt() * noise.next();
            let packet = truth + scatter.sqrt() * noise.next();
            filter.fly(0.0, 0.0);
            if round >= 300 {
                scaled += (packet - filter.loss()).powi(2) / filter.expected();
                count += 1.0;
            }
            filter.hear(packet);
            if round >= 300 {
                squares += (truth - filter.loss()).powi(2);
            }
        }
    }
    ((squares / count).sqrt(), scaled / count)
}

/// A real link fades while nothing moves: 3 dB² a second beside a scatter of 18 dB² describe the
/// recorded BLE links best (the book, "Replay"), where our simulator has none and 3 dB². The filter
/// finds out which of them it hears.
#[test]
fn how_much_a_link_wanders_is_learned() {
    for (wandering, scatter) in [(3.0f32, 18.0f32), (1.0, 5.0), (10.0, 10.0)] {
        let (error, scaled) = errors_of_a_wandering_link(wandering, scatter);
        // The variance of the best filter of these two, in the steady state.
        let q = wandering * DT;
        let before = 0.5 * (q + (q * q + 4.0 * q * scatter).sqrt());
        let best = (before * scatter / (before + scatter)).sqrt();
        assert!(error < 1.2 * best, "{error} dB of {best} with {wandering} and {scatter}");
        assert!((0.8..1.3).contains(&scaled), "{scaled} with {wandering} and {scatter}");
    }
    // A link that does not wander is followed no further than its noise is averaged.
    let (error, scaled) = errors_of_a_wandering_link(0.0, 3.0);
    assert!(error < 0.4, "{error} dB");
    assert!((0.9..1.2).contains(&scaled), "{scaled}");
}

/// A packet counts for no more than one that is three standard deviations off, however far it is:
/// it moves the loss by 3·P/√S at most, and the slopes by as much as any other outlier.
#[test]
fn an_outlier_moves_the_estimate_by_no_more_than_hubers_bound() {
    for (seed, moving) in [(1, false), (2, true), (3, true)] {
        let mut noise = Noise::new(seed);
        let (mut motion, mut loss) = (Motion::new(), 60.0);
        let mut filter = Filter::of(config(), loss);
        for round in 0..400 {
            let [p, q] = if moving { motion.round(&mut noise) } else { [0.0; 2] };
            loss += 6.0 * p + 6.0 * q;
            filter.fly(p, q);
            if round % 20 == 19 {
                let before = filter;
                let deviation = before.expected().sqrt();
                let bound = OUTLIER * before.state().variance / deviation;
                let mut slopes = Vec::new();
                for off in [3.1 * deviation, 30.0, 60.0, 120.0] {
                    for side in [-1.0, 1.0] {
                        let mut hit = before;
                        hit.hear(before.loss() + side * off);
                        let moved = hit.loss() - before.loss();
                        // While R is learned, it grows a little with the outlier itself.
                        assert!(
                            moved * side >= 0.0 && moved.abs() <= bound * 1.05,
                            "{moved} dB of {bound} dB for {off} dB"
                        );
                        slopes.push(hit.slopes().map(|slope| side * slope));
                        assert_eq!(hit.state().step, before.state().step, "one is no step");
                    }
                }
                for (one, other) in slopes.iter().skip(2).zip(&slopes) {
                    for (one, other) in one.iter().zip(other) {
                        assert!((one - other).abs() < 0.02, "{slopes:?}");
                    }
                }
                filter.hear(loss + 60.0 * if round % 40 == 19 { 1.0 } else { -1.0 });
            } else {
                filter.hear(loss + NOISE.sqrt() * noise.next());
            }
        }
        assert!((filter.loss() - loss).abs() < 4.0, "{} of {loss}", filter.loss());
    }
}

/// Hovers for so many rounds of packets about this loss.
fn hover(filter: &mut Filter, noise: &mut Noise, rounds: usize, loss: f32) {
    for _ in 0..rounds {
        filter.fly(0.0, 0.0);
        filter.hear(loss + 1.5 * noise.next());
    }
}

/// A drone that hovers believes in a door that falls shut after a second, and in its opening too.
#[test]
fn a_step_at_rest_is_recognised() {
    for height in [15.0, 20.0, 30.0] {
        for seed in 1..=20 {
            let mut noise = Noise::new(seed);
            let mut filter = Filter::of(config(), 60.0);
            hover(&mut filter, &mut noise, 200, 60.0);
            assert_eq!(filter.state().step, None);
            hover(&mut filter, &mut noise, 10, 60.0 + height);
            assert!((filter.loss() - 60.0 - height).abs() < 3.0, "{} dB", filter.loss());
            let step = filter.state().step.expect("a step");
            assert!(step.is_beyond, "{step:?}");
            assert!(step.room.0.abs() < 1e-3, "{step:?}");
            assert!((step.height.0 - height).abs() < 6.0, "{step:?}");
            // R, which has grown meanwhile, is learned again.
            hover(&mut filter, &mut noise, 200, 60.0 + height);
            hover(&mut filter, &mut noise, 10, 60.0);
            assert!((filter.loss() - 60.0).abs() < 3.0, "{} dB", filter.loss());
            assert!(!filter.state().step.expect("it is remembered").is_beyond);
        }
    }
}

/// A step of five standard deviations is no noise.
#[test]
fn a_small_step_at_rest_is_followed_within_two_seconds() {
    for seed in 1..=10 {
        let mut noise = Noise::new(seed);
        let mut filter = Filter::of(config(), 60.0);
        hover(&mut filter, &mut noise, 200, 60.0);
        hover(&mut filter, &mut noise, 10, 68.0);
        let noise = filter.noise();
        assert!((filter.loss() - 68.0).abs() < 3.0, "{} dB, R {noise}, seed {seed}", filter.loss());
    }
}

/// A pair that flies round a corner knows afterwards at which length its link steps.
#[test]
fn a_step_in_flight_is_recognised_and_remembered() {
    for seed in 1..=10 {
        let mut noise = Noise::new(seed);
        let (corner, height) = (1.0, 20.0);
        let law = |length: f32| 60.0 + 3.0 * length + if length > corner { height } else { 0.0 };
        let mut filter = Filter::of(config(), law(0.0));
        let mut length = 0.0;
        let mut fly = |filter: &mut Filter, way: f32, rounds: usize| {
            for _ in 0..rounds {
                length += way;
                filter.fly(0.0, way);
                filter.hear(law(length) + 1.5 * noise.next());
            }
            length
        };
        fly(&mut filter, 0.0, 50);
        let length = fly(&mut filter, 0.04, 32);
        assert!((filter.loss() - law(length)).abs() < 3.0, "{} of {}", filter.loss(), law(length));
        let step = filter.state().step.expect("a step of 20 dB");
        assert!(step.is_beyond);
        assert!((step.height.0 - height).abs() < 8.0, "{step:?}");
        let at = length + step.room.0;
        assert!((at - corner).abs() < 0.15, "at {at} m with seed {seed}");
        // Back on the good side the room is positive.
        let length = fly(&mut filter, -0.04, 15);
        let step = filter.state().step.expect("it is not forgotten");
        assert!(!step.is_beyond, "{step:?}");
        assert!((length + step.room.0 - corner).abs() < 0.3, "{step:?} at {length} m");
        // And once the whole pair is elsewhere, so is the corner.
        let smoothing = filter.smoothing();
        let on = Separation { own: Metres(-2.0), peer: Metres(2.0) };
        filter.link.separate(&smoothing, on);
        assert_eq!(filter.state().step, None);
    }
}

/// The events of a link in one round.
#[derive(Clone, Copy, Debug)]
struct Round {
    own: f32,
    peer: f32,
    packet: Option<f32>,
}

fn rounds() -> impl Strategy<Value = Vec<Round>> {
    let way = || prop_oneof![3 => -0.1f32..0.1, 1 => Just(0.0), 1 => -2.0f32..2.0];
    let packet = prop::option::weighted(0.8, 30.0f32..100.0);
    let round = (way(), way(), packet).prop_map(|(own, peer, packet)| Round { own, peer, packet });
    prop::collection::vec(round, 1..300)
}

/// A number of any bits, and often one that is none.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => any::<u32>().prop_map(f32::from_bits),
        1 => prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1e38]),
    ]
}

/// The least value of the quadratic form of the covariance with (1, p, q), relative to its terms.
/// The form is what a separation by p and q leaves as variance, less what the constants add.
fn least_form(filter: &Filter) -> f32 {
    let config = &filter.config;
    let [a, b] = filter.slopes();
    let mut least = f32::INFINITY;
    let ways = [-3.0, -1.0, -0.3, -0.1, 0.0, 0.1, 0.3, 1.0, 3.0f32];
    for p in ways {
        for q in ways {
            let mut moved = *filter;
            let by = Separation { own: Metres(p), peer: Metres(q) };
            moved.link.separate(&filter.smoothing(), by);
            let added = (config.motion_doubt * (a * p + b * q)).powi(2)
                + config.way_variance * (p.abs() + q.abs());
            let total = moved.state().variance;
            let form = total - added;
            least = least.min(form / (total.abs() + added + filter.state().variance + 1.0));
        }
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default()
    })]

    /// The covariance is positive semidefinite: no separation makes a variance negative.
    #[test]
    fn the_covariance_stays_positive_semidefinite(rounds in rounds()) {
        let mut filter = Filter::of(config(), 60.0);
        for (n, round) in rounds.iter().enumerate() {
            filter.fly(round.own, round.peer);
            if let Some(packet) = round.packet {
                filter.hear(packet);
            }
            prop_assert!(filter.state().variance >= 0.0);
            if n % 10 == 9 || n + 1 == rounds.len() {
                let least = least_form(&filter);
                prop_assert!(least > -1e-4, "{least} after {n} rounds");
            }
        }
    }

    /// The slopes stay positive and within their limits, so a policy can divide by them.
    #[test]
    fn the_slopes_stay_within_their_limits(rounds in rounds(), first in -50.0f32..200.0) {
        let mut filter = Filter::of(config(), first);
        for round in &rounds {
            filter.fly(round.own, round.peer);
            if let Some(packet) = round.packet {
                filter.hear(packet);
            }
            prop_assert!(filter.slopes().iter().all(|slope| (0.4..=60.0).contains(slope)));
        }
    }

    /// Numbers that are none are as if they had not been.
    #[test]
    fn bad_numbers_change_nothing(
        rounds in rounds(),
        bad in prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ) {
        let (mut link, mut disturbed) =
            (Filter::of(config(), 60.0), Filter::of(config(), 60.0));
        for round in &rounds {
            let smoothing = disturbed.smoothing();
            disturbed.hear(bad);
            let by = Separation { own: Metres(bad), peer: Metres(0.1) };
            disturbed.link.separate(&smoothing, by);
            let by = Separation { own: Metres(0.1), peer: Metres(bad) };
            disturbed.link.separate(&smoothing, by);
            disturbed.link.predict(&smoothing, MetresPerSecond(bad), ROUND);
            for filter in [&mut link, &mut disturbed] {
                filter.fly(round.own, round.peer);
                if let Some(packet) = round.packet {
                    filter.hear(packet);
                }
            }
            prop_assert_eq!(link.link, disturbed.link);
        }
    }

    /// Packets far beyond any radio's, and separations as far as a drone flies in a round at
    /// 100 m/s, leave numbers.
    #[test]
    fn absurd_packets_leave_numbers(
        rounds in prop::collection::vec((-20.0f32..20.0, -20.0f32..20.0, -1e4f32..1e4), 1..60),
    ) {
        finite_after(rounds)?;
    }

    /// Packets of any bits leave numbers.
    #[test]
    fn packets_of_any_bits_leave_numbers(
        rounds in prop::collection::vec((-20.0f32..20.0, -20.0f32..20.0, any_number()), 1..60),
    ) {
        finite_after(rounds)?;
    }

    /// Separations of any bits leave numbers.
    #[test]
    fn separations_of_any_bits_leave_numbers(
        rounds in prop::collection::vec((any_number(), any_number(), -100.0f32..200.0), 1..60),
    ) {
        finite_after(rounds)?;
    }
}

fn finite_after(rounds: Vec<(f32, f32, f32)>) -> Result<(), TestCaseError> {
    let mut filter = Filter::of(config(), 60.0);
    for (own, peer, packet) in rounds {
        filter.fly(own, peer);
        filter.hear(packet);
        let state = filter.state();
        let numbers = [state.loss.0, state.variance, filter.slopes()[0], filter.slopes()[1]];
        prop_assert!(numbers.iter().all(|number| number.is_finite()), "{state:?}");
        prop_assert!(
            state.step.is_none_or(|step| step.room.0.is_finite() && step.height.0.is_finite())
        );
    }
    // And it listens still.
    filter.rest(300, 60.0);
    prop_assert!((filter.loss() - 60.0).abs() < 1.0, "{} dB", filter.loss());
    Ok(())
}

/// Half a round twice is a round once.
#[test]
fn the_prediction_does_not_depend_on_the_rate() {
    let coast = |parts: u32| {
        let mut filter = Filter::of(config(), 60.0);
        let smoothing = filter.smoothing();
        for _ in 0..parts {
            let way = Metres(1.0 / parts as f32);
            filter.link.separate(&smoothing, Separation { own: way, peer: Metres::ZERO });
        }
        filter.loss()
    };
    for parts in [2, 10, 100] {
        assert!((coast(parts) - coast(1)).abs() < 1e-3, "{} and {}", coast(parts), coast(1));
    }
}
