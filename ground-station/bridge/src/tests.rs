use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use proptest::prelude::*;
use units::{Duration, Instant};

use super::*;

/// The radio chip of a drone with a safelink, behind a radio that loses packets and
/// acknowledgements (crazyflie2-nrf-firmware, `src/esb.c`).
struct Scripted {
    safelink: bool,
    up: u8,
    down: u8,
    /// The packet of the drone that is in the acknowledgements now.
    offered: Vec<u8>,
    to_send: VecDeque<Vec<u8>>,
    received: Vec<Vec<u8>>,
    /// For each exchange in turn whether the packet and whether its acknowledgement is lost.
    losses: VecDeque<(bool, bool)>,
    /// After so many exchanges more the dongle is pulled out.
    left: usize,
}

const UP: u8 = 1 << 3;
const DOWN: u8 = 1 << 2;
const EMPTY: [u8; 1] = [0xF3];

impl Scripted {
    fn new(to_send: Vec<Vec<u8>>, losses: Vec<(bool, bool)>) -> Self {
        Self {
            safelink: false,
            up: 0,
            down: 0,
            offered: EMPTY.to_vec(),
            to_send: to_send.into(),
            received: Vec::new(),
            losses: losses.into(),
            left: usize::MAX,
        }
    }

    fn take(&mut self, packet: &[u8]) -> Vec<u8> {
        if packet == [0xFF, 0x05, 0x01] {
            (self.safelink, self.up, self.down) = (true, 0, 0);
            return packet.to_vec();
        }
        assert!(self.safelink, "a packet without a safelink");
        if packet[0] & DOWN != self.down {
            self.down ^= DOWN;
            self.offered = self.to_send.pop_front().unwrap_or_else(|| EMPTY.to_vec());
        }
        if packet[0] & UP == self.up {
            self.up ^= UP;
            if packet[0] & 0xF3 != 0xF3 {
                self.received.push(plain(packet));
            }
        }
        let mut answer = self.offered.clone();
        answer[0] = answer[0] & !(UP | DOWN) | self.down;
        answer
    }
}

impl Radio for Scripted {
    fn exchange(&mut self, packet: &[u8]) -> Result<Option<Vec<u8>>, RadioLost> {
        self.left = self.left.checked_sub(1).ok_or_else(|| RadioLost("pulled out".into()))?;
        let (lost, unheard) = self.losses.pop_front().unwrap_or((false, false));
        if lost {
            return Ok(None);
        }
        let answer = self.take(packet);
        Ok((!unheard).then_some(answer))
    }
}

/// A packet without the two bits of its header that mean nothing.
fn plain(packet: &[u8]) -> Vec<u8> {
    let mut packet = packet.to_vec();
    packet[0] &= 0xF3;
    packet
}

fn client(port: u16) -> SocketAddr {
    (Ipv4Addr::LOCALHOST, port).into()
}

/// Any packet but a null one, which is a scan.
fn packets(most: usize) -> impl Strategy<Value = Vec<Vec<u8>>> {
    let packet = prop::collection::vec(any::<u8>(), 1..=31);
    let packet = packet.prop_filter("a null packet", |packet| packet[0] & 0xF3 != 0xF3);
    prop::collection::vec(packet, 0..most)
}

