//! What somebody without the keys, and what a thief with some of them, can do.

use std::cell::RefCell;
use std::collections::HashSet;

use crate::common;
use crate::common::net::{Net, Setup};
use crate::common::{Chance, fleet, identity, sealed, seeded};
use airlink::keys::{self, Keys, Own};
use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Scope, Seal, Sealed};
use proptest::prelude::*;
use units::{Dbm, Instant, MetresPerSecond, NodeId, Order};
use wire::p2p::{Capsule, Counter, Epoch, Header, MAX_BODY, Message, Telemetry, Wave};
use wire::radio::Datarate;

/// All that a link is but its counts.
fn state<S: std::fmt::Debug>(link: &Airlink<S>) -> String {
    let all = format!("{link:?}");
    let (state, _) = all.rsplit_once("counters: ").unwrap();
    state.to_owned()
}

/// Four who have been talking for a while, the pilot's stick in use.
fn talking(seed: u64) -> Net<Sealed> {
    let mut net = Net::row(Setup { earshot: 3, ..Setup::default() }, seed, 4, sealed);
    net.stick = Some(Order::Explore(MetresPerSecond(0.2)));
    net.run(5_000_000);
    assert!(net.said.iter().any(|said| said.to == 0 && matches!(said.event, Event::Order { .. })));
    net
}

fn changes_nothing(net: &mut Net<Sealed>, to: usize, bytes: &[u8]) {
    let before = state(&net.nodes[to].link);
    assert_eq!(net.inject(to, bytes), None);
    assert_eq!(state(&net.nodes[to].link), before, "{bytes:02x?}");
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn any_bytes_change_nothing(
        header in prop::collection::vec(any::<u8>(), 0..8),
        rest in prop::collection::vec(any::<u8>(), 0..60),
        likely in any::<bool>(),
    ) {
        let mut net = talking_once();
        let mut bytes = [header, rest].concat();
        if likely && let [first, second, ..] = bytes.as_mut_slice() {
            *first = 0x10 | (1 + *first % 5);
            *second &= 0x7F;
        }
        for to in 0..4 {
            changes_nothing(&mut net, to, &bytes);
        }
    }
}

/// One net for many trials that must leave it as it is.
fn talking_once() -> std::cell::RefMut<'static, Net<Sealed>> {
    thread_local! {
        static NET: &'static RefCell<Net<Sealed>> = Box::leak(Box::new(RefCell::new(talking(1))));
    }
    NET.with(|net| net.borrow_mut())
}

/// Right before the packet itself comes, so that but for the change it would be taken.
fn spoil(link: &mut Airlink<Sealed>, now: Instant, packet: &[u8]) {
    let before = state(link);
    let mut is_nothing = |bytes: &[u8]| {
        assert_eq!(link.receive(now, Dbm(-50.0), bytes), None, "{bytes:02x?}");
        assert_eq!(state(link), before, "{bytes:02x?}");
    };
    for bit in 0..8 * packet.len() {
        let mut bytes = packet.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        is_nothing(&bytes);
    }
    for length in 0..packet.len() {
        is_nothing(&packet[..length]);
    }
    for more in 1..4 {
        is_nothing(&[packet, &[0; 4][..more]].concat());
    }
}

#[test]
fn a_packet_with_any_bit_flipped_or_byte_missing_changes_nothing() {
    let mut net = talking(2);
    net.probe = Some(spoil);
    let (seen, since) = (net.said.len(), net.sent.len());
    net.run(1_100_000);
    // Of every kind but membership, which is not said every second; and all were taken afterwards.
    let kinds: HashSet<_> =
        net.sent[since..].iter().map(|sent| Net::<Sealed>::kind(&sent.bytes)).collect();
    assert!(kinds.len() == 4, "{kinds:?}");
    assert!(net.said.len() > seen + 50);
}

