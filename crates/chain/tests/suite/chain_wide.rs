//! The chain-wide policy by its claims: with exact sums one flight makes all links equal, a
//! relay's two sides tell it the same, a loss that all links share means nothing, and chains of
//! any length become equal about as fast as their relays can fly.

use chain::chain_wide::{ChainWide, ChainWideState, HeadNews, Side};
use chain::filter::LinkState;
use chain::policy::{PolicyConfig, SpeedLaw};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Db, DbPerMetre, Duration, LinkSum, Metres, MetresPerDb, MetresPerSecond};

use crate::noise::Noise;

/// One round of the 5 Hz loop.
const ROUND: Duration = Duration::from_millis(200);
const DT: f32 = 0.2;

/// The policy that flies.
fn config() -> ChainWide {
    match PolicyConfig::CHAIN.law {
        SpeedLaw::ChainWide(config) => config,
        other => panic!("not chain-wide but {other:?}"),
    }
}

/// The same without a zone in which relays hover, at a gain that makes the velocity of the first
/// round the way to the relay's place, in m/s for m.
fn exact() -> ChainWide {
    ChainWide { gain: 1.0, local_gain: 0.0, near: Metres::ZERO, ..config() }
}

/// A link whose loss is known exactly.
fn link(loss: f32, slope: f32) -> LinkState {
    LinkState {
        loss: Db(loss),
        slopes: [DbPerMetre(slope); 2],
        variance: 0.0,
        step: None,
        hump: Db(0.0),
    }
}

/// A head that flies at so many m/s and is not held.
const fn flies_at(speed: f32) -> HeadNews {
    HeadNews { velocity: MetresPerSecond(speed), calls: false }
}

/// The state of a drone that knows this level over the reference.
fn at_level(level: Option<f32>) -> ChainWideState {
    let mut state = ChainWideState::new();
    let known = level.map(|level| LinkSum {
        surplus: Metres(level),
        compliance: MetresPerDb(1.0),
        links: 1,
    });
    state.listen([known.unwrap_or(LinkSum::NONE), LinkSum::NONE]);
    state
}

/// The sums over these links, for links that were equal at this level over the reference.
fn sum(config: &ChainWide, links: &[LinkState], level: Option<f32>) -> LinkSum {
    let state = at_level(level);
    links.iter().fold(LinkSum::NONE, |beyond, &link| state.sum(config, &Side { link, beyond }))
}

/// The level that the sums over all links agree on, after as many rounds as a mission has.
fn level(config: &ChainWide, links: &[LinkState]) -> f32 {
    let mut level = None;
    for _ in 0..50 {
        level = sum(config, links, level).level().map(|level| level.0);
    }
    level.unwrap()
}

/// The velocity of each relay of a chain whose sums are exact, positive towards the head.
fn velocities(config: &ChainWide, links: &[LinkState], head: f32) -> Vec<f32> {
    let level = Some(level(config, links));
    (1..links.len())
        .map(|at| {
            let side = |link, beyond| Side { link, beyond: sum(config, beyond, level) };
            let front = side(links[at - 1], &links[..at - 1]);
            let back = side(links[at], &links[at + 1..]);
            at_level(level).step(config, ROUND, [&front, &back], flies_at(head)).0
        })
        .collect()
}

/// Links with losses of 50 to 75 dB and slopes of 0.5 to 20 dB/m.
fn links() -> impl Strategy<Value = Vec<LinkState>> {
    let one = (50.0f32..75.0, 0.5f32..20.0).prop_map(|(loss, slope)| link(loss, slope));
    prop::collection::vec(one, 2..15)
}

/// Over so many decibels a link of the log-distance law with the exponent 2.5, which the policy
/// assumes, becomes longer by a factor of e.
const FOLD: f32 = 25.0 / std::f32::consts::LN_10;

/// The losses of the links after their nodes, the head first, have moved by these metres.
fn moved(links: &[LinkState], head: f32, ways: &[f32]) -> Vec<f32> {
    let way = |node: usize| match node.checked_sub(1) {
        None => head,
        Some(relay) => ways.get(relay).copied().unwrap_or(0.0),
    };
    let loss = |(at, link): (usize, &LinkState)| {
        let length = FOLD / link.slopes[0].0;
        let longer = length + way(at) - way(at + 1);
        link.loss.0 + FOLD * (longer / length).ln()
    };
    links.iter().enumerate().map(loss).collect()
}

