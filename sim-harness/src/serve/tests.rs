//! The served chain through real sockets of the loopback and through none, with a world that does
//! nothing but keep time and answer clients.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::atomic::AtomicBool;
use std::thread;

use crtp::{Access, Outcome, Parameters, Server, Snapshot};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::metrics::Reference;
use crate::scenario::Scenario;

/// A world of drones that do nothing but keep time and answer their clients; their state is "idle".
struct Clockwork {
    now: Instant,
    servers: Vec<Server>,
}

impl Clockwork {
    fn new(members: usize) -> Self {
        Self { now: Instant::ZERO, servers: (0..members).map(|_| Server::new()).collect() }
    }
}

impl World for Clockwork {
    fn now(&self) -> Instant {
        self.now
    }

    fn advance(&mut self) {
        self.now = self.now + STEP;
    }

    fn members(&self) -> usize {
        self.servers.len()
    }

    fn state(&self, _member: usize) -> Option<State> {
        Some(State::Idle)
    }

    fn client(&mut self, member: usize, packet: &[u8]) {
        let mut parameters = Parameters::DEFAULT;
        if let Some(server) = self.servers.get_mut(member) {
            server.receive(self.now, packet, Access::Full, &mut parameters, |_, _| Outcome::Done);
        }
    }

    fn poll_client(&mut self, member: usize, take: &mut dyn FnMut(&[u8])) {
        let snapshot = Snapshot { taken: self.now, state: Some(State::Idle), ..Snapshot::DEFAULT };
        let Some(server) = self.servers.get_mut(member) else { return };
        while let Some(packet) = server.poll(self.now, &snapshot, &Parameters::DEFAULT) {
            take(packet.bytes());
        }
    }

    fn ordered(&self) -> Option<Order> {
        None
    }
}

/// With the two bits set that are always set on the air.
const ECHO: [u8; 3] = [0xFC, 1, 2];
const LOG_RESET: [u8; 2] = [0x51, 5];
/// Block 7 with the first variable, a float, and its start at 100 Hz.
const LOG_CREATE: [u8; 6] = [0x51, 6, 7, 7, 0, 0];
const LOG_START: [u8; 4] = [0x51, 3, 7, 1];

fn hover(forward: f32) -> Vec<u8> {
    let mut packet = vec![0x70, 10];
    for value in [forward, 0.0, 0.0, 0.4] {
        packet.extend(value.to_le_bytes());
    }
    packet
}

fn client(port: u16) -> SocketAddr {
    SocketAddrV4::new(Ipv4Addr::LOCALHOST, port).into()
}

/// Drives a chain without sockets: what is said, at whose port, at which step.
fn said<W: World>(
    world: W,
    steps: u64,
    said: &[(u64, usize, Vec<u8>)],
) -> (W, Vec<(usize, Vec<u8>)>) {
    let mut chain = Chain::new(world);
    let mut sent = Vec::new();
    let mut out = |member, _, packet: &[u8]| sent.push((member, packet.to_vec()));
    for step in 0..steps {
        for (_, member, packet) in said.iter().filter(|(at, ..)| *at == step) {
            chain.receive(*member, client(1), packet, &mut out);
        }
        chain.step(&mut out);
    }
    (chain.into_world(), sent)
}

#[test]
fn a_scan_is_answered_and_takes_the_drone_from_nobody() {
    let mut chain = Chain::new(Clockwork::new(2));
    let mut sent = Vec::new();
    let mut out = |member, to, packet: &[u8]| sent.push((member, to, packet.to_vec()));
    chain.receive(1, client(1), &LOG_RESET, &mut out);
    chain.receive(1, client(1), &LOG_CREATE, &mut out);
    chain.receive(1, client(1), &LOG_START, &mut out);
    chain.receive(1, client(2), &[0xFF], &mut out);
    chain.step(&mut out);
    chain.receive(1, client(2), &ECHO, &mut out);
    chain.step(&mut out);
    let to: Vec<_> = sent.iter().map(|(_, to, _)| to.port()).collect();
    assert_eq!(to, [1, 1, 1, 2, 1, 2, 2]);
    assert_eq!(sent[3], (1, client(2), vec![0xFF]));
    assert_eq!(sent[5].2, ECHO);
}

#[test]
fn what_is_no_packet_or_at_no_drone_does_nothing() {
    let packets = [(0, 7, ECHO.to_vec()), (0, 0, Vec::new()), (0, 0, vec![0; 64])];
    let (_, sent) = said(Clockwork::new(1), 10, &packets);
    assert!(sent.is_empty());
}

/// A mission at point level, half a minute of it flown by hover set-points.
fn flight(seed: u64) -> Vec<(usize, Vec<u8>)> {
    let scenario = Scenario::open("demo").unwrap();
    let world = crate::mission::World::of(&scenario);
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
    packets.extend((0..300).map(|n| (10 * n, 0, hover(0.3))));
    said(live, 3_000, &packets).1
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

    /// Time goes on whatever datagrams come.
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
