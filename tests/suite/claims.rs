//! The paper's claims about equal links, each put to the test where it can fail: that eq. (11)
//! makes links equal, that equal is best, that the relative velocity is a difference, that the
//! literal gain oscillates and the flashed one does not, that the order of the chain is kept, that
//! no drone touches a wall, and that decibels lost over the first metre mean nothing.
//!
//! Claims that hold for any signal are properties over random ones. Claims about whole missions
//! fly the built-in scenarios.

use std::path::Path;
use world::World;

use chain::filter::{Kalman, LinkFilter, Slope, Smoothing};
use chain::policy::{LinkEnd, PolicyConfig, SlopeOf, SpeedLaw};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use random::{Purpose, Stream};
use rayon::prelude::*;
use sim_harness::mission::Mission;
use sim_harness::scenario::{Scenario, builtin};
use units::{Db, DbPerMetre, Dbm, Duration, MetresPerSecond, MissionKind};
use world::{Optimum, Path as Way, SkeletonPlace, best_chain};

const ROUND: Duration = Duration::from_millis(200);

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        max_shrink_iters: 200,
        ..Default::default()
    }
}

// ---- Equation (11) on any continuous, strictly monotone signal ------------------------------

/// A loss that grows strictly and continuously with either end moving away from the other: a law
/// of distance, and rock of a density of its own in every metre of the tunnel.
#[derive(Clone, Debug)]
struct Law {
    /// dB per decade of (distance + 1 m).
    decade: f32,
    /// dB/m in each metre, positive.
    density: Vec<f32>,
    /// What is lost over no distance at all.
    first: f32,
}

impl Law {
    /// Integral of the density from the base to `x`.
    fn rock(&self, x: f32) -> f32 {
        let whole = (x as usize).min(self.density.len() - 1);
        let before: f32 = self.density[..whole].iter().sum();
        before + self.density[whole] * (x - whole as f32)
    }

    fn loss(&self, a: f32, b: f32) -> f32 {
        let (near, far) = (a.min(b), a.max(b));
        self.first + self.decade * (1.0 + far - near).log10() + self.rock(far) - self.rock(near)
    }

    /// No link grows faster than this, in dB/m.
    fn steepest(&self) -> f32 {
        let rock = self.density.iter().copied().fold(0.0, f32::max);
        self.decade / core::f32::consts::LN_10 + rock
    }

    /// The worst link of the best chain, by bisection: a loss is enough if as many hops of it
    /// reach from the base to the head, each as far as it carries.
    fn best_worst(&self, links: usize, head: f32) -> f32 {
        let farthest = |from: f32, loss: f32| bisect(from, head, |x| self.loss(from, x) <= loss);
        let reaches = |loss: f32| {
            let end = (0..links).fold(0.0, |at, _| farthest(at, loss));
            end >= head - 1e-3
        };
        let most = self.loss(0.0, head);
        most - bisect(0.0, most - self.first, |spare| reaches(most - spare))
    }
}

