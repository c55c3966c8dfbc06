//! Attacks on the link: by recordings, forged packets and floods without the keys, and by a thief
//! with the keys of one drone.

use std::cell::RefCell;
use std::collections::HashSet;

use crate::common;
use crate::common::net::{GHOSTS_STRENGTH, Net, Setup};
use crate::common::{Rng, fleet, identity, sealed, seeded};
use airlink::keys::{self, Keys, Own};
use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Scope, Seal, Sealed};
use proptest::prelude::*;
use units::{Dbm, Instant, MetresPerSecond, NodeId, Order};
use wire::p2p::{
    Capsule, Counter, Epoch, Header, Kind, MAX_BODY, Message, Telemetry, VERSION, Wave,
};
use wire::radio::Datarate;

/// The state of a link without its counts.
fn state<S: std::fmt::Debug>(link: &Airlink<S>) -> String {
    let all = format!("{link:?}");
    let (state, _) = all.rsplit_once("counters: ").unwrap();
    state.to_owned()
}

/// A chain of four that has run for 5 s while the operator steers the head.
fn running_chain(seed: u64) -> Net<Sealed> {
    let mut net = Net::row(Setup { range: 3, ..Setup::default() }, seed, 4, sealed);
    net.stick = Some(Order::explore(MetresPerSecond(0.2)));
    net.run(5_000_000);
    assert!(
        net.received
            .iter()
            .any(|received| received.to == 0 && matches!(received.event, Event::Order { .. }))
    );
    net
}

/// Asserts that node `to` refuses `bytes` and that its state stays as it is.
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
        let mut net = shared_chain();
        let mut bytes = [header, rest].concat();
        if likely && let [first, second, ..] = bytes.as_mut_slice() {
            *first = VERSION << 4 | (1 + *first % Kind::ALL.len() as u8);
            *second &= 0x7F;
        }
        for to in 0..4 {
            changes_nothing(&mut net, to, &bytes);
        }
    }
}

/// One chain for many trials, which must leave it as it is.
fn shared_chain() -> std::cell::RefMut<'static, Net<Sealed>> {
    thread_local! {
        static NET: &'static RefCell<Net<Sealed>> = Box::leak(Box::new(RefCell::new(running_chain(1))));
    }
    NET.with(|net| net.borrow_mut())
}

/// Gives `link` damaged copies of a packet right before the packet itself, which is still accepted
/// afterwards, and asserts that they change nothing.
fn try_damaged_copies(link: &mut Airlink<Sealed>, now: Instant, packet: &[u8]) {
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
    let mut net = running_chain(2);
    net.probe = Some(try_damaged_copies);
    let (seen, since) = (net.received.len(), net.sent.len());
    net.run(1_100_000);
    // The packets were of every kind but membership, which is rare, and were accepted afterwards.
    let kinds: HashSet<_> =
        net.sent[since..].iter().map(|sent| Net::<Sealed>::kind(&sent.bytes)).collect();
    assert!(kinds.len() == 4, "{kinds:?}");
    assert!(net.received.len() > seen + 50);
}

