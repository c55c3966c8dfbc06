//! Messages on the air: the bytes of each message, that they and it say the same, and that nothing
//! else is taken.

use crate::messages;
use crate::messages::Numbers::{Flying, Wild};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{
    Dbm, Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond, MissionKind,
    NodeId, Order, Payload, Phase, Role, Signpost, Volts,
};
use wire::p2p::{
    Beacon, Capsule, Commands, Counter, Epoch, Error, HEADER, HEARD, Header, Heard, Kind, MAX_BODY,
    Membership, Message, MissionMessage, ORDER, Report, STAMP_US, TAG, TELEMETRY, Telemetry, Wave,
};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

fn encoded(message: &Message) -> Vec<u8> {
    let mut out = [0xA5; MAX_BODY];
    let length = message.encode(&mut out);
    assert!(out[length..].iter().all(|byte| *byte == 0xA5), "what follows is left alone");
    out[..length].to_vec()
}

fn counter() -> Counter {
    Counter::new(Epoch::new(0x00_0102).unwrap(), 0x0A_0B0C).unwrap()
}

fn sum(surplus: f32, compliance: f32, links: u8) -> LinkSum {
    LinkSum { surplus: Metres(surplus), compliance: MetresPerDb(compliance), links }
}

fn report() -> Report {
    let heard = [(2, -57.0, true, 0x0102), (4, -83.0, false, 0xCC_FFEE)].map(
        |(node, rssi, is_new, epoch)| Heard {
            node: NodeId(node),
            rssi: Dbm(rssi),
            is_new,
            epoch: Epoch::new(epoch).unwrap(),
        },
    );
    Report {
        phase: Phase::Linked,
        recall: true,
        calls: true,
        is_uneven: false,
        velocity: MetresPerSecond(-0.25),
        odometer: Metres(-12.5),
        links: Some(LinkSpan { weakest: Dbm(-71.25), strongest: Dbm(-58.0) }),
        sums: [sum(-2.5, 0.75, 2), LinkSum::NONE],
        waiting: 2,
        head_velocity: MetresPerSecond(-0.1),
        signpost: None,
        heard: heapless::Vec::from_iter(heard),
    }
}

fn telemetry() -> Telemetry {
    Telemetry {
        state: 7,
        fault: 1,
        battery: Some(Volts(3.7)),
        endurance: Some(Duration::from_secs(240)),
        front: Some((NodeId(2), Dbm(-57.0))),
        back: None,
        odometer: Metres(-12.5),
        velocity: MetresPerSecond(-0.25),
        height: Some(Metres(0.5)),
        heeded: 0x0B0C,
    }
}

const REFUSED: Membership = Membership::Refused { node: NodeId(9), epoch: Epoch::FIRST };

/// By the tables in the types' documentation.
#[test]
fn the_bytes_are_those_of_the_tables() {
    let beacon = Beacon { role: Role::Relay, state: 7, battery: Some(Volts(3.7)) };
    let command =
        Capsule { node: NodeId(5), counter: counter(), sealed: [0x5E; 4], tag: [0x7A; 8] };
    let other = Capsule { node: NodeId(6), ..command };
    let sealed =
        Capsule { node: NodeId(5), counter: counter(), sealed: [0x5E; 14], tag: [0x7A; 8] };
    let capsule = |length: usize| {
        [&[5, 0x0C, 0x0B, 0x0A, 0x02, 0x01, 0x00][..], &vec![0x5E; length], &[0x7A; 8]].concat()
    };
    let reported = vec![
        0b0101_1010, // two wait, calls, recall, linked
        0x06,
        0xFF, // -250 mm/s
        0x00,
        0xE7,
        0xFF, // -6400/512 m
        0xE3,
        0xFE, // -285 quarters
        0x18,
        0xFF, // -232 quarters
        0xD8,
        0xFF, // -40/16 m
        0x00,
        0x03, // 768/1024 m/dB
        0,
        0,
        0,
        0,    // nothing known towards the base
        0x02, // two links towards the head
        0xE7, // -25 * 4 mm/s
        0x82,
        57,
        0x02,
        0x01,
        0x00, // the one
        4,
        83,
        0xEE,
        0xFF,
        0xCC, // the other
    ];
    let table = [
        (Message::Beacon(beacon), vec![1, 7, 185]),
        (Message::Report(report()), reported),
        (Message::Command(command.into()), capsule(4)),
        (
            Message::Command(Commands { first: command, second: Some(other) }),
            [capsule(4), [&[6][..], &capsule(4)[1..]].concat()].concat(),
        ),
        (Message::Telemetry(sealed), capsule(14)),
        (Message::Membership(Membership::Join), vec![1]),
        (Message::Membership(Membership::Leave), vec![2]),
        (Message::Membership(REFUSED), vec![3, 9, 1, 0, 0]),
        (
            Message::Mission(MissionMessage {
                mission: MissionKind::Swarm,
                payload: Payload::new(&[7, 0, 9]).unwrap(),
            }),
            vec![1, 7, 0, 9],
        ),
    ];
    for (message, bytes) in table {
        assert_eq!(encoded(&message), bytes, "{message:?}");
        assert_eq!(Message::decode(message.kind(), &bytes), Ok(message));
    }
}

