//! A relay whose links are equal where they are not best looks for the better place.

use agent::{Agent, AgentConfig, BodyVelocity, Fitness, Inputs, Outputs};
use chain::launch::LaunchConfig;
use chain::neighbours::Heard;
use chain::report::Report;
use units::{Dbm, Duration, Instant, MetresPerSecond, MissionKind, NodeId, Order, Phase, Role};

use super::rig::{flown, gallery};

const HEAD: usize = 0;
const RELAY: usize = 1;
const BASE: usize = 2;
const DT: f32 = 0.2;

/// Head, relay and base on a line, who all hear each other with the strength that `radio` gives
/// for the relay's place.
struct Chain {
    agents: [Agent; 3],
    ways: [f32; 3],
    velocities: [f32; 3],
    reports: [Option<Report>; 3],
    now: Instant,
    /// The strengths of the relay's links to head and base.
    radio: fn(f32) -> [f32; 2],
}

impl Chain {
    fn new(ways: [f32; 3], radio: fn(f32) -> [f32; 2]) -> Self {
        let now = Instant::from_millis(1_000);
        let node = |n: u8, role| Agent::new_linked(NodeId(n), role, MissionKind::Chain, now);
        let agents = [node(0, Role::Head), node(1, Role::Relay), node(2, Role::Base)];
        Self { agents, ways, velocities: [0.0; 3], reports: [None; 3], now, radio }
    }

    fn strength(&self, one: usize, other: usize) -> f32 {
        let [front, back] = (self.radio)(self.ways[RELAY]);
        match (one.min(other), one.max(other)) {
            (HEAD, RELAY) => front,
            (RELAY, BASE) => back,
            _ => -85.0,
        }
    }

    fn round(&mut self, order: Order) -> [Outputs; 3] {
        let config = AgentConfig {
            launch: LaunchConfig { limit: Dbm(-64.0), ..LaunchConfig::WHEN_SETTLED },
            ..AgentConfig::DEFAULT
        }
        .with_limits(None, Some(Dbm(-100.0)));
        self.now = self.now + Duration::from_millis(200);
        let before = self.reports;
        let outputs: Vec<_> = (0..3)
            .map(|me| {
                let heard: Vec<_> = (0..3)
                    .filter(|other| *other != me)
                    .filter_map(|other| {
                        let rssi = Dbm(self.strength(me, other).round());
                        Some(Heard {
                            report: before[other]?,
                            rssi: Some(rssi),
                            reverse: Some(rssi),
                        })
                    })
                    .collect();
                let forward = MetresPerSecond(self.velocities[me]);
                let inputs = Inputs {
                    ranges: gallery(),
                    velocity: Some(BodyVelocity { forward, lateral: MetresPerSecond::ZERO }),
                    heading: None,
                    height: Some(units::Metres(0.3)),
                    heard: &heard,
                    located: None,
                    told: &[],
                    order: Some(order),
                    fitness: Fitness::Fit,
                    endurance: None,
                };
                self.agents[me].step(&config, self.now, &inputs)
            })
            .collect();
        for (n, outputs) in outputs.iter().enumerate() {
            self.reports[n] = Some(outputs.report);
            let wanted = flown(outputs.setpoint).map_or(0.0, |(forward, _)| forward);
            // The lag of the velocity loop, 0.3 s.
            self.velocities[n] += (wanted - self.velocities[n]) * 0.5;
            self.ways[n] += self.velocities[n] * DT;
        }
        [outputs[0], outputs[1], outputs[2]]
    }
}

/// Equal at 8 m, −72 dBm, and 12 dB better beyond a hill at 12 m.
fn hill(relay: f32) -> [f32; 2] {
    let front = -72.0 + 2.5 * (relay - 8.0);
    let back = match relay {
        way if way < 9.5 => -72.0 - 6.0 * (way - 8.0),
        way if way < 11.0 => -81.0 + 14.0 * (way - 9.5),
        way => -60.0 - 2.0 * (way - 11.0),
    };
    [front.min(-50.0), back]
}

const HOLD: Order = Order::explore(MetresPerSecond(0.0));

#[test]
fn a_relay_that_stands_at_the_worse_of_two_places_finds_the_better_one_and_stays() {
    let mut chain = Chain::new([20.0, 8.2, 0.0], hill);
    let mut neighbours_moved = 0.0f32;
    let mut searched = 0;
    for _ in 0..300 {
        let before = chain.ways;
        let [_, relay, _] = chain.round(HOLD);
        if relay.report.phase == Phase::Searching {
            searched += 1;
            neighbours_moved = neighbours_moved.max((chain.ways[HEAD] - before[HEAD]).abs());
        }
    }
    let [front, back] = hill(chain.ways[RELAY]);
    assert!(searched > 0, "it has searched");
    assert!(front.min(back) > -66.0, "at {} m: {front} and {back} dBm", chain.ways[RELAY]);
    assert!(neighbours_moved < 0.01, "the head holds its place");
    let rests = chain.ways[RELAY];
    (0..100).for_each(|_| _ = chain.round(HOLD));
    assert!((chain.ways[RELAY] - rests).abs() < 0.2, "it stays there");
}

#[test]
fn a_relay_that_has_nothing_better_searches_once_and_comes_back() {
    let mut chain = Chain::new([16.0, 8.0, 0.0], |relay| {
        [-72.0 + 4.0 * (relay - 8.0), -72.0 - 4.0 * (relay - 8.0)]
    });
    let (mut begun, mut was) = (0, false);
    for _ in 0..600 {
        let [_, relay, _] = chain.round(HOLD);
        let searches = relay.report.phase == Phase::Searching;
        begun += u32::from(searches && !was);
        was = searches;
    }
    assert_eq!(begun, 1);
    assert!(!was && (chain.ways[RELAY] - 8.0).abs() < 0.3, "at {} m", chain.ways[RELAY]);
}

#[test]
fn an_order_to_return_ends_a_search() {
    let mut chain = Chain::new([20.0, 8.0, 0.0], hill);
    let mut relay = chain.round(HOLD)[RELAY];
    for _ in 0..100 {
        if relay.report.phase == Phase::Searching {
            break;
        }
        relay = chain.round(HOLD)[RELAY];
    }
    assert_eq!(relay.report.phase, Phase::Searching);
    assert_ne!(chain.round(Order::Return)[RELAY].report.phase, Phase::Searching);
}
