//! What is remembered: the record's bytes, the vendor's block, and that no power cut loses both
//! copies.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::{Dbm, Metres, NodeId, Radians, Role};
use wire::radio::{Address, Channel, Datarate, TxPower};
use wire::settings::{
    Chosen, Error, LENGTH, Limits, Radio, Settings, Slot, Trim, VENDOR_LENGTH, VendorConfig,
    VendorError, Write, newest,
};

fn seeded() -> ProptestConfig {
    ProptestConfig { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

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
};

/// By the table in the module's documentation; the CRC by Python's `zlib.crc32`.
const GOLDEN_BYTES: [u8; LENGTH] = [
    b'U', b'C', b'H', b'N', 2, // version
    0x07, 0x00, 0x00, 0x00, // sequence
    4, 1, // node, relay
    93, 1, 0x04, 0xE7, 0xE7, 0xE7, 0xE7, 0xFC, 0, // channel, 1 Mbit/s, address, -4 dBm
    0x00, 0x00, 0x80, 0x3C, // 2^-6 rad
    0x00, 0x00, 0x00, 0xBD, // -2^-5 rad
    0x00, 0x00, 0x00, 0x3F, // 0.5 m
    0x00, 0x00, 0x50, 0xC2, // -52 dBm
    0x00, 0x00, 0x00, 0x00, // the agent's own
    0x48, 0x34, 0xAF, 0x68,
];

/// The same as version 1 has it, without limits.
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
fn a_record_from_before_there_were_limits_is_read() {
    let settings = Settings { limits: Limits::DEFAULT, ..GOLDEN };
    assert_eq!(Settings::decode(&VERSION_1_BYTES), Ok((settings, 7)));
    let newer = GOLDEN.encode(8).unwrap();
    let chosen = newest(&VERSION_1_BYTES, &newer).map(|chosen| chosen.settings);
    assert_eq!(chosen, Some(GOLDEN));
    assert_eq!(Settings::decode(&VERSION_1_BYTES[..35]), Err(Error::Short));
}

fn settings() -> impl Strategy<Value = Settings> {
    let role = prop::sample::select(&[Role::Head, Role::Relay, Role::Base]);
    let rate = prop::sample::select(&[Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2]);
    let radio = (0_u8..126, rate, any::<[u8; 5]>(), prop::sample::select(&TxPower::ALL)).prop_map(
        |(channel, datarate, address, power)| Radio {
            channel: Channel::new(channel).unwrap(),
            datarate,
            address: Address(address),
            power,
        },
    );
    let trim = (-0.35f32..0.35, -0.35f32..0.35)
        .prop_map(|(pitch, roll)| Trim { pitch: Radians(pitch), roll: Radians(roll) });
    let height = prop::option::of((0.01f32..4.0).prop_map(Metres));
    let limit = || prop::option::of((-96.0f32..=-20.0).prop_map(Dbm));
    let limits = (limit(), limit()).prop_map(|(launch, retreat)| Limits { launch, retreat });
    (any::<u8>(), role, radio, trim, height, limits).prop_map(
        |(node, role, radio, trim, height, limits)| Settings {
            node: NodeId(node),
            role,
            radio,
            trim,
            height,
            limits,
        },
    )
}

/// An EEPROM that loses power in the middle of a write.
struct Eeprom {
    bytes: Vec<u8>,
}

/// Where power goes, and how what is being written then looks afterwards.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// So many bytes have been written.
    after: usize,
    /// What the cell or the page that is being written holds afterwards.
    garbage: u8,
}

/// How many bytes are written at a time: one, or what a page of this size holds.
const UNITS: [usize; 4] = [1, 8, 32, 64];

impl Eeprom {
    fn filled_with(byte: u8) -> Self {
        Self { bytes: vec![byte; 0x2000] }
    }

    fn read(&self, slot: Slot) -> &[u8] {
        &self.bytes[usize::from(slot.address())..][..LENGTH]
    }

    fn newest(&self) -> Option<Chosen> {
        newest(self.read(Slot::A), self.read(Slot::B))
    }

    /// Writes unit by unit, forwards or backwards. The unit that is torn is garbage from its
    /// beginning to its end, also where nothing was to be written.
    fn write(&mut self, write: &Write, unit: usize, backwards: bool, cut: Option<Cut>) {
        let start = usize::from(write.slot.address());
        let mut pieces: Vec<(usize, &[u8])> = write
            .record
            .chunks(unit)
            .enumerate()
            .map(|(i, piece)| (start + i * unit, piece))
            .collect();
        if backwards {
            pieces.reverse();
        }
        let mut written = 0;
        for (at, piece) in pieces {
            if let Some(cut) = cut
                && written + piece.len() > cut.after
            {
                for (i, cell) in self.bytes[at..at + unit].iter_mut().enumerate() {
                    *cell = cut.garbage.wrapping_mul(i as u8 | 1);
                }
                return;
            }
            self.bytes[at..at + piece.len()].copy_from_slice(piece);
            written += piece.len();
        }
    }
}

fn cuts() -> impl Strategy<Value = Option<Cut>> {
    prop::option::of((0..=LENGTH, any::<u8>()).prop_map(|(after, garbage)| Cut { after, garbage }))
}