#[test]
fn the_bytes_of_a_header_are_those_of_the_table() {
    let header = Header {
        kind: Kind::Report,
        from: NodeId(3),
        wave: Wave::Inward,
        place: 1,
        owner: NodeId(15),
        counter: counter(),
    };
    let bytes = [0x62, 0b1011_0011, 0x0C, 0x0B, 0x0A, 0x02, 0x01, 0x00];
    assert_eq!(header.encode(), bytes);
    let packet = [&bytes[..], &[1, 2, 3]].concat();
    assert_eq!(Header::decode(&packet), Ok((header, &packet[HEADER..])));
}

#[test]
fn the_bytes_of_what_is_sealed_are_those_of_the_tables() {
    let explore = Order::explore(MetresPerSecond(0.4));
    assert_eq!(wire::p2p::encode_order(explore), [2, 0x90, 0x01, 0]);
    let codes = [
        (Order::Wait, 1),
        (Order::Return, 3),
        (Order::Land, 4),
        (Order::Stop, 5),
        (Order::Perch, 6),
    ];
    for (task, code) in codes {
        assert_eq!(wire::p2p::encode_order(task), [code, 0, 0, 0]);
    }
    let told = [7, 1, 185, 60, 0x12, 57, 0, 0, 0x83, 0xFF, 0xE7, 25, 0x0C, 0x0B];
    assert_eq!(telemetry().encode(), told);
    assert_eq!(Telemetry::decode(&told), Ok(telemetry()));
}

