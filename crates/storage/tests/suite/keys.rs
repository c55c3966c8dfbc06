//! The bytes of the keys, which page replaces which keys, and that nothing prints a key.

use crate::common::{crc32, keys, seeded};
use proptest::prelude::*;
use storage::epoch::Issue;
use storage::keys::{
    KeysRecord, LENGTH, LIMITS_LENGTH, PAGE_ADDRESS, PAGE_LENGTH, POLICY_LENGTH, Page, PageMission,
    Secret, encode_limits, encode_policy,
};
use storage::ledger::Ledger;
use storage::settings::{Limits, Settings, SwarmPlan};
use storage::{Error, Record, Slots};
use units::{Dbm, Metres, MissionKind, NodeId, Point2, PolicyCode, Radians, Role};

const fn counting(from: u8) -> Secret {
    let mut bytes = [0; 16];
    let mut i = 0;
    while i < 16 {
        bytes[i] = from + i as u8;
        i += 1;
    }
    Secret::new(bytes)
}

const GOLDEN: KeysRecord = KeysRecord {
    fleet: 0x8765_4321,
    generation: 2,
    issue: Issue::new(9).unwrap(),
    node: NodeId(15),
    role: Role::Base,
    may_fly: true,
    group: counting(0xA0),
    own: counting(0xB0),
};

/// By the table in the module's documentation; the CRC by Python's `zlib.crc32`.
const GOLDEN_BYTES: [u8; LENGTH] = [
    b'U', b'C', b'H', b'K', 1, // version
    0x07, 0x00, 0x00, 0x00, // sequence
    2, 15, 2, 1, 9, 0, 0, // generation, node, base, cfclient, issue
    0x21, 0x43, 0x65, 0x87, // fleet
    0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8, 0xA9, 0xAA, 0xAB, 0xAC, 0xAD, 0xAE, 0xAF,
    0xB0, 0xB1, 0xB2, 0xB3, 0xB4, 0xB5, 0xB6, 0xB7, 0xB8, 0xB9, 0xBA, 0xBB, 0xBC, 0xBD, 0xBE, 0xBF,
    0x24, 0x80, 0xD6, 0xA9,
];

#[test]
fn the_bytes_are_those_of_the_table() {
    assert_eq!(GOLDEN.encode(7), Ok(GOLDEN_BYTES));
    assert_eq!(KeysRecord::decode(&GOLDEN_BYTES), Ok((GOLDEN, 7)));
}

#[test]
fn a_page_is_whole_words_at_the_beginning_of_a_sector() {
    assert_eq!((PAGE_ADDRESS % 0x2_0000, LENGTH % 4), (0, 0));
}

proptest! {
    #![proptest_config(seeded(256))]

    #[test]
    fn what_is_read_is_written_the_same(
        keys in keys(), sequence in any::<u32>(), at in 4..LENGTH - 4, byte in any::<u8>(),
    ) {
        let mut record = keys.encode(sequence).unwrap();
        record[at] = byte;
        let crc = crc32(&record[..LENGTH - 4]);
        record[LENGTH - 4..].copy_from_slice(&crc.to_le_bytes());
        if let Ok((keys, sequence)) = KeysRecord::decode(&record) {
            prop_assert_eq!(keys.encode(sequence), Ok(record));
        }
    }

    #[test]
    fn nothing_printed_has_anything_of_a_key(keys in keys(), sequence in any::<u32>()) {
        let masked = KeysRecord { group: Secret::new([0; 16]), own: Secret::new([0; 16]), ..keys };
        let printed = |keys: KeysRecord| {
            let slots = Slots::read(&keys.encode(sequence).unwrap(), &[]);
            format!("{keys:?} {slots:?} {:?}", slots.write(&keys).unwrap())
        };
        prop_assert_eq!(printed(keys), printed(masked));
    }
}

#[test]
fn a_page_of_the_same_fleet_must_be_a_later_issue_and_another_fleets_need_not() {
    let issue = |number| KeysRecord { issue: Issue::new(number).unwrap(), ..GOLDEN };
    assert!(issue(1).supersedes(None, &Ledger::EMPTY));
    assert!(issue(10).supersedes(Some(&issue(9)), &Ledger::EMPTY));
    assert!(!issue(9).supersedes(Some(&issue(9)), &Ledger::EMPTY), "loaded twice");
    assert!(!issue(8).supersedes(Some(&issue(9)), &Ledger::EMPTY), "an old page");
    let renumbered = KeysRecord { node: NodeId(3), role: Role::Relay, may_fly: false, ..issue(8) };
    assert!(
        !renumbered.supersedes(Some(&issue(9)), &Ledger::EMPTY),
        "an old page for another number"
    );
    assert!(KeysRecord { fleet: 1, ..issue(1) }.supersedes(Some(&issue(9)), &Ledger::EMPTY));
}