#[test]
fn a_recording_says_nothing_however_late() {
    let mut net = talking(4);
    let recorded: Vec<_> = net.sent.iter().map(|sent| sent.bytes.clone()).collect();
    for pause in [0, 700_000, 20_000_000] {
        net.run(pause);
        for bytes in &recorded {
            for to in 0..4 {
                changes_nothing(&mut net, to, bytes);
            }
        }
    }
}

#[test]
fn a_recording_says_nothing_after_the_hearers_reboot() {
    let mut net = talking(5);
    let mut recorded: Vec<_> = net.sent.iter().map(|sent| sent.bytes.clone()).collect();
    for _ in 0..2 {
        net.nodes[1].on = false;
        net.run(1_500_000);
        net.reboot(1);
        // Before it has heard anybody, while it listens, and when it knows the others.
        for pause in [1, 150_000, 3_000_000] {
            net.run(pause);
            for bytes in &recorded {
                assert_eq!(net.inject(1, bytes), None);
            }
        }
        // It is none the worse for it.
        let seen = net.said.len();
        net.run(3_000_000);
        let heard = |from| {
            net.said[seen..].iter().any(|said| {
                said.to == 1
                    && matches!(said.event, Event::Report { from: f, .. } if f == NodeId(from))
            })
        };
        assert!([0, 2, 3].into_iter().all(heard));
        recorded.extend(net.sent.iter().map(|sent| sent.bytes.clone()));
    }
}

#[test]
fn a_recording_of_a_senders_earlier_epoch_says_nothing() {
    let mut net = talking(6);
    net.nodes[2].on = false;
    net.run(1_500_000);
    let recorded: Vec<_> =
        net.sent.iter().filter(|sent| sent.from == 2).map(|sent| sent.bytes.clone()).collect();
    net.reboot(2);
    for pause in [1, 150_000, 3_000_000] {
        net.run(pause);
        for bytes in &recorded {
            for to in 0..4 {
                assert_eq!(net.inject(to, bytes), None);
            }
        }
    }
    assert!(net.nodes[2].link.status().standing == airlink::Standing::Member);
}

#[test]
fn what_somebody_said_who_has_left_says_nothing() {
    let mut net = talking(15);
    net.leave(2);
    net.run(300_000);
    let recorded: Vec<_> =
        net.sent.iter().filter(|sent| sent.from == 2).map(|sent| sent.bytes.clone()).collect();
    for bytes in &recorded {
        for to in [0, 1, 3] {
            changes_nothing(&mut net, to, bytes);
        }
    }
    // Nor does its goodbye send anybody away when it is back.
    net.reboot(2);
    net.run(3_000_000);
    let goodbye = recorded.last().unwrap();
    for to in [0, 1, 3] {
        changes_nothing(&mut net, to, goodbye);
    }
}

/// Orders that were on the air before the head's reboot are void after it.
#[test]
fn an_order_of_before_the_reboot_is_void() {
    let mut net = Net::row(Setup { earshot: 1, ..Setup::default() }, 8, 3, sealed);
    net.run(2_000_000);
    net.stick = Some(Order::Explore(MetresPerSecond(0.3)));
    net.run(3_000_000);
    net.stick = None;
    net.nodes[0].on = false;
    net.run(1_500_000);
    net.reboot(0);
    let seen = net.said.len();
    net.run(5_000_000);
    let is_order =
        |said: &common::net::Said| said.to == 0 && matches!(said.event, Event::Order { .. });
    assert!(!net.said[seen..].iter().any(is_order), "the pilot has let go");
    // The pilot's next word reaches it.
    net.stick = Some(Order::Explore(MetresPerSecond(0.3)));
    net.run(1_000_000);
    assert!(net.said[seen..].iter().any(is_order));
}

/// A packet of `from`'s, sealed for the hop with what every drone has.
fn packet(seal: &Sealed, from: NodeId, counter: Counter, message: &Message) -> Vec<u8> {
    let header = Header { kind: message.kind(), from, wave: Wave::Outward, place: 0, counter };
    let clear = header.encode();
    let mut body = [0; MAX_BODY];
    let length = message.encode(&mut body);
    let mut nonce = [0; 16];
    nonce[..8].copy_from_slice(&clear);
    let tag = seal.seal(Scope::Fleet, &nonce, &clear, &mut body[..length]);
    [&clear[..], &body[..length], &tag].concat()
}