proptest! {
    #![proptest_config(seeded())]

    /// A value that has been on the air once is sent and received unchanged from then on.
    #[test]
    fn whole_steps_go_and_come_unchanged(
        message in messages::messages(Flying),
        task in messages::tasks(Flying),
        telemetry in messages::telemetry(Flying),
    ) {
        let message = Message::decode(message.kind(), &encoded(&message)).unwrap();
        prop_assert_eq!(Message::decode(message.kind(), &encoded(&message)), Ok(message));
        let task = wire::p2p::decode_order(&wire::p2p::encode_order(task)).unwrap();
        prop_assert_eq!(wire::p2p::decode_order(&wire::p2p::encode_order(task)), Ok(task));
        let telemetry = Telemetry::decode(&telemetry.encode()).unwrap();
        prop_assert_eq!(Telemetry::decode(&telemetry.encode()), Ok(telemetry));
    }

    #[test]
    fn what_has_no_steps_goes_and_comes_unchanged(
        header in messages::headers(Flying),
        orders in messages::commands(Flying),
        telemetry in messages::capsules::<TELEMETRY>(Flying),
        membership in messages::memberships(Flying),
    ) {
        let bytes = header.encode();
        prop_assert_eq!(Header::decode(&bytes), Ok((header, &[][..])));
        let messages =
            [Message::Command(orders), Message::Telemetry(telemetry), Message::Membership(membership)];
        for message in messages {
            let bytes = encoded(&message);
            prop_assert_eq!(Message::decode(message.kind(), &bytes), Ok(message));
        }
    }

    #[test]
    fn numbers_of_a_report_move_by_half_a_step(report in messages::reports(Flying)) {
        let bytes = encoded(&Message::Report(report.clone()));
        let Ok(Message::Report(back)) = Message::decode(Kind::Report, &bytes) else { panic!() };
        near(back.velocity.0, report.velocity.0, 0.000_5)?;
        near(back.odometer.0, report.odometer.0, 1.0 / 1024.0)?;
        near(back.head_velocity.0, report.head_velocity.0, 0.002)?;
        for end in [|links: LinkSpan| links.weakest.0, |links: LinkSpan| links.strongest.0] {
            near_too(back.links.map(end), report.links.map(end), 0.125)?;
        }
        for (back, sum) in back.sums.into_iter().zip(report.sums) {
            near(back.surplus.0, sum.surplus.0, 1.0 / 32.0)?;
            near(back.compliance.0, sum.compliance.0, 1.0 / 2048.0)?;
            prop_assert_eq!(back.links, sum.links);
        }
        prop_assert_eq!(back.heard.len(), report.heard.len());
        for (back, heard) in back.heard.iter().zip(&report.heard) {
            near(back.rssi.0, heard.rssi.0, 0.5)?;
            let rest = |of: &Heard| (of.node, of.is_new, of.epoch);
            prop_assert_eq!(rest(back), rest(heard));
        }
        let marks = |of: &Report| (of.phase, of.recall, of.calls, of.is_uneven);
        prop_assert_eq!(marks(&back), marks(&report));
        let from = |post: Option<Signpost>| post.map(|post| post.from.0);
        near_too(from(back.signpost), from(report.signpost), 1.0 / 32.0)?;
        let rest = |post: Option<Signpost>| post.map(|post| Signpost { from: Metres(0.0), ..post });
        prop_assert_eq!(rest(back.signpost), rest(report.signpost));
    }

    #[test]
    fn numbers_of_telemetry_move_by_half_a_step(telemetry in messages::telemetry(Flying)) {
        let back = Telemetry::decode(&telemetry.encode()).unwrap();
        near_too(back.battery.map(|is| is.0), telemetry.battery.map(|is| is.0), 0.01)?;
        let seconds = |time: Option<Duration>| time.map(Duration::as_secs_f32);
        near_too(seconds(back.endurance), seconds(telemetry.endurance), 2.0)?;
        let ends = [(back.front, telemetry.front), (back.back, telemetry.back)];
        for (back, link) in ends {
            near_too(back.map(|(_, link)| link.0), link.map(|(_, link)| link.0), 0.5)?;
            prop_assert_eq!(back.map(|(node, _)| node), link.map(|(node, _)| node));
        }
        near(back.odometer.0, telemetry.odometer.0, 0.05)?;
        near(back.velocity.0, telemetry.velocity.0, 0.005)?;
        near_too(back.height.map(|is| is.0), telemetry.height.map(|is| is.0), 0.01)?;
        let rest = |of: &Telemetry| (of.state, of.fault, of.heeded);
        prop_assert_eq!(rest(&back), rest(&telemetry));
    }

    #[test]
    fn the_speed_of_a_task_moves_by_half_a_step(task in messages::tasks(Flying)) {
        match (task, wire::p2p::decode_order(&wire::p2p::encode_order(task)).unwrap()) {
            (Order::Explore(course), Order::Explore(back)) => {
                near(back.speed.0, course.speed.0, 0.000_5)?;
                prop_assert_eq!(back.branch, course.branch);
            }
            (task, back) => prop_assert_eq!(back, task),
        }
    }

    #[test]
    fn a_battery_moves_by_half_a_step(beacon in messages::beacons(Flying)) {
        let bytes = encoded(&Message::Beacon(beacon));
        let Ok(Message::Beacon(back)) = Message::decode(Kind::Beacon, &bytes) else { panic!() };
        near_too(back.battery.map(|is| is.0), beacon.battery.map(|is| is.0), 0.01)?;
        prop_assert_eq!((back.role, back.state), (beacon.role, beacon.state));
    }

    /// Whatever its numbers are, what is sent is taken, and says numbers.
    #[test]
    fn every_message_can_be_sent(
        message in messages::messages(Wild),
        header in messages::headers(Wild),
        task in messages::tasks(Wild),
        telemetry in messages::telemetry(Wild),
    ) {
        let back = Message::decode(message.kind(), &encoded(&message)).unwrap();
        prop_assert!(finite(&back));
        prop_assert!(Header::decode(&header.encode()).is_ok());
        let back = (wire::p2p::decode_order(&wire::p2p::encode_order(task)).unwrap(), Telemetry::decode(&telemetry.encode()).unwrap());
        prop_assert!(finite(&back));
    }

    #[test]
    fn any_bytes_are_a_message_or_an_error(
        kind in prop::sample::select(&Kind::ALL), bytes in prop::collection::vec(any::<u8>(), 0..70),
    ) {
        taken(kind, &bytes);
    }

    /// One message, one encoding: whatever is taken is what would have been sent.
    #[test]
    fn what_is_taken_would_be_sent_the_same(
        message in messages::messages(Flying),
        header in messages::headers(Flying),
        telemetry in messages::telemetry(Flying),
        task in messages::tasks(Flying),
        at in any::<prop::sample::Index>(),
        bits in 1_u8..,
    ) {
        for bits in [0, bits] {
            let mut bytes = encoded(&message);
            let at_byte = at.index(bytes.len());
            bytes[at_byte] ^= bits;
            taken(message.kind(), &bytes);
            let mut bytes = header.encode();
            bytes[at.index(HEADER)] ^= bits;
            taken(Kind::Beacon, &bytes);
            let mut bytes = telemetry.encode();
            bytes[at.index(TELEMETRY)] ^= bits;
            taken(Kind::Beacon, &bytes);
            let mut bytes = wire::p2p::encode_order(task);
            bytes[at.index(ORDER)] ^= bits;
            taken(Kind::Beacon, &bytes);
        }
    }

    /// Of every length that a message has not.
    #[test]
    fn a_byte_too_many_or_too_few_is_refused(message in messages::messages(Flying)) {
        let bytes = encoded(&message);
        for length in 0..=MAX_BODY + 16 {
            let mut other = bytes.clone();
            other.resize(length, 0);
            let may_be = match message.kind() {
                Kind::Report => length.is_multiple_of(5) || length % 5 == 4,
                Kind::Command => [19, 38].contains(&length),
                Kind::Mission => (1..=MAX_BODY).contains(&length),
                _ => false,
            };
            if length == bytes.len() || may_be {
                continue;
            }
            prop_assert_eq!(Message::decode(message.kind(), &other), Err(Error::Length(length)));
        }
    }

    #[test]
    fn counters_count_within_their_epoch(counter in messages::counters()) {
        prop_assert_eq!(Counter::from_bytes(counter.to_bytes()), Some(counter));
        prop_assert_eq!(Counter::new(counter.epoch(), counter.count()), Some(counter));
        prop_assert_eq!(u32::from(counter.low16()), counter.count() & 0xFFFF);
        prop_assert_eq!(Epoch::from_bytes(counter.epoch().to_bytes()), Some(counter.epoch()));
        if let Some(next) = counter.next() {
            prop_assert!(next > counter && next.epoch() == counter.epoch());
            prop_assert_eq!(next.count(), counter.count() + 1);
        }
        if let Some(epoch) = counter.epoch().next() {
            prop_assert!(Counter::new(epoch, 0).unwrap() > counter);
        }
    }
}

