//! The contents of the EEPROM: what is decoded would have been written the same, what is written
//! next is what then holds, and epochs rise.

use std::fmt::Debug;

use storage::epoch::{self, EpochRecord};
use storage::keys::{self, KeysRecord, Page};
use storage::ledger::Ledger;
use storage::settings::Settings;
use storage::vendor::{self, VendorConfig};
use storage::{Record, Slot, Slots};

/// The bytes are the slots of the settings, the keys and the epoch, and the vendor's block: checked
/// as they are, and with the right checksums, which a fuzzer does not find by chance.
pub fn check(mut data: &[u8]) {
    let mut record = |length: usize| {
        let (record, rest) = data.split_at(length.min(data.len()));
        data = rest;
        [record.to_vec(), mended(record)]
    };
    let settings = [record(Settings::LENGTH), record(Settings::LENGTH)];
    let keys = [record(KeysRecord::LENGTH), record(KeysRecord::LENGTH)];
    let epochs = [record(EpochRecord::LENGTH), record(EpochRecord::LENGTH)];
    let [vendor, _] = record(vendor::LENGTH);
    let after = [record(keys::POLICY_LENGTH), record(keys::LIMITS_LENGTH)];
    for choice in 0..4 {
        let (a, b) = (choice & 1, choice >> 1);
        holds::<Settings>(&settings[0][a], &settings[1][b]);
        holds::<KeysRecord>(&keys[0][a], &keys[1][b]);
        if let Some(keys) = Slots::read(&keys[0][1], &keys[1][1]).newest() {
            epochs_rise(&epochs[0][a], &epochs[1][b], keys);
        }
        let page = [&keys[0][a][..], &after[0][b], &after[1][b]].concat();
        if let Page::New { limits: Some(limits), .. } =
            KeysRecord::on_page(&page, None, &Ledger::EMPTY)
        {
            let settings = Settings { limits, ..Settings::DEFAULT };
            assert!(settings.encode(1).is_ok(), "limits of a page that no drone keeps");
        }
    }
    let _ = Settings::without_record(Some(&vendor));
    if let Ok(vendor) = VendorConfig::decode(&summed(&vendor))
        && let Ok((settings, sequence)) = Settings::decode(&settings[0][1])
    {
        assert!(settings.with_vendor(&vendor).encode(sequence).is_ok());
    }
}

/// A decoded record would have been written the same, and holds once it is written into the other
/// slot.
fn holds<R: Record + Debug>(a: &[u8], b: &[u8]) {
    for slot in [a, b] {
        if let Ok((record, sequence)) = R::decode(slot) {
            let written = record.encode(sequence).unwrap();
            let written = written.as_ref();
            // What an older version has written is written anew as the newest.
            if slot[4] == written[4] {
                assert_eq!(written, &slot[..R::LENGTH]);
            }
            assert_eq!(R::decode(written), Ok((record, sequence)));
        }
    }
    let slots = Slots::<R>::read(a, b);
    let Some(newest) = slots.newest() else { return };
    let write = slots.write(newest).unwrap();
    assert_ne!(Some(write.slot()), slots.newest_slot());
    let after = match write.slot() {
        Slot::A => Slots::<R>::read(write.bytes(), b),
        Slot::B => Slots::<R>::read(a, write.bytes()),
    };
    assert_eq!((after.newest(), after.newest_slot()), (Some(newest), Some(write.slot())));
}

/// Each boot has a higher epoch than the one before, also where one slot is misread.
fn epochs_rise(a: &[u8], b: &[u8], keys: &KeysRecord) {
    let used = Ledger::EMPTY.with(keys);
    for ledger in [Ledger::EMPTY, used] {
        let Ok(first) = epoch::next(&Slots::read(a, b), keys, &ledger, 5) else { continue };
        let [one, other] = [first.writes[0].bytes(), first.writes[1].bytes()];
        assert_ne!(first.writes[0].slot(), first.writes[1].slot());
        let epoch = first.kept([one, other]).unwrap();
        for (a, b) in [(one, other), (one, &[][..]), (&[], other)] {
            if let Ok(then) = epoch::next(&Slots::read(a, b), keys, &used, 5) {
                let [one, other] = [then.writes[0].bytes(), then.writes[1].bytes()];
                assert!(then.kept([one, other]).unwrap() > epoch);
            }
        }
    }
}

/// The record with the CRC-32 that it should have.
fn mended(record: &[u8]) -> Vec<u8> {
    let mut record = record.to_vec();
    if let Some((body, crc)) = record.split_last_chunk_mut::<4>() {
        let sum = !body.iter().fold(!0_u32, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
            })
        });
        *crc = sum.to_le_bytes();
    }
    record
}

/// The vendor's block with the sum that it should have.
fn summed(block: &[u8]) -> Vec<u8> {
    let mut block = block.to_vec();
    if let Some((sum, body)) = block.split_last_mut() {
        *sum = body.iter().fold(0, |sum, byte| sum.wrapping_add(*byte));
    }
    block
}
