//! The bytes of the settings, in every version, and of the vendor's configuration block.

use storage::settings::{LENGTH, Limits, Radio, Settings, Source, SwarmPlan, Trim};
use storage::vendor::{self, VendorConfig};
use storage::{Error, Record, Slots};
use units::{Dbm, Metres, MissionKind, NodeId, Point2, PolicyCode, Radians, Role};
use wire::radio::{Address, Channel, Datarate, TxPower};

const GOLDEN: Settings = Settings {
    node: NodeId(4),
    role: Role::Relay,
    radio: Radio {
        channel: Channel::new(93).unwrap(),
        datarate: Datarate::Mbit1,
        address: Address([0xE7, 0xE7, 0xE7, 0xE7, 0x04]),
        power: TxPower::Minus4,
    },
    trim: Trim { pitch: Radians(0.015625), roll: Radians(-0.03125) },
    height: Some(Metres(0.5)),
    limits: Limits { launch: Some(Dbm(-52.0)), retreat: None },
    policy: PolicyCode::new(5),
    mission: MissionKind::Swarm,
    swarm: Some(PLAN),
    fetched: true,
};

const PLAN: SwarmPlan = SwarmPlan {
    drones: 3,
    corner: Point2::new(-9.75, -3.75),
    area: (Metres(9.0), Metres(7.5)),
    entrance: Point2::new(0.0, 2.56),
    width: Metres(1.51),
    direction: Radians(-core::f32::consts::FRAC_PI_2),
    length: Metres(6.0),
    both: false,
};

/// By the table in the module's documentation; the CRC by Python's `zlib.crc32`.
const GOLDEN_BYTES: [u8; LENGTH] = [
    b'U', b'C', b'H', b'N', 6, // version
    0x07, 0x00, 0x00, 0x00, // sequence
    4, 1, // node, relay
    93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7, 0xFC,
    5, // channel, 1 Mbit/s, address, -4 dBm, policy
    0x00, 0x00, 0x80, 0x3C, // 2^-6 rad
    0x00, 0x00, 0x00, 0xBD, // -2^-5 rad
    0x00, 0x00, 0x00, 0x3F, // 0.5 m
    0x00, 0x00, 0x50, 0xC2, // -52 dBm
    0x00, 0x00, 0x00, 0x00, // the agent's own
    0x81, // swarm, fetched
    3,    // drones
    0x31, 0xFC, 0x89, 0xFE, // corner
    0x84, 0x03, 0xEE, 0x02, // area
    0x00, 0x00, 0x00, 0x01, // entrance
    0x97, 0x00, // 1.51 m wide
    0xD8, 0xDC, // -90 degrees
    0x58, 0x02, // 6 m long
    0xF2, 0x6E, 0xAF, 0xBE,
];

/// The same where no drone is fetched, as version 5 wrote it.
const VERSION_5_BYTES: [u8; LENGTH] = [
    b'U', b'C', b'H', b'N', 5, // version
    0x07, 0x00, 0x00, 0x00, // sequence
    4, 1, // node, relay
    93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7, 0xFC,
    5, // channel, 1 Mbit/s, address, -4 dBm, policy
    0x00, 0x00, 0x80, 0x3C, // 2^-6 rad
    0x00, 0x00, 0x00, 0xBD, // -2^-5 rad
    0x00, 0x00, 0x00, 0x3F, // 0.5 m
    0x00, 0x00, 0x50, 0xC2, // -52 dBm
    0x00, 0x00, 0x00, 0x00, // the agent's own
    1,    // swarm
    3,    // drones
    0x31, 0xFC, 0x89, 0xFE, // corner
    0x84, 0x03, 0xEE, 0x02, // area
    0x00, 0x00, 0x00, 0x01, // entrance
    0x97, 0x00, // 1.51 m wide
    0xD8, 0xDC, // -90 degrees
    0x58, 0x02, // 6 m long
    0xA7, 0x1A, 0xE1, 0xF3,
];

/// The same without a plan, as version 4 wrote it.
const VERSION_4_BYTES: [u8; 45] = [
    b'U', b'C', b'H', b'N', 0x04, 0x07, 0x00, 0x00, 0x00, 0x04, 0x01, 0x5D, 0x01, 0x04, 0xE7, 0xE7,
    0xE7, 0xE7, 0xFC, 0x05, 0x00, 0x00, 0x80, 0x3C, 0x00, 0x00, 0x00, 0xBD, 0x00, 0x00, 0x00, 0x3F,
    0x00, 0x00, 0x50, 0xC2, 0x00, 0x00, 0x00, 0x00, 0x01, 0x8D, 0x30, 0x21, 0x22,
];