fn finite(message: &impl std::fmt::Debug) -> bool {
    let text = format!("{message:?}");
    !text.contains("NaN") && !text.contains("inf")
}

/// To `half` a step, and a little: steps are rounded to an f32 too.
fn near(back: f32, was: f32, half: f32) -> Result<(), TestCaseError> {
    prop_assert!((back - was).abs() <= half * 1.02 + was.abs() * 1e-7, "{back} of {was}");
    Ok(())
}

fn near_too(back: Option<f32>, was: Option<f32>, half: f32) -> Result<(), TestCaseError> {
    match (back, was) {
        (Some(back), Some(was)) => near(back, was, half),
        (back, was) => {
            prop_assert_eq!(back, was);
            Ok(())
        }
    }
}

/// If these bytes are anything, they are what would have been sent for it.
fn taken(kind: Kind, bytes: &[u8]) {
    if let Ok(message) = Message::decode(kind, bytes) {
        assert_eq!(encoded(&message), bytes, "{message:?}");
    }
    if let Ok((header, rest)) = Header::decode(bytes) {
        assert_eq!([&header.encode()[..], rest].concat(), bytes, "{header:?}");
    }
    if let Ok(task) = wire::p2p::decode_order(bytes) {
        assert_eq!(wire::p2p::encode_order(task), bytes, "{task:?}");
    }
    if let Ok(telemetry) = Telemetry::decode(bytes) {
        assert_eq!(telemetry.encode(), bytes, "{telemetry:?}");
    }
}

