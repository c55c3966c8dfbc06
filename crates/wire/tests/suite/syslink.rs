//! The line to the radio chip: what is sent is what arrives, noise costs nothing but itself, and no
//! bytes do harm.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Dbm, Volts};
use wire::radio::{Address, Channel, Datarate, TxPower};
use wire::syslink::{
    Battery, Decoder, EncodeError, Incoming, MAX_DATA, MAX_FRAME, MAX_P2P, MAX_RAW, Malformed,
    Outgoing, Port, Release,
};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// A frame, put together here and not by the code under test.
fn frame(kind: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xBC, 0xCF, kind, u8::try_from(data.len()).unwrap()];
    bytes.extend(data);
    let (mut a, mut b) = (0_u8, 0_u8);
    for byte in &bytes[2..] {
        a = a.wrapping_add(*byte);
        b = b.wrapping_add(a);
    }
    bytes.extend([a, b]);
    bytes
}

/// The frames that the decoder finds when `bytes` arrive in pieces of `chunk`.
fn decoded(decoder: &mut Decoder, bytes: &[u8], chunk: usize) -> Vec<(u8, Vec<u8>)> {
    let mut found = Vec::new();
    for mut piece in bytes.chunks(chunk) {
        while let Some(frame) = decoder.next(&mut piece) {
            found.push((frame.kind, frame.data.to_vec()));
        }
        assert!(piece.is_empty());
    }
    found
}

/// The packet in a frame.
fn parsed(bytes: &[u8], check: impl FnOnce(Result<Incoming<'_>, Malformed>)) {
    let mut decoder = Decoder::new();
    let mut line = bytes;
    check(Incoming::parse(&decoder.next(&mut line).unwrap()));
}

/// As the radio chip sends it.
fn sent_by_radio(packet: &Incoming<'_>) -> Vec<u8> {
    match packet {
        Incoming::Raw(data) => frame(0x00, data),
        Incoming::RawBroadcast(data) => frame(0x06, data),
        Incoming::Channel(channel) => frame(0x01, &[channel.number()]),
        Incoming::Datarate(rate) => frame(0x02, &[*rate as u8]),
        Incoming::Address(Address([a, b, c, d, e])) => frame(0x05, &[*e, *d, *c, *b, *a]),
        Incoming::Power(power) => frame(0x07, &[power.dbm().0 as i8 as u8]),
        Incoming::Rssi(rssi) => frame(0x04, &[rssi.map_or(0, |rssi| -rssi.0 as u8)]),
        Incoming::P2p { port, rssi, data } => {
            frame(0x08, &[&[port.number(), -rssi.0 as u8], *data].concat())
        }
        Incoming::P2pBroadcast { port, rssi, data } => {
            frame(0x0A, &[&[port.number(), -rssi.0 as u8], *data].concat())
        }
        Incoming::Battery(battery) => {
            let flags = u8::from(battery.charging) | u8::from(battery.usb) << 1;
            let mut data = vec![flags];
            data.extend(battery.voltage.0.to_le_bytes());
            // The charger's current.
            data.extend(250_f32.to_le_bytes());
            frame(0x13, &data)
        }
        Incoming::ShutdownRequest => frame(0x15, &[]),
        Incoming::NrfVersion(text) => frame(0x30, &[*text, &[0]].concat()),
        Incoming::Unknown(kind) => frame(*kind, &[]),
    }
}

/// As the radio chip receives it.
fn received_by_radio(packet: &Outgoing<'_>) -> (u8, Vec<u8>) {
    match packet {
        Outgoing::Raw(data) => (0x00, data.to_vec()),
        Outgoing::Channel(channel) => (0x01, vec![channel.number()]),
        Outgoing::Datarate(rate) => (0x02, vec![*rate as u8]),
        Outgoing::Address(Address([a, b, c, d, e])) => (0x05, vec![*e, *d, *c, *b, *a]),
        Outgoing::Power(power) => (0x07, vec![power.dbm().0 as i8 as u8]),
        Outgoing::P2pBroadcast { port, data } => (0x0A, [&[port.number()], *data].concat()),
        Outgoing::RadioReady => (0x0B, vec![]),
        Outgoing::BatteryAutoupdate => (0x14, vec![]),
        Outgoing::ShutdownAck => (0x16, vec![]),
        Outgoing::NrfVersion => (0x30, vec![]),
    }
}

const RATES: [Datarate; 3] = [Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2];

fn ports() -> impl Strategy<Value = Port> {
    (0_u8..16).prop_map(|number| Port::new(number).unwrap())
}

fn channels() -> impl Strategy<Value = Channel> {
    (0_u8..126).prop_map(|number| Channel::new(number).unwrap())
}

fn rates() -> impl Strategy<Value = Datarate> {
    prop::sample::select(&RATES)
}

fn powers() -> impl Strategy<Value = TxPower> {
    prop::sample::select(&TxPower::ALL)
}

fn bytes(most: usize) -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..=most)
}