#[test]
fn a_recording_is_refused_however_late_it_comes() {
    let mut net = running_chain(4);
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
fn a_recording_is_refused_after_the_receivers_reboot() {
    let mut net = running_chain(5);
    let mut recorded: Vec<_> = net.sent.iter().map(|sent| sent.bytes.clone()).collect();
    for _ in 0..2 {
        net.nodes[1].on = false;
        net.run(1_500_000);
        net.reboot(1);
        // The recording comes before the node has heard another, while it listens, and when it
        // knows the others.
        for pause in [1, 150_000, 3_000_000] {
            net.run(pause);
            for bytes in &recorded {
                assert_eq!(net.inject(1, bytes), None);
            }
        }
        // The node still accepts the others' packets.
        let seen = net.received.len();
        net.run(3_000_000);
        let heard = |from| {
            net.received[seen..].iter().any(|received| {
                received.to == 1
                    && matches!(received.event, Event::Report { from: f, .. } if f == NodeId(from))
            })
        };
        assert!([0, 2, 3].into_iter().all(heard));
        recorded.extend(net.sent.iter().map(|sent| sent.bytes.clone()));
    }
}

#[test]
fn a_recording_of_a_senders_earlier_epoch_is_refused() {
    let mut net = running_chain(6);
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
fn a_recording_of_a_node_that_has_left_is_refused() {
    let mut net = running_chain(15);
    net.leave(2);
    net.run(300_000);
    let recorded: Vec<_> =
        net.sent.iter().filter(|sent| sent.from == 2).map(|sent| sent.bytes.clone()).collect();
    for bytes in &recorded {
        for to in [0, 1, 3] {
            changes_nothing(&mut net, to, bytes);
        }
    }
    // Nor does a recording of its leave make the others forget it when it is back.
    net.reboot(2);
    net.run(3_000_000);
    let leave = recorded.last().unwrap();
    for to in [0, 1, 3] {
        changes_nothing(&mut net, to, leave);
    }
}

/// Where the end of a packet falls into 1.25 µs of its program, a radio chip sends, in place of a packet
/// of its own, one that it has received a while ago from a third node. To its receivers this is an
/// authentic packet of that node, from the wrong place and in another node's turn.
#[test]
fn a_packet_that_a_radio_chip_sends_once_more_is_no_news_and_brings_no_strength() {
    for range in [1, 2, 5] {
        let setup = Setup { range, loss: 0.2, late: 150, ..Setup::default() };
        let mut net = Net::row(setup, 20 + range as u64, 6, sealed);
        net.stick = Some(Order::explore(MetresPerSecond(0.2)));
        net.run(5_000_000);
        net.setup.ghosts = 0.3;
        net.run(20_000_000);
        let ghosts = net.sent.iter().filter(|sent| sent.is_ghost).count();
        assert!(ghosts > 500, "{ghosts}");
        let mut reports = HashSet::new();
        for received in &net.received {
            if let Event::Report { from, counter, rssi, .. } = received.event {
                assert!(reports.insert((received.to, from, counter)), "one report came twice");
                assert_ne!(rssi, Some(GHOSTS_STRENGTH), "the strength is another sender's");
            }
            // Of a node that it has never heard itself a receiver knows no other strength.
            if let (Event::Beacon { rssi, .. }, 5) = (&received.event, range) {
                assert_ne!(*rssi, GHOSTS_STRENGTH, "the strength is another sender's");
            }
        }
        let refused: u32 = net.nodes.iter().map(|node| node.link.counters().refused.replayed).sum();
        assert!(refused > 300, "{refused} of {ghosts} refused");
        // The chain lives: each node follows the next one, and orders come to the head.
        let follows = |node: &common::net::Node<Sealed>| node.link.status().follows;
        assert!(net.nodes[..5].iter().all(|node| follows(node) > Some(node.identity.node)));
        let orders = |received: &&common::net::Received| {
            received.to == 0 && matches!(received.event, Event::Order { .. })
        };
        let orders = net.received.iter().filter(orders).count();
        assert!(orders > 50, "{orders} orders");
    }
}

/// The packets that the others have sent while node 0 was jammed for `jammed` µs, played to it in their
/// order and loudly; returns the events.
fn jam_and_hold(net: &mut Net<Sealed>, jammed: u64) -> Vec<Event> {
    let since = net.sent.len();
    net.nodes[0].position += 100;
    net.run(jammed);
    let held: Vec<_> = net.sent[since..].iter().filter(|sent| sent.from != 0).cloned().collect();
    held.iter().filter_map(|sent| net.inject(0, &sent.bytes)).collect()
}

/// A packet that was jammed, recorded and played in its order later has the counter that is due. It
/// was obeyed, however late it came.
#[test]
fn a_packet_that_was_held_back_for_seconds_is_refused() {
    let mut net = running_chain(16);
    let refused = |net: &Net<Sealed>| net.nodes[0].link.counters().refused;
    let events = jam_and_hold(&mut net, 20_000_000);
    let (held, replayed) = (refused(&net).held, refused(&net).replayed);
    // The packets of the last two seconds are not too old yet.
    let orders = |event: &&Event| matches!(event, Event::Order { .. });
    assert!(events.iter().filter(orders).count() <= 10, "{events:?}");
    assert!(held > 400, "{held} held, {replayed} replayed");
    // Nor does what a neighbour said of itself so long ago, which takes the place of what is so now.
    let reports = events.iter().filter(|event| matches!(event, Event::Report { .. })).count();
    assert!((1..=40).contains(&reports), "{reports} reports");
    // The drone hears the others as before, and obeys.
    net.nodes[0].position -= 100;
    let seen = net.received.len();
    net.run(1_000_000);
    let obeyed = |received: &&common::net::Received| {
        received.to == 0 && matches!(received.event, Event::Order { .. })
    };
    assert!(net.received[seen..].iter().filter(obeyed).count() >= 3);
}

/// The strength of a packet that was held back is the attacker's, and so is its phase.
#[test]
fn a_packet_out_of_its_turn_brings_no_strength_and_no_phase() {
    let mut net = running_chain(17);
    let frame = |net: &Net<Sealed>| {
        let all = format!("{:?}", net.nodes[0].link);
        let (_, sync) = all.split_once("clock_sync: ").unwrap();
        sync.split_once("leader").unwrap().0.to_owned()
    };
    let before = frame(&net);
    let events = jam_and_hold(&mut net, 1_000_000);
    let reports: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Report { rssi, .. } => Some(*rssi),
            _ => None,
        })
        .collect();
    assert!(reports.len() >= 10, "a report that is a second old still counts");
    assert!(reports.iter().all(Option::is_none), "the attacker's is -50: {reports:?}");
    assert_eq!(frame(&net), before);
}