/// The largest number of `low..=high` for which `holds`, which holds up to somewhere.
fn bisect(low: f32, high: f32, holds: impl Fn(f32) -> bool) -> f32 {
    if holds(high) {
        return high;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// A law, the head's place, and relays anywhere between, nearest to the base first.
fn chains() -> impl Strategy<Value = (Law, f32, Vec<f32>)> {
    let law = (5.0f32..40.0, prop::collection::vec(0.3f32..4.0, 16), 0.0f32..60.0)
        .prop_map(|(decade, density, first)| Law { decade, density, first });
    (law, 4.0f32..16.0, prop::collection::vec(0.02f32..0.98, 1..6)).prop_map(
        |(law, head, mut parts)| {
            parts.sort_by(f32::total_cmp);
            parts.dedup_by(|a, b| (*a - *b).abs() < 0.01);
            let relays = parts.into_iter().map(|part| part * head).collect();
            (law, head, relays)
        },
    )
}

/// Equation (11) with a gain that is small for every slope up to `steepest`.
fn careful(steepest: f32) -> PolicyConfig {
    PolicyConfig {
        law: SpeedLaw::Proportional {
            gain: 1.5,
            slope: Slope::Constant(DbPerMetre(steepest)),
            of: SlopeOf::WeakerLink,
            follow: 0.0,
        },
        ..PolicyConfig::T0
    }
}

/// The losses of all links, from the base's to the head's.
fn losses(places: &[f32], loss: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    places.windows(2).map(|pair| loss(pair[0], pair[1])).collect()
}

fn spread(losses: &[f32]) -> f32 {
    let most = losses.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    most - losses.iter().copied().fold(f32::INFINITY, f32::min)
}

fn worst(losses: &[f32]) -> f32 {
    losses.iter().copied().fold(f32::NEG_INFINITY, f32::max)
}

/// All relays move at once, once per round, by what the policy says of the true losses; until all
/// links are equal to `enough`, or the rounds are up. Calls `watch` after each round.
fn iterate(
    policy: &PolicyConfig,
    places: &mut [f32],
    loss: impl Fn(f32, f32) -> f32,
    enough: f32,
    mut watch: impl FnMut(&[f32]),
) -> Vec<f32> {
    for _ in 0..30_000 {
        let now = losses(places, &loss);
        if spread(&now) <= enough {
            return now;
        }
        let end = |loss: f32| LinkEnd::still(Dbm(-loss));
        for (relay, pair) in now.windows(2).enumerate() {
            let velocity = policy.velocity(end(pair[1]), end(pair[0]));
            places[relay + 1] += (velocity * ROUND).0;
        }
        watch(places);
    }
    losses(places, &loss)
}

proptest! {
    #![proptest_config(cases(64))]

    /// Section III-B: with a continuous signal that falls strictly with distance the iteration
    /// converges to equal links from anywhere, no relay ever passes another, and the weakest link
    /// then is that of the best chain there is.
    #[test]
    fn equation_11_converges_to_equal_links_and_equal_is_best((law, head, relays) in chains()) {
        let mut places = vec![0.0];
        places.extend(&relays);
        places.push(head);
        let mut in_order = true;
        let equal = iterate(
            &careful(law.steepest()), &mut places, |a, b| law.loss(a, b), 0.05,
            |now| in_order &= now.windows(2).all(|pair| pair[0] <= pair[1]),
        );
        prop_assert!(spread(&equal) <= 0.05, "{} dB apart at {places:?}", spread(&equal));
        prop_assert!(in_order, "two relays changed places");
        let best = law.best_worst(relays.len() + 1, head);
        prop_assert!(worst(&equal) <= best + 0.06, "{} dB, best {best}", worst(&equal));
        prop_assert!(worst(&equal) >= best - 0.01, "{} dB beats {best}", worst(&equal));
    }

    /// The weakest link never gets weaker on the way there: what a mission has, it keeps.
    #[test]
    fn the_weakest_link_never_gets_weaker((law, head, relays) in chains()) {
        let mut places = vec![0.0];
        places.extend(&relays);
        places.push(head);
        let mut last = worst(&losses(&places, |a, b| law.loss(a, b)));
        let mut fell = 0.0_f32;
        iterate(&careful(law.steepest()), &mut places, |a, b| law.loss(a, b), 0.1, |now| {
            let is = worst(&losses(now, |a, b| law.loss(a, b)));
            fell = fell.max(is - last);
            last = is;
        });
        prop_assert!(fell < 1e-3, "weaker by {fell} dB in one round");
    }
}

/// The best chain to a head this far along the main gallery.
fn best(world: &World, links: usize, head: f32) -> Optimum {
    best_chain(&world.radio, &way_to(world, head), links)
}

/// The way to a place this far along the main gallery.
fn way_to(world: &World, head: f32) -> Way {
    world.path_to(SkeletonPlace::main(head))
}

/// The loss between two places of the main gallery.
fn loss(world: &World, a: f32, b: f32) -> f32 {
    world.radio.strength(SkeletonPlace::main(a), SkeletonPlace::main(b)).loss().0
}

/// The same in the simulator's own radio, with the exact solution that its metrics use: straight,
/// where it is known by hand, and round corners.
#[test]
fn equal_links_are_the_exact_optimum_in_the_simulators_radio() {
    let scenario = Scenario::open("straight").unwrap();
    let world = scenario.world();
    for links in 1..=5_u8 {
        let best = best(&world, links.into(), 20.0);
        let hop = 20.0 / f32::from(links);
        assert!((best.worst.0 - (40.0 + 20.0 * hop.log10())).abs() < 0.02, "{best:?}");
        for (n, place) in best.positions.iter().enumerate() {
            assert!((place - hop * n as f32).abs() < 0.05, "{best:?}");
        }
    }
    for name in ["s-turns-5", "zigzag-5", "winding-5"] {
        let scenario = Scenario::open(name).unwrap();
        let world = scenario.world();
        let head = if name == "zigzag-5" { 30.0 } else { 23.0 };
        let best = best(&world, 5, head);
        let start = |n: u8| head * f32::from(n) / 5.0;
        let mut places: Vec<_> = (0..=5).map(start).collect();
        let loss = |a, b| loss(&world, a, b);
        // Behind a corner a link grows by tens of decibels per metre.
        let equal = iterate(&careful(60.0), &mut places, loss, 0.2, |_| ());
        assert!(spread(&equal) <= 0.2, "{name}: {equal:?}");
        let gap = worst(&equal) - best.worst.0;
        assert!((-0.05..0.25).contains(&gap), "{name}: {gap} dB from {best:?}");
    }
}

/// The best chain is best: no chain of random places has a stronger weakest link, with a radio
/// that jumps at every corner as well.
#[test]
fn no_random_chain_beats_the_best_chain() {
    let mut random = Stream::new(1, Purpose::Start);
    for name in ["zigzag-5", "zigzag-5-step", "winding-5-step"] {
        let world = Scenario::open(name).unwrap().world();
        let loss = |a, b| loss(&world, a, b);
        let best = best(&world, 4, 20.0);
        assert_eq!(best.worst.0, worst(&losses(&best.positions, loss)));
        for _ in 0..2_000 {
            let mut places = vec![0.0, 20.0];
            places.extend((0..3).map(|_| 20.0 * random.uniform()));
            places.sort_by(f32::total_cmp);
            let found = worst(&losses(&places, loss));
            // The optimum is exact to its grid.
            assert!(found > best.worst.0 - 0.05, "{name}: {found} dB at {places:?}, {best:?}");
        }
    }
}

// ---- The sign of the relative velocity ------------------------------------------------------

/// The motion of the two ends that the filter is given.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    /// v₁ − v₂, the rate at which they separate.
    Difference,
    /// v₁ + v₂, as Algorithm 1 prints it.
    Sum,
    /// v₂ − v₁.
    WrongSign,
    /// Nothing.
    Nothing,
}

const ALL_TOLD: [Told; 4] = [Told::Difference, Told::Sum, Told::WrongSign, Told::Nothing];

impl Told {
    /// The rate of separation that the filter is given for a link between these ends.
    fn of(self, front: f32, back: f32) -> MetresPerSecond {
        MetresPerSecond(match self {
            Self::Difference => front - back,
            Self::Sum => front + back,
            Self::WrongSign => back - front,
            Self::Nothing => 0.0,
        })
    }
}

/// Root mean square error in dB of the filter over ten minutes in which two drones wander in a
/// straight gallery, each on its own, with the paper's noise and loss.
fn filter_error(smoothing: &Smoothing, told: Told, seed: u64) -> f32 {
    let mut motion = Stream::new(seed, Purpose::Drone(0));
    let mut packets = Stream::new(seed, Purpose::Link(0, 1));
    let law = |distance: f32| 40.0 + 30.0 * distance.log10();
    let (mut front, mut back) = (5.0_f32, 0.0_f32);
    let (mut v_front, mut v_back) = (0.0_f32, 0.0_f32);
    let mut link = LinkFilter::new();
    let (mut sum, mut count) = (0.0, 0);
    for round in 0..3_000 {
        // Every two seconds another speed, towards where there is room.
        if round % 10 == 0 {
            v_front = 0.3 * motion.normal() - 0.1 * (front - 5.0);
            v_back = 0.3 * motion.normal() - 0.1 * back;
            (v_front, v_back) = (v_front.clamp(-0.4, 0.4), v_back.clamp(-0.4, 0.4));
        }
        front += v_front * 0.2;
        back += v_back * 0.2;
        if front - back < 1.5 {
            let middle = 0.5 * (front + back);
            (front, back) = (middle + 0.75, middle - 0.75);
        }
        let loss = law(front - back);
        link.predict(smoothing, told.of(v_front, v_back), ROUND);
        let noise = 3.0_f32.sqrt() * packets.normal();
        if packets.uniform() >= 0.2 {
            link.update(smoothing, Dbm((-loss + noise).round()));
        }
        if let Some(rssi) = link.rssi().filter(|_| round > 50) {
            sum += (rssi.0 + loss).powi(2);
            count += 1;
        }
    }
    (sum / count as f32).sqrt()
}

/// The paper prints the sum of two velocities. It must be their difference: with the sum the
/// filter is worse than one that is given no motion, with the sign reversed worse still.
#[test]
fn the_relative_velocity_is_a_difference() {
    let slope = Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) };
    // The paper's K, and one that trusts its motion more.
    let sharper =
        Kalman { slope, process_variance: 0.05, motion_doubt: 0.0, measurement_variance: 3.0 };
    for smoothing in [PolicyConfig::K.smoothing, Smoothing::Kalman(sharper)] {
        for seed in 1..=4 {
            let [difference, sum, wrong, nothing] =
                ALL_TOLD.map(|told| filter_error(&smoothing, told, seed));
            let all = format!("{difference} {sum} {wrong} {nothing} dB, seed {seed}");
            assert!(difference < 0.8 * nothing, "telling the motion helps: {all}");
            assert!(sum > 1.2 * nothing, "telling the sum is worse than nothing: {all}");
            assert!(wrong > 1.5 * nothing, "telling the opposite is worst: {all}");
            let raw = filter_error(&PolicyConfig::T0.smoothing, Told::Nothing, seed);
            assert!(difference < 0.7 * raw, "and filtering pays at all: {difference} {raw}");
        }
    }
}