#[test]
fn a_page_is_taken_over_wiped_or_left() {
    let page = |keys: KeysRecord| keys.encode(0).unwrap();
    let newer = KeysRecord { issue: Issue::new(10).unwrap(), ..GOLDEN };
    let on_page = |page: &[u8]| KeysRecord::on_page(page, Some(&GOLDEN), &Ledger::EMPTY);
    assert_eq!(
        on_page(&page(newer)),
        Page::New { keys: newer, policy: None, limits: None, mission: None }
    );
    assert_eq!(on_page(&page(GOLDEN)), Page::Old);
    assert_eq!(
        KeysRecord::on_page(&page(GOLDEN), None, &Ledger::EMPTY),
        Page::New { keys: GOLDEN, policy: None, limits: None, mission: None }
    );
    let other = KeysRecord { fleet: !GOLDEN.fleet, ..GOLDEN };
    let ledger = Ledger::EMPTY.with(&GOLDEN).with(&other);
    assert_eq!(KeysRecord::on_page(&page(GOLDEN), Some(&other), &ledger), Page::Old);
    assert_eq!(on_page(&[0xFF; LENGTH]), Page::Empty);
    assert_eq!(on_page(&[0; LENGTH]), Page::Empty);
    assert_eq!(on_page(&[&[0; LENGTH][..], &[0xFF; 8]].concat()), Page::Empty);
    let with = |at: usize, byte: u8| {
        let mut bytes = page(newer);
        bytes[at] = byte;
        bytes
    };
    assert_eq!(on_page(&with(4, 2)), Page::Unknown(2));
    assert_eq!(on_page(&with(0, 0)), Page::Damaged(Error::Magic));
    assert_eq!(on_page(&with(30, 0)), Page::Damaged(Error::Checksum));
    assert_eq!(on_page(&page(newer)[..LENGTH - 1]), Page::Damaged(Error::Short));
}

#[test]
fn a_policy_may_follow_the_keys_on_the_page() {
    let policy = PolicyCode::new(2).unwrap();
    // The CRC by Python's `zlib.crc32`.
    let bytes = [b'U', b'P', 1, 2, 0x51, 0x5E, 0x3E, 0x46];
    assert_eq!(encode_policy(policy), bytes);
    let on_page = |after: &[u8]| {
        KeysRecord::on_page(&[&GOLDEN_BYTES[..], after].concat(), None, &Ledger::EMPTY)
    };
    let new = |policy| Page::New { keys: GOLDEN, policy, limits: None, mission: None };
    assert_eq!(on_page(&bytes), new(Some(policy)));
    for none in [&[][..], &[0xFF; 8], &bytes[..7]] {
        assert_eq!(on_page(none), new(None));
    }
    for at in 0..bytes.len() {
        let mut bytes = bytes;
        bytes[at] ^= 1;
        assert_eq!(on_page(&bytes), new(None), "byte {at}");
    }
}

#[test]
fn limits_may_follow_the_keys_on_the_page_with_a_policy_or_without() {
    let policy = PolicyCode::new(2).unwrap();
    let (launch, retreat) = (Dbm(-67.5), Dbm(-72.0));
    let bytes = encode_limits(launch, retreat);
    // The floats and the CRC by Python's `struct.pack` and `zlib.crc32`.
    let golden = [b'U', b'L', 1, 0, 0, 0, 0x87, 0xC2, 0, 0, 0x90, 0xC2, 0x38, 0xBD, 0xD6, 0x78];
    assert_eq!(bytes, golden);
    let on_page = |after: &[&[u8]]| {
        let page = [&GOLDEN_BYTES[..], &after.concat(), &[0xFF; 24]].concat();
        KeysRecord::on_page(&page, None, &Ledger::EMPTY)
    };
    let both = Some(Limits { launch: Some(launch), retreat: Some(retreat) });
    let new = |policy, limits| Page::New { keys: GOLDEN, policy, limits, mission: None };
    assert_eq!(on_page(&[&bytes]), new(None, both));
    assert_eq!(on_page(&[&encode_policy(policy), &bytes]), new(Some(policy), both));
    for at in 0..bytes.len() {
        let mut bytes = bytes;
        bytes[at] ^= 1;
        assert_eq!(on_page(&[&bytes]), new(None, None), "byte {at}");
    }
    for (launch, retreat) in [(-97.0, -72.0), (-67.0, -19.0), (f32::NAN, -72.0), (0.0, -72.0)] {
        let refused = encode_limits(Dbm(launch), Dbm(retreat));
        assert_eq!(on_page(&[&refused]), new(None, None), "{launch} {retreat}");
    }
}

