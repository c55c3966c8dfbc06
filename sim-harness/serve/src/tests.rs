//! The served chain through real sockets of the loopback and through none, with a world that does
//! nothing but keep time and record the calls.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::atomic::AtomicBool;
use std::thread;

use airlink::{Identity, Schedule, Scope, Seal};
use crtp::{ParameterId, Snapshot};
use onboard::{Config, Drone, Keys, Setup};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{MetresPerSecond, MissionKind, NodeId, Role};
use wire::p2p::{Epoch, TAG};
use wire::radio::Datarate;

use super::clients::Clients;
use super::*;
use measure::metrics::Reference;
use report::Folder;
use scenario::Scenario;

/// Drones that hear nothing but their clients.
struct Clockwork {
    now: Instant,
    drones: Vec<Drone<Clear>>,
    orders: Vec<(u64, Order)>,
}

/// Sealing that does not seal.
struct Clear;

impl Seal for Clear {
    fn seal(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8]) -> [u8; TAG] {
        [0; TAG]
    }

    fn open(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8], _: &[u8; TAG]) -> bool {
        true
    }
}

impl Clockwork {
    fn new(members: usize) -> Self {
        let drone = |n| {
            let role = if n + 1 == members { Role::Base } else { Role::Relay };
            let node = NodeId(n as u8);
            let mut drone = Drone::new(Config::DEFAULT, &Setup::new(node, role));
            let schedule = Schedule::new(Datarate::Mbit2, node).unwrap();
            let (seal, epoch) = (Clear, Epoch::FIRST);
            let keys = Keys::Held { seal, epoch, schedule, may_fly: true };
            drone.open_link(Instant::ZERO, keys);
            drone
        };
        Self { now: Instant::ZERO, drones: (0..members).map(drone).collect(), orders: Vec::new() }
    }

    fn note(&mut self) {
        let Some(order) = self.ordered() else { return };
        if self.orders.last().is_none_or(|(_, last)| *last != order) {
            self.orders.push((self.now.as_micros() / 1_000, order));
        }
    }
}

impl World for Clockwork {
    fn now(&self) -> Instant {
        self.now
    }

    fn advance(&mut self) {
        self.now = self.now + STEP;
        self.drones.iter_mut().for_each(|drone| drone.attend(self.now));
        self.note();
    }

    fn nodes(&self) -> Vec<Node> {
        let node = |Identity { node, role }| Node { id: node, role, mission: MissionKind::Chain };
        self.drones.iter().map(|drone| node(drone.identity())).collect()
    }

    fn state(&self, member: usize) -> Option<State> {
        Some(self.drones.get(member)?.state())
    }

    fn client(&mut self, member: usize, packet: &[u8]) {
        self.drones[member].client(self.now, packet);
        self.note();
    }

    fn most_clients(&self, _: usize) -> usize {
        clients::MOST
    }

    fn poll_client(&mut self, member: usize, take: &mut dyn FnMut(&[u8])) {
        let drone = &mut self.drones[member];
        let snapshot = drone.snapshot(self.now, &Snapshot::DEFAULT);
        while let Some(packet) = drone.poll_client(self.now, &snapshot) {
            take(packet.bytes());
        }
    }

    fn ordered(&self) -> Option<Order> {
        self.drones.last()?.operator().order()
    }
}

/// The two bits that are always set on the air are set.
const ECHO: [u8; 3] = [0xFC, 1, 2];
const LOG_RESET: [u8; 2] = [0x51, 5];
/// Block 7 with the first variable, a float, and its start at 100 Hz.
const LOG_CREATE: [u8; 6] = [0x51, 6, 7, 7, 0, 0];
const LOG_START: [u8; 4] = [0x51, 3, 7, 1];
const STOP: [u8; 2] = [0x70, 0];
const E_STOP: [u8; 2] = [0x91, 3];