/// The head does not accept orders that were on the air before its reboot.
#[test]
fn an_order_from_before_the_reboot_is_void() {
    let mut net = Net::row(Setup { range: 1, ..Setup::default() }, 8, 3, sealed);
    net.run(2_000_000);
    net.stick = Some(Order::explore(MetresPerSecond(0.3)));
    net.run(3_000_000);
    net.stick = None;
    net.nodes[0].on = false;
    net.run(1_500_000);
    net.reboot(0);
    let seen = net.received.len();
    net.run(5_000_000);
    let is_order = |received: &common::net::Received| {
        received.to == 0 && matches!(received.event, Event::Order { .. })
    };
    assert!(
        !net.received[seen..].iter().any(is_order),
        "the head accepts an order although the operator has let go of the stick"
    );
    // The operator's next order reaches the head.
    net.stick = Some(Order::explore(MetresPerSecond(0.3)));
    net.run(1_000_000);
    assert!(net.received[seen..].iter().any(is_order));
}

/// A packet in the name of `from`, sealed for the hop with the group key, which every drone has.
fn packet(seal: &Sealed, from: NodeId, counter: Counter, message: &Message) -> Vec<u8> {
    let (kind, wave, owner) = (message.kind(), Wave::Outward, from);
    let header = Header { kind, from, wave, place: 0, owner, counter };
    let clear = header.encode();
    let mut body = [0; MAX_BODY];
    let length = message.encode(&mut body);
    let mut nonce = [0; 16];
    nonce[..8].copy_from_slice(&clear);
    let tag = seal.seal(Scope::Fleet, &nonce, &clear, &mut body[..length]);
    [&clear[..], &body[..length], &tag].concat()
}

/// The nonce of a capsule.
fn end_nonce(label: &[u8; 3], node: NodeId, counter: Counter) -> [u8; 16] {
    let mut nonce = [0; 16];
    nonce[..3].copy_from_slice(label);
    nonce[3] = node.0;
    nonce[4..10].copy_from_slice(&counter.to_bytes());
    nonce
}

/// A counter of epoch 1, far ahead of those in use.
fn far(count: u32) -> Counter {
    Counter::new(Epoch::new(1).unwrap(), count).unwrap()
}

/// A command to `node`, sealed with the keys of `seal`.
fn order_for(seal: &Sealed, node: NodeId, counter: Counter, aad: &[u8], order: Order) -> Message {
    let mut text = wire::p2p::encode_order(order);
    let nonce = end_nonce(b"cmd", node, counter);
    let tag = seal.seal(Scope::EndToEnd(node), &nonce, aad, &mut text);
    Message::Command(Capsule { node, counter, sealed: text, tag }.into())
}

