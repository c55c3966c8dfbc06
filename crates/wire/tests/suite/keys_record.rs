//! The keys that a drone remembers: the record's bytes, that no power cut loses both copies, which
//! page replaces which, and that nothing prints a key.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{NodeId, Role};
use wire::settings::epoch::Issue;
use wire::settings::keys::{
    Error, KeysRecord, LENGTH, PAGE_ADDRESS, Secret, Write, address, newest,
};
use wire::settings::{LENGTH as SETTINGS, Slot, epoch};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

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
fn records_lie_beside_each_other_and_each_slot_in_pages_of_its_own() {
    const PAGE: usize = 32;
    for slot in [Slot::A, Slot::B] {
        let of = |address: u16, length: usize| (usize::from(address), length);
        let spans = [
            of(slot.address(), SETTINGS),
            of(address(slot), LENGTH),
            of(epoch::address(slot), epoch::LENGTH),
        ];
        for (at, _) in spans {
            assert_eq!(at % PAGE, 0);
        }
        for pair in spans.windows(2) {
            let (at, length) = pair[0];
            assert!((at + length).next_multiple_of(PAGE) <= pair[1].0, "{pair:x?}");
        }
    }
    assert!(usize::from(epoch::address(Slot::A)) + epoch::LENGTH <= usize::from(Slot::B.address()));
    assert!(usize::from(epoch::address(Slot::B)) + epoch::LENGTH <= 0x400, "the vendor's");
    assert_eq!((PAGE_ADDRESS % 0x2_0000, LENGTH % 4), (0, 0), "a sector's beginning, whole words");
}

fn keys() -> impl Strategy<Value = KeysRecord> {
    let role = prop::sample::select(&[Role::Head, Role::Relay, Role::Base]);
    (any::<u32>(), 1_u8.., 1_u8..=254, 0_u8..16, role, any::<bool>(), any::<[[u8; 16]; 2]>())
        .prop_map(|(fleet, generation, issue, node, role, may_fly, [group, own])| KeysRecord {
            fleet,
            generation,
            issue: Issue::new(issue).unwrap(),
            node: NodeId(node),
            role,
            may_fly: may_fly && role == Role::Base,
            group: Secret::new(group),
            own: Secret::new(own),
        })
}

/// What a memory holds when power went after `after` bytes of a write: the rest is as it was, or
/// garbage.
fn torn(old: &[u8], new: &[u8], after: usize, backwards: bool, garbage: Option<u8>) -> Vec<u8> {
    let mut bytes = old.to_vec();
    let order: Vec<usize> =
        if backwards { (0..new.len()).rev().collect() } else { (0..new.len()).collect() };
    for (written, at) in order.into_iter().enumerate() {
        match garbage {
            _ if written < after => bytes[at] = new[at],
            Some(garbage) => bytes[at] = garbage.wrapping_mul(at as u8 | 1),
            None => {}
        }
    }
    bytes
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn what_is_written_is_read(keys in keys(), sequence in any::<u32>()) {
        let record = keys.encode(sequence).unwrap();
        prop_assert_eq!(KeysRecord::decode(&record), Ok((keys, sequence)));
    }

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
    fn a_power_cut_leaves_the_old_keys_or_the_new(
        writes in prop::collection::vec(
            (keys(), 0..=LENGTH, any::<bool>(), prop::option::of(any::<u8>())), 1..12,
        ),
        blank in any::<u8>(),
    ) {
        let mut slots = [vec![blank; LENGTH], vec![blank; LENGTH]];
        // Two torn writes may add up to the earlier one, whole.
        let mut begun = Vec::new();
        for (keys, after, backwards, garbage) in writes {
            let old = newest(&slots[0], &slots[1]);
            let write = Write::after(old.as_ref(), &keys).unwrap();
            prop_assert!(old.is_none_or(|old| old.slot != write.slot), "the newer one is kept");
            let slot = &mut slots[usize::from(write.slot == Slot::B)];
            *slot = torn(slot, &write.record, after, backwards, garbage);
            let is = newest(&slots[0], &slots[1]).map(|chosen| chosen.keys);
            let was = old.map(|chosen| chosen.keys);
            if after == LENGTH {
                prop_assert_eq!(is, Some(keys));
                begun.clear();
            } else {
                begun.push(keys);
                prop_assert!(is == was || is.is_some_and(|is| begun.contains(&is)), "neither");
            }
        }
    }

    #[test]
    fn any_bytes_are_keys_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        prop_assert!(KeysRecord::decode(&bytes).is_err());
        prop_assert_eq!(newest(&bytes, &bytes), None);
    }

    #[test]
    fn a_disturbed_record_is_none(keys in keys(), at in 0..LENGTH, bit in 0_u8..8) {
        let mut record = keys.encode(7).unwrap();
        record[at] ^= 1 << bit;
        prop_assert!(KeysRecord::decode(&record).is_err());
    }

    #[test]
    fn nothing_printed_has_anything_of_a_key(keys in keys(), sequence in any::<u32>()) {
        let record = keys.encode(sequence).unwrap();
        let write = Write::after(None, &keys).unwrap();
        let chosen = newest(&record, &[]);
        let masked = KeysRecord { group: Secret::new([0; 16]), own: Secret::new([0; 16]), ..keys };
        let masked_record = masked.encode(sequence).unwrap();
        prop_assert_eq!(format!("{keys:?}"), format!("{masked:?}"));
        prop_assert_eq!(format!("{chosen:?}"), format!("{:?}", newest(&masked_record, &[])));
        prop_assert_eq!(format!("{write:?}"), format!("{:?}", Write::after(None, &masked).unwrap()));
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1_u32).wrapping_neg())
        })
    })
}

#[test]
fn a_page_of_the_same_fleet_must_be_a_later_issue_and_another_fleets_need_not() {
    let issue = |number| KeysRecord { issue: Issue::new(number).unwrap(), ..GOLDEN };
    assert!(issue(1).supersedes(None));
    assert!(issue(10).supersedes(Some(&issue(9))));
    assert!(!issue(9).supersedes(Some(&issue(9))), "loaded twice");
    assert!(!issue(8).supersedes(Some(&issue(9))), "an old page");
    let renumbered = KeysRecord { node: NodeId(3), role: Role::Relay, may_fly: false, ..issue(8) };
    assert!(!renumbered.supersedes(Some(&issue(9))), "an old page for another number");
    assert!(KeysRecord { fleet: 1, ..issue(1) }.supersedes(Some(&issue(9))));
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
        assert_eq!(Write::after(None, &keys), Err(Error::Value));
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
    assert_eq!(KeysRecord::decode(&[0xFF; LENGTH]), Err(Error::Magic));
    assert_eq!(KeysRecord::decode(&[0; LENGTH]), Err(Error::Magic), "a wiped page");
    assert_eq!(KeysRecord::decode(&with(4, 2)), Err(Error::Version(2)));
    assert_eq!(KeysRecord::decode(&with(20, 0)), Err(Error::Crc));
}