fn hover(forward: f32) -> Vec<u8> {
    let mut packet = vec![0x70, 10];
    for value in [forward, 0.0, 0.0, 0.4] {
        packet.extend(value.to_le_bytes());
    }
    packet
}

fn set(id: ParameterId, value: &[u8]) -> Vec<u8> {
    [&[0x22], &id.row().to_le_bytes()[..], value].concat()
}

fn client(port: u16) -> SocketAddr {
    SocketAddrV4::new(Ipv4Addr::LOCALHOST, port).into()
}

/// Whether a packet is of another service than the console.
fn is_answer(packet: &[u8]) -> bool {
    packet.first().is_some_and(|header| header >> 4 != 0)
}

/// Drives a chain without sockets: what is said, at whose port, at which step. The console is left
/// out of what the drones send.
fn said<W: World>(
    world: W,
    steps: u64,
    said: &[(u64, usize, Vec<u8>)],
) -> (W, Vec<(usize, Vec<u8>)>) {
    let mut chain = Chain::new(world);
    let mut sent = Vec::new();
    let mut out = |member, _, packet: &[u8]| {
        if is_answer(packet) {
            sent.push((member, packet.to_vec()));
        }
    };
    for step in 0..steps {
        for (_, member, packet) in said.iter().filter(|(at, ..)| *at == step) {
            chain.receive(*member, client(1), packet, &mut out);
        }
        chain.step(&mut out);
    }
    (chain.into_world(), sent)
}

fn orders(steps: u64, packets: &[(u64, usize, Vec<u8>)]) -> Vec<(u64, Order)> {
    said(Clockwork::new(5), steps, packets).0.orders
}

/// The base of five drones.
const BASE: usize = 4;

const fn explore(speed: f32) -> Order {
    Order::explore(MetresPerSecond(speed))
}

#[test]
fn the_base_alone_takes_orders() {
    let packets = |member| [(10, member, hover(0.25)), (30, member, STOP.to_vec())];
    assert_eq!(orders(100, &packets(BASE)), [(100, explore(0.25)), (300, Order::Land)]);
    for member in 0..BASE {
        assert_eq!(orders(100, &packets(member)), []);
    }
}

/// A client at another drone than the base stops that drone alone.
#[test]
fn every_drone_takes_an_emergency_stop() {
    for member in 0..BASE {
        let (world, sent) = said(Clockwork::new(5), 10, &[(0, member, E_STOP.to_vec())]);
        assert_eq!(sent, [(member, vec![0x9D, 0x83, 1, 0])]);
        let stopped: Vec<_> = world.drones.iter().map(Drone::is_stopped).collect();
        assert!((0..5).all(|n| stopped[n] == (n == member)), "{stopped:?}");
    }
}

#[test]
fn a_set_point_is_a_word_for_half_a_second() {
    let orders = orders(200, &[(0, BASE, hover(0.25)), (100, BASE, hover(-0.25))]);
    let halt = explore(0.0);
    assert_eq!(orders, [(0, explore(0.25)), (510, halt), (1_000, explore(-0.25)), (1_510, halt)]);
}

#[test]
fn parameters_order() {
    let speed = set(ParameterId::SPEED, &0.125_f32.to_le_bytes());
    let faster = set(ParameterId::SPEED, &0.25_f32.to_le_bytes());
    let task = |code| set(ParameterId::TASK, &[code]);
    let read = [&[0x2D], &ParameterId::TASK.row().to_le_bytes()[..]].concat();
    let (world, sent) = said(
        Clockwork::new(5),
        100,
        &[
            (0, BASE, speed),
            (1, BASE, task(1)),
            (2, BASE, faster),
            (3, BASE, task(2)),
            (4, BASE, task(9)),
            (5, BASE, read.clone()),
        ],
    );
    assert_eq!(world.orders, [(10, explore(0.125)), (20, explore(0.25)), (30, Order::Return)]);
    let answer = [&read[..], &[0, 2]].concat();
    assert_eq!(sent.last(), Some(&(BASE, answer)));
}