fn spread(losses: &[f32]) -> f32 {
    let most = losses.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    most - losses.iter().copied().fold(f32::INFINITY, f32::min)
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default()
    })]

    /// Each relay knows its own place: once all of them are there, all links are equal.
    #[test]
    fn exact_sums_lead_to_equal_losses(links in links()) {
        let ways = velocities(&exact(), &links, 0.0);
        let losses = moved(&links, 0.0, &ways);
        prop_assert!(spread(&losses) < 0.02, "{losses:?}");
    }

    /// In a chain whose links are equal every relay hovers.
    #[test]
    fn equal_links_move_no_relay(
        loss in 45.0f32..85.0, slopes in prop::collection::vec(0.5f32..20.0, 2..15),
    ) {
        let links: Vec<_> = slopes.iter().map(|slope| link(loss, *slope)).collect();
        for velocity in velocities(&config(), &links, 0.0) {
            prop_assert!(velocity.abs() < 2e-3, "{velocity} m/s");
        }
    }

    /// What the links towards the head tell a relay is what those towards the base tell it: the
    /// chain seen from its other end gives the opposite velocities.
    #[test]
    fn both_sides_wish_the_same(links in links(), flying in any::<bool>()) {
        let config = if flying { config() } else { exact() };
        let mirrored: Vec<_> = links.iter().rev().copied().collect();
        let here = velocities(&config, &links, 0.0);
        let there = velocities(&config, &mirrored, 0.0);
        for (here, there) in here.iter().zip(there.iter().rev()) {
            prop_assert!((here + there).abs() < 1e-3 + 1e-3 * here.abs(), "{here} and {there}");
        }
    }

    /// A loss that all links share moves nothing.
    #[test]
    fn a_loss_of_all_links_changes_nothing(links in links(), shift in -30.0f32..30.0) {
        let shifted: Vec<_> =
            links.iter().map(|one| LinkState { loss: one.loss + Db(shift), ..*one }).collect();
        for config in [config(), exact()] {
            let here = velocities(&config, &links, 0.1);
            let there = velocities(&config, &shifted, 0.1);
            for (here, there) in here.iter().zip(&there) {
                prop_assert!((here - there).abs() < 2e-3 + 1e-3 * here.abs(), "{here} and {there}");
            }
        }
    }

    /// Relays of an equal chain share the head's velocity by the compliances behind them, so the
    /// links stay equal while the head flies.
    #[test]
    fn links_stay_equal_behind_a_head_that_flies(
        loss in 45.0f32..85.0,
        slopes in prop::collection::vec(0.5f32..20.0, 2..15),
        head in -0.4f32..0.4,
    ) {
        let links: Vec<_> = slopes.iter().map(|slope| link(loss, *slope)).collect();
        let velocities = velocities(&config(), &links, head);
        // A way of a centimetre is one over which the slopes hardly change.
        let part = 0.01;
        let ways: Vec<f32> = velocities.iter().map(|velocity| part * velocity).collect();
        let losses = moved(&links, part * head, &ways);
        prop_assert!(spread(&losses) < 0.01, "{losses:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default()
    })]

    /// A neighbour's sums are a claim: whatever bits they have, the relay knows its way again with
    /// the next sums that make sense.
    #[test]
    fn a_relay_survives_sums_of_any_bits(
        links in links(),
        claims in prop::collection::vec((any::<u32>(), any::<u32>(), any::<u8>(), any::<u32>(), any::<bool>()), 1..20),
    ) {
        let config = config();
        let level = Some(level(&config, &links));
        let front = Side { link: links[0], beyond: LinkSum::NONE };
        let back = Side { link: links[1], beyond: sum(&config, &links[2..], level) };
        let mut state = at_level(level);
        for (surplus, compliance, links, head, calls) in claims {
            let beyond = LinkSum {
                surplus: Metres(f32::from_bits(surplus)),
                compliance: MetresPerDb(f32::from_bits(compliance)),
                links,
            };
            let head = HeadNews { calls, ..flies_at(f32::from_bits(head)) };
            state.step(&config, ROUND, [&front, &Side { beyond, ..back }], head);
        }
        let still = flies_at(0.0);
        let velocity = state.step(&config, ROUND, [&front, &back], still).0;
        let expected = at_level(level).step(&config, ROUND, [&front, &back], still).0;
        // It may be more cautious than before.
        prop_assert!(velocity.is_finite() && velocity * expected >= 0.0, "{velocity}");
        prop_assert!(velocity.abs() <= expected.abs() * 1.001 + 1e-6, "{velocity} of {expected}");
    }
}

/// The nodes of the longest chain that the tests fly, and the lag of its drones.
const LONGEST: usize = 15;
const LAG: f32 = 0.3;

/// A drone on a line.
#[derive(Clone)]
struct Drone {
    /// Distance from the base.
    place: f32,
    velocity: f32,
    policy: ChainWideState,
    /// The sums of its last report.
    sums: [LinkSum; 2],
}

/// A chain on a line without any radio: link losses are known to the drones, reports are one round
/// old, and a drone follows its commands with a lag.
struct Chain {
    /// From the head to the base.
    drones: Vec<Drone>,
    /// What each link loses besides its distance, dB.
    walls: Vec<f32>,
}