/// The same without a mission, as version 3 wrote it.
const VERSION_3_BYTES: [u8; 44] = [
    b'U', b'C', b'H', b'N', 3, 0x07, 0x00, 0x00, 0x00, 4, 1, 93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7,
    0xFC, 5, 0x00, 0x00, 0x80, 0x3C, 0x00, 0x00, 0x00, 0xBD, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00,
    0x50, 0xC2, 0x00, 0x00, 0x00, 0x00, 0xF8, 0x67, 0xFC, 0x70,
];

/// The same without a policy, as version 2 wrote it.
const VERSION_2_BYTES: [u8; 44] = [
    b'U', b'C', b'H', b'N', 2, 0x07, 0x00, 0x00, 0x00, 4, 1, 93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7,
    0xFC, 0, 0x00, 0x00, 0x80, 0x3C, 0x00, 0x00, 0x00, 0xBD, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00,
    0x50, 0xC2, 0x00, 0x00, 0x00, 0x00, 0x48, 0x34, 0xAF, 0x68,
];

/// The same without a policy and limits, as version 1 wrote it.
const VERSION_1_BYTES: [u8; 36] = [
    b'U', b'C', b'H', b'N', 1, 0x07, 0x00, 0x00, 0x00, 4, 1, 93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7,
    0xFC, 0, 0x00, 0x00, 0x80, 0x3C, 0x00, 0x00, 0x00, 0xBD, 0x00, 0x00, 0x00, 0x3F, 0xDE, 0x34,
    0x72, 0xA6,
];

#[test]
fn the_bytes_are_those_of_the_table() {
    assert_eq!(GOLDEN.encode(7), Ok(GOLDEN_BYTES));
    assert_eq!(Settings::decode(&GOLDEN_BYTES), Ok((GOLDEN, 7)));
}

#[test]
fn records_of_older_versions_are_read_and_replaced() {
    let version_5 = Settings { fetched: false, ..GOLDEN };
    assert_eq!(Settings::decode(&VERSION_5_BYTES), Ok((version_5, 7)));
    let version_4 = Settings { swarm: None, ..version_5 };
    assert_eq!(Settings::decode(&VERSION_4_BYTES), Ok((version_4, 7)));
    let version_3 = Settings { mission: MissionKind::Chain, ..version_4 };
    let version_2 = Settings { policy: None, ..version_3 };
    assert_eq!(Settings::decode(&VERSION_3_BYTES), Ok((version_3, 7)));
    let version_1 = Settings { limits: Limits::DEFAULT, ..version_2 };
    assert_eq!(Settings::decode(&VERSION_2_BYTES), Ok((version_2, 7)));
    assert_eq!(Settings::decode(&VERSION_1_BYTES), Ok((version_1, 7)));
    for old in [
        &VERSION_1_BYTES[..],
        &VERSION_2_BYTES,
        &VERSION_3_BYTES,
        &VERSION_4_BYTES,
        &VERSION_5_BYTES,
    ] {
        assert_eq!(Settings::decode(&old[..old.len() - 1]), Err(Error::Short));
        let write = Slots::read(old, &[]).write(&GOLDEN).unwrap();
        assert_eq!(write.address(), 0x300);
        assert_eq!(Slots::read(old, write.bytes()).newest(), Some(&GOLDEN));
    }
}

#[test]
fn an_older_version_fetches_no_drone() {
    let mut record = VERSION_5_BYTES;
    record[40] |= 0x80;
    let sum = crate::common::crc32(&record[..60]);
    record[60..].copy_from_slice(&sum.to_le_bytes());
    assert_eq!(Settings::decode(&record), Err(Error::Value));
}

#[test]
fn an_older_version_has_no_policy() {
    for (record, crc) in [(&VERSION_1_BYTES[..], 32), (&VERSION_2_BYTES, 40)] {
        let mut record = record.to_vec();
        record[19] = 1;
        let sum = crate::common::crc32(&record[..crc]);
        record[crc..].copy_from_slice(&sum.to_le_bytes());
        assert_eq!(Settings::decode(&record), Err(Error::Value));
    }
}

#[test]
fn what_could_not_be_read_back_is_not_written() {
    let tilted = |pitch, roll| Trim { pitch: Radians(pitch), roll: Radians(roll) };
    for settings in [
        Settings { trim: tilted(f32::NAN, 0.0), ..GOLDEN },
        Settings { trim: tilted(0.0, 0.4), ..GOLDEN },
        Settings { height: Some(Metres(f32::INFINITY)), ..GOLDEN },
        Settings { height: Some(Metres::ZERO), ..GOLDEN },
        Settings { height: Some(Metres(-0.3)), ..GOLDEN },
        Settings { limits: Limits { launch: Some(Dbm(0.0)), retreat: None }, ..GOLDEN },
        Settings { limits: Limits { launch: None, retreat: Some(Dbm(f32::NAN)) }, ..GOLDEN },
        Settings { swarm: Some(SwarmPlan { drones: 16, ..PLAN }), ..GOLDEN },
        Settings { swarm: Some(SwarmPlan { width: Metres(0.1), ..PLAN }), ..GOLDEN },
        Settings { swarm: Some(SwarmPlan { length: Metres(f32::NAN), ..PLAN }), ..GOLDEN },
        Settings { swarm: Some(SwarmPlan { direction: Radians(3.5), ..PLAN }), ..GOLDEN },
        Settings { swarm: Some(SwarmPlan { corner: Point2::new(328.0, 0.0), ..PLAN }), ..GOLDEN },
    ] {
        assert_eq!(settings.encode(1), Err(Error::Value), "{settings:?}");
        assert_eq!(Slots::read(&[], &[]).write(&settings), Err(Error::Value));
    }
}