#[test]
fn an_emergency_stop_is_the_last_order() {
    let orders = orders(100, &[(0, BASE, E_STOP.to_vec()), (1, BASE, hover(0.25))]);
    assert_eq!(orders, [(0, Order::Stop)]);
}

#[test]
fn a_scan_is_answered_and_takes_the_drone_from_nobody() {
    let mut chain = Chain::new(Clockwork::new(2));
    let mut sent = Vec::new();
    let mut out = |member, to, packet: &[u8]| {
        if is_answer(packet) {
            sent.push((member, to, packet.to_vec()));
        }
    };
    chain.receive(1, client(1), &LOG_RESET, &mut out);
    chain.receive(1, client(1), &LOG_CREATE, &mut out);
    chain.receive(1, client(1), &LOG_START, &mut out);
    chain.receive(1, client(2), &[0xFF], &mut out);
    chain.step(&mut out);
    chain.receive(1, client(2), &ECHO, &mut out);
    chain.step(&mut out);
    let to: Vec<_> = sent.iter().map(|(_, to, _)| to.port()).collect();
    assert_eq!(to, [1, 1, 1, 2, 1, 2, 1]);
    assert_eq!(sent[3], (1, client(2), vec![0xFF]));
    assert_eq!(sent[5].2, ECHO);
}

/// What the base sends to each of two clients that speak in this order, a step after each packet.
/// The console is left out.
fn to_two(packets: &[(u16, &[u8])], steps: usize) -> [Vec<Vec<u8>>; 2] {
    let mut chain = Chain::new(Clockwork::new(2));
    let mut sent = [Vec::new(), Vec::new()];
    let mut out = |_, to: SocketAddr, packet: &[u8]| {
        if is_answer(packet) {
            sent[usize::from(to.port()) - 1].push(packet.to_vec());
        }
    };
    for (from, packet) in packets {
        chain.receive(1, client(*from), packet, &mut out);
        chain.step(&mut out);
    }
    (0..steps).for_each(|_| chain.step(&mut out));
    sent
}

/// The rows of log blocks of this number.
fn rows(sent: &[Vec<u8>], block: u8) -> usize {
    sent.iter().filter(|packet| packet[0] & 0xF3 == 0x52 && packet[1] == block).count()
}

/// Both begin by resetting the log, and give their blocks the same numbers.
#[test]
fn each_of_two_clients_gets_its_own_log_rows_and_answers() {
    let three = [&LOG_RESET[..], &LOG_CREATE, &LOG_START];
    let packets: Vec<_> =
        [1, 2].into_iter().flat_map(|n| three.map(|packet| (n, packet))).collect();
    let [first, second] = to_two(&packets, 50);
    assert_eq!([rows(&first, 7), rows(&second, 7)], [54, 51]);
    for sent in [&first, &second] {
        let answers: Vec<_> = sent.iter().filter(|packet| packet[0] & 0xF3 == 0x51).collect();
        assert_eq!(answers, [&[0x5D, 5, 0, 0], &[0x5D, 6, 7, 0], &[0x5D, 3, 7, 0]]);
        assert_eq!(sent.len(), 3 + rows(sent, 7), "nothing of the other's");
    }
}

#[test]
fn a_client_cannot_stop_or_delete_the_log_blocks_of_another() {
    let stop = [0x51, 4, 7];
    let delete = [0x51, 2, 7];
    let [first, second] = to_two(
        &[(1, &LOG_CREATE), (1, &LOG_START), (2, &stop), (2, &delete), (2, &LOG_RESET), (2, &stop)],
        20,
    );
    assert_eq!(rows(&first, 7), 25);
    let missing = |command| vec![0x5D, command, 7, 2];
    assert_eq!(second, [missing(4), missing(2), vec![0x5D, 5, 0, 0], missing(4)]);
}