fn batteries() -> impl Strategy<Value = Battery> {
    (any::<bool>(), any::<bool>(), -10f32..10.0).prop_map(|(charging, usb, voltage)| Battery {
        charging,
        usb,
        voltage: Volts(voltage),
    })
}

/// Packets of the radio chip with their data, which they borrow.
fn incoming(pick: u8, data: &[u8], parts: Parts) -> Incoming<'_> {
    let p2p = &data[..data.len().min(MAX_P2P)];
    let rssi = Dbm(-f32::from(parts.sample));
    match pick {
        0 => Incoming::Raw(data),
        1 => Incoming::Channel(parts.channel),
        2 => Incoming::Datarate(parts.rate),
        3 => Incoming::Address(parts.address),
        4 => Incoming::Power(parts.power),
        5 => Incoming::Rssi((parts.sample != 0).then_some(rssi)),
        6 => Incoming::P2pBroadcast { port: parts.port, rssi, data: p2p },
        7 => Incoming::Battery(parts.battery),
        8 => Incoming::ShutdownRequest,
        9 => Incoming::NrfVersion(p2p.split(|byte| *byte == 0).next().unwrap()),
        10 => Incoming::P2p { port: parts.port, rssi, data: p2p },
        11 => Incoming::RawBroadcast(data),
        _ => Incoming::Unknown(0xF0),
    }
}

fn outgoing(pick: u8, data: &[u8], parts: Parts) -> Outgoing<'_> {
    match pick {
        0 if data.is_empty() => Outgoing::Raw(&[0xFF]),
        0 => Outgoing::Raw(&data[..data.len().min(MAX_RAW)]),
        1 => Outgoing::Channel(parts.channel),
        2 => Outgoing::Datarate(parts.rate),
        3 => Outgoing::Address(parts.address),
        4 => Outgoing::Power(parts.power),
        5 => Outgoing::P2pBroadcast { port: parts.port, data: &data[..data.len().min(MAX_P2P)] },
        6 => Outgoing::RadioReady,
        7 => Outgoing::BatteryAutoupdate,
        8 => Outgoing::ShutdownAck,
        _ => Outgoing::NrfVersion,
    }
}

/// The values that packets are made of.
#[derive(Clone, Copy, Debug)]
struct Parts {
    channel: Channel,
    rate: Datarate,
    address: Address,
    power: TxPower,
    port: Port,
    sample: u8,
    battery: Battery,
}

fn parts() -> impl Strategy<Value = Parts> {
    let address = any::<[u8; 5]>().prop_map(Address);
    (channels(), rates(), address, powers(), ports(), 0_u8..128, batteries()).prop_map(
        |(channel, rate, address, power, port, sample, battery)| Parts {
            channel,
            rate,
            address,
            power,
            port,
            sample,
            battery,
        },
    )
}

/// A stretch of the line.
#[derive(Clone, Debug)]
enum Stretch {
    Good(u8, Vec<u8>),
    Noise(Vec<u8>),
}

