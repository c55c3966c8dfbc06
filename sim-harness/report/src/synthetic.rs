//! A made-up mission for tests: a head and three relays in an S-shaped tunnel, with every kind
//! of thing in it that the outputs have to show. No simulator, just formulas.

use agent::{ChainDuty, Duty, State};
use units::{
    Dbm, Instant, Metres, MetresPerSecond, MissionKind, NodeId, Order, Point2, Pose2, Radians, Role,
};
use world::{CentreLine, FloorPlan, SkeletonPlace};

use mission::trace::{DroneFrame, Frame, LinkFrame, Node, TeamMap, Trace};

const CORNERS: [Point2; 4] =
    [Point2::new(0.0, 0.0), Point2::new(12.0, 0.0), Point2::new(12.0, 9.0), Point2::new(27.0, 9.0)];
const HALF_WIDTH: f32 = 1.1;
const BASE: usize = 4;

/// Five minutes: out, relays following one by one, relay 2 losing touch for a while.
pub(crate) fn mission() -> Trace {
    let mut noise = Noise(7);
    let frames = (0..1500).map(|tick| frame(tick, &mut noise)).collect();
    Trace {
        scenario: "S-bend <script>alert(1)</script> & \"friends\"".to_owned(),
        seed: Some(42),
        mission: MissionKind::Chain,
        floor_plan: floor_plan(),
        nodes: (0..=BASE).map(node).collect(),
        launch_limit: Dbm(-70.0),
        passage: None,
        team_map: TeamMap::default(),
        frames,
    }
}

/// Each kind of mission, with the name that the second drone has in it.
pub(crate) const SECOND_NAMES: [(MissionKind, &str); 3] = [
    (MissionKind::Chain, "relay 1"),
    (MissionKind::Swarm, "drone 1"),
    (MissionKind::Explore, "explorer 1"),
];

/// The same drones under the names that they have in another mission.
pub(crate) fn named_as(kind: MissionKind) -> Trace {
    let mut trace = mission();
    trace.mission = kind;
    trace.nodes.iter_mut().for_each(|node| node.mission = kind);
    trace
}

fn node(index: usize) -> Node {
    let role = match index {
        0 => Role::Head,
        BASE => Role::Base,
        _ => Role::Relay,
    };
    Node { id: NodeId(index as u8), role, mission: MissionKind::Chain }
}

fn floor_plan() -> FloorPlan {
    let w = HALF_WIDTH;
    let outline = [
        [-1.5, -w],
        [12.0 + w, -w],
        [12.0 + w, 9.0 - w],
        [28.0, 9.0 - w],
        [28.0, 9.0 + w],
        [12.0 - w, 9.0 + w],
        [12.0 - w, w],
        [-1.5, w],
    ];
    let pillar = [[19.6, 8.3], [20.2, 8.3], [20.2, 8.8], [19.6, 8.8]];
    let ring = |corners: &[[f32; 2]]| corners.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    let centre_line = CentreLine { name: "main".into(), points: CORNERS.to_vec() };
    FloorPlan { outlines: vec![ring(&outline), ring(&pillar)], centre_lines: vec![centre_line] }
}

/// The point of the centre-line this far along it, and its direction there.
fn along(way: f32) -> (Point2, f32) {
    let mut rest = way;
    for pair in CORNERS.windows(2) {
        let (dx, dy) = (pair[1].x - pair[0].x, pair[1].y - pair[0].y);
        let length = libm::hypotf(dx, dy);
        if rest <= length {
            let t = rest / length;
            return (Point2::new(pair[0].x + dx * t, pair[0].y + dy * t), libm::atan2f(dy, dx));
        }
        rest -= length;
    }
    (CORNERS[3], 0.0)
}