/// A whole chain in a straight gallery whose relays filter with the motion that they are given: 5 links,
/// noise, loss, 0.3 s of lag. Root mean square over the last minute of three of the largest
/// difference between adjacent true losses, dB.
fn chain_difference(policy: &PolicyConfig, told: Told, seed: u64) -> f32 {
    const RELAYS: usize = 4;
    let head = 23.0;
    let law = |distance: f32| 40.0 + 30.0 * distance.max(0.3).log10();
    let mut start = Stream::new(seed, Purpose::Start);
    let mut places: Vec<f32> = (0..RELAYS).map(|_| 1.0 + 21.0 * start.uniform()).collect();
    places.push(0.0);
    places.push(head);
    places.sort_by(f32::total_cmp);
    let mut packets: Vec<_> =
        (0..2 * RELAYS as u8).map(|n| Stream::new(seed, Purpose::Link(n, 0))).collect();
    let mut velocities = [0.0_f32; RELAYS + 2];
    // Each relay has a filter of its own for each of its links: towards the base, the head.
    let mut filters = [[LinkFilter::new(); 2]; RELAYS];
    let (mut sum, mut count) = (0.0, 0);
    for round in 0..900 {
        let commands: Vec<_> = (0..RELAYS)
            .map(|relay| {
                let me = relay + 1;
                let mut ends = [LinkEnd::still(Dbm(0.0)); 2];
                for (side, other) in [me - 1, me + 1].into_iter().enumerate() {
                    let filter = &mut filters[relay][side];
                    let (front, back) = (me.max(other), me.min(other));
                    let told = told.of(velocities[front], velocities[back]);
                    filter.predict(&policy.smoothing, told, ROUND);
                    let air = &mut packets[2 * relay + side];
                    let noise = 3.0_f32.sqrt() * air.normal();
                    if air.uniform() >= 0.2 || filter.rssi().is_none() {
                        let loss = law(places[front] - places[back]);
                        filter.update(&policy.smoothing, Dbm((noise - loss).round()));
                    }
                    ends[side] = LinkEnd::still(filter.rssi().unwrap());
                }
                policy.velocity(ends[1], ends[0]).0
            })
            .collect();
        for (relay, wanted) in commands.into_iter().enumerate() {
            // A first-order vehicle over one round of 0.2 s with 0.3 s of lag.
            velocities[relay + 1] +=
                (1.0 - (-0.2_f32 / 0.3).exp()) * (wanted - velocities[relay + 1]);
            let (low, high) = (places[relay] + 0.1, places[relay + 2] - 0.1);
            places[relay + 1] =
                (places[relay + 1] + velocities[relay + 1] * 0.2).max(low).min(high);
        }
        if round >= 600 {
            let now = losses(&places, |a, b| law(b - a));
            let most = now.windows(2).map(|p| (p[0] - p[1]).abs()).fold(0.0, f32::max);
            sum += most * most;
            count += 1;
        }
    }
    (sum / count as f32).sqrt()
}