/// No step is lost on the way through an f32.
#[test]
fn every_step_goes_and_comes() {
    let silent = encoded(&Message::Report(messages::SILENT));
    for step in i16::MIN..=i16::MAX {
        let [low, high] = step.to_le_bytes();
        taken(Kind::Report, &[2, low, high, 0]);
        let mut report = silent.clone();
        for at in [1, 3, 10, 12, 14, 16] {
            report[at..at + 2].copy_from_slice(&[low, high]);
        }
        report[5] = low ^ high;
        // A span that begins or ends at 0 dBm; none at all in the middle.
        report[6..8].copy_from_slice(&step.min(0).to_le_bytes());
        report[8..10].copy_from_slice(&step.max(0).to_le_bytes());
        report[18] = 0x1F;
        taken(Kind::Report, &report);
        let steps = [0, 0, low, high, 0, 0, 0, 0, low, high, low, high, 0, 0];
        assert!(Telemetry::decode(&steps).is_ok());
        taken(Kind::Beacon, &steps);
        assert!(Message::decode(Kind::Report, &report).is_ok());
    }
}

/// Every single bit that is zero in all messages, and every number that another one denies.
#[test]
fn bits_without_a_meaning_are_refused() {
    let flipped = |bytes: &[u8], bit: usize| {
        let mut bytes = bytes.to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        bytes
    };
    let reserved = |message: &Message, bits: &mut dyn Iterator<Item = usize>| {
        let bytes = encoded(message);
        for bit in bits {
            let refused = Message::decode(message.kind(), &flipped(&bytes, bit));
            assert_eq!(refused, Err(Error::Reserved), "bit {bit} of {message:?}");
        }
    };
    let silent = Message::Report(messages::SILENT);
    // A weakest link above the strongest: either alone, but for the sign of the weakest and a positive
    // strongest, which are a span to 0 dBm and one from there.
    reserved(&silent, &mut (8 * 6..8 * 8 - 1).chain([8 * 10 - 1]));
    // Sums that are not there: a sum over no links has no compliance.
    reserved(&silent, &mut (8 * 12..8 * 14).chain(8 * 16..8 * 18));
    // An entry beyond the last one of its list.
    let post = Signpost { revision: 3, index: 0, count: 1, from: Metres(4.0), branch: None };
    let posted = Message::Report(Report { signpost: Some(post), ..messages::SILENT });
    reserved(&posted, &mut (8 * 21..8 * 21 + 3));
    // A sum in one direction says nothing of the other.
    for (sums, denied) in [
        ([sum(1.0, 2.0, 2), LinkSum::NONE], 8 * 16..8 * 18),
        ([LinkSum::NONE, sum(1.0, 2.0, 2)], 8 * 12..8 * 14),
    ] {
        let summed = Message::Report(Report { sums, ..messages::SILENT });
        reserved(&summed, &mut denied.into_iter());
    }
    reserved(&Message::Report(report()), &mut (4..7).flat_map(|bit| [8 * 20 + bit, 8 * 25 + bit]));
    reserved(&Message::Membership(REFUSED), &mut (8 + 4..17));
    let (node, counter) = (NodeId(5), counter());
    let command = Capsule { node, counter, sealed: [0x5E; 4], tag: [0; TAG] };
    let sealed = Capsule { node, counter, sealed: [0x5E; 14], tag: [0; TAG] };
    reserved(&Message::Command(command.into()), &mut (4..8));
    reserved(&Message::Telemetry(sealed), &mut (4..8));

    let header = Header {
        kind: Kind::Beacon,
        from: node,
        owner: node,
        wave: Wave::Outward,
        place: 0,
        counter,
    }
    .encode();
    // Node 5 with the turn of a node 17, which there is not.
    assert_eq!(Header::decode(&flipped(&header, 15)), Err(Error::Reserved));
    for task in [Order::Wait, Order::Return, Order::Land, Order::Perch, Order::Stop] {
        for bit in 8..32 {
            assert_eq!(
                wire::p2p::decode_order(&flipped(&wire::p2p::encode_order(task), bit)),
                Err(Error::Reserved)
            );
        }
    }
    let explore = wire::p2p::encode_order(Order::explore(MetresPerSecond(0.4)));
    for bit in 26..32 {
        let code = 1 << (bit - 24);
        assert_eq!(wire::p2p::decode_order(&flipped(&explore, bit)), Err(Error::Code(code)));
    }
    let lonely = Telemetry { front: None, back: None, ..telemetry() }.encode();
    let without_neighbour = (32..64).filter(|bit| ![32 + 4, 48 + 4].contains(bit));
    for bit in without_neighbour {
        assert_eq!(Telemetry::decode(&flipped(&lonely, bit)), Err(Error::Reserved), "bit {bit}");
    }
    let told = Telemetry { back: Some((NodeId(9), Dbm(-70.0))), ..telemetry() }.encode();
    for bit in (37..40).chain(53..56) {
        assert_eq!(Telemetry::decode(&flipped(&told, bit)), Err(Error::Reserved), "bit {bit}");
    }
}