fn end_nonce(what: &[u8; 3], node: NodeId, counter: Counter) -> [u8; 16] {
    let mut nonce = [0; 16];
    nonce[..3].copy_from_slice(what);
    nonce[3] = node.0;
    nonce[4..10].copy_from_slice(&counter.to_bytes());
    nonce
}

fn far(count: u32) -> Counter {
    Counter::new(Epoch::new(1).unwrap(), count).unwrap()
}

fn order_for(seal: &Sealed, node: NodeId, counter: Counter, aad: &[u8], task: Order) -> Message {
    let mut text = wire::p2p::encode_order(task);
    let nonce = end_nonce(b"cmd", node, counter);
    let tag = seal.seal(Scope::EndToEnd(node), &nonce, aad, &mut text);
    Message::Command(Capsule { node, counter, sealed: text, tag })
}

#[test]
fn a_thief_with_a_relays_keys_can_order_nobody_about() {
    let mut net = talking(9);
    // Node 2's board is on somebody's desk.
    let thief = sealed(identity(2, 4));
    for (to, count) in [(0, 900_000), (1, 900_001)] {
        let node = NodeId(to as u8);
        let message = order_for(&thief, node, far(count), &[node.0, 1, 0, 0], Order::Stop);
        // In the base's name, who is fresh to everybody.
        let forged = packet(&thief, NodeId(3), far(count), &message);
        assert_eq!(net.inject(to, &forged), None);
        assert_eq!(net.nodes[to].link.counters().refused.forged, 1);
    }
    // Nor by what it has heard: another node's order, or the same with another number.
    let heard = net.sent.iter().rev().find_map(|sent| {
        let (header, rest) = Header::decode(&sent.bytes).unwrap();
        let mut body = rest[..rest.len() - 8].to_vec();
        let tag = rest[rest.len() - 8..].try_into().unwrap();
        let mut nonce = [0; 16];
        nonce[..8].copy_from_slice(&sent.bytes[..8]);
        assert!(thief.open(Scope::Fleet, &nonce, &sent.bytes[..8], &mut body, &tag));
        match Message::decode(header.kind, &body) {
            Ok(Message::Command(capsule)) if capsule.node == NodeId(0) => Some(capsule),
            _ => None,
        }
    });
    let heard = heard.unwrap();
    for (count, to, capsule) in [
        (900_010, 0, Capsule { counter: far(900_010), ..heard }),
        (900_011, 1, Capsule { node: NodeId(1), counter: far(900_011), ..heard }),
        (900_012, 0, heard),
    ] {
        let forged = packet(&thief, NodeId(3), far(count), &Message::Command(capsule));
        assert_eq!(net.inject(to, &forged), None);
    }
    // Nor can it read them.
    let mut text = heard.sealed;
    let nonce = end_nonce(b"cmd", heard.node, heard.counter);
    assert!(!thief.open(Scope::EndToEnd(heard.node), &nonce, &[0, 1, 0, 0], &mut text, &heard.tag));
}

#[test]
fn a_thief_with_a_relays_keys_cannot_speak_as_another_to_the_base() {
    let mut net = talking(10);
    let thief = sealed(identity(2, 4));
    let tell = |node: u8, count: u32| {
        let mut text = common::telemetry().encode();
        let (node, counter) = (NodeId(node), far(count));
        let nonce = end_nonce(b"tel", node, counter);
        let tag = thief.seal(Scope::EndToEnd(node), &nonce, &[node.0], &mut text);
        let message = Message::Telemetry(Capsule { node, counter, sealed: text, tag });
        packet(&thief, NodeId(1), counter, &message)
    };
    assert_eq!(net.inject(3, &tell(0, 900_000)), None);
    assert_eq!(net.inject(3, &tell(1, 900_001)), None);
    assert_eq!(net.nodes[3].link.counters().refused.forged, 2);
    // As itself it can: the test forges well.
    let event = net.inject(3, &tell(2, 900_002));
    assert!(matches!(event, Some(Event::Telemetry { from: NodeId(2), .. })));
}