fn stretches() -> impl Strategy<Value = Vec<Stretch>> {
    let good = (any::<u8>(), bytes(MAX_DATA)).prop_map(|(kind, data)| Stretch::Good(kind, data));
    let noise = bytes(20).prop_map(Stretch::Noise);
    // Half a start, a start, a header that promises data, and a frame that breaks off.
    let false_start = prop_oneof![
        Just(vec![0xBC]),
        Just(vec![0xBC, 0xCF]),
        (any::<u8>(), 0_u8..70).prop_map(|(kind, length)| vec![0xBC, 0xCF, kind, length]),
        (any::<u8>(), bytes(MAX_DATA), 1_usize..60).prop_map(|(kind, data, cut)| {
            let whole = frame(kind, &data);
            whole[..whole.len().saturating_sub(cut).max(1)].to_vec()
        }),
    ]
    .prop_map(Stretch::Noise);
    prop::collection::vec(prop_oneof![3 => good, 1 => noise, 2 => false_start], 0..30)
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn what_the_radio_chip_says_is_understood(
        pick in 0_u8..13, data in bytes(MAX_DATA), parts in parts(),
    ) {
        let packet = incoming(pick, &data, parts);
        parsed(&sent_by_radio(&packet), |understood| assert_eq!(understood, Ok(packet)));
    }

    #[test]
    fn what_is_said_to_the_radio_chip_arrives(
        pick in 0_u8..10, data in bytes(MAX_DATA), parts in parts(), room in 0..=MAX_FRAME,
    ) {
        let packet = outgoing(pick, &data, parts);
        let mut out = [0; MAX_FRAME];
        let length = packet.encode(&mut out).unwrap();
        let (kind, data) = received_by_radio(&packet);
        prop_assert_eq!(&out[..length], frame(kind, &data));
        // With less room it is refused, and nothing is written.
        let mut small = vec![0xAA; room];
        match packet.encode(&mut small) {
            Ok(wrote) => prop_assert!(wrote == length && wrote <= room),
            Err(error) => {
                prop_assert!(error == EncodeError::NoRoom && length > room);
                prop_assert!(small.iter().all(|byte| *byte == 0xAA));
            }
        }
    }

    /// The claim of the decoder: each good frame is handed on, in order, whatever lies between.
    #[test]
    fn no_noise_costs_a_good_frame(stretches in stretches(), chunk in 1_usize..80) {
        let mut line = Vec::new();
        let mut expected = Vec::new();
        for stretch in &stretches {
            match stretch {
                Stretch::Good(kind, data) => {
                    line.extend(frame(*kind, data));
                    expected.push((*kind, data.clone()));
                }
                Stretch::Noise(bytes) => line.extend(bytes),
            }
        }
        // The last false start waits for what it promised.
        line.extend([0; MAX_FRAME]);
        let mut decoder = Decoder::new();
        let found = decoded(&mut decoder, &line, chunk);
        let mut rest = found.iter();
        for frame in &expected {
            prop_assert!(rest.any(|other| other == frame), "{frame:?} is lost");
        }
        prop_assert_eq!(decoder.counters().good as usize, found.len());
    }

    #[test]
    fn it_does_not_matter_how_the_bytes_are_cut_up(
        stretches in stretches(), chunk in 1_usize..80,
    ) {
        let line: Vec<u8> = stretches
            .iter()
            .flat_map(|stretch| match stretch {
                Stretch::Good(kind, data) => frame(*kind, data),
                Stretch::Noise(bytes) => bytes.clone(),
            })
            .collect();
        let (mut one, mut other) = (Decoder::new(), Decoder::new());
        prop_assert_eq!(decoded(&mut one, &line, line.len().max(1)),
            decoded(&mut other, &line, chunk));
        prop_assert_eq!(one.counters(), other.counters());
    }

    #[test]
    fn any_bytes_end_in_a_value_or_an_error(line in bytes(2000), kind in any::<u8>(),
        data in bytes(MAX_DATA))
    {
        let mut decoder = Decoder::new();
        let mut rest: &[u8] = &line;
        while let Some(frame) = decoder.next(&mut rest) {
            let _ = Incoming::parse(&frame);
        }
        parsed(&frame(kind, &data), |_| ());
    }
}

