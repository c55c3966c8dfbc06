//! Packet storms, bad clocks and numbers of any bits: no panic, and no set-point that is not
//! finite and within its limits. A packet's content is a claim of somebody else's.

use agent::{Agent, AgentConfig, BodyVelocity, Fitness, Inputs, Outputs, State};
use chain::neighbours::Heard;
use chain::policy::PolicyConfig;
use chain::report::Report;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tunnel_nav::{Diagonals, Range};
use units::{
    Branch, Course, Dbm, Instant, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond,
    MissionKind, NodeId, Order, Phase, Radians, Role, Setpoint, Signpost,
};

use super::rig::{EXPLORE, Rig, Scene, gallery, heard};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// Every named policy, with the agent's other defaults.
fn configs() -> impl Strategy<Value = AgentConfig> {
    prop::sample::select(&[
        PolicyConfig::T0,
        PolicyConfig::T5,
        PolicyConfig::K,
        PolicyConfig::AUTHORS,
        PolicyConfig::K_TUNED,
        PolicyConfig::CHAIN,
    ])
    .prop_map(|policy| AgentConfig { policy, ..AgentConfig::DEFAULT })
}

/// Whether a set-point may be flown: finite, and within what the configuration allows.
fn sound(config: &AgentConfig, outputs: &Outputs) -> Result<(), String> {
    let Setpoint::Fly { forward, lateral, yaw_rate, height } = outputs.setpoint else {
        return Ok(());
    };
    let speeds = [config.policy.max_speed, config.retreat.speed, config.flight.return_speed];
    let fastest = speeds.into_iter().fold(0.0, |most: f32, speed| most.max(speed.0));
    // Two beams inside the danger distance push at 45° each.
    let push = config.nav.push_gain * config.nav.danger.0 * core::f32::consts::SQRT_2;
    let fine = forward.0.abs() <= fastest + push + 1e-5
        && lateral.abs() <= config.nav.max_lateral
        && yaw_rate.abs() <= config.nav.max_yaw_rate
        && (0.0..=config.flight.height.0).contains(&height.0)
        && outputs.status.state.is_airborne();
    if fine { Ok(()) } else { Err(format!("{outputs:?}")) }
}

/// A number such as a sensor or a packet could hold: plausible, absurd, or not one.
fn number(plausible: std::ops::Range<f32>) -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => plausible,
        1 => prop::sample::select(&[
            f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -0.0, 1e-40,
        ]),
        1 => any::<f32>(),
    ]
}

fn branch() -> impl Strategy<Value = Option<Branch>> {
    prop::option::of(prop::sample::select(&[Branch::Left, Branch::Right, Branch::Straight]))
}

fn task() -> impl Strategy<Value = Order> {
    prop_oneof![
        1 => Just(Order::Wait),
        6 => (number(-0.5..0.5), branch()).prop_map(|(speed, branch)| {
            Order::Explore(Course { speed: MetresPerSecond(speed), branch })
        }),
        2 => Just(Order::Return),
        1 => Just(Order::Land),
        1 => Just(Order::Perch),
    ]
}

fn order() -> impl Strategy<Value = Option<Order>> {
    prop::option::weighted(0.5, task())
}

fn packet() -> impl Strategy<Value = Heard> {
    let phase = prop::sample::select(&[
        Phase::Waiting,
        Phase::Transit,
        Phase::Linked,
        Phase::Linked,
        Phase::Base,
        Phase::Out,
    ]);
    let sender = prop_oneof![4 => 0u8..5, 1 => any::<u8>()];
    let links = prop::option::of((number(-90.0..-40.0), number(-90.0..-40.0)));
    let sum = (number(-50.0..50.0), number(0.0..10.0), 0u8..=15).prop_map(
        |(surplus, compliance, links)| LinkSum {
            surplus: Metres(surplus),
            compliance: MetresPerDb(compliance),
            links,
        },
    );
    let head = number(-0.5..0.5).prop_map(MetresPerSecond);
    let post = (any::<[u8; 3]>(), number(-10.0..30.0), branch()).prop_map(
        |([revision, index, count], from, branch)| {
            // Mostly lists that come as a whole.
            let (index, count) = (index % 2, count % 4);
            Signpost { revision, index, count, from: Metres(from), branch }
        },
    );
    (
        (sender, any::<u16>(), phase, any::<bool>(), links),
        (prop::array::uniform2(sum), head, prop::option::of(number(-90.0..-30.0))),
        (number(-90.0..-30.0), number(-0.5..0.5), number(-10.0..30.0), prop::option::of(post)),
    )
        .prop_map(|(of_chain, (sums, head_velocity, reverse), own)| {
            let (from, sequence, phase, recall, links) = of_chain;
            let (rssi, velocity, odometer, signpost) = own;
            let report = Report {
                calls: false,
                is_uneven: false,
                from: NodeId(from),
                sequence,
                phase,
                velocity: MetresPerSecond(velocity),
                odometer: Metres(odometer),
                links: links.map(|(weakest, strongest)| LinkSpan {
                    weakest: Dbm(weakest),
                    strongest: Dbm(strongest),
                }),
                sums,
                waiting: 2,
                head_velocity,
                signpost,
                recall,
            };
            Heard { report, rssi: Some(Dbm(rssi)), reverse: reverse.map(Dbm) }
        })
}