proptest! {
    /// Whatever the radio loses, short of a second of silence, every packet goes through once,
    /// unchanged and in order, in both directions, and no two polls are closer than the rate.
    #[test]
    fn packets_go_through_unchanged_and_in_order_and_never_faster_than_the_rate(
        up in packets(60),
        down in packets(60),
        losses in prop::collection::vec((prop::bool::weighted(0.3), prop::bool::weighted(0.3)), 400),
        rate in 200_u16..=Rate::MOST,
        pauses in prop::collection::vec(0_u64..20_000, 400),
    ) {
        let rate = Rate::per_second(rate).unwrap();
        let mut radio = Scripted::new(down.clone(), losses);
        let mut poller = Poller::new(rate);
        let mut now = Instant::from_micros(1);
        let (mut sent, mut polls, mut waiting) = (Vec::new(), Vec::new(), up.iter());
        for pause in pauses.into_iter().chain([1_000; 2_000]) {
            now = now + Duration::from_micros(pause);
            if let Some(packet) = waiting.next() {
                let _ = poller.receive(now, client(1), packet);
            } else {
                // So that the client is not gone, and the drone is polled.
                let _ = poller.receive(now, client(1), &[0xFC]);
                radio.received.retain(|packet| packet[..] != [0xF0]);
            }
            if let Some(packet) = poller.poll(now) {
                polls.push(now);
                let answer = radio.exchange(&packet).unwrap();
                let heard = poller.acknowledged(now, answer.as_deref());
                prop_assert_ne!(heard.event, Some(Event::Silent));
                sent.extend(heard.packet.as_deref().map(plain));
            }
        }
        let plain = |packets: &[Vec<u8>]| packets.iter().map(|packet| plain(packet)).collect();
        let (up, down): (Vec<_>, Vec<_>) = (plain(&up), plain(&down));
        let wanted: Vec<_> = up.into_iter().filter(|packet| packet[..] != [0xF0]).collect();
        radio.received.retain(|packet| packet[..] != [0xF0]);
        prop_assert_eq!(&radio.received, &wanted);
        prop_assert_eq!(sent, down);
        for pair in polls.windows(2) {
            prop_assert!(pair[1].since(pair[0]) >= rate.interval());
        }
    }

    #[test]
    fn any_datagram_and_any_acknowledgement_is_taken(
        datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=31), 100),
        answers in prop::collection::vec(
            prop::option::of(prop::collection::vec(any::<u8>(), 0..=32)), 100
        ),
    ) {
        let mut poller = Poller::new(Rate::DEFAULT);
        let mut now = Instant::ZERO;
        for (datagram, answer) in datagrams.iter().zip(&answers) {
            now = now + Duration::from_millis(10);
            let _ = poller.receive(now, client(1), datagram);
            if let Some(packet) = poller.poll(now) {
                prop_assert!((1..=32).contains(&packet.len()));
                let _ = poller.acknowledged(now, answer.as_deref());
            }
            let _ = poller.attend(now);
        }
    }
}

#[test]
fn a_scan_is_answered_and_polls_nothing() {
    let mut poller = Poller::new(Rate::DEFAULT);
    let heard = poller.receive(Instant::ZERO, client(1), &[0xFF]);
    assert_eq!(heard, Heard { answer: Some(&[0xFF]), event: None });
    assert_eq!((poller.due(), poller.client()), (None, None));
}

#[test]
fn a_client_that_is_silent_is_gone_and_the_drone_is_polled_no_more() {
    let mut poller = Poller::new(Rate::DEFAULT);
    let heard = poller.receive(Instant::ZERO, client(1), &[0xFC, 1]);
    assert_eq!(heard.event, Some(Event::Connected(client(1))));
    let late = Instant::from_micros(2_999_999);
    assert_eq!(poller.attend(late), None);
    assert!(poller.due().is_some());
    let gone = late + Duration::from_micros(1);
    assert_eq!(poller.attend(gone), Some(Event::Gone(client(1))));
    assert_eq!((poller.due(), poller.poll(gone)), (None, None));
    assert_eq!(poller.attend(gone), None);
}

/// An order that waits for a drone that is out of reach must not be flown once it is back.
#[test]
fn what_waits_for_a_silent_drone_is_dropped() {
    let mut poller = Poller::new(Rate::DEFAULT);
    let mut radio = Scripted::new(vec![vec![0x50, 7]], vec![(true, true); 150]);
    let (mut now, mut events) = (Instant::ZERO, Vec::new());
    for n in 0..200 {
        let _ = poller.receive(now, client(1), &[0x3C, n]);
        if let Some(packet) = poller.poll(now) {
            let answer = radio.exchange(&packet).unwrap();
            events.extend(poller.acknowledged(now, answer.as_deref()).event);
        }
        now = now + Duration::from_millis(10);
    }
    assert_eq!(events, [Event::Silent, Event::Answers]);
    assert!(radio.received.iter().all(|packet| packet[1] >= 150), "{:?}", radio.received);
    assert!(radio.received.len() >= 40, "{:?}", radio.received);
}

/// The next client does not get what the drone had for the last one.
#[test]
fn a_new_client_begins_anew() {
    let mut poller = Poller::new(Rate::DEFAULT);
    let _ = poller.receive(Instant::ZERO, client(1), &[0x3C, 1]);
    let heard = poller.receive(Instant::ZERO, client(2), &[0x3C, 2]);
    assert_eq!(heard.event, Some(Event::Connected(client(2))));
    let mut radio = Scripted::new(Vec::new(), Vec::new());
    for n in 0..10 {
        let now = Instant::from_micros(n * 10_000);
        let packet = poller.poll(now).unwrap();
        let answer = radio.exchange(&packet).unwrap();
        let _ = poller.acknowledged(now, answer.as_deref());
    }
    assert_eq!(radio.received, [[0x30, 2]]);
}

