//! Whatever is written into the slots, however it is interrupted, the record that is read
//! afterwards is the one from before or the new one, whole. The same properties hold for every
//! record.

use std::fmt::Debug;

use crate::common::{Memory, Power, epochs, keys, ledgers, mended, seeded, settings};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use storage::epoch::EpochRecord;
use storage::keys::KeysRecord;
use storage::ledger::Ledger;
use storage::settings::Settings;
use storage::{Record, Slot};

/// Sizes of a page: a byte, and those of EEPROMs in use.
const PAGES: [usize; 4] = [1, 8, 32, 64];

/// A write of a record, which the power may not last for.
type Attempt<R> = (R, Option<usize>, u64);

fn attempts<R: Debug>(record: impl Strategy<Value = R>) -> impl Strategy<Value = Vec<Attempt<R>>> {
    let cut = prop::option::of(0..64_usize);
    prop::collection::vec((record, cut, any::<u64>()), 1..12)
}

fn the_old_record_or_the_new<R: Record + Debug>(
    attempts: Vec<Attempt<R>>,
    blank: u8,
    page: usize,
) -> TestCaseResult {
    let mut memory = Memory::filled_with(blank, page);
    // Two torn writes may add up to the earlier one, whole.
    let mut begun = Vec::new();
    for (record, left, random) in attempts {
        let slots = memory.slots::<R>();
        let was = slots.newest().copied();
        let write = slots.write(&record).unwrap();
        prop_assert_ne!(slots.newest_slot(), Some(write.slot()), "the newer record stays");
        let before = memory.bytes.clone();
        let written =
            memory.write(write.address(), write.bytes(), &mut Power { left, random, misreads: 0 });
        let is = memory.slots::<R>().newest().copied();
        let kept = write.is_kept(memory.at(write.address(), R::LENGTH));
        if written.is_ok() {
            prop_assert!(kept && is == Some(record), "{is:?}");
            begun.clear();
        } else {
            begun.push(record);
            prop_assert!(is == was || is.is_some_and(|is| begun.contains(&is)), "{is:?}");
            prop_assert!(!kept || is == Some(record), "{is:?} is kept");
        }
        let start = usize::from(write.address());
        let end = start + R::LENGTH.next_multiple_of(page);
        prop_assert_eq!(&memory.bytes[..start], &before[..start]);
        prop_assert_eq!(&memory.bytes[end..], &before[end..]);
    }
    Ok(())
}

/// Cuts the write of `new` over `old` at every byte, in either slot.
fn no_byte_is_a_bad_moment<R: Record + Debug>(old: R, new: R, random: u64) {
    for page in PAGES {
        for (cut, rounds) in (0..=R::LENGTH).flat_map(|cut| [(cut, 1), (cut, 2)]) {
            let mut memory = Memory::filled_with(0xFF, page);
            for _ in 0..rounds {
                let write = memory.slots::<R>().write(&old).unwrap();
                let power = &mut Power { left: None, random, misreads: 0 };
                memory.write(write.address(), write.bytes(), power).unwrap();
            }
            let write = memory.slots::<R>().write(&new).unwrap();
            let power = &mut Power { left: Some(cut), random, misreads: 0 };
            let written = memory.write(write.address(), write.bytes(), power);
            assert_eq!(written.is_ok(), cut == R::LENGTH);
            let slots = memory.slots::<R>();
            let is = *slots.newest().unwrap();
            assert!(is == old || is == new, "cut after {cut} bytes in pages of {page}: {is:?}");
            assert!(written.is_err() || is == new);
        }
    }
}

/// What is decoded would have been written the same by this version or an older one, and holds once
/// it is written again.
fn a_record_or_an_error<R: Record + Debug>(a: &[u8], b: &[u8]) -> TestCaseResult {
    for bytes in [a, b] {
        if let Ok((record, sequence)) = R::decode(bytes) {
            let again = record.encode(sequence).unwrap();
            prop_assert_eq!(R::decode(again.as_ref()), Ok((record, sequence)));
        }
    }
    let slots = storage::Slots::<R>::read(a, b);
    let Some(newest) = slots.newest() else { return Ok(()) };
    let Ok(write) = slots.write(newest) else { return Ok(()) };
    let after = match write.slot() {
        Slot::A => storage::Slots::<R>::read(write.bytes(), b),
        Slot::B => storage::Slots::<R>::read(a, write.bytes()),
    };
    prop_assert_eq!(after.newest_slot(), Some(write.slot()));
    prop_assert_eq!(after.newest(), Some(newest));
    Ok(())
}