/// The same in the closed loop, where a wrong prediction moves the drones that it is about.
#[test]
fn a_chain_that_is_told_the_sum_stays_unequal() {
    let policy = PolicyConfig {
        law: SpeedLaw::Proportional {
            gain: 0.4,
            slope: Slope::LogDistance { exponent: 3.0, loss_at_1m: Db(40.0) },
            of: SlopeOf::SteeperLink,
            follow: 0.0,
        },
        ..PolicyConfig::K
    };
    let mean = |told| (1..=6).map(|seed| chain_difference(&policy, told, seed)).sum::<f32>() / 6.0;
    let [difference, sum, wrong, _] = ALL_TOLD.map(mean);
    assert!(difference < 1.5, "{difference} dB with the difference");
    assert!(sum > 1.3 * difference, "{sum} dB with the sum, {difference} with the difference");
    assert!(wrong > 1.5 * difference, "{wrong} dB with the sign wrong, {difference} with it right");
}

// ---- The gain --------------------------------------------------------------------------------

fn scenario(file: &str) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios").join(file);
    Scenario::read(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// How far a relay still flies to and fro over the last 30 s, the busiest of them, in metres: its
/// way less what it got on by, so that slow creeping into place does not count.
fn swing(scenario: &Scenario) -> f32 {
    let world = scenario.world();
    let mut mission = Mission::new(scenario, &world, 1);
    let mut tracks: Vec<Vec<f32>> = vec![Vec::new(); scenario.drones.relays];
    while !mission.is_over() {
        mission.round();
        if mission.time_us() + 30_000_000 > scenario.duration_us {
            for (track, way) in tracks.iter_mut().zip(mission.ways().skip(1)) {
                track.push(way);
            }
        }
    }
    let to_and_fro = |track: &Vec<f32>| {
        let way: f32 = track.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        way - (track[track.len() - 1] - track[0]).abs()
    };
    tracks.iter().map(to_and_fro).fold(0.0, f32::max)
}

/// The same policy for a world whose exponent it knows: the gain is then what it says, where a
/// slope that is assumed too steep would hide half of it.
fn knowing(policy: PolicyConfig, known: f32) -> PolicyConfig {
    let known = Slope::LogDistance { exponent: known, loss_at_1m: Db(40.0) };
    let mut policy = policy;
    if let Smoothing::Kalman(kalman) = &mut policy.smoothing {
        kalman.slope = known;
    }
    if let SpeedLaw::Proportional { slope, .. } = &mut policy.law {
        *slope = known;
    }
    policy
}

/// Without any noise, e/3 in each round of 5 Hz is a gain of 1.67 1/s, and a chain of eight links
/// with real lag and delay swings for ever by it; the flashed policy comes to rest.
#[test]
fn the_literal_gain_is_a_limit_cycle_and_the_default_is_not() {
    let scenario = scenario("limit-cycle.toml");
    let swing_with = |policy| {
        let agent = agent::AgentConfig { policy, ..scenario.agent };
        swing(&Scenario { agent, ..scenario.clone() })
    };
    for (name, literal) in [("t0", PolicyConfig::T0), ("k", PolicyConfig::K)] {
        let swing = swing_with(knowing(literal, 2.0));
        println!("{name}: {swing} m");
        assert!(swing > 1.0, "{name} flies {swing} m to and fro only");
    }
    for default in [PolicyConfig::K_TUNED, knowing(PolicyConfig::K_TUNED, 2.0)] {
        let swing = swing_with(default);
        println!("default: {swing} m");
        assert!(swing < 0.02, "default flies {swing} m to and fro");
    }
}

// ---- Whole missions --------------------------------------------------------------------------

/// Seeds flown of each built-in scenario.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=12;

/// What went wrong on a mission.
#[derive(Debug)]
#[allow(dead_code)] // Read by its Debug form.
struct Wrong {
    scenario: &'static str,
    policy: &'static str,
    seed: u64,
    rounds_out_of_order: u32,
    wall_contacts: u32,
    drone_contacts: u32,
}

/// Whether a scenario is for the suite. Long chains and those that lose drones are for the benchmark
/// `chain`, which counts touches and lost order as well.
fn is_short(scenario: &Scenario) -> bool {
    scenario.drones.flying() <= 5 && scenario.losses.is_empty()
}

/// Flies every built-in scenario that is wanted and short and tells of every mission in which two drones
/// changed places or a drone touched anything.
fn fly_all(
    policies: &[&'static str],
    wanted: impl Fn(&str) -> bool,
    seeds: std::ops::RangeInclusive<u64>,
) -> Vec<Wrong> {
    let names: Vec<_> = builtin::names().filter(|name| wanted(name)).collect();
    let worlds: Vec<_> = names
        .par_iter()
        .map(|name| (*name, Scenario::open(name).unwrap()))
        .filter(|(_, scenario)| is_short(scenario))
        .map(|(name, scenario)| {
            let world = scenario.world();
            (name, scenario, world)
        })
        .collect();
    let missions: Vec<_> = worlds
        .iter()
        .flat_map(|known| policies.iter().map(move |policy| (known, *policy)))
        .flat_map(|(known, policy)| seeds.clone().map(move |seed| (known, policy, seed)))
        .collect();
    missions
        .into_par_iter()
        .filter_map(|((name, scenario, world), policy, seed)| {
            let scenario = scenario.with_policy(policy).unwrap();
            let mut mission = Mission::new(&scenario, world, seed);
            let (mut chain, mut rounds_out_of_order) = (Vec::new(), 0);
            while !mission.is_over() {
                mission.round();
                if scenario.mission != MissionKind::Chain {
                    // A swarm has no order.
                    continue;
                }
                mission.chain(&mut chain);
                // Drones in different branches have no order.
                let lost = chain.windows(2).any(|pair| {
                    let in_line =
                        world.skeleton().in_line(world.base.on, pair[0].place, pair[1].place);
                    in_line && pair[1].way < pair[0].way
                });
                rounds_out_of_order += u32::from(lost);
            }
            let wrong = Wrong {
                scenario: name,
                policy,
                seed,
                rounds_out_of_order,
                wall_contacts: mission.wall_contacts(),
                drone_contacts: mission.drone_contacts(),
            };
            let touched = wrong.wall_contacts + wrong.drone_contacts;
            (rounds_out_of_order + touched > 0).then_some(wrong)
        })
        .collect()
}

/// With the flashed policy, in every built-in scenario: no drone of a chain passes another, and none touches a wall or
/// touches another drone.
#[test]
fn the_default_policy_keeps_the_order_and_off_everything() {
    let wrong = fly_all(&["chain"], |_| true, SEEDS);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The centring keeps any policy off the walls: it does not matter how badly a relay is sent to
/// and fro.
#[test]
fn the_papers_variants_touch_no_wall() {
    let wrong = fly_all(&["t0", "t5", "k", "authors"], |_| true, 1..=3);
    let touched: Vec<_> = wrong.iter().filter(|wrong| wrong.wall_contacts > 0).collect();
    assert!(touched.is_empty(), "{touched:#?}");
}

// ---- The first metre -------------------------------------------------------------------------

/// Radios that lose 7 dB more over the first metre, in a world that knows it and with limits and
/// receivers moved as well: the same mission is flown.
#[test]
fn decibels_of_the_first_metre_change_no_decision() {
    let text = |shift: f32| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios/short.toml");
        let radio = format!(
            "[radio]\nresolution_db = 0.0\nloss_at_1m_db = {}\nsensitivity_dbm = {}\n\n[vehicle]",
            40.0 + shift,
            -85.0 - shift
        );
        std::fs::read_to_string(file)
            .unwrap()
            .replace("[vehicle]", &radio)
            .replace("limit_dbm = -60.0", &format!("limit_dbm = {}", -60.0 - shift))
            .replace("limit_dbm = -80.0", &format!("limit_dbm = {}", -80.0 - shift))
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("claims");
    std::fs::create_dir_all(&folder).unwrap();
    let flown = |shift: f32, policy: &str| {
        let file = folder.join(format!("shifted-{policy}-{shift}.toml"));
        std::fs::write(&file, text(shift)).unwrap();
        let scenario = Scenario::read(&file).unwrap_or_else(|error| panic!("{error}"));
        let scenario = scenario.with_policy(policy).unwrap();
        let world = scenario.world();
        let mut mission = Mission::new(&scenario, &world, 1);
        let mut frames = Vec::new();
        while !mission.is_over() {
            mission.round();
            frames.push(mission.frame());
        }
        frames
    };
    for policy in ["k", "k-tuned"] {
        let (here, there) = (flown(0.0, policy), flown(7.0, policy));
        for (one, other) in here.iter().zip(&there) {
            for (a, b) in one.drones.iter().zip(&other.drones) {
                assert_eq!(a.state.name(), b.state.name(), "{policy} at {} us", one.time_us);
                let off = (a.way - b.way).abs();
                assert!(off < 0.01, "{policy}: {off} m apart at {} us", one.time_us);
            }
        }
        assert!(here.iter().zip(&there).any(|(a, b)| a.drones != b.drones), "nothing was shifted");
    }
}