#[test]
fn a_thief_with_a_relays_keys_can_give_no_orders() {
    let mut net = running_chain(9);
    // The thief has the keys of node 2.
    let thief = sealed(identity(2, 4));
    for (to, count) in [(0, 900_000), (1, 900_001)] {
        let node = NodeId(to as u8);
        let message = order_for(&thief, node, far(count), &[node.0, 1, 0, 0], Order::Stop);
        // The packet is in the name of the base, which is fresh to all nodes.
        let forged = packet(&thief, NodeId(3), far(count), &message);
        assert_eq!(net.inject(to, &forged), None);
        assert_eq!(net.nodes[to].link.counters().refused.forged, 1);
    }
    // Nor do orders that the thief has heard serve: with another counter, to another node, or as
    // they are.
    let heard = net.sent.iter().rev().find_map(|sent| {
        let (header, rest) = Header::decode(&sent.bytes).unwrap();
        let mut body = rest[..rest.len() - 8].to_vec();
        let tag = rest[rest.len() - 8..].try_into().unwrap();
        let mut nonce = [0; 16];
        nonce[..8].copy_from_slice(&sent.bytes[..8]);
        assert!(thief.open(Scope::Fleet, &nonce, &sent.bytes[..8], &mut body, &tag));
        match Message::decode(header.kind, &body) {
            Ok(Message::Command(commands)) => {
                Some(commands.first).filter(|capsule| capsule.node == NodeId(0))
            }
            _ => None,
        }
    });
    let heard = heard.unwrap();
    for (count, to, capsule) in [
        (900_010, 0, Capsule { counter: far(900_010), ..heard }),
        (900_011, 1, Capsule { node: NodeId(1), counter: far(900_011), ..heard }),
        (900_012, 0, heard),
    ] {
        let forged = packet(&thief, NodeId(3), far(count), &Message::Command(capsule.into()));
        assert_eq!(net.inject(to, &forged), None);
    }
    // Nor can the thief read them.
    let mut text = heard.sealed;
    let nonce = end_nonce(b"cmd", heard.node, heard.counter);
    assert!(!thief.open(Scope::EndToEnd(heard.node), &nonce, &[0, 1, 0, 0], &mut text, &heard.tag));
}

#[test]
fn a_thief_with_a_relays_keys_cannot_send_another_nodes_telemetry() {
    let mut net = running_chain(10);
    let thief = sealed(identity(2, 4));
    let telemetry_of = |node: u8, count: u32| {
        let mut text = common::telemetry().encode();
        let (node, counter) = (NodeId(node), far(count));
        let nonce = end_nonce(b"tel", node, counter);
        let tag = thief.seal(Scope::EndToEnd(node), &nonce, &[node.0], &mut text);
        let message = Message::Telemetry(Capsule { node, counter, sealed: text, tag });
        packet(&thief, NodeId(1), counter, &message)
    };
    assert_eq!(net.inject(3, &telemetry_of(0, 900_000)), None);
    assert_eq!(net.inject(3, &telemetry_of(1, 900_001)), None);
    assert_eq!(net.nodes[3].link.counters().refused.forged, 2);
    // The telemetry of node 2 itself is accepted, which shows that the test forges well.
    let event = net.inject(3, &telemetry_of(2, 900_002));
    assert!(matches!(event, Some(Event::Telemetry { from: NodeId(2), .. })));
}

#[test]
fn an_order_with_the_bases_key_is_accepted() {
    let mut net = running_chain(11);
    let base = sealed(identity(3, 4));
    let order = order_for(&base, NodeId(1), far(900_000), &[1, 1, 0, 0], Order::Land);
    let event = net.inject(1, &packet(&base, NodeId(3), far(900_000), &order));
    assert_eq!(event, Some(Event::Order { task: Order::Land, counter: far(900_000) }));
    // An order for another epoch than the node's own is not.
    let order = order_for(&base, NodeId(1), far(900_001), &[1, 2, 0, 0], Order::Land);
    assert_eq!(net.inject(1, &packet(&base, NodeId(3), far(900_001), &order)), None);
    assert_eq!(net.nodes[1].link.counters().refused.forged, 1);
}