/// Lines with noise: what is found at once, without more bytes coming, and what is counted.
#[test]
fn the_decoder_finds_its_way_back() {
    let ready = frame(0x0B, &[]);
    let rssi = frame(0x04, &[57]);
    let mut broken = rssi.clone();
    broken[4] ^= 1;
    // (what, line, types found, bad checksums, resyncs)
    type Row<'a> = (&'a str, Vec<u8>, &'a [u8], u32, u32);
    let table: [Row<'_>; 9] = [
        ("nothing", vec![], &[], 0, 0),
        ("two frames", [&rssi[..], &ready].concat(), &[0x04, 0x0B], 0, 0),
        ("noise first", [&[1, 2, 3], &rssi[..]].concat(), &[0x04], 0, 1),
        ("half a start", [&[0xBC], &rssi[..]].concat(), &[0x04], 0, 1),
        ("a start twice", [&[0xBC, 0xCF], &rssi[..]].concat(), &[0x04], 0, 1),
        ("too long", [&[0xBC, 0xCF, 0, 65], &rssi[..]].concat(), &[0x04], 0, 1),
        ("broken", [&broken[..], &rssi].concat(), &[0x04], 1, 1),
        ("a frame in a false one", [&[0xBC, 0xCF, 0, 5], &rssi[..]].concat(), &[0x04], 1, 1),
        ("two disturbances", [&[9], &rssi[..], &[9, 9], &ready].concat(), &[0x04, 0x0B], 0, 2),
    ];
    for (what, line, kinds, bad_checksums, resyncs) in table {
        let mut decoder = Decoder::new();
        let found = decoded(&mut decoder, &line, 1);
        assert_eq!(found.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), kinds, "{what}");
        let counters = decoder.counters();
        assert_eq!(counters.good as usize, kinds.len(), "{what}");
        assert_eq!((counters.bad_checksums, counters.resyncs), (bad_checksums, resyncs), "{what}");
    }
}

#[test]
fn a_long_false_start_delays_what_it_hides_and_no_more() {
    let rssi = frame(0x04, &[57]);
    let mut line = vec![0xBC, 0xCF, 0x00, 64];
    while line.len() + rssi.len() <= MAX_FRAME {
        line.extend(&rssi);
    }
    let hidden = (line.len() - 4) / rssi.len();
    line.resize(MAX_FRAME - 1, 0);
    let mut decoder = Decoder::new();
    assert!(decoded(&mut decoder, &line, 7).is_empty());
    assert_eq!(decoded(&mut decoder, &[0], 7).len(), hidden);
}

#[test]
fn data_that_a_type_does_not_allow_is_malformed() {
    let nan = f32::NAN.to_le_bytes();
    let long = [0; 2 + MAX_P2P + 1];
    let cases: [(u8, &[u8]); 20] = [
        (0x01, &[]),
        (0x01, &[126]),
        (0x01, &[80, 0]),
        (0x02, &[3]),
        (0x04, &[]),
        (0x04, &[128]),
        (0x05, &[0xE7; 4]),
        (0x05, &[0xE7; 6]),
        (0x07, &[1]),
        (0x08, &[]),
        (0x08, &[0]),
        (0x08, &[0, 128]),
        (0x08, &long),
        (0x0A, &[]),
        (0x0A, &[0]),
        (0x0A, &[16, 40]),
        (0x0A, &long),
        (0x13, &[]),
        (0x13, &[0; 10]),
        (0x13, &[0, 0, 0, 0, 0, nan[0], nan[1], nan[2], nan[3]]),
    ];
    for (kind, data) in cases {
        parsed(&frame(kind, data), |understood| {
            assert_eq!(understood, Err(Malformed(kind)), "{data:?}");
        });
    }
}

#[test]
fn packets_that_carry_too_much_or_nothing_are_refused() {
    let port = Port::new(2).unwrap();
    let mut out = [0; 2 * MAX_FRAME];
    for packet in [
        Outgoing::Raw(&[]),
        Outgoing::Raw(&[0; MAX_RAW + 1]),
        Outgoing::P2pBroadcast { port, data: &[0; MAX_P2P + 1] },
    ] {
        assert_eq!(packet.encode(&mut out), Err(EncodeError::Length));
    }
    assert_eq!(Port::new(16), None);
}

#[test]
fn a_release_is_what_a_version_begins_with() {
    let release = |year, month| Some(Release { year, month });
    for (text, expected) in [
        (&b"2025.02 (CF21)"[..], release(2025, 2)),
        (b"2022.01", release(2022, 1)),
        (b"2022.01.1 (CF21)", release(2022, 1)),
        (b"2021.06-12-g1a2b3c4*", release(2021, 6)),
        (b"2021.06*", release(2021, 6)),
        (b"2021.13", None),
        (b"2021.00", None),
        (b"2021.061", None),
        (b"021.06", None),
        (b"NA", None),
        (b"", None),
    ] {
        assert_eq!(Release::parse(text), expected, "{}", text.escape_ascii());
    }
    assert!(Release { year: 2021, month: 12 } < Release { year: 2022, month: 1 });
}