/// The way of each node at this time: the head flies, relays launch and spread evenly.
fn ways(t: f32) -> [f32; BASE + 1] {
    let head = (0.16 * t).min(34.0);
    let mut all = [0.0; BASE + 1];
    all[0] = head;
    for (k, place) in all.iter_mut().enumerate().take(BASE).skip(1) {
        let launch = 60.0 * k as f32;
        let due = head * (BASE - k) as f32 / BASE as f32;
        let wave = 0.15 * libm::sinf(0.4 * t + k as f32);
        *place = if t < launch { 0.0 } else { due.min(0.3 * (t - launch)) + wave.min(due) };
    }
    all
}

fn frame(tick: u64, noise: &mut Noise) -> Frame {
    let t = tick as f32 * 0.2;
    let places = ways(t);
    let flying: Vec<usize> =
        (0..=BASE).filter(|&k| k == 0 || k == BASE || t >= 60.0 * k as f32).collect();
    let drones = (0..=BASE).map(|k| drone(k, t, &places, &flying, noise)).collect();
    let order = if t < 250.0 { Order::explore(MetresPerSecond(0.16)) } else { Order::Return };
    Frame { time_us: tick * 200_000, order, drones, team_links: Vec::new() }
}

fn drone(k: usize, t: f32, places: &[f32], flying: &[usize], noise: &mut Noise) -> DroneFrame {
    let (point, heading) = along(places[k]);
    let up = flying.contains(&k) && k != BASE;
    let slot = flying.iter().position(|&other| other == k);
    let peer = |step: isize| {
        slot.and_then(|s| s.checked_add_signed(step)).and_then(|s| flying.get(s)).copied()
    };
    let mut link = |peer: Option<usize>| peer.map(|peer| link(places, k, peer, noise));
    DroneFrame {
        pose: Pose2 {
            at: Point2::new(point.x, point.y + 0.05 * k as f32),
            yaw: Radians(heading + 0.05 * libm::sinf(t)),
        },
        height: if up { 0.5 } else { 0.0 },
        place: SkeletonPlace::main(places[k]),
        way: places[k],
        commanded: if up { [0.16, 0.02 * libm::sinf(t)] } else { [0.0; 2] },
        yaw_rate: 0.0,
        ranges: if up { [1.5, 1.6, f32::INFINITY, 1.4] } else { [f32::NAN; 4] },
        state: state(k, t, up),
        goal: None,
        target: None,
        battery_v: if k == BASE { f32::NAN } else { 4.1 - 0.002 * t },
        front: if k == 0 || (k == 2 && lost(t)) { None } else { link(peer(-1)) },
        back: if k == BASE { None } else { link(peer(1)) },
    }
}

fn lost(t: f32) -> bool {
    (200.0..212.0).contains(&t)
}

fn state(k: usize, t: f32, up: bool) -> State {
    let on_duty = |duty| State::OnMission(Duty::Chain(duty));
    let now = Instant::from_millis((t * 1000.0) as u64);
    match k {
        BASE => State::Idle,
        0 => on_duty(ChainDuty::Leading { patient_until: Instant::from_millis(2_000) }),
        _ if !up => State::Armed { since: Instant::ZERO },
        _ if t < 60.0 * k as f32 + 3.0 => State::TakingOff { since: now },
        2 if lost(t) => on_duty(ChainDuty::Reconnecting { since: now, from: Metres(4.0) }),
        _ => on_duty(ChainDuty::Relaying { patient_until: Instant::from_millis(2_000) }),
    }
}

fn link(places: &[f32], k: usize, peer: usize, noise: &mut Noise) -> LinkFrame {
    let distance = (places[k] - places[peer]).abs().max(0.5);
    let truth = -48.0 - 2.1 * distance;
    LinkFrame {
        peer: NodeId(peer as u8),
        raw: Dbm(libm::roundf(truth + 2.5 * noise.next())),
        filtered: Dbm(truth + 0.5 * noise.next()),
        truth: Dbm(truth),
    }
}

/// Roughly normal, of unit deviation: what a picture needs, not what statistics do.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        let sum: f32 = (0..4)
            .map(|_| {
                self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
            })
            .sum();
        sum * 0.87
    }
}