/// A record of which a byte or two are others, with the checksum that goes with them.
fn disturbed<R: Record>(record: R, sequence: u32, changes: &[(usize, u8)]) -> Vec<u8> {
    let mut bytes = record.encode(sequence & 0xFF_FFFF).unwrap().as_ref().to_vec();
    for (at, byte) in changes {
        let at = 4 + at % (R::LENGTH - 8);
        bytes[at] = *byte;
    }
    mended(bytes)
}

macro_rules! properties {
    ($module:ident, $record:ty, $strategy:ident) => {
        mod $module {
            use super::*;

            proptest! {
                #![proptest_config(seeded(256))]

                #[test]
                fn a_power_cut_leaves_the_old_record_or_the_new(
                    attempts in attempts($strategy()), blank in any::<u8>(),
                    page in prop::sample::select(&PAGES),
                ) {
                    the_old_record_or_the_new::<$record>(attempts, blank, page)?;
                }

                #[test]
                fn what_is_written_is_read(record in $strategy(), sequence in 0_u32..1 << 24) {
                    let bytes = record.encode(sequence).unwrap();
                    prop_assert_eq!(<$record>::decode(&bytes), Ok((record, sequence)));
                }

                #[test]
                fn a_bit_that_flips_spoils_the_record(
                    record in $strategy(), at in any::<prop::sample::Index>(), bit in 0_u8..8,
                ) {
                    let mut bytes = record.encode(7).unwrap();
                    bytes[at.index(<$record>::LENGTH)] ^= 1 << bit;
                    prop_assert!(<$record>::decode(&bytes).is_err());
                }

                #[test]
                fn any_bytes_are_a_record_or_an_error(
                    a in prop::collection::vec(any::<u8>(), 0..80),
                    b in prop::collection::vec(any::<u8>(), <$record>::LENGTH),
                ) {
                    a_record_or_an_error::<$record>(&a, &b)?;
                }

                #[test]
                fn any_fields_are_a_record_or_an_error(
                    records in [$strategy(), $strategy()], sequences in any::<[u32; 2]>(),
                    changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..3),
                ) {
                    let [a, b] = [0, 1].map(|i| disturbed(records[i], sequences[i], &changes));
                    a_record_or_an_error::<$record>(&a, &b)?;
                }
            }

            proptest! {
                #![proptest_config(seeded(8))]

                #[test]
                fn every_byte_of_a_write_may_be_the_last(
                    old in $strategy(), new in $strategy(), random in any::<u64>(),
                ) {
                    no_byte_is_a_bad_moment::<$record>(old, new, random);
                }
            }
        }
    };
}

properties!(of_settings, Settings, settings);
properties!(of_keys, KeysRecord, keys);
properties!(of_epochs, EpochRecord, epochs);
properties!(of_ledgers, Ledger, ledgers);

#[test]
fn the_newer_of_two_records_holds_also_where_the_numbers_begin_anew() {
    let record = |fleet, sequence| EpochRecord { fleet }.encode(sequence).unwrap();
    let settings = |node, sequence| {
        let node = units::NodeId(node);
        Settings { node, ..Settings::DEFAULT }.encode(sequence).unwrap()
    };
    let newest = |a: &[u8], b: &[u8]| {
        storage::Slots::<Settings>::read(a, b).newest().map(|settings| settings.node.0)
    };
    assert_eq!(newest(&settings(1, 7), &settings(2, 8)), Some(2));
    assert_eq!(newest(&settings(1, 8), &settings(2, 7)), Some(1));
    assert_eq!(newest(&settings(1, u32::MAX), &settings(2, 0)), Some(2));
    assert_eq!(newest(&settings(1, 7), &[]), Some(1));
    assert_eq!(newest(&[], &settings(2, 7)), Some(2));
    assert_eq!(newest(&[], &[]), None);
    assert_eq!(newest(&record(1, 7), &record(2, 8)), None, "records of another kind");
}

#[test]
fn each_slot_has_pages_of_its_own() {
    const PAGE: usize = 64;
    /// Where the vendor's persistent parameters begin.
    const END: usize = 0x400;
    let spans = |addresses: [u16; 2], length| addresses.map(|at| (usize::from(at), length));
    let mut spans = [
        spans(Settings::ADDRESSES, Settings::LENGTH),
        spans(KeysRecord::ADDRESSES, KeysRecord::LENGTH),
        spans(EpochRecord::ADDRESSES, EpochRecord::LENGTH),
        spans(Ledger::ADDRESSES, Ledger::LENGTH),
    ]
    .concat();
    spans.sort_unstable();
    spans.push((END, 0));
    assert!(storage::vendor::LENGTH <= spans[0].0);
    for pair in spans.windows(2) {
        let (at, length) = pair[0];
        assert_eq!(at % PAGE, 0);
        assert!((at + length).next_multiple_of(PAGE) <= pair[1].0, "{pair:x?}");
    }
}