impl Chain {
    /// A chain of `nodes` with 6 m to a link; the relays stand as far from their even places as a
    /// chain that has flown out allows.
    fn new(nodes: usize, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let length = 6.0 * (nodes - 1) as f32;
        let mut places: Vec<f32> =
            (2..nodes).map(|_| length * (0.05 + 0.9 * noise.uniform())).collect();
        places.extend([0.0, length]);
        places.sort_by(|a, b| b.total_cmp(a));
        // No two drones are nearer than a metre.
        for at in 1..nodes {
            places[at] = places[at].min(places[at - 1] - 1.0);
        }
        places[nodes - 1] = 0.0;
        for at in (1..nodes - 1).rev() {
            places[at] = places[at].max(places[at + 1] + 1.0);
        }
        let drones = places.into_iter().map(|place| Drone {
            place,
            velocity: 0.0,
            policy: ChainWideState::new(),
            sums: [LinkSum::NONE; 2],
        });
        let walls = (1..nodes).map(|_| 3.0 * noise.next()).collect();
        Self { drones: drones.collect(), walls }
    }

    /// The link towards the base of drone `at`.
    fn link(&self, at: usize) -> LinkState {
        let distance = (self.drones[at].place - self.drones[at + 1].place).max(0.3);
        let slope = 30.0 / (std::f32::consts::LN_10 * distance);
        let loss = 40.0 + 30.0 * distance.log10() + self.walls[at];
        LinkState { variance: 0.05, ..link(loss, slope) }
    }

    fn losses(&self) -> Vec<f32> {
        (0..self.walls.len()).map(|at| self.link(at).loss.0).collect()
    }

    /// A round of 0.2 s with the head at `head` m/s.
    fn round(&mut self, config: &ChainWide, head: f32) {
        let before = self.drones.clone();
        let last = before.len() - 1;
        let kept = (-DT / LAG).exp();
        let mut commands = vec![0.0; before.len()];
        commands[0] = head;
        for at in 0..=last {
            let front =
                (at > 0).then(|| Side { link: self.link(at - 1), beyond: before[at - 1].sums[0] });
            let back =
                (at < last).then(|| Side { link: self.link(at), beyond: before[at + 1].sums[1] });
            let mut policy = before[at].policy;
            let sums = |policy: &ChainWideState| {
                [front, back]
                    .map(|side| side.map_or(LinkSum::NONE, |side| policy.sum(config, &side)))
            };
            policy.listen(sums(&policy));
            if let (Some(front), Some(back)) = (front, back) {
                let known = |is_end: bool, side: &Side| is_end || side.beyond.links > 0;
                if known(at == 1, &front) && known(at + 1 == last, &back) {
                    let speed = policy.step(config, ROUND, [&front, &back], flies_at(head));
                    commands[at] = speed.limited_to(PolicyConfig::CHAIN.max_speed).0;
                }
            }
            self.drones[at].policy = policy;
            self.drones[at].sums = sums(&policy);
        }
        for (drone, command) in self.drones.iter_mut().zip(commands) {
            let away = drone.velocity - command;
            drone.place += command * DT + away * (1.0 - kept) * LAG;
            drone.velocity = command + away * kept;
        }
    }

    /// The time that the relay with the longest way to its place needs at full speed, s: no policy
    /// makes the links equal earlier.
    fn bound(&self, config: &ChainWide) -> f32 {
        let places = |chain: &Self| chain.drones.iter().map(|d| d.place).collect::<Vec<_>>();
        let mut there = Self { drones: self.drones.clone(), walls: self.walls.clone() };
        for _ in 0..1_000 {
            there.round(config, 0.0);
        }
        let ways = places(self).into_iter().zip(places(&there)).map(|(a, b)| (a - b).abs());
        ways.fold(0.0, f32::max) / PolicyConfig::CHAIN.max_speed.0
    }
}

/// Chains of 4 to 15 nodes with random places and walls: all links come within 1 dB of each other
/// soon after the relay with the longest way could be there, and stay so.
#[test]
fn a_chain_becomes_equal_about_as_fast_as_its_relays_can_fly() {
    let config = config();
    for nodes in 4..=LONGEST {
        for seed in 1..=5 {
            let mut chain = Chain::new(nodes, seed);
            let bound = chain.bound(&config);
            let mut equal_since = None;
            for round in 0..1_500 {
                chain.round(&config, 0.0);
                if spread(&chain.losses()) <= 1.0 {
                    equal_since.get_or_insert(round);
                } else {
                    equal_since = None;
                }
            }
            let since = equal_since.map(|round| round as f32 * DT);
            assert!(
                since.is_some_and(|since| since < bound + 4.0),
                "{nodes} nodes, seed {seed}: equal since {since:?} s, could be since {bound} s"
            );
        }
    }
}

/// Behind a head that flies on, the links stay equal.
#[test]
fn a_chain_stays_equal_behind_its_head() {
    let config = config();
    for nodes in [4, 8, LONGEST] {
        let mut chain = Chain::new(nodes, 1);
        for _ in 0..3_000 {
            chain.round(&config, 0.0);
        }
        for head in [0.2, -0.2, 0.0] {
            for round in 0..100 {
                chain.round(&config, head);
                let losses = chain.losses();
                assert!(spread(&losses) < 1.0, "{losses:?} in round {round} at {head} m/s");
            }
        }
    }
}