/// A chip that answers the question for a safelink with something else has none.
#[test]
fn a_drone_without_a_safelink_gets_its_packets_as_they_are() {
    let mut poller = Poller::new(Rate::DEFAULT);
    let _ = poller.receive(Instant::ZERO, client(1), &[0x3C, 1]);
    let mut polled = Vec::new();
    for n in 0..12 {
        let now = Instant::from_micros(n * 10_000);
        polled.push(poller.poll(now).unwrap());
        let _ = poller.acknowledged(now, Some(&[0xF3]));
    }
    assert_eq!(polled[10..], [vec![0x3C, 1], vec![0xFF]]);
}

/// Over a real port: the client's packet arrives, the drone's comes back, and a dongle that is
/// pulled out ends the bridge with its driver's word.
#[test]
fn a_lost_dongle_ends_the_bridge() {
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1).unwrap();
    let address = ports.addresses()[0];
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    socket.set_read_timeout(Some(std::time::Duration::from_secs(60))).unwrap();
    let stop = AtomicBool::new(false);
    let (radio, ended) = thread::scope(|scope| {
        let stop = &stop;
        let bridge = scope.spawn(move || {
            let mut radio = Scripted::new(vec![vec![0x50, 7]], Vec::new());
            radio.left = 20;
            let ended = run(&mut radio, ports, Rate::DEFAULT, stop, |_, _| {});
            (radio, ended)
        });
        let mut buffer = [0; 32];
        socket.send_to(&[0xFF], address).unwrap();
        assert_eq!(socket.recv(&mut buffer).unwrap(), 1);
        socket.send_to(&[0x3C, 1], address).unwrap();
        assert_eq!(socket.recv(&mut buffer).unwrap(), 2);
        assert_eq!(plain(&buffer[..2]), [0x50, 7]);
        bridge.join().unwrap()
    });
    assert_eq!(radio.received, [[0x30, 1]]);
    let said = ended.unwrap_err().to_string();
    assert_eq!(said, "the Crazyradio is lost (pulled out); plug it in and start the bridge again");
    assert!(!stop.load(Ordering::Relaxed));
}

#[test]
fn an_address_is_read_and_written_as_bitcrazes_tools_do() {
    let text = "radio://0/80/2M/E7E7E7E703";
    let address: RadioAddress = text.parse().unwrap();
    assert_eq!(address.to_string(), text);
    assert_eq!((address.dongle, address.channel.number(), address.rate), (0, 80, None));
    assert_eq!(address.address.0, [0xE7, 0xE7, 0xE7, 0xE7, 0x03]);
    let limited: RadioAddress = "radio://1/100/250k/e7e7e7e7e7?rate_limit=50".parse().unwrap();
    assert_eq!(limited.to_string(), "radio://1/100/250K/E7E7E7E7E7");
    assert_eq!(limited.rate, Rate::per_second(50));
}

#[test]
fn a_wrong_address_is_refused_with_what_is_wrong() {
    for (text, what) in [
        ("udp://127.0.0.1:19850", "does not begin with radio://"),
        ("radio://0/80/2M", "is not a dongle, a channel"),
        ("radio://x/80/2M/E7E7E7E7E7", "has \"x\" for a dongle's number"),
        ("radio://0/126/2M/E7E7E7E7E7", "has \"126\" for a channel"),
        ("radio://0/80/3M/E7E7E7E7E7", "has \"3M\" for 250K, 1M or 2M"),
        ("radio://0/80/2M/E7E7E7E7", "has \"E7E7E7E7\" for ten hexadecimal digits"),
        ("radio://0/80/2M/+7E7E7E7E7", "has \"+7E7E7E7E7\" for ten"),
        ("radio://0/80/2M/E7E7E7E7E7?rate_limit=5", "has the rate_limit \"5\" for 10 to 1000"),
        ("radio://0/80/2M/E7E7E7E7E7?safelink=0", "has the option \"safelink=0\""),
    ] {
        let refused = text.parse::<RadioAddress>().unwrap_err().to_string();
        assert!(refused.contains(what), "{refused}");
        assert!(refused.ends_with("; give one such as radio://0/80/2M/E7E7E7E703"), "{refused}");
    }
}