#[test]
fn the_log_blocks_of_a_client_that_is_gone_are_deleted_when_the_next_one_comes() {
    let mut chain = Chain::new(Clockwork::new(2));
    let mut to = Vec::new();
    let mut out = |_, client: SocketAddr, packet: &[u8]| {
        if is_answer(packet) {
            to.push(client.port());
        }
    };
    chain.receive(1, client(1), &LOG_CREATE, &mut out);
    chain.receive(1, client(1), &LOG_START, &mut out);
    chain.gone(1, client(1), &mut out);
    chain.step(&mut out);
    chain.receive(1, client(2), &ECHO, &mut out);
    chain.step(&mut out);
    assert_eq!(to, [1, 1, 1, 2]);
}

/// It holds however many blocks the clients ask for, and in whichever order they come and go.
#[test]
fn a_client_that_fills_the_log_keeps_no_other_from_resetting_and_logging() {
    let creates: Vec<_> = (0..=u8::MAX).map(|block| [0x51, 6, block, 7, 0, 0]).collect();
    let mut packets: Vec<(u16, &[u8])> = creates.iter().map(|packet| (1, &packet[..])).collect();
    packets.extend([(2, &LOG_RESET[..]), (2, &LOG_CREATE), (1, &LOG_RESET)]);
    packets.extend([(2, &LOG_CREATE[..]), (2, &LOG_START)]);
    let [first, second] = to_two(&packets, 20);
    let errors: Vec<_> = first.iter().map(|packet| packet[3]).collect();
    assert_eq!(errors.iter().filter(|error| **error == 0).count(), 16 + 1);
    assert_eq!(
        second[..4],
        [vec![0x5D, 5, 0, 0], vec![0x5D, 6, 7, 12], vec![0x5D, 6, 7, 0], vec![0x5D, 3, 7, 0]]
    );
    assert_eq!(rows(&second, 7), 21);
}

#[test]
fn a_positioning_system_at_a_port_is_no_client() {
    let position = [&[0x6C][..], &[0; 12]].concat();
    let mut chain = Chain::new(Clockwork::new(2));
    let mut out = |_, _, _: &[u8]| {};
    assert_eq!(chain.receive(1, client(1), &ECHO, &mut out), Taken::Client);
    assert_eq!(chain.receive(1, client(2), &position, &mut out), Taken::NoClient);
}

/// A drone that is polled serves the newest client; the older one can stop it.
#[test]
fn a_displaced_client_is_not_served_until_the_newer_one_is_gone_but_stops() {
    let mut clients = Clients::new(1);
    let first = |is_first| Taken::Displaced { is_first };
    let mut taken = |from, packet: &[u8]| clients.admit(client(from), packet).0;
    assert_eq!(taken(1, &ECHO), Taken::Client);
    assert_eq!(taken(2, &ECHO), Taken::Client);
    assert_eq!([taken(1, &ECHO), taken(1, &ECHO)], [first(true), first(false)]);
    assert!(Clients::is_open_to_all(&E_STOP) && !Clients::is_open_to_all(&hover(0.1)));
    clients.gone(client(2));
    assert_eq!(clients.admit(client(1), &ECHO).0, Taken::Client);
}

#[test]
fn what_is_no_packet_or_at_no_drone_does_nothing() {
    let (world, sent) = said(
        Clockwork::new(1),
        10,
        &[(0, 7, ECHO.to_vec()), (0, 0, Vec::new()), (0, 0, vec![0; 64])],
    );
    assert!(sent.is_empty() && world.orders.is_empty());
}

/// A mission at point level, half a minute of it flown by hover set-points.
fn flight(seed: u64) -> Vec<(usize, Vec<u8>)> {
    let scenario = Scenario::open("demo").unwrap();
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let live = Live::new(&scenario, &world, &reference, seed, false);
    let mut packets: Vec<_> = [LOG_RESET.to_vec(), LOG_CREATE.to_vec(), LOG_START.to_vec()]
        .into_iter()
        .map(|packet| (0, 0, packet))
        .collect();
    // uchain.backRaw at the head: what is random in it.
    let variable = crtp::variables()
        .position(|variable| (variable.group, variable.name) == ("uchain", "backRaw"))
        .unwrap();
    packets[1].2[4..].copy_from_slice(&(variable as u16).to_le_bytes());
    packets.extend((0..300).map(|n| (10 * n, BASE, hover(0.3))));
    said(live, 3_000, &packets).1
}