proptest! {
    #![proptest_config(seeded())]

    #[test]
    fn what_is_written_is_read(settings in settings(), sequence in any::<u32>()) {
        let record = settings.encode(sequence).unwrap();
        prop_assert_eq!(Settings::decode(&record), Ok((settings, sequence)));
    }

    /// The claim: whatever is written, however it is interrupted, what is read afterwards are the
    /// settings from before or the new ones, whole.
    #[test]
    fn a_power_cut_leaves_the_old_settings_or_the_new(
        writes in prop::collection::vec((settings(), cuts()), 1..12),
        blank in any::<u8>(), unit in prop::sample::select(&UNITS), backwards in any::<bool>(),
    ) {
        let mut eeprom = Eeprom::filled_with(blank);
        for (settings, cut) in writes {
            let old = eeprom.newest();
            let write = Write::after(old.as_ref(), &settings).unwrap();
            prop_assert!(old.is_none_or(|old| old.slot != write.slot), "the newer one is kept");
            eeprom.write(&write, unit, backwards, cut);
            let is = eeprom.newest().map(|chosen| chosen.settings);
            let was = old.map(|chosen| chosen.settings);
            if cut.is_none_or(|cut| cut.after >= LENGTH) {
                prop_assert_eq!(is, Some(settings));
            } else {
                prop_assert!(is == was || is == Some(settings), "{is:?} is neither");
            }
            let untouched = |range: core::ops::Range<usize>| {
                eeprom.bytes[range].iter().all(|byte| *byte == blank)
            };
            prop_assert!(untouched(0..0x200) && untouched(0x400..0x2000));
        }
    }

    /// Every byte at which one write can end, for both slots.
    #[test]
    fn no_byte_is_a_bad_moment(old in settings(), new in settings(), garbage in any::<u8>()) {
        for unit in UNITS {
            for (after, rounds) in (0..LENGTH).flat_map(|after| [(after, 1), (after, 2)]) {
                let mut eeprom = Eeprom::filled_with(0xFF);
                for _ in 0..rounds {
                    let write = Write::after(eeprom.newest().as_ref(), &old).unwrap();
                    eeprom.write(&write, unit, false, None);
                }
                let write = Write::after(eeprom.newest().as_ref(), &new).unwrap();
                eeprom.write(&write, unit, false, Some(Cut { after, garbage }));
                let is = eeprom.newest().unwrap().settings;
                prop_assert!(is == old || is == new, "cut after {after} of {unit}: {is:?}");
            }
        }
    }

    #[test]
    fn any_bytes_are_settings_or_an_error(
        bytes in prop::collection::vec(any::<u8>(), 0..64), a in any::<[u8; LENGTH]>(),
    ) {
        let _ = (Settings::decode(&bytes), VendorConfig::decode(&bytes));
        prop_assert_eq!(newest(&bytes, &a), None);
    }

    #[test]
    fn a_disturbed_record_is_none(settings in settings(), at in 0..LENGTH, bit in 0_u8..8) {
        let mut record = settings.encode(7).unwrap();
        record[at] ^= 1 << bit;
        prop_assert!(Settings::decode(&record).is_err());
    }
}

#[test]
fn the_newer_of_two_records_holds_also_where_the_numbers_begin_anew() {
    let record =
        |node, sequence| Settings { node: NodeId(node), ..GOLDEN }.encode(sequence).unwrap();
    let chosen = |a: &[u8], b: &[u8]| newest(a, b).map(|chosen| chosen.settings.node.0);
    assert_eq!(chosen(&record(1, 7), &record(2, 8)), Some(2));
    assert_eq!(chosen(&record(1, 8), &record(2, 7)), Some(1));
    assert_eq!(chosen(&record(1, u32::MAX), &record(2, 0)), Some(2));
    assert_eq!(chosen(&record(1, 7), &[]), Some(1));
    assert_eq!(chosen(&[], &record(2, 7)), Some(2));
    assert_eq!(chosen(&[], &[]), None);
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
    ] {
        assert_eq!(settings.encode(1), Err(Error::Value), "{settings:?}");
        assert_eq!(Write::after(None, &settings), Err(Error::Value));
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
    assert_eq!(Settings::decode(&[0xFF; LENGTH]), Err(Error::Magic));
    assert_eq!(Settings::decode(&with(4, 3)), Err(Error::Version(3)));
    assert_eq!(Settings::decode(&with(9, 5)), Err(Error::Crc));
}

/// A block as the vendor's tools write it.
fn vendor_block(channel: u8, speed: u8, pitch: f32, roll: f32) -> [u8; VENDOR_LENGTH] {
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
fn what_is_no_vendor_block_says_why() {
    let good = vendor_block(80, 2, 0.0, 0.0);
    let with = |at: usize, byte: u8| {
        let mut bytes = good;
        bytes[at] = byte;
        bytes
    };
    assert_eq!(VendorConfig::decode(&good[..20]), Err(VendorError::Short));
    assert_eq!(VendorConfig::decode(&[0xFF; 21]), Err(VendorError::Magic));
    assert_eq!(VendorConfig::decode(&with(4, 0)), Err(VendorError::Version(0)));
    assert_eq!(VendorConfig::decode(&with(5, 81)), Err(VendorError::Checksum));
    for bad in [
        vendor_block(126, 2, 0.0, 0.0),
        vendor_block(80, 3, 0.0, 0.0),
        vendor_block(80, 2, f32::NAN, 0.0),
        vendor_block(80, 2, 0.0, 45.0),
    ] {
        assert_eq!(VendorConfig::decode(&bad), Err(VendorError::Value));
    }
}