/// Echoes of a node's own packets are neither accepted nor taken for a second node.
#[test]
fn echoes_do_not_silence_a_node() {
    let mut net = running_chain(12);
    let own: Vec<_> =
        net.sent.iter().filter(|sent| sent.from == 1).map(|sent| sent.bytes.clone()).collect();
    for bytes in &own {
        changes_nothing(&mut net, 1, bytes);
    }
    assert_eq!(net.nodes[1].link.counters().refused.own as usize, own.len());
}

#[test]
fn packets_of_another_key_generation_are_refused() {
    let mut net = running_chain(13);
    let base = fleet().base(2);
    let keys = Keys { group: fleet().group(2), own: Own::Node(keys::node(&base, NodeId(2))) };
    let message =
        Message::Beacon(wire::p2p::Beacon { role: units::Role::Relay, state: 0, battery: None });
    let bytes = packet(&Sealed::new(keys), NodeId(2), far(900_000), &message);
    changes_nothing(&mut net, 1, &bytes);
    assert_eq!(net.nodes[1].link.counters().refused.tag, 1);
}

/// Each packet of a flood from 16 numbers is well-formed but for the tag: it costs one decryption
/// and leaves no state.
#[test]
fn a_flood_leaves_no_state_behind() {
    let mut net = running_chain(14);
    let mut rng = Rng(14);
    for _ in 0..20_000 {
        let mut bytes = [0; 60];
        for byte in &mut bytes {
            *byte = rng.next() as u8;
        }
        bytes[0] = VERSION << 4 | (1 + rng.below(Kind::ALL.len() as u64) as u8);
        bytes[1] = rng.below(16) as u8;
        assert_eq!(net.inject(1, &bytes[..17 + rng.below(44) as usize]), None);
    }
    assert_eq!(net.nodes[1].link.counters().refused.tag, 20_000);
    let seen = net.received.len();
    net.run(1_000_000);
    assert!(
        net.received[seen..].iter().any(|received| received.to == 1),
        "node 1 does not hear the others as before"
    );
}

thread_local! {
    static NONCES: RefCell<HashSet<(Vec<u8>, [u8; 16])>> = RefCell::default();
}

/// A [`Sealed`] that asserts that no nonce is used twice under one key.
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
    fn no_nonce_is_used_twice_whenever_nodes_reboot(
        seed in any::<u64>(),
        boots in prop::collection::vec((0_usize..4, 1_u64..3_000_000, 0_u64..2_000_000), 1..8),
    ) {
        NONCES.with_borrow_mut(HashSet::clear);
        let make = |identity| Recording(sealed(identity), identity);
        let mut net = Net::row(Setup { loss: 0.2, ..Setup::default() }, seed, 4, make);
        net.stick = Some(Order::explore(MetresPerSecond(0.1)));
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

/// Every version of the crate must make these keys, and these packets for as long as the version in
/// their header is 6.
#[test]
fn keys_stay_and_packets_stay_within_a_version() {
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
            "6221240000010000c9f4d75a677b6b6bbf638588af72a77dc4c24cfedae9f00d8b65ebb9",
        ),
        (
            "telemetry",
            hex(&first_packets(1)[2]),
            "6411250000010000c01d23d34ac0b6caf4878b6321c6d2f56a8a98da834d15bde499094256bfd800ab3a5993d1",
        ),
        ("beacon", hex(&first_packets(1)[3]), "61312600000100008e03874cd34264540f9c7e"),
    ];
    for (name, is, should) in table {
        assert_eq!(is, should, "{name}");
    }
}

/// The first four packets of node `node`, which has a report and telemetry to send.
fn first_packets(node: usize) -> Vec<Vec<u8>> {
    let identity = identity(node, 3);
    let schedule = Schedule::new(Datarate::Mbit2, identity.node).unwrap();
    let now = Instant::from_millis(1);
    let mut link =
        Airlink::new(LinkConfig::DEFAULT, identity, sealed(identity), Epoch::FIRST, schedule, now);
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

/// The tag is the first known answer of the standard (NIST SP 800-232), cut to 8 bytes.
#[test]
fn the_cipher_is_that_of_the_standard() {
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