/// One round's inputs, owned.
#[derive(Clone, Debug)]
struct Round {
    clock: Clock,
    ranges: [f32; 4],
    velocity: Option<(f32, f32)>,
    heading: Option<f32>,
    height: Option<f32>,
    heard: Vec<Heard>,
    order: Option<Order>,
}

/// What the clock does: mostly 0.2 s, sometimes a pause, sometimes anything at all.
#[derive(Clone, Copy, Debug)]
enum Clock {
    On(u64),
    At(u64),
}

fn round() -> impl Strategy<Value = Round> {
    let clock = prop_oneof![
        8 => Just(Clock::On(200_000)),
        2 => (0u64..20_000_000).prop_map(Clock::On),
        1 => any::<u64>().prop_map(Clock::At),
    ];
    let beam = || number(0.05..2.5);
    (
        (clock, [beam(), beam(), beam(), beam()]),
        prop::option::weighted(0.9, (number(-0.5..0.5), number(-0.5..0.5))),
        prop::option::weighted(0.9, number(-3.0..3.0)),
        prop::option::weighted(0.9, number(0.0..0.4)),
        prop::collection::vec(packet(), 0..6),
        order(),
    )
        .prop_map(|((clock, ranges), velocity, heading, height, heard, order)| Round {
            clock,
            ranges,
            velocity,
            heading,
            height,
            heard,
            order,
        })
}

fn play(agent: &mut Agent, config: &AgentConfig, rounds: &[Round]) -> Result<(), String> {
    let mut now = Instant::ZERO;
    for round in rounds {
        now = match round.clock {
            Clock::On(us) => now + units::Duration::from_micros(us),
            Clock::At(us) => Instant::from_micros(us),
        };
        let [nw, ne, sw, se] = round.ranges.map(|d| Range::measured(Metres(d), Metres(2.0)));
        let inputs = Inputs {
            ranges: Diagonals { nw, ne, sw, se },
            velocity: round.velocity.map(|(forward, lateral)| BodyVelocity {
                forward: MetresPerSecond(forward),
                lateral: MetresPerSecond(lateral),
            }),
            heading: round.heading.map(Radians),
            height: round.height.map(Metres),
            heard: &round.heard,
            located: None,
            told: &[],
            order: round.order,
            fitness: Fitness::Fit,
            endurance: None,
        };
        let outputs = agent.step(config, now, &inputs);
        sound(config, &outputs)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(seeded())]

    /// Any inputs in any order: set-points stay sound. One that takes off comes through all the
    /// states; one that begins in the air is sure to fly.
    #[test]
    fn set_points_are_sound_whatever_comes_in(
        config in configs(),
        linked in any::<bool>(),
        number in 0u8..3,
        rounds in prop::collection::vec(round(), 1..60),
    ) {
        let role = if number == 0 { Role::Head } else { Role::Relay };
        let id = NodeId(number);
        let mut agent =
            if linked { Agent::new_linked(id, role, MissionKind::Chain, Instant::ZERO) } else { Agent::new(id, role, MissionKind::Chain) };
        prop_assert_eq!(play(&mut agent, &config, &rounds), Ok(()));
    }

    /// After any inputs, an order to stop stops, and nothing starts the motors again.
    #[test]
    fn stop_stops_whatever_came_before_and_comes_after(
        config in configs(),
        before in prop::collection::vec(round(), 0..20),
        after in prop::collection::vec(round(), 0..20),
    ) {
        let mut agent = Agent::new_linked(NodeId(1), Role::Relay, MissionKind::Chain, Instant::ZERO);
        let _ = play(&mut agent, &config, &before);
        let stop = Inputs {
            ranges: gallery(),
            velocity: None,
            heading: None,
            height: None,
            heard: &[],
            located: None,
            told: &[],
            order: Some(Order::Stop),
            fitness: Fitness::Fit,
            endurance: None,
        };
        let outputs = agent.step(&config, Instant::ZERO, &stop);
        prop_assert_eq!(outputs.setpoint, Setpoint::Stop);
        let _ = play(&mut agent, &config, &after);
        prop_assert_eq!(agent.state(), State::Stopped);
    }

    /// The same inputs give the same outputs.
    #[test]
    fn a_mind_has_no_moods(
        config in configs(), rounds in prop::collection::vec(round(), 1..20),
    ) {
        let mut one = Agent::new_linked(NodeId(1), Role::Relay, MissionKind::Chain, Instant::ZERO);
        let mut other = one.clone();
        let _ = play(&mut one, &config, &rounds);
        let _ = play(&mut other, &config, &rounds);
        prop_assert_eq!(format!("{one:?}"), format!("{other:?}"));
    }
}