#[test]
fn what_is_no_message_says_why() {
    let with = |message: &Message, at: usize, byte: u8| {
        let mut bytes = encoded(message);
        bytes[at] = byte;
        Message::decode(message.kind(), &bytes)
    };
    let beacon = Message::Beacon(Beacon { role: Role::Head, state: 0, battery: None });
    let told = Message::Report(report());
    let refused = Message::Membership(REFUSED);
    let join = Message::Membership(Membership::Join);
    let one = Capsule { node: NodeId(5), counter: counter(), sealed: [0; 4], tag: [0; TAG] };
    let command = Message::Command(one.into());
    let other = Some(Capsule { node: NodeId(6), ..one });
    let commands = Message::Command(Commands { first: one, second: other });
    let mut no_epoch = encoded(&command);
    no_epoch[4..7].fill(0);
    let table = [
        ("no such role", with(&beacon, 0, 3), Error::Code(3)),
        ("no such change", with(&join, 0, 0), Error::Code(0)),
        ("nor that", with(&join, 0, 4), Error::Code(4)),
        ("a refusal without a node", with(&join, 0, 3), Error::Length(1)),
        ("a join with a node", with(&refused, 0, 1), Error::Length(5)),
        ("a refusal of no epoch", with(&refused, 2, 0), Error::Reserved),
        ("the weakest the strongest", with(&told, 7, 0xFF), Error::Reserved),
        ("heard twice", with(&told, 25, 2), Error::Reserved),
        ("heard twice, once anew", with(&told, 25, 0x82), Error::Reserved),
        ("a sum over no links", with(&told, 18, 0), Error::Reserved),
        ("two commands for one node", with(&commands, 19, 5), Error::Reserved),
        ("one and a half", Message::decode(Kind::Command, &[0; 30]), Error::Length(30)),
        ("never switched on", Message::decode(Kind::Command, &no_epoch), Error::Reserved),
    ];
    for (what, decoded, error) in table {
        assert_eq!(decoded, Err(error), "{what}");
    }
    let header = [
        ("nothing", vec![], Error::Length(0)),
        ("a later version of another length", vec![0x72], Error::Version(7)),
        ("the version before", vec![0x52], Error::Version(5)),
        ("no such kind", vec![0x67], Error::Kind(7)),
        ("nor that", vec![0x60], Error::Kind(0)),
        ("short", vec![0x61, 0, 0, 0, 0, 1, 0], Error::Length(7)),
        ("never switched on", vec![0x61, 0, 0, 0, 0, 0, 0, 0], Error::Reserved),
        ("no such turn", vec![0x61, 0xC0, 0, 0, 0, 1, 0, 0], Error::Reserved),
        ("nor that", vec![0x61, 0x84, 0, 0, 0, 1, 0, 0], Error::Reserved),
    ];
    for (what, bytes, error) in header {
        assert_eq!(Header::decode(&bytes), Err(error), "{what}");
    }
    assert_eq!(wire::p2p::decode_order(&[0; 4]), Err(Error::Code(0)));
    assert_eq!(wire::p2p::decode_order(&[7, 0, 0, 0]), Err(Error::Code(7)));
    assert_eq!(wire::p2p::decode_order(&[1, 0, 0]), Err(Error::Length(3)));
    assert_eq!(Telemetry::decode(&[0; 15]), Err(Error::Length(15)));
}

