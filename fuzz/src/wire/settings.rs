//! What is in the EEPROM: whatever is taken would have been written the same, and what is written
//! next is what then holds.

use wire::settings::epoch::{self, Provisioned};
use wire::settings::keys::{self, KeysRecord};
use wire::settings::{self, Settings, Slot, VENDOR_LENGTH, VendorConfig};

/// The bytes are those of an EEPROM: the slots of the settings, the keys and the epoch, and the
/// vendor's block. As they are, and with sums that are right, which nobody finds by chance.
pub fn check(mut data: &[u8]) {
    let mut record = |length: usize| {
        let (record, rest) = data.split_at(length.min(data.len()));
        data = rest;
        [record.to_vec(), mended(record)]
    };
    let settings = [record(settings::LENGTH), record(settings::LENGTH)];
    let keys = [record(keys::LENGTH), record(keys::LENGTH)];
    let epochs = [record(epoch::LENGTH), record(epoch::LENGTH)];
    let [vendor, _] = record(VENDOR_LENGTH);
    for choice in 0..4 {
        let (a, b) = (choice & 1, choice >> 1);
        settings_hold(&settings[0][a], &settings[1][b]);
        keys_hold(&keys[0][a], &keys[1][b]);
        if let Some(chosen) = keys::newest(&keys[0][1], &keys[1][1]) {
            epochs_rise(&epochs[0][a], &epochs[1][b], &chosen.keys);
        }
    }
    let _ = VendorConfig::decode(&vendor);
    if let Ok(vendor) = VendorConfig::decode(&summed(&vendor))
        && let Ok((settings, sequence)) = Settings::decode(&settings[0][1])
    {
        assert!(settings.with_vendor(&vendor).encode(sequence).is_ok());
    }
}

fn settings_hold(a: &[u8], b: &[u8]) {
    for slot in [a, b] {
        if let Ok((settings, sequence)) = Settings::decode(slot) {
            let written = settings.encode(sequence).unwrap();
            // What an older version has written is written anew as the newest.
            if slot[4] == written[4] {
                assert_eq!(written, slot[..settings::LENGTH]);
            }
            assert_eq!(Settings::decode(&written), Ok((settings, sequence)));
        }
    }
    let Some(current) = settings::newest(a, b) else { return };
    let write = settings::Write::after(Some(&current), &current.settings).unwrap();
    assert_ne!(write.slot, current.slot);
    let after = match write.slot {
        Slot::A => settings::newest(&write.record, b),
        Slot::B => settings::newest(a, &write.record),
    };
    assert_eq!(after.unwrap().slot, write.slot);
}

fn keys_hold(a: &[u8], b: &[u8]) {
    for slot in [a, b] {
        if let Ok((keys, sequence)) = KeysRecord::decode(slot) {
            assert_eq!(keys.encode(sequence).unwrap(), slot[..keys::LENGTH]);
        }
    }
    let Some(current) = keys::newest(a, b) else { return };
    let write = keys::Write::after(Some(&current), &current.keys).unwrap();
    assert_ne!(write.slot, current.slot);
    let after = match write.slot {
        Slot::A => keys::newest(&write.record, b),
        Slot::B => keys::newest(a, &write.record),
    };
    assert_eq!(after.unwrap().slot, write.slot);
}

/// Each boot has a higher epoch than the one before.
fn epochs_rise(a: &[u8], b: &[u8], keys: &KeysRecord) {
    for provisioned in [Provisioned::Now, Provisioned::Before] {
        let Ok(next) = epoch::next(a, b, keys, provisioned) else { continue };
        let first = next.kept(&next.record).unwrap();
        let then = match next.slot {
            Slot::A => epoch::next(&next.record, b, keys, Provisioned::Before),
            Slot::B => epoch::next(a, &next.record, keys, Provisioned::Before),
        };
        if let Ok(then) = then {
            assert!(then.kept(&then.record).unwrap() > first);
            assert_ne!(then.slot, next.slot);
        }
    }
}

/// The same with the CRC-32 that it should have.
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

/// The same with the sum that it should have.
fn summed(block: &[u8]) -> Vec<u8> {
    let mut block = block.to_vec();
    if let Some((sum, body)) = block.split_last_mut() {
        *sum = body.iter().fold(0, |sum, byte| sum.wrapping_add(*byte));
    }
    block
}