/// A thousand packets in one step, of 256 senders, with old and doubled numbers and the drone's
/// own echo among them: the neighbours that go on speaking are the neighbours afterwards.
#[test]
fn a_packet_storm_passes() {
    let mut rig = Rig::on_duty(Role::Relay);
    let storm: Vec<Heard> = (0..1_000u16)
        .map(|n| {
            let from = (n % 256) as u8;
            heard(from, n.wrapping_mul(7_919), Phase::Linked, -40.0 - f32::from(n % 50))
        })
        .collect();
    let inputs = Inputs {
        ranges: gallery(),
        velocity: None,
        heading: None,
        height: Some(Metres(0.3)),
        heard: &storm,
        located: None,
        told: &[],
        order: Some(EXPLORE),
        fitness: Fitness::Fit,
        endurance: None,
    };
    rig.now = rig.now + units::Duration::from_millis(200);
    let outputs = rig.agent.step(&super::rig::CONFIG, rig.now, &inputs);
    sound(&super::rig::CONFIG, &outputs).unwrap();
    assert_eq!(rig.state().name(), "relaying");
    // The storm over, it takes as long as a loss to be forgotten.
    let air = Scene::quiet().order(EXPLORE).at_height(Some(0.3));
    let outputs = rig.during(3.0, &air);
    let peers = (outputs.status.front.unwrap().peer, outputs.status.back.unwrap().peer);
    assert_eq!(peers, (NodeId(0), NodeId(3)));
}

/// A drone that hears nothing but itself, doubled and delayed, is alone.
#[test]
fn ones_own_echo_is_no_company() {
    let mut rig = Rig::on_duty(Role::Relay);
    let air = Scene::quiet().order(EXPLORE).at_height(Some(0.3));
    let echo = Scene { heard: vec![(2, Phase::Linked, -30.0); 3], ..air };
    let outputs = rig.during(3.0, &echo);
    assert_eq!((outputs.status.front, outputs.status.back), (None, None));
    assert_eq!(rig.state().name(), "backing-up");
}

/// The first packet of a neighbour whose strength is not a number must not reach the motors: the
/// head multiplies its pilot's speed by what that link can spare.
#[test]
fn a_first_packet_without_a_strength_moves_nothing() {
    let mut rig = Rig::new(Role::Head);
    let called = Scene::quiet().without(0).without(3).order(EXPLORE);
    rig.until("taking-off", &called);
    rig.until("leading", &called.clone().at_height(Some(0.3)));
    for rssi in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut rig = rig.clone();
        let scene = called.clone().at_height(Some(0.3)).also(1, Phase::Linked, rssi);
        for _ in 0..3 {
            let outputs = rig.step(&scene);
            sound(&super::rig::CONFIG, &outputs).unwrap();
        }
    }
}

/// A neighbour that claims to fly at 10²⁰ m/s is not believed for ever: once it speaks sense again
/// the link to it is a number again.
#[test]
fn an_absurd_claim_of_a_neighbour_passes() {
    let config = AgentConfig::DEFAULT;
    let mut agent = Agent::new_linked(NodeId::HEAD, Role::Head, MissionKind::Chain, Instant::ZERO);
    let mut last = None;
    for n in 0..50u16 {
        let mut packet = heard(1, n, Phase::Linked, -55.0);
        packet.report.velocity = MetresPerSecond(if n == 3 { 1e20 } else { 0.0 });
        let inputs = Inputs {
            ranges: gallery(),
            velocity: None,
            heading: None,
            height: Some(Metres(0.3)),
            heard: &[packet],
            located: None,
            told: &[],
            order: Some(EXPLORE),
            fitness: Fitness::Fit,
            endurance: None,
        };
        let outputs = agent.step(&config, Instant::from_millis(200 * u64::from(n)), &inputs);
        sound(&config, &outputs).unwrap();
        last = Some(outputs);
    }
    let link = last.unwrap().status.back.unwrap().rssi;
    assert!((link.0 + 55.0).abs() < 1.0, "{link}");
}