#[test]
fn the_base_itself_is_obeyed() {
    let mut net = talking(11);
    let base = sealed(identity(3, 4));
    let order = order_for(&base, NodeId(1), far(900_000), &[1, 1, 0, 0], Order::Land);
    let event = net.inject(1, &packet(&base, NodeId(3), far(900_000), &order));
    assert_eq!(event, Some(Event::Order { task: Order::Land, counter: far(900_000) }));
    // But not for another epoch than the node's own.
    let order = order_for(&base, NodeId(1), far(900_001), &[1, 2, 0, 0], Order::Land);
    assert_eq!(net.inject(1, &packet(&base, NodeId(3), far(900_001), &order)), None);
    assert_eq!(net.nodes[1].link.counters().refused.forged, 1);
}

/// Echoes of a node's own words are neither obeyed nor taken for a second node.
#[test]
fn its_own_words_do_not_silence_a_node() {
    let mut net = talking(12);
    let own: Vec<_> =
        net.sent.iter().filter(|sent| sent.from == 1).map(|sent| sent.bytes.clone()).collect();
    for bytes in &own {
        changes_nothing(&mut net, 1, bytes);
    }
    assert_eq!(net.nodes[1].link.counters().refused.own as usize, own.len());
}

#[test]
fn of_another_generation_nothing_is_heard() {
    let mut net = talking(13);
    let base = fleet().base(2);
    let keys = Keys { group: fleet().group(2), own: Own::Node(keys::node(&base, NodeId(2))) };
    let message =
        Message::Beacon(wire::p2p::Beacon { role: units::Role::Relay, state: 0, battery: None });
    let bytes = packet(&Sealed::new(keys), NodeId(2), far(900_000), &message);
    changes_nothing(&mut net, 1, &bytes);
    assert_eq!(net.nodes[1].link.counters().refused.tag, 1);
}

/// A flood from 16 numbers, every packet of it well-formed but for the tag: it costs one opening
/// each, and leaves nothing behind.
#[test]
fn a_flood_leaves_nothing_behind() {
    let mut net = talking(14);
    let mut chance = Chance(14);
    for _ in 0..20_000 {
        let mut bytes = [0; 60];
        for byte in &mut bytes {
            *byte = chance.next() as u8;
        }
        bytes[0] = 0x10 | (1 + chance.below(5) as u8);
        bytes[1] = chance.below(16) as u8;
        assert_eq!(net.inject(1, &bytes[..17 + chance.below(44) as usize]), None);
    }
    let seen = net.said.len();
    net.run(1_000_000);
    assert!(net.said[seen..].iter().any(|said| said.to == 1), "it hears the others as before");
}

thread_local! {
    static NONCES: RefCell<HashSet<(Vec<u8>, [u8; 16])>> = RefCell::default();
}

/// Seals as [`Sealed`], and never twice with one nonce under one key.
#[derive(Clone, Debug)]
struct Recording(Sealed, Identity);

impl Seal for Recording {
    fn seal(&self, scope: Scope, nonce: &[u8; 16], aad: &[u8], body: &mut [u8]) -> [u8; 8] {
        let key = match scope {
            Scope::Fleet => vec![],
            Scope::EndToEnd(node) => vec![node.0],
        };
        let first = NONCES.with_borrow_mut(|nonces| nonces.insert((key, *nonce)));
        assert!(first, "{:?} uses {nonce:02x?} twice", self.1);
        self.0.seal(scope, nonce, aad, body)
    }