#[test]
fn what_is_no_record_says_why() {
    let with = |at: usize, byte: u8| {
        let mut bytes = GOLDEN_BYTES;
        bytes[at] = byte;
        bytes
    };
    assert_eq!(Settings::decode(&GOLDEN_BYTES[..LENGTH - 1]), Err(Error::Short));
    assert_eq!(Settings::decode(&[0xFF; LENGTH]), Err(Error::Blank));
    assert_eq!(Settings::decode(&[0; LENGTH]), Err(Error::Magic));
    assert_eq!(Settings::decode(&with(4, 7)), Err(Error::Version(7)));
    assert_eq!(Settings::decode(&with(9, 5)), Err(Error::Checksum));
}

/// A block as the vendor's tools write it.
fn vendor_block(channel: u8, speed: u8, pitch: f32, roll: f32) -> [u8; vendor::LENGTH] {
    let mut block = vec![0x30, 0x78, 0x42, 0x43, 1, channel, speed];
    block.extend(pitch.to_le_bytes());
    block.extend(roll.to_le_bytes());
    block.extend([0xE7, 0x05, 0xE7, 0xE7, 0xE7]);
    block.push(block.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)));
    block.try_into().unwrap()
}

#[test]
fn what_the_vendors_tools_set_carries_over() {
    let vendor = VendorConfig::decode(&vendor_block(93, 1, 1.5, -0.5)).unwrap();
    let settings = Settings::DEFAULT.with_vendor(&vendor);
    assert_eq!(settings.radio.channel.number(), 93);
    assert_eq!(settings.radio.datarate, Datarate::Mbit1);
    assert_eq!(settings.radio.address, Address([0xE7, 0xE7, 0xE7, 0xE7, 0x05]));
    assert!((settings.trim.pitch.0 - 0.026_18).abs() < 1e-5);
    assert!((settings.trim.roll.0 + 0.008_727).abs() < 1e-5);
    assert_eq!(settings.radio.power, Settings::DEFAULT.radio.power);
    assert_eq!(settings.node, Settings::DEFAULT.node);
    assert!(settings.encode(0).is_ok());
}

#[test]
fn a_drone_without_a_record_has_the_settings_of_the_vendors_tools_or_the_default() {
    let block = vendor_block(93, 1, 0.0, 0.0);
    let (settings, source) = Settings::without_record(Some(&block));
    assert_eq!((settings.node, settings.role, source), (NodeId(5), Role::Relay, Source::Vendor));
    assert_eq!(settings.radio.channel.number(), 93);
    for none in [None, Some(&[0xFF; vendor::LENGTH][..])] {
        assert_eq!(Settings::without_record(none), (Settings::DEFAULT, Source::Default));
    }
    let far = Address([0xE7; 5]);
    let mut block = block;
    block[16] = far.0[4];
    block[20] = block[..20].iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte));
    let (settings, source) = Settings::without_record(Some(&block));
    assert_eq!((settings.node, settings.radio.address), (Settings::DEFAULT.node, far));
    assert_eq!(source, Source::Vendor);
}

#[test]
fn what_is_no_vendor_block_says_why() {
    let good = vendor_block(80, 2, 0.0, 0.0);
    let with = |at: usize, byte: u8| {
        let mut bytes = good;
        bytes[at] = byte;
        bytes
    };
    assert_eq!(VendorConfig::decode(&good[..20]), Err(Error::Short));
    assert_eq!(VendorConfig::decode(&[0xFF; 21]), Err(Error::Blank));
    assert_eq!(VendorConfig::decode(&with(4, 0)), Err(Error::Version(0)));
    assert_eq!(VendorConfig::decode(&with(5, 81)), Err(Error::Checksum));
    for bad in [
        vendor_block(126, 2, 0.0, 0.0),
        vendor_block(80, 3, 0.0, 0.0),
        vendor_block(80, 2, f32::NAN, 0.0),
        vendor_block(80, 2, 0.0, 45.0),
    ] {
        assert_eq!(VendorConfig::decode(&bad), Err(Error::Value));
    }
}