#[test]
fn a_mission_may_follow_on_the_page_with_a_policy_or_without() {
    let policy = PolicyCode::new(2).unwrap();
    let plan = SwarmPlan {
        drones: 3,
        corner: Point2::new(-9.75, -3.75),
        area: (Metres(9.0), Metres(7.5)),
        entrance: Point2::new(0.0, 0.0),
        width: Metres(1.51),
        direction: Radians(0.0),
        length: Metres(6.0),
        both: false,
    };
    let swarm = PageMission { kind: MissionKind::Swarm, swarm: Some(plan), fetched: false };
    let bytes = swarm.encode().unwrap();
    assert_eq!(LENGTH + POLICY_LENGTH + LIMITS_LENGTH + bytes.len(), PAGE_LENGTH);
    // The CRC by Python's `zlib.crc32`.
    assert_eq!(bytes[..6], [b'U', b'C', b'H', b'M', 1, 1]);
    assert_eq!(bytes[28..], [0xEA, 0x31, 0x31, 0x79]);
    let on_page = |policy: &[u8], mission: &[u8]| {
        KeysRecord::on_page(&[&GOLDEN_BYTES[..], policy, mission].concat(), None, &Ledger::EMPTY)
    };
    let new = |policy, mission| Page::New { keys: GOLDEN, policy, limits: None, mission };
    assert_eq!(on_page(&[], &bytes), new(None, Some(swarm)));
    assert_eq!(on_page(&encode_policy(policy), &bytes), new(Some(policy), Some(swarm)));
    for (kind, fetched) in MissionKind::ALL.into_iter().flat_map(|it| [(it, false), (it, true)]) {
        let mission = PageMission { kind, swarm: None, fetched };
        let bytes = mission.encode().unwrap();
        assert_eq!(bytes[5] & 0x80 != 0, fetched);
        assert_eq!(on_page(&[], &bytes), new(None, Some(mission)));
        for before in [false, true] {
            let before = Settings { fetched: before, ..Settings::DEFAULT };
            let settings = mission.applied_to(before);
            assert_eq!((settings.mission, settings.fetched), (kind, fetched));
        }
    }
    for at in 0..bytes.len() {
        let mut bytes = bytes;
        bytes[at] ^= 1;
        assert_eq!(on_page(&[], &bytes), new(None, None), "byte {at}");
    }
    let large = SwarmPlan { area: (Metres(101.0), Metres(1.0)), ..plan };
    let large = PageMission { kind: MissionKind::Swarm, swarm: Some(large), fetched: false };
    assert_eq!(large.encode(), Err(Error::Value));
}

#[test]
fn what_contradicts_itself_is_neither_written_nor_read() {
    let bad = [
        KeysRecord { node: NodeId(16), ..GOLDEN },
        KeysRecord { generation: 0, ..GOLDEN },
        KeysRecord { role: Role::Head, ..GOLDEN },
        KeysRecord { role: Role::Relay, ..GOLDEN },
    ];
    for keys in bad {
        assert_eq!(keys.encode(1), Err(Error::Value), "{keys:?}");
        assert_eq!(Slots::read(&[], &[]).write(&keys), Err(Error::Value));
    }
    // Role, flags, issue and what must be zero.
    for (at, byte) in [(11, 3), (12, 2), (12, 0x81), (13, 0), (13, 255), (14, 1), (15, 0x80)] {
        let mut record = GOLDEN_BYTES;
        record[at] = byte;
        let crc = crc32(&record[..LENGTH - 4]);
        record[LENGTH - 4..].copy_from_slice(&crc.to_le_bytes());
        assert_eq!(KeysRecord::decode(&record), Err(Error::Value), "byte {at} is {byte}");
    }
}

#[test]
fn what_is_no_record_says_why() {
    let with = |at: usize, byte: u8| {
        let mut bytes = GOLDEN_BYTES;
        bytes[at] = byte;
        bytes
    };
    assert_eq!(KeysRecord::decode(&GOLDEN_BYTES[..LENGTH - 1]), Err(Error::Short));
    assert_eq!(KeysRecord::decode(&[0xFF; LENGTH]), Err(Error::Blank));
    assert_eq!(KeysRecord::decode(&[0; LENGTH]), Err(Error::Magic), "a wiped page");
    assert_eq!(KeysRecord::decode(&with(4, 2)), Err(Error::Version(2)));
    assert_eq!(KeysRecord::decode(&with(20, 0)), Err(Error::Checksum));
}
