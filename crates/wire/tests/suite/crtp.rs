//! Packets between clients and drones: the bytes are those of cflib and of the vendor's
//! firmware, what is encoded is what is read, and no bytes do harm.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Duration, Instant, Metres, MetresPerSecond, Radians, RadiansPerSecond};
use wire::crtp::{
    Entry, Errno, Error, Fix, HighLevel, LinkRequest, LogData, LogRequest, LogType, MAX_DATA,
    MemoryRequest, Packet, ParamRequest, ParamType, PlatformRequest, Port, Positions, Reply,
    Request, Rpyt, Setpoint, SupervisorCommand, SupervisorQuestion, Value,
};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

/// Header and data from hexadecimal digits.
fn packet(hex: &str) -> Packet {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    let bytes: Vec<u8> = digits
        .chunks(2)
        .map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect();
    Packet::from_bytes(&bytes).unwrap()
}

fn hex(packet: &Packet) -> String {
    packet.bytes().iter().map(|byte| format!("{byte:02X}")).collect()
}

/// As cflib 0.1.34 packs them, and older clients did.
#[test]
fn requests_are_read_as_cflib_sends_them() {
    let table: &[(&str, Request<'_>)] = &[
        ("FF", Request::Null),
        ("FD 00", Request::Link(LinkRequest::Source)),
        ("FC 00 0102", Request::Link(LinkRequest::Echo(&[0, 1, 2]))),
        ("FE", Request::Link(LinkRequest::Sink)),
        ("DD 00", Request::Platform(PlatformRequest::Protocol)),
        ("DD 01", Request::Platform(PlatformRequest::Firmware)),
        ("DD 02", Request::Platform(PlatformRequest::DeviceType)),
        ("DC 00 01", Request::Platform(PlatformRequest::ContinuousWave)),
        ("DC 03 01", Request::Platform(PlatformRequest::Notify)),
        ("DC 01 01", Request::OldCommand(SupervisorCommand::Arm(true))),
        ("DE 4142", Request::Platform(PlatformRequest::Application(b"AB"))),
        ("5D 05", Request::Log(LogRequest::Reset)),
        ("5C 03", Request::Log(LogRequest::TableInfo)),
        ("5C 02 3412", Request::Log(LogRequest::TableItem(0x1234))),
        ("5D 02 07", Request::Log(LogRequest::Delete(7))),
        ("5D 04 07", Request::Log(LogRequest::Stop(7))),
        (
            "5D 03 07 0A",
            Request::Log(LogRequest::Start {
                block: 7,
                period: Duration::from_millis(100),
                command: 3,
            }),
        ),
        (
            "5D 08 07 E803",
            Request::Log(LogRequest::Start {
                block: 7,
                period: Duration::from_millis(1000),
                command: 8,
            }),
        ),
        ("5D 00 07", Request::Log(LogRequest::Unknown { command: 0, block: 7 })),
        ("5D 03 07", Request::Log(LogRequest::Unknown { command: 3, block: 7 })),
        ("4C 01", Request::Memory(MemoryRequest::Count)),
        ("4C 02 03", Request::Memory(MemoryRequest::Info(3))),
        (
            "4D 01 78563412 14",
            Request::Memory(MemoryRequest::Read { memory: 1, address: 0x1234_5678 }),
        ),
        (
            "4E 01 78563412 AA",
            Request::Memory(MemoryRequest::Write { memory: 1, address: 0x1234_5678 }),
        ),
        ("2C 03", Request::Param(ParamRequest::TableInfo)),
        ("2C 02 0100", Request::Param(ParamRequest::TableItem(1))),
        ("2D 0201", Request::Param(ParamRequest::Read(0x0102))),
        ("2E 0201 07", Request::Param(ParamRequest::Write { id: 0x0102, value: &[7] })),
        ("2F 02 0300", Request::Param(ParamRequest::ExtendedType { id: 3, with_status: false })),
        ("2F 03 0300", Request::Param(ParamRequest::Store(3))),
        ("2F 04 0300", Request::Param(ParamRequest::StoredState(3))),
        ("2F 05 0300", Request::Param(ParamRequest::Clear(3))),
        ("2F 06 0300", Request::Param(ParamRequest::Default { id: 3, with_status: false })),
        ("2F 07 0300", Request::Param(ParamRequest::ExtendedType { id: 3, with_status: true })),
        ("2F 08 0300", Request::Param(ParamRequest::Default { id: 3, with_status: true })),
        (
            "2F 00 6100 626300 08 05",
            Request::Param(ParamRequest::SetByName {
                group: b"a",
                name: b"bc",
                kind: 8,
                value: &[5],
            }),
        ),
        ("7C 00", Request::Setpoint(Setpoint::Stop)),
        ("7C 06 0000", Request::Setpoint(Setpoint::Other(6))),
        ("7D 00 E8030000", Request::SetpointsEnd(1000)),
        (
            "8C 07 00 9A99993E 00000000 00 0000803F",
            Request::HighLevel(HighLevel::TakeOff { group: 0 }),
        ),
        (
            "8C 08 00 00000000 00000000 00 0000803F",
            Request::HighLevel(HighLevel::Land { group: 0 }),
        ),
        ("8C 03 05", Request::HighLevel(HighLevel::Stop { group: 5 })),
        ("8C 0C 00", Request::HighLevel(HighLevel::Other(12))),
        ("9C 0C", Request::Supervisor(SupervisorQuestion::All)),
        ("9C 05", Request::Supervisor(SupervisorQuestion::Bit(4))),
        ("9D 01 00", Request::Command(SupervisorCommand::Arm(false))),
        ("9D 02", Request::Command(SupervisorCommand::Recover)),
        ("9D 03", Request::Command(SupervisorCommand::EmergencyStop)),
        ("9D 04", Request::Command(SupervisorCommand::EmergencyStopWatchdog)),
        ("6D 03", Request::OldCommand(SupervisorCommand::EmergencyStop)),
        ("6D 04", Request::OldCommand(SupervisorCommand::EmergencyStopWatchdog)),
        ("6C 0000803F 000000C0 0000003F", Request::Positions(Positions::Own(fix(None)))),
    ];
    for (bytes, request) in table {
        assert_eq!(Request::parse(&packet(bytes)).as_ref(), Ok(request), "{bytes}");
    }
}

/// A place with this heading.
fn fix(yaw: Option<f32>) -> Fix {
    Fix { at: [1.0, -2.0, 0.5].map(Metres), yaw: yaw.map(Radians) }
}

#[test]
fn a_position_of_a_client_in_each_of_its_four_formats() {
    let quarter = core::f32::consts::FRAC_PI_2;
    let of = |bytes: &str, number| match Request::parse(&packet(bytes)) {
        Ok(Request::Positions(positions)) => positions.of(number),
        other => panic!("{bytes} is {other:?}"),
    };
    let is_fix = |found: Option<Fix>, yaw: Option<f32>| {
        let Fix { at, yaw: found } = found.expect("a position");
        let is_near = |a: f32, b: f32| (a - b).abs() < 2e-3;
        assert_eq!(found.is_some(), yaw.is_some());
        assert!(is_near(found.map_or(0.0, |yaw| yaw.0), yaw.unwrap_or_default()), "{found:?}");
        assert!(at.iter().zip(fix(None).at).all(|(a, b)| is_near(a.0, b.0)), "{at:?}");
    };
    is_fix(of("6C 0000803F 000000C0 0000003F", 3), None);
    // A quarter turn to the left: x, y, z and w, √½ each of the last two.
    let turned = "6D 08 0000803F 000000C0 0000003F 00000000 00000000 F304353F F304353F";
    is_fix(of(turned, 3), Some(quarter));
    // Drones 3 and 4 in millimetres.
    let two = "6E 03 E803 30F8 F401 04 0000 0000 0000";
    is_fix(of(two, 3), None);
    assert_eq!(of(two, 4).map(|fix| fix.at), Some([Metres(0.0); 3]));
    assert_eq!(of(two, 5), None);
    // The same turn in 32 bits: z is the largest, w the last of the three others, 511 of 511.
    is_fix(of("6D 09 03 E803 30F8 F401 FF010080", 3), Some(quarter));
}

#[test]
fn a_position_that_is_none_is_refused() {
    for (bytes, error) in [
        ("6C 0000C07F 000000C0 0000003F", Error::Value),
        // 200 m from the origin.
        ("6C 00004843 000000C0 0000003F", Error::Value),
        ("6C 0000803F 000000C0", Error::Length(8)),
        // A rotation of no length.
        ("6D 08 0000803F 000000C0 0000003F 00000000 00000000 00000000 00000000", Error::Value),
        ("6E 03 E803", Error::Length(0)),
        ("6D 07", Error::Command(7)),
    ] {
        assert_eq!(Request::parse(&packet(bytes)), Err(error), "{bytes}");
    }
}

#[test]
fn old_and_new_set_points_turn_the_same_way() {
    // 0.5 m/s forward, 0.25 m/s to the left, 90 °/s counter-clockwise, 0.3 m up, as cflib sends it
    // to new firmware and to old.
    let hover = Setpoint::Hover {
        forward: MetresPerSecond(0.5),
        lateral: MetresPerSecond(0.25),
        yaw_rate: RadiansPerSecond(90.0 * (core::f32::consts::PI / 180.0)),
        height: Metres(0.3),
    };
    let new = packet("7C 0A 0000003F 0000803E 0000B442 9A99993E");
    let old = packet("7C 05 0000003F 0000803E 0000B4C2 9A99993E");
    assert_eq!(Request::parse(&new), Ok(Request::Setpoint(hover)));
    assert_eq!(Request::parse(&old), Ok(Request::Setpoint(hover)));
    assert_eq!(Request::Setpoint(hover).packet(), new);
    for (old, new) in [(1, 8), (2, 9)] {
        let of = |kind: u8, turn: &str| {
            let rest = if kind == old && old == 1 || kind == 8 {
                format!("0000803E {turn}")
            } else {
                format!("{turn} 0000803E")
            };
            packet(&format!("7C {kind:02X} 0000003F 0000803E {rest}"))
        };
        let (a, b) = (of(old, "0000B4C2"), of(new, "0000B442"));
        assert_eq!(Request::parse(&a), Request::parse(&b));
        assert!(Request::parse(&a).is_ok());
    }
}

#[test]
fn an_entry_that_is_not_whole_is_left_for_the_next_packet() {
    // cflib fills a packet up with the type of the entry that no longer fits.
    let mut bytes = vec![0x5D, 6, 1];
    for variable in 0..9_u8 {
        bytes.extend([0x77, variable, 0]);
    }
    bytes.push(0x71);
    let packet = Packet::from_bytes(&bytes).unwrap();
    let Ok(Request::Log(LogRequest::Create { block: 1, entries })) = Request::parse(&packet) else {
        panic!("no block");
    };
    let entries: Vec<Entry> = entries.iter().collect();
    assert_eq!(entries.len(), 9);
    assert_eq!(entries[8], Entry { kind: 7, variable: 8 });
}

#[test]
fn what_is_no_request_says_why() {
    let table = [
        ("1C 00", Error::Port(1)),
        ("EC 00", Error::Port(14)),
        ("0C 41", Error::Channel(0)),
        ("3D 00", Error::Channel(1)),
        ("4F 00", Error::Channel(3)),
        ("5F 00", Error::Channel(3)),
        ("7F 00", Error::Channel(3)),
        ("6F 00", Error::Channel(3)),
        ("9E 00", Error::Channel(2)),
        ("2C", Error::Length(0)),
        ("2C 02 01", Error::Length(2)),
        ("2C 00 00", Error::Command(0)),
        ("2D 01", Error::Length(1)),
        ("2E 01", Error::Length(1)),
        ("2F 00 61 00 62", Error::Length(4)),
        ("2F 00 6100 6200", Error::Length(5)),
        ("2F 01 0000", Error::Command(1)),
        ("2F 06 00", Error::Length(2)),
        ("3C 00", Error::Length(1)),
        ("4D 01 00000000", Error::Length(5)),
        ("5C 01", Error::Command(1)),
        ("5D", Error::Length(0)),
        ("7C", Error::Length(0)),
        ("7C 0A 00000000 00000000 00000000", Error::Length(12)),
        ("7C 0A 00000000 00000000 00000000 0000C07F", Error::Value),
        ("7C 0A 0000807F 00000000 00000000 00000000", Error::Value),
        ("7C 0A F9021550 00000000 00000000 00000000", Error::Value),
        ("7D 01", Error::Command(1)),
        ("8C 07", Error::Length(1)),
        ("9C 00", Error::Command(0)),
        ("9C 0D", Error::Command(13)),
        ("9D 05", Error::Command(5)),
        ("9D 01", Error::Length(1)),
        ("DC 04", Error::Command(4)),
        ("DD 03", Error::Command(3)),
        ("DF 00", Error::Channel(3)),
    ];
    for (bytes, error) in table {
        assert_eq!(Request::parse(&packet(bytes)), Err(error), "{bytes}");
    }
    assert_eq!(Packet::from_bytes(&[]), Err(Error::Length(0)));
    assert_eq!(Packet::from_bytes(&[0; 32]), Err(Error::Length(32)));
    assert_eq!(Packet::new(Port::Link, 4, &[]), Err(Error::Channel(4)));
    assert_eq!(Packet::new(Port::Link, 0, &[0; 31]), Err(Error::Length(31)));
}

#[test]
fn replies_are_those_of_the_vendors_firmware() {
    let group = "stateEstimate";
    let table: &[(Reply<'_>, &str)] = &[
        (Reply::Console(b"hi"), "0C 6869"),
        (
            Reply::LogTable { count: 0x0102, crc: 0x1234_5678, blocks: 16, entries: 128 },
            "5C 03 0201 78563412 10 80",
        ),
        (
            Reply::LogVariable { id: 5, kind: LogType::F32, group, name: "vx" },
            "5C 02 0500 07 7374617465457374696D61746500 767800",
        ),
        (Reply::NoLogVariable, "5C 02"),
        (Reply::LogControl { command: 6, block: 3, outcome: Ok(()) }, "5D 06 03 00"),
        (Reply::LogControl { command: 6, block: 3, outcome: Err(Errno::Exists) }, "5D 06 03 11"),
        (Reply::ParamTable { count: 3, crc: 1 }, "2C 03 0300 01000000"),
        (
            Reply::Param { id: 1, kind: ParamType::U16, read_only: true, group: "a", name: "b" },
            "2C 02 0100 49 6100 6200",
        ),
        (Reply::NoParam, "2C 02"),
        (Reply::ParamRead { id: 2, value: Ok(Value::F32(0.3)) }, "2D 0200 00 9A99993E"),
        (Reply::ParamRead { id: 2, value: Err(Errno::Missing) }, "2D 0200 02"),
        (Reply::ParamWritten { id: 2, value: Ok(Value::I16(-2)) }, "2E 0200 FEFF"),
        (Reply::ParamWritten { id: 2, value: Err(Errno::Missing) }, "2E 0200 02"),
        (
            Reply::ParamSetByName { group: b"a", name: b"bc", outcome: Err(Errno::NotAllowed) },
            "2F 00 6100 626300 0D",
        ),
        (Reply::ParamNotExtended { id: 1, with_status: false }, "2F 02 0100 02"),
        (Reply::ParamNotExtended { id: 1, with_status: true }, "2F 07 0100 02"),
        (Reply::ParamNotKept { command: 4, id: 1 }, "2F 04 0100 02"),
        (
            Reply::ParamDefault { id: 1, value: Ok(Value::U8(9)), with_status: false },
            "2F 06 0100 09",
        ),
        (
            Reply::ParamDefault { id: 1, value: Ok(Value::U8(9)), with_status: true },
            "2F 08 0100 00 09",
        ),
        (
            Reply::ParamDefault { id: 1, value: Err(Errno::Missing), with_status: true },
            "2F 08 0100 02",
        ),
        (Reply::MemoryCount(0), "4C 01 00"),
        (Reply::NoMemoryInfo(9), "4C 02 09"),
        (Reply::NoMemoryRead { memory: 1, address: 258 }, "4D 01 02010000 05"),
        (Reply::NoMemoryWrite { memory: 1, address: 258 }, "4E 01 02010000 05"),
        (Reply::HighLevel { head: [7, 0, 1], outcome: Err(Errno::NoCommand) }, "8C 07 00 01 08"),
        (Reply::Supervisor { question: SupervisorQuestion::All, state: 0x011E }, "9C 8C 1E01"),
        (Reply::Supervisor { question: SupervisorQuestion::Bit(8), state: 0x011E }, "9C 89 01"),
        (Reply::Supervisor { question: SupervisorQuestion::Bit(0), state: 0x011E }, "9C 81 00"),
        (
            Reply::Commanded { command: SupervisorCommand::Arm(true), done: true, holds: false },
            "9D 81 01 00",
        ),
        (Reply::Protocol, "DD 00 0C000000"),
        (Reply::Firmware("1.0"), "DD 01 312E30"),
        (Reply::DeviceType("CF21"), "DD 02 43463231"),
        (Reply::Source, "FD 42697463 72617A65 20 4372617A 79666C69 65 000000000000000000000000"),
    ];
    for (reply, bytes) in table {
        assert_eq!(hex(&reply.packet()), bytes.replace(' ', ""), "{reply:?}");
    }
}

#[test]
fn a_log_block_has_a_time_stamp_of_24_bits_and_its_values_as_they_were_asked_for() {
    let block = Reply::log_data(3, Instant::from_millis(0x0112_3456))
        .with(Value::F32(-1.5), LogType::F32)
        .with(Value::F32(1.0), LogType::F16)
        .with(Value::F32(-1.9), LogType::I8)
        .with(Value::F32(1e9), LogType::U16)
        .with(Value::F32(f32::NAN), LogType::I32)
        .with(Value::I8(-1), LogType::U32)
        .with(Value::U32(u32::MAX), LogType::I16)
        .with(Value::U16(0x1234), LogType::U16);
    let bytes = "5E 03 563412 0000C0BF 003C FF FFFF 00000000 00000000 FF7F 3412";
    assert_eq!(hex(&block.packet()), bytes.replace(' ', ""));
    let full = (0..40)
        .fold(Reply::log_data(0, Instant::ZERO), |data, n| data.with(Value::U8(n), LogType::U8));
    assert_eq!(full.packet().data().len(), 4 + LogData::MAX);
    assert_eq!(full.packet().data().len(), MAX_DATA);
}

/// By Python's `struct.pack("<e", x)`, and infinite where that refuses.
#[test]
fn half_numbers_are_rounded_to_the_nearest() {
    let table = [
        (0.0_f32, 0x0000_u16),
        (-0.0, 0x8000),
        (1.0, 0x3C00),
        (-2.0, 0xC000),
        (65504.0, 0x7BFF),
        (65_519.99, 0x7BFF),
        (65520.0, 0x7C00),
        (1e9, 0x7C00),
        (f32::NEG_INFINITY, 0xFC00),
        (6.103_515_6e-5, 0x0400),
        (6.0975e-5, 0x03FF),
        (5.960_464_5e-8, 0x0001),
        (2.98e-8, 0x0000),
        (2.980_232_2e-8, 0x0000),
        (2.980_232_6e-8, 0x0001),
        (1e-10, 0x0000),
        (0.1, 0x2E66),
        (-38.354_164, 0xD0CB),
        (1.000_488_3, 0x3C00),
        (1.001_464_8, 0x3C02),
        (0.333_333, 0x3555),
        (2049.0, 0x6800),
        (2051.0, 0x6802),
        (-7.312_715e-5, 0x84CB),
        (6.948_675e-5, 0x048E),
        (5.275_492_4e-5, 0x0375),
        (-4.898_619_6e-5, 0x8336),
    ];
    for (x, half) in table {
        let packet = Reply::log_data(0, Instant::ZERO).with(Value::F32(x), LogType::F16).packet();
        assert_eq!(packet.data()[4..], half.to_le_bytes(), "{x}");
    }
    let nan = Reply::log_data(0, Instant::ZERO).with(Value::F32(f32::NAN), LogType::F16).packet();
    assert_eq!(nan.data()[5] & 0x7C, 0x7C);
    assert_ne!(nan.data()[5] & 0x03, 0);
}

#[test]
fn codes_of_types_are_read_as_they_are_written() {
    for code in 0..=255 {
        if let Some(kind) = LogType::from_code(code) {
            assert_eq!(kind as u8, code);
        }
        if let Some(kind) = ParamType::from_code(code) {
            assert_eq!(kind as u8, code);
        }
    }
}

fn values() -> impl Strategy<Value = Value> {
    prop_oneof![
        any::<u8>().prop_map(Value::U8),
        any::<u16>().prop_map(Value::U16),
        any::<u32>().prop_map(Value::U32),
        any::<i8>().prop_map(Value::I8),
        any::<i16>().prop_map(Value::I16),
        any::<i32>().prop_map(Value::I32),
        (-1e9_f32..1e9).prop_map(Value::F32),
    ]
}

fn log_type(value: Value) -> LogType {
    match value {
        Value::U8(_) => LogType::U8,
        Value::U16(_) => LogType::U16,
        Value::U32(_) => LogType::U32,
        Value::I8(_) => LogType::I8,
        Value::I16(_) => LogType::I16,
        Value::I32(_) => LogType::I32,
        Value::F32(_) => LogType::F32,
    }
}

fn param_type(value: Value) -> ParamType {
    match value {
        Value::U8(_) => ParamType::U8,
        Value::U16(_) => ParamType::U16,
        Value::U32(_) => ParamType::U32,
        Value::I8(_) => ParamType::I8,
        Value::I16(_) => ParamType::I16,
        Value::I32(_) => ParamType::I32,
        Value::F32(_) => ParamType::F32,
    }
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn any_bytes_are_a_packet_or_none_and_a_request_or_none(
        bytes in prop::collection::vec(any::<u8>(), 0..40),
    ) {
        match Packet::from_bytes(&bytes) {
            Err(error) => {
                prop_assert!(bytes.is_empty() || bytes.len() > 31);
                prop_assert_eq!(error, Error::Length(bytes.len()));
            }
            Ok(packet) => {
                prop_assert_eq!(packet.bytes()[0] & 0xF3, bytes[0] & 0xF3);
                prop_assert_eq!(packet.data(), &bytes[1..]);
                prop_assert_eq!(Packet::from_bytes(packet.bytes()), Ok(packet));
                if let Ok(request) = Request::parse(&packet) {
                    let again = request.packet();
                    prop_assert_eq!(Request::parse(&again).map(|r| r.packet()), Ok(again));
                }
            }
        }
    }

    #[test]
    fn set_points_arrive_as_they_were_sent(
        n in prop::array::uniform4(-100.0_f32..100.0), kind in 0..4, thrust in any::<u16>(),
    ) {
        let [a, b, c, d] = n;
        let setpoint = match kind {
            0 => Setpoint::Velocity {
                axes: [MetresPerSecond(a), MetresPerSecond(b), MetresPerSecond(c)],
                yaw_rate: RadiansPerSecond(d),
            },
            1 => Setpoint::Height {
                roll: Radians(a), pitch: Radians(b), yaw_rate: RadiansPerSecond(c), height: Metres(d),
            },
            2 => Setpoint::Hover {
                forward: MetresPerSecond(a), lateral: MetresPerSecond(b),
                yaw_rate: RadiansPerSecond(c), height: Metres(d),
            },
            _ => Setpoint::Position { axes: [Metres(a), Metres(b), Metres(c)], yaw: Radians(d) },
        };
        let packet = Request::Setpoint(setpoint).packet();
        let Ok(Request::Setpoint(arrived)) = Request::parse(&packet) else {
            return Err(TestCaseError::fail("no set-point"));
        };
        for (sent, arrived) in numbers(&setpoint).into_iter().zip(numbers(&arrived)) {
            prop_assert!((sent - arrived).abs() <= sent.abs() * 1e-6);
        }
        let rpyt = Rpyt {
            roll: Radians(a), pitch: Radians(b), yaw_rate: RadiansPerSecond(c), thrust,
        };
        let packet = Request::Rpyt(rpyt).packet();
        let Ok(Request::Rpyt(arrived)) = Request::parse(&packet) else {
            return Err(TestCaseError::fail("no set-point"));
        };
        prop_assert!((arrived.roll.0 - a).abs() <= a.abs() * 1e-6);
        prop_assert_eq!((arrived.thrust, arrived.is_off()), (thrust, thrust == 0));
    }

    #[test]
    fn a_parameter_is_read_as_it_was_written(value in values()) {
        let packet = Reply::ParamWritten { id: 0, value: Ok(value) }.packet();
        prop_assert_eq!(param_type(value).read(&packet.data()[2..]), Some(value));
        let short = &packet.data()[2..packet.data().len() - 1];
        prop_assert_eq!(param_type(value).read(short), None);
    }

    #[test]
    fn a_number_asked_for_as_what_it_is_is_itself(value in values()) {
        let kind = log_type(value);
        let packet = Reply::log_data(0, Instant::ZERO).with(value, kind).packet();
        prop_assert_eq!(packet.data().len(), 4 + kind.size());
        prop_assert_eq!(param_type(value).read(&packet.data()[4..]), Some(value));
    }

    /// And a number that does not fit is the nearest that does.
    #[test]
    fn whole_numbers_keep_their_order(a in values(), b in values(), kind in 1_u8..=6) {
        let kind = LogType::from_code(kind).unwrap();
        let as_kind = |value: Value| {
            let packet = Reply::log_data(0, Instant::ZERO).with(value, kind).packet();
            let bytes = &packet.data()[4..];
            match kind {
                LogType::U8 => i64::from(bytes[0]),
                LogType::I8 => i64::from(bytes[0].cast_signed()),
                LogType::U16 => i64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                LogType::I16 => i64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
                LogType::U32 => i64::from(u32::from_le_bytes(bytes.try_into().unwrap())),
                _ => i64::from(i32::from_le_bytes(bytes.try_into().unwrap())),
            }
        };
        let exact = |value: Value| match value {
            Value::U8(n) => f64::from(n),
            Value::U16(n) => f64::from(n),
            Value::U32(n) => f64::from(n),
            Value::I8(n) => f64::from(n),
            Value::I16(n) => f64::from(n),
            Value::I32(n) => f64::from(n),
            Value::F32(x) => f64::from(x),
        };
        if exact(a) <= exact(b) {
            prop_assert!(as_kind(a) <= as_kind(b));
        }
        let (least, most) = match kind {
            LogType::U8 => (0.0, 255.0),
            LogType::I8 => (-128.0, 127.0),
            LogType::U16 => (0.0, 65_535.0),
            LogType::I16 => (-32_768.0, 32_767.0),
            LogType::U32 => (0.0, 4_294_967_295.0),
            _ => (-2_147_483_648.0, 2_147_483_647.0),
        };
        prop_assert_eq!(as_kind(a) as f64, exact(a).clamp(least, most).trunc());
    }
}

fn numbers(setpoint: &Setpoint) -> [f32; 4] {
    match *setpoint {
        Setpoint::Velocity { axes: [x, y, z], yaw_rate } => [x.0, y.0, z.0, yaw_rate.0],
        Setpoint::Height { roll, pitch, yaw_rate, height } => {
            [roll.0, pitch.0, yaw_rate.0, height.0]
        }
        Setpoint::Hover { forward, lateral, yaw_rate, height } => {
            [forward.0, lateral.0, yaw_rate.0, height.0]
        }
        Setpoint::Position { axes: [x, y, z], yaw } => [x.0, y.0, z.0, yaw.0],
        Setpoint::Stop | Setpoint::Other(_) => [0.0; 4],
    }
}