/// Only a link of the chain has a code for each answer to whether the signal falls evenly: the eighth
/// code was the last one.
#[test]
fn each_code_of_a_phase_has_a_meaning() {
    let phases = [
        Phase::Waiting,
        Phase::Transit,
        Phase::Linked,
        Phase::Base,
        Phase::Out,
        Phase::Searching,
        Phase::Perched,
    ];
    for (code, phase) in (0..).zip(phases) {
        let even = Report { phase, ..messages::SILENT };
        let uneven = Report { is_uneven: true, ..even.clone() };
        let is_linked = phase == Phase::Linked;
        let (said, of_uneven) = if is_linked { (&uneven, 7) } else { (&even, code) };
        for (told, code, heard) in [(&even, code, &even), (&uneven, of_uneven, said)] {
            let bytes = encoded(&Message::Report(told.clone()));
            assert_eq!(bytes[0], code, "{told:?}");
            let back = Message::decode(Kind::Report, &bytes);
            assert_eq!(back, Ok(Message::Report(heard.clone())));
        }
    }
}

/// Four bytes of zeros are no links. A link of 0 dBm is heard within centimetres.
#[test]
fn links_of_0_dbm_alone_are_none() {
    let span = |weakest, strongest| {
        let links = Some(LinkSpan { weakest: Dbm(weakest), strongest: Dbm(strongest) });
        let bytes = encoded(&Message::Report(Report { links, ..messages::SILENT }));
        let Ok(Message::Report(back)) = Message::decode(Kind::Report, &bytes) else { panic!() };
        back.links.map(|links| (links.weakest.0, links.strongest.0))
    };
    assert_eq!(span(0.0, 0.0), None);
    assert_eq!(span(-0.1, 0.1), None);
    assert_eq!(span(-0.25, 0.0), Some((-0.25, 0.0)));
    assert_eq!(span(-70.5, 0.0), Some((-70.5, 0.0)));
}

#[test]
fn what_cannot_be_said_is_left_out() {
    let nan = Dbm(f32::NAN);
    let heard = [(16, Dbm(-60.0)), (3, nan), (3, Dbm(-60.0)), (4, Dbm(7.0))]
        .map(|(node, rssi)| Heard { node: NodeId(node), rssi, is_new: true, epoch: Epoch::FIRST });
    let report = Report {
        velocity: MetresPerSecond(f32::NAN),
        odometer: Metres(f32::INFINITY),
        links: Some(LinkSpan { weakest: Dbm(-50.0), strongest: Dbm(-60.0) }),
        sums: [sum(f32::NAN, 1.0, 1), sum(f32::NEG_INFINITY, -1.0, 200)],
        head_velocity: MetresPerSecond(f32::NAN),
        heard: heapless::Vec::from_iter(heard),
        ..messages::SILENT
    };
    let bytes = encoded(&Message::Report(report));
    let left = [(3, -255.0), (4, 0.0)].map(|(node, rssi)| Heard {
        node: NodeId(node),
        rssi: Dbm(rssi),
        is_new: true,
        epoch: Epoch::FIRST,
    });
    let said = Report {
        odometer: Metres(((1 << 23) - 1) as f32 / 512.0),
        sums: [LinkSum::NONE, sum(-2048.0, 0.0, 15)],
        heard: heapless::Vec::from_iter(left),
        ..messages::SILENT
    };
    assert_eq!(Message::decode(Kind::Report, &bytes), Ok(Message::Report(said)));

    let low = Telemetry {
        battery: Some(Volts(-1.0)),
        endurance: Some(Duration::MAX),
        front: Some((NodeId(16), Dbm(-60.0))),
        back: Some((NodeId(15), Dbm(-300.0))),
        height: Some(Metres(9.0)),
        ..telemetry()
    };
    let said = Telemetry {
        battery: Some(Volts(0.02)),
        endurance: Some(Duration::from_secs(1016)),
        front: None,
        back: Some((NodeId(15), Dbm(-255.0))),
        height: Some(Metres(5.08)),
        ..low
    };
    assert_eq!(Telemetry::decode(&low.encode()), Ok(said));
}