/// Every frame goes to the disk while the mission is flown; memory keeps no more than a report shows.
#[test]
fn the_frames_of_a_served_mission_are_written_as_they_are_flown() {
    let scenario = Scenario::open("demo").unwrap();
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let scratch = tempfile::tempdir().unwrap();
    let out = scratch.path().join("out");
    let live = Live::new(&scenario, &world, &reference, 1, false);
    let mut live = live.with_files(Folder::open(&out).unwrap()).unwrap();
    let seconds = 200;
    for _ in 0..100 * seconds {
        live.advance();
    }
    let (mut folder, files) = live.take_files().unwrap().unwrap();
    files.finish(&mut folder, live.trace(), &serde_json::json!({})).unwrap();
    folder.finish().unwrap();
    let table = std::fs::read_to_string(out.join("trace.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 5 * seconds * live.nodes().len());
    assert!(live.trace().frames.len() <= mission::trace::MOST_FRAMES);
}

#[test]
fn the_same_datagrams_at_the_same_simulated_times_make_the_same_run() {
    let once = flight(1);
    assert_eq!(once.len(), 3 + 3_000);
    assert!(once == flight(1), "the same run differs");
    assert!(once != flight(2), "the seed does nothing");
}

#[test]
fn a_client_gets_every_row_of_its_log_at_whatever_speed() {
    for speed in [1.0, 10.0, 1_000.0] {
        let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 3).unwrap();
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        socket.connect(ports.addresses()[1]).unwrap();
        let stop = AtomicBool::new(false);
        let rows = thread::scope(|scope| {
            let stop = &stop;
            let served = scope.spawn(move || {
                serve(Clockwork::new(3), ports, speed, None, stop, |_, _| {});
            });
            for packet in [&LOG_RESET[..], &LOG_CREATE, &LOG_START] {
                socket.send(packet).unwrap();
            }
            let mut rows = Vec::new();
            let mut packet = [0; 31];
            while rows.len() < 60 {
                let length = socket.recv(&mut packet).unwrap();
                if let [header, 7, a, b, c, ..] = packet[..length]
                    && header & 0xF3 == 0x52
                {
                    rows.push(u32::from_le_bytes([a, b, c, 0]));
                }
            }
            stop.store(true, std::sync::atomic::Ordering::Relaxed);
            served.join().unwrap();
            rows
        });
        assert!(rows.windows(2).all(|pair| pair[1] - pair[0] == 10), "{rows:?}");
    }
}

#[test]
fn a_client_that_never_pauses_does_not_stop_time() {
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1).unwrap();
    let to = ports.addresses()[0];
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            while !stop.load(Ordering::Relaxed) {
                let _ = socket.send_to(&ECHO, to);
            }
        });
        let minute = Some(Duration::from_secs(60));
        let (world, _) = serve(Clockwork::new(1), ports, 1e6, minute, &stop, |_, _| {});
        stop.store(true, Ordering::Relaxed);
        assert_eq!(world.now(), Instant::from_millis(60_000));
    });
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 256,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Time goes on and no call panics, with any bytes from any sender.
    #[test]
    fn any_datagrams_at_any_ports_are_survived(
        packets in prop::collection::vec(
            (0_u64..50, 0_usize..4, prop::collection::vec(any::<u8>(), 0..40)),
            0..60,
        )
    ) {
        let (world, _) = said(Clockwork::new(3), 60, &packets);
        prop_assert_eq!(world.now(), Instant::from_millis(600));
    }
}