    fn open(
        &self,
        scope: Scope,
        nonce: &[u8; 16],
        aad: &[u8],
        body: &mut [u8],
        tag: &[u8; 8],
    ) -> bool {
        self.0.open(scope, nonce, aad, body, tag)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..seeded() })]

    #[test]
    fn no_nonce_is_used_twice_whoever_is_switched_off_when(
        seed in any::<u64>(),
        boots in prop::collection::vec((0_usize..4, 1_u64..3_000_000, 0_u64..2_000_000), 1..8),
    ) {
        NONCES.with_borrow_mut(HashSet::clear);
        let make = |who| Recording(sealed(who), who);
        let mut net = Net::row(Setup { loss: 0.2, ..Setup::default() }, seed, 4, make);
        net.stick = Some(Order::Explore(MetresPerSecond(0.1)));
        for (node, runs, off) in boots {
            net.run(runs);
            net.nodes[node].on = false;
            net.run(off);
            net.reboot(node);
        }
        net.run(2_000_000);
        prop_assert!(NONCES.with_borrow(HashSet::len) > 20);
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Keys and packets that every version must make the same.
#[test]
fn keys_and_packets_are_those_of_the_first_version() {
    let base = fleet().base(1);
    let table = [
        ("group 1", hex(fleet().group(1).expose()), "a69569635450588375b39c25565af13f"),
        ("group 2", hex(fleet().group(2).expose()), "d3e7b848007ca9fe69be4ba8e8469967"),
        ("base 1", hex(base.expose()), "ab13dfea1704b4d1cbcf6b30b17d83ec"),
        ("node 0", hex(keys::node(&base, NodeId(0)).expose()), "0d5f422707fa11b2c244519c42ce9126"),
        (
            "node 15",
            hex(keys::node(&base, NodeId(15)).expose()),
            "e22bc719b05d03ea3b49dda8b8c76c96",
        ),
        (
            "report",
            hex(&first_packets(1)[1]),
            "1221020000010000a7d22fcf45409810512339263f024ac9bbfc7923c3c4dcf497195a5e",
        ),
        (
            "telemetry",
            hex(&first_packets(1)[2]),
            "14110300000100003994957ba9ae20335398213ffc4266664ef4b5f3f825f050595df3e5bf0c5bc4a48fbed02d",
        ),
        ("beacon", hex(&first_packets(1)[3]), "1131040000010000255ae2e54e7890b9a9d61a"),
    ];
    for (what, is, should) in table {
        assert_eq!(is, should, "{what}");
    }
}

/// What node `node` says first, having something of everything to say.
fn first_packets(node: usize) -> Vec<Vec<u8>> {
    let who = identity(node, 3);
    let schedule = Schedule::new(Datarate::Mbit2, who.node).unwrap();
    let now = Instant::from_millis(1);
    let mut link = Airlink::new(LinkConfig::DEFAULT, who, sealed(who), Epoch::FIRST, schedule, now);
    link.report(common::report());
    link.telemeter(Telemetry { state: 9, ..common::telemetry() });
    let mut packets = Vec::new();
    let mut out = [0; 60];
    while packets.len() < 4 {
        let due = link.due().unwrap();
        packets.extend(link.transmit(due, &mut out).map(|length| out[..length].to_vec()));
    }
    packets
}

/// The cipher is the standard's (NIST SP 800-232): the first of its known answers, cut short.
#[test]
fn the_cipher_is_the_standards() {
    let key: [u8; 16] = core::array::from_fn(|n| n as u8);
    let keys =
        Keys { group: keys::Key::from_bytes(key), own: Own::Node(keys::Key::from_bytes(key)) };
    let tag = Sealed::new(keys).seal(Scope::Fleet, &key, &[], &mut []);
    assert_eq!(hex(&tag), "4427d64b8e1e1451");
}

#[test]
fn a_key_is_not_printed() {
    let printed = format!("{:?}", sealed(identity(3, 4)));
    assert_eq!(printed, "Sealed { keys: Keys { group: Key(..), own: Base(Key(..)) } }");
}