/// A number beyond its bytes becomes the largest or the smallest of them, and one that is none makes
/// its sum a sum over no links.
#[test]
fn the_numbers_of_a_sum_saturate() {
    let (most, least) = (32767.0 / 16.0, -2048.0);
    let table = [
        (sum(most, 65535.0 / 1024.0, 15), sum(most, 65535.0 / 1024.0, 15)),
        (sum(3000.0, 64.0, 16), sum(most, 65535.0 / 1024.0, 15)),
        (sum(f32::INFINITY, f32::INFINITY, u8::MAX), sum(most, 65535.0 / 1024.0, 15)),
        (sum(-3000.0, -0.1, 1), sum(least, 0.0, 1)),
        (sum(f32::NEG_INFINITY, f32::NEG_INFINITY, 1), sum(least, 0.0, 1)),
        (sum(-0.0, -0.0, 1), sum(0.0, 0.0, 1)),
        // A head's chain is too short by 1 m.
        (sum(1.0, 1.0, 0), sum(1.0, 0.0, 0)),
        (sum(f32::NAN, 1.0, 3), LinkSum::NONE),
        (sum(1.0, f32::NAN, 3), LinkSum::NONE),
        (sum(f32::NAN, f32::NAN, 0), LinkSum::NONE),
    ];
    for (told, heard) in table {
        for sums in [[told, LinkSum::NONE], [LinkSum::NONE, told], [told; 2]] {
            let expected = sums.map(|sum| if sum == LinkSum::NONE { sum } else { heard });
            let bytes = encoded(&Message::Report(Report { sums, ..messages::SILENT }));
            let Ok(Message::Report(back)) = Message::decode(Kind::Report, &bytes) else { panic!() };
            assert_eq!(back.sums, expected, "{told:?}");
        }
    }
}

#[test]
fn the_heads_velocity_saturates() {
    let table = [
        (0.508, 0.508),
        (0.6, 0.508),
        (f32::INFINITY, 0.508),
        (-0.508, -0.508),
        (-0.6, -0.512),
        (f32::NEG_INFINITY, -0.512),
        (f32::NAN, 0.0),
    ];
    for (told, heard) in table {
        let head_velocity = MetresPerSecond(told);
        let bytes = encoded(&Message::Report(Report { head_velocity, ..messages::SILENT }));
        let Ok(Message::Report(back)) = Message::decode(Kind::Report, &bytes) else { panic!() };
        assert_eq!(back.head_velocity, MetresPerSecond(heard), "{told}");
    }
}

/// A message has one encoding: a step that no velocity becomes is either refused or sent again.
#[test]
fn every_step_of_the_heads_velocity_goes_and_comes() {
    let mut report = encoded(&Message::Report(messages::SILENT));
    for step in i8::MIN..=i8::MAX {
        report[19] = step.to_le_bytes()[0];
        taken(Kind::Report, &report);
    }
}

#[test]
fn the_longest_report_fits() {
    let one =
        |node| Heard { node: NodeId(node), rssi: Dbm(-60.0), is_new: true, epoch: Epoch::FIRST };
    let heard = (0..HEARD as u8).map(one).collect();
    let bytes = encoded(&Message::Report(Report { heard, ..report() }));
    assert_eq!(bytes.len(), 20 + 5 * HEARD);
    let one_more = [&bytes[..], &[15, 60, 1, 0, 0]].concat();
    assert_eq!(Message::decode(Kind::Report, &one_more), Err(Error::Length(45)));
}

/// The stamp never goes back, nor past the last count.
#[test]
fn a_counter_is_stamped_with_the_time() {
    let at = |steps: u64| Instant::from_micros(steps * STAMP_US + 1);
    let counter = |count| Counter::new(Epoch::FIRST, count).unwrap();
    assert_eq!(counter(5).stamped(at(900)), Some(counter(900)));
    assert_eq!(counter(901).stamped(at(900)), Some(counter(901)));
    assert_eq!(counter(5).stamped(at(1 << 24)), None);
    assert_eq!((counter(900).delay(at(907)), counter(900).delay(at(893))), (7, -7));
}

#[test]
fn epochs_and_counts_end() {
    assert_eq!(Epoch::new(0), None);
    assert_eq!(Epoch::new(1), Some(Epoch::FIRST));
    assert_eq!(Epoch::new(1 << 24), None);
    let last = Epoch::new((1 << 24) - 1).unwrap();
    assert_eq!(last.next(), None);
    assert_eq!(Counter::new(last, 1 << 24), None);
    assert_eq!(Counter::new(last, (1 << 24) - 1).unwrap().next(), None);
    assert_eq!(Counter::from_bytes([1, 0, 0, 0, 0, 0]), None);
    assert_eq!(Epoch::FIRST.next().map(Epoch::get), Some(2));
}
