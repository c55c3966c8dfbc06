//! That no epoch is ever used twice: the record's bytes, each state that two slots can be in, and
//! drones that are switched on, cut off and provisioned in any order.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{Cut, Memory, Power, mended, seeded};
use proptest::prelude::*;
use storage::epoch::{EpochError, EpochRecord, Issue, LENGTH, Next, next};
use storage::keys::{KeysRecord, Page, Secret};
use storage::ledger::{FLEETS, Ledger};
use storage::{Readings, Record, Slot, Slots};
use units::{NodeId, Role};
use wire::p2p::Epoch;

const FLEET: u32 = 0x8765_4321;
const BLANK: [u8; LENGTH] = [0xFF; LENGTH];
const GARBAGE: [u8; LENGTH] = [0x5A; LENGTH];

fn keys_of(fleet: u32, issue: Issue) -> KeysRecord {
    KeysRecord {
        fleet,
        generation: 1,
        issue,
        node: NodeId(3),
        role: Role::Relay,
        may_fly: false,
        group: Secret::new([1; 16]),
        own: Secret::new([2; 16]),
    }
}

fn issue(number: u8) -> Issue {
    Issue::new(number).unwrap()
}

/// The first epoch of an issue.
fn first(number: u8) -> u32 {
    Issue::EPOCHS * u32::from(number)
}

/// By the table in the module's documentation; the CRC by Python's `zlib.crc32`.
fn golden(epoch: u32, fleet: u32) -> [u8; LENGTH] {
    let mut record = *b"UCHE\x01eeeffffcccc";
    record[5..8].copy_from_slice(&epoch.to_le_bytes()[..3]);
    record[8..12].copy_from_slice(&fleet.to_le_bytes());
    seal(record)
}

/// The same with the right CRC.
fn seal(record: [u8; LENGTH]) -> [u8; LENGTH] {
    mended(record.to_vec()).try_into().unwrap()
}

/// What `next` makes of the bytes of two slots.
fn next_of(a: &[u8], b: &[u8], keys: &KeysRecord, ledger: &Ledger) -> Result<Next, EpochError> {
    next(&Slots::read(a, b), keys, ledger, RANDOM)
}

/// The random number of the tests, of which the lower 15 bits count.
const RANDOM: u32 = 0x8000_0064;
const FIRST: u32 = 0x64;

fn epoch_of(next: &Next) -> u32 {
    next.kept([next.writes[0].bytes(), next.writes[1].bytes()]).unwrap().get()
}

#[test]
fn the_bytes_are_those_of_the_table() {
    let record = golden(first(3) + 5, FLEET);
    assert_eq!(
        record,
        [
            b'U', b'C', b'H', b'E', 1, 0x08, 0x03, 0x03, 0x21, 0x43, 0x65, 0x87, //
            0xA5, 0xA1, 0xBA, 0xB6,
        ]
    );
    let keys = keys_of(FLEET, issue(3));
    let before = golden(first(3) + 4, FLEET);
    let next = next_of(&before, &before, &keys, &Ledger::EMPTY.with(&keys)).unwrap();
    assert_eq!(next.writes.map(|write| write.bytes().to_vec()), [record, record]);
    assert_eq!(next.writes.map(|write| write.slot()), [Slot::B, Slot::A]);
}

/// The slot that is written first, and the epoch that `next` chooses under issue 3.
fn of(a: &[u8], b: &[u8], used: bool) -> Result<(Slot, u32), EpochError> {
    let keys = keys_of(FLEET, issue(3));
    let ledger = if used { Ledger::EMPTY.with(&keys) } else { Ledger::EMPTY };
    let next = next_of(a, b, &keys, &ledger)?;
    Ok((next.writes[0].slot(), epoch_of(&next)))
}

#[test]
fn each_state_of_two_slots_has_one_answer() {
    let ours = |n| golden(first(3) + n, FLEET);
    let old = golden(first(2) + 7, FLEET);
    let foreign = golden(first(3) + 7, FLEET + 1);
    let later = golden(first(4), FLEET);
    let mut version = BLANK;
    version.copy_from_slice(&ours(9));
    version[4] = 2;
    let version = seal(version);
    let fresh = first(3);
    for used in [true, false] {
        let of = |a: &[u8], b: &[u8]| of(a, b, used);
        assert_eq!(of(&ours(5), &ours(4)), Ok((Slot::B, fresh + 6)));
        assert_eq!(of(&ours(4), &ours(5)), Ok((Slot::A, fresh + 6)));
        assert_eq!(of(&ours(5), &ours(5)), Ok((Slot::B, fresh + 6)));
        assert_eq!(of(&ours(5), &old), Ok((Slot::B, fresh + 6)));
        // The slot that cannot be read may have held the next one.
        for other in [BLANK, GARBAGE, foreign] {
            assert_eq!(of(&ours(5), &other), Ok((Slot::B, fresh + 7)));
            assert_eq!(of(&other, &ours(5)), Ok((Slot::A, fresh + 7)));
        }
        // An old page on a drone that has had a later one.
        assert_eq!(of(&later, &ours(5)), Err(EpochError::Older));
        assert_eq!(of(&BLANK, &later), Err(EpochError::Older));
        // The last of an issue, and none of the next.
        let [last_but_one, last] = [2, 1].map(|n| ours(Issue::EPOCHS - n));
        assert_eq!(of(&last_but_one, &last_but_one), Ok((Slot::B, first(4) - 1)));
        assert_eq!(of(&last, &last_but_one), Err(EpochError::Spent));
        assert_eq!(of(&last_but_one, &BLANK), Err(EpochError::Spent));
    }
    // Nothing of this issue yet, or what may hide a higher epoch: closed, unless nothing of the
    // issue can have been used.
    for a in [BLANK, GARBAGE, foreign, old] {
        for b in [BLANK, GARBAGE, foreign, old] {
            assert_eq!(of(&a, &b, true), Err(EpochError::Lost));
            assert_eq!(of(&a, &b, false).map(|(_, epoch)| epoch), Ok(fresh + FIRST));
        }
    }
    assert_eq!(of(&old, &GARBAGE, false), Ok((Slot::B, fresh + FIRST)));
    assert_eq!(of(&foreign, &GARBAGE, false), Ok((Slot::B, fresh + FIRST)));
    assert_eq!(of(&GARBAGE, &foreign, false), Ok((Slot::A, fresh + FIRST)));
    assert_eq!(of(&[], &[], true), Err(EpochError::Lost));
    assert_eq!(of(&ours(5), &version, true), Err(EpochError::Version(2)));
    assert_eq!(of(&version, &BLANK, true), Err(EpochError::Version(2)));
    assert_eq!(of(&version, &old, false), Ok((Slot::A, fresh + FIRST)));
}

/// The slot with the last epoch was misread once, and the drone took the other slot's successor: the
/// epoch of the boot before.
#[test]
fn a_slot_that_is_misread_brings_no_epoch_back() {
    let keys = keys_of(FLEET, issue(3));
    let ledger = Ledger::EMPTY.with(&keys);
    let mut slots = [golden(first(3), FLEET); 2];
    let mut used = BTreeSet::from([first(3)]);
    for misread in [0, 1, 1, 0, 0, 1] {
        let mut read = slots;
        read[misread] = GARBAGE;
        let next = next_of(&read[0], &read[1], &keys, &ledger).unwrap();
        assert!(used.insert(epoch_of(&next)));
        for write in &next.writes {
            slots[usize::from(write.slot() == Slot::B)].copy_from_slice(write.bytes());
        }
    }
}

#[test]
fn an_epoch_that_is_not_read_back_from_both_slots_is_none() {
    let next = next_of(&BLANK, &BLANK, &keys_of(FLEET, issue(1)), &Ledger::EMPTY).unwrap();
    let bytes = next.writes[0].bytes();
    assert_eq!(next.kept([bytes; 2]), Epoch::new(first(1) + FIRST));
    for bad in [&BLANK[..], &bytes[..LENGTH - 1]] {
        assert_eq!(next.kept([bytes, bad]), None);
        assert_eq!(next.kept([bad, bytes]), None);
    }
    for bit in 0..8 * LENGTH {
        let mut read_back = bytes.to_vec();
        read_back[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(next.kept([bytes, &read_back]), None);
    }
}

/// Each issue's epochs lie between its first and the next issue's, and all of them fit.
#[test]
fn issues_share_no_epoch_and_the_last_one_fits() {
    let mut issue = Issue::FIRST;
    let mut number = 1;
    loop {
        assert_eq!(issue.get(), number);
        let keys = keys_of(FLEET, issue);
        let epoch = |record: &[u8]| {
            let next = next_of(record, record, &keys, &Ledger::EMPTY)?;
            Ok::<_, EpochError>(epoch_of(&next))
        };
        assert_eq!(epoch(&BLANK), Ok(first(number) + FIRST));
        let last = first(number) + Issue::EPOCHS - 1;
        assert_eq!(epoch(&golden(last - 1, FLEET)), Ok(last));
        assert_eq!(epoch(&golden(last, FLEET)), Err(EpochError::Spent));
        match issue.next() {
            Some(next) => (issue, number) = (next, number + 1),
            None => break,
        }
    }
    assert_eq!(issue, Issue::LAST);
    assert!(first(255) <= 1 << 24);
    assert_eq!((Issue::new(0), Issue::new(255)), (None, None));
}

#[test]
fn the_ledger_remembers_the_last_issue_of_the_last_fleets() {
    let fleets = FLEETS as u32;
    let mut ledger = Ledger::EMPTY;
    for fleet in 0..=fleets {
        assert!(!ledger.has(&keys_of(fleet, issue(1))));
        ledger = ledger.with(&keys_of(fleet, issue(4)));
    }
    assert_eq!(ledger.last_issue(0), None, "the first of nine");
    for fleet in 1..=fleets {
        let has = [3, 4, 5].map(|number| ledger.has(&keys_of(fleet, issue(number))));
        assert_eq!(has, [true, true, false]);
    }
    let ledger = ledger.with(&keys_of(1, issue(5)));
    assert!((1..=fleets).all(|fleet| ledger.last_issue(fleet).is_some()), "no fleet twice");
    let bytes = ledger.encode(7).unwrap();
    assert_eq!(Ledger::decode(&bytes), Ok((ledger, 7)));
}

/// What a boot came to.
#[derive(Debug)]
enum Fate {
    /// The drone seals with this epoch of these keys.
    Speaks(KeysRecord, Epoch),
    Silent,
}

/// A drone's memory, and the page that lies in its flash.
struct Drone {
    eeprom: Memory,
    page: Option<Vec<u8>>,
}

/// Attempts at each step, as the firmware makes them.
const TRIES: usize = 6;

impl Drone {
    fn new() -> Self {
        Self { eeprom: Memory::filled_with(0xFF, 32), page: None }
    }

    /// Reads until two readings agree; `None` where none do.
    fn read(&self, address: u16, length: usize, power: &mut Power) -> Option<Vec<u8>> {
        let mut readings = Readings::new();
        (0..TRIES).find_map(|_| {
            let mut bytes = [0; 64];
            bytes[..length].copy_from_slice(self.eeprom.at(address, length));
            if power.misreads() {
                let bit = power.draw() as usize % (8 * length);
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            readings.confirm(bytes).then(|| bytes[..length].to_vec())
        })
    }

    fn slots<R: Record>(&self, power: &mut Power) -> Option<Slots<R>> {
        let [a, b] = R::ADDRESSES.map(|address| self.read(address, R::LENGTH, power));
        Some(Slots::read(&a?, &b?))
    }

    /// Writes a record into both slots, as the firmware does; whether it is in both.
    fn keep_twice<R: Record>(&mut self, record: &R, power: &mut Power) -> Result<bool, Cut> {
        for _ in 0..TRIES {
            let Some(slots) = self.slots::<R>(power) else { continue };
            if slots.both_hold(record) {
                return Ok(true);
            }
            let write = slots.write(record).unwrap();
            self.eeprom.write(write.address(), write.bytes(), power)?;
        }
        Ok(false)
    }

    /// The keys, after those of the page were taken over.
    fn keys(&mut self, ledger: &Ledger, power: &mut Power) -> Result<Option<KeysRecord>, Cut> {
        let Some(slots) = self.slots::<KeysRecord>(power) else { return Ok(None) };
        let current = slots.newest().copied();
        let page = self.page.clone().unwrap_or_default();
        let keys = match KeysRecord::on_page(&page, current.as_ref(), ledger) {
            Page::New { keys, .. } => Some(keys),
            _ => current,
        };
        let Some(keys) = keys else { return Ok(None) };
        if !self.keep_twice(&keys, power)? {
            return Ok(None);
        }
        // Wiping it can be cut short, too; torn it is no record.
        let wiped = power.spend();
        if wiped || power.draw().is_multiple_of(2) {
            self.page = None;
        }
        if wiped { Ok(Some(keys)) } else { Err(Cut) }
    }

    /// Switched on: the keys and the epoch that it then seals with, unless power goes first.
    fn boot(&mut self, power: &mut Power) -> Result<Fate, Cut> {
        let Some(ledgers) = self.slots::<Ledger>(power) else { return Ok(Fate::Silent) };
        let ledger = ledgers.newest().copied().unwrap_or(Ledger::EMPTY);
        let Some(keys) = self.keys(&ledger, power)? else { return Ok(Fate::Silent) };
        let Some(slots) = self.slots(power) else { return Ok(Fate::Silent) };
        let random = power.draw() as u32;
        let Ok(next) = next(&slots, &keys, &ledger, random) else { return Ok(Fate::Silent) };
        let mut read_back = Vec::new();
        for write in &next.writes {
            self.eeprom.write(write.address(), write.bytes(), power)?;
            let read = self.read(write.address(), EpochRecord::LENGTH, power);
            read_back.push(read.unwrap_or_default());
        }
        let Some(epoch) = next.kept([&read_back[0], &read_back[1]]) else {
            return Ok(Fate::Silent);
        };
        if !ledger.has(&keys) && !self.keep_twice(&ledger.with(&keys), power)? {
            return Ok(Fate::Silent);
        }
        Ok(Fate::Speaks(keys, epoch))
    }
}

#[derive(Clone, Copy, Debug)]
enum Act {
    /// Switched on, perhaps cut off after so many bytes, on a bus that may turn bits over.
    Boot { drone: usize, cut: Option<usize>, misreads: u8, random: u64 },
    /// A byte of a slot of epochs or keys decays.
    Decay { drone: usize, record: usize, slot: usize, byte: usize },
    /// A page of this fleet for this node is made and loaded.
    Provision { drone: usize, fleet: u32, node: u8 },
    /// The page that was loaded so many pages ago is loaded once more into the same drone, whatever
    /// fleets it was in since.
    Reload { drone: usize, back: usize },
}

const DRONES: usize = 3;

fn acts() -> impl Strategy<Value = Vec<Act>> {
    let misreads = prop_oneof![2 => Just(0), 1 => 1..60_u8];
    let boot = (0..DRONES, prop::option::of(0..400_usize), misreads, any::<u64>())
        .prop_map(|(drone, cut, misreads, random)| Act::Boot { drone, cut, misreads, random });
    let provision = (0..DRONES, 0..3_u32, 0..2_u8)
        .prop_map(|(drone, fleet, node)| Act::Provision { drone, fleet, node });
    let reload = (0..DRONES, 0..5_usize).prop_map(|(drone, back)| Act::Reload { drone, back });
    let decay = (0..DRONES, 0..2_usize, 0..2_usize, 0..LENGTH)
        .prop_map(|(drone, record, slot, byte)| Act::Decay { drone, record, slot, byte });
    prop::collection::vec(prop_oneof![8 => boot, 2 => provision, 2 => reload, 1 => decay], 1..120)
}

/// Everything that happens to a bag of drones, and what came of it.
struct Fleet {
    drones: Vec<Drone>,
    /// The last issue of each fleet.
    issued: [Option<Issue>; 3],
    /// The pages that each drone was given.
    pages: Vec<Vec<KeysRecord>>,
    /// What has been sealed with.
    used: BTreeMap<(u32, u8), BTreeSet<u32>>,
    last: BTreeMap<(usize, u32), u32>,
}

impl Fleet {
    fn new() -> Self {
        Self {
            drones: (0..DRONES).map(|_| Drone::new()).collect(),
            issued: [None; 3],
            pages: vec![Vec::new(); DRONES],
            used: BTreeMap::new(),
            last: BTreeMap::new(),
        }
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Boot { drone, cut, misreads, random } => {
                let mut power = Power { left: cut, random, misreads };
                if let Ok(Fate::Speaks(keys, epoch)) = self.drones[drone].boot(&mut power) {
                    self.uses(drone, &keys, epoch.get());
                }
            }
            Act::Decay { drone, record, slot, byte } => {
                let records = [EpochRecord::ADDRESSES, KeysRecord::ADDRESSES];
                let at = usize::from(records[record][slot]) + byte;
                self.drones[drone].eeprom.bytes[at] ^= 0x10;
            }
            Act::Provision { drone, fleet, node } => {
                let issued = &mut self.issued[fleet as usize];
                let issue = issued.map_or(Some(Issue::FIRST), Issue::next).unwrap();
                *issued = Some(issue);
                let keys = KeysRecord { node: NodeId(node), ..keys_of(fleet, issue) };
                self.drones[drone].page = Some(keys.encode(0).unwrap().to_vec());
                self.pages[drone].push(keys);
            }
            Act::Reload { drone, back } => {
                let pages = &self.pages[drone];
                if let Some(old) = pages.len().checked_sub(1 + back).map(|at| pages[at]) {
                    self.drones[drone].page = Some(old.encode(0).unwrap().to_vec());
                }
            }
        }
    }

    /// The claim: under the same keys and number no epoch comes twice, not even on another drone,
    /// and on one drone they rise.
    fn uses(&mut self, drone: usize, keys: &KeysRecord, epoch: u32) {
        let name = (keys.fleet, keys.node.0);
        assert!(self.used.entry(name).or_default().insert(epoch), "{epoch} of {name:?} again");
        let last = self.last.insert((drone, keys.fleet), epoch);
        assert!(last.is_none_or(|last| last < epoch), "drone {drone}: {epoch} after {last:?}");
    }
}

proptest! {
    #![proptest_config(seeded(1_000))]

    #[test]
    fn no_epoch_is_used_twice_whatever_happens(acts in acts()) {
        let mut fleet = Fleet::new();
        for act in acts {
            fleet.act(act);
        }
    }

    /// Not by staying silent: once power stays, a drone that was provisioned speaks.
    #[test]
    fn a_drone_whose_power_was_cut_any_number_of_times_speaks_again(
        cuts in prop::collection::vec((0..400_usize, any::<u64>()), 0..40), spare in any::<bool>(),
    ) {
        let mut fleet = Fleet::new();
        fleet.act(Act::Provision { drone: 0, fleet: 0, node: 1 });
        if spare {
            fleet.act(Act::Boot { drone: 0, cut: None, misreads: 0, random: 1 });
        }
        for (cut, random) in cuts {
            fleet.act(Act::Boot { drone: 0, cut: Some(cut), misreads: 0, random });
        }
        let spoke = fleet.drones[0].boot(&mut Power { left: None, random: 0, misreads: 0 });
        prop_assert!(matches!(spoke, Ok(Fate::Speaks(..))));
    }

    #[test]
    fn any_bytes_in_the_slots_give_an_epoch_of_the_issue_or_an_error(
        a in prop::collection::vec(any::<u8>(), 0..20), b in any::<[u8; LENGTH]>(), n in 1_u8..=254,
    ) {
        if let Ok(next) = next_of(&a, &b, &keys_of(FLEET, issue(n)), &Ledger::EMPTY) {
            let epoch = epoch_of(&next);
            prop_assert!((first(n)..first(n) + Issue::EPOCHS).contains(&epoch));
        }
    }
}

/// Every byte at which a boot can be cut, and every byte of the boot after it.
#[test]
fn no_byte_is_a_bad_moment() {
    // Keys, epoch and ledger, each twice, and the wiping of the page.
    const BYTES: usize = 2 * (56 + 16 + 53) + 1;
    for (cut, again) in (0..=BYTES).flat_map(|cut| (0..=BYTES).map(move |again| (cut, again))) {
        let mut fleet = Fleet::new();
        fleet.act(Act::Provision { drone: 0, fleet: 0, node: 1 });
        for cut in [Some(cut), Some(again), None, Some(cut), Some(again), None] {
            fleet.act(Act::Boot { drone: 0, cut, misreads: 0, random: 7 });
        }
        assert!(fleet.used[&(0, 1)].len() >= 2, "cut after {cut}, then {again}");
    }
}

/// A drone that has had another fleet's keys in between began the first fleet's epochs anew when
/// it was given the old page again.
#[test]
fn an_old_page_is_not_taken_again_after_another_fleets() {
    let mut fleet = Fleet::new();
    let boot = |random| Act::Boot { drone: 0, cut: None, misreads: 0, random };
    fleet.act(Act::Provision { drone: 0, fleet: 0, node: 1 });
    fleet.act(boot(1));
    fleet.act(Act::Provision { drone: 0, fleet: 1, node: 1 });
    fleet.act(boot(2));
    fleet.act(Act::Reload { drone: 0, back: 1 });
    fleet.act(boot(1));
    assert_eq!(fleet.used[&(0, 1)].len(), 1);
    assert_eq!(fleet.used[&(1, 1)].len(), 2, "the drone keeps the later fleet's keys");
}

/// The keys of the fleet that a drone was in before stayed in the second slot.
#[test]
fn no_earlier_key_stays_in_the_memory() {
    let mut drone = Drone::new();
    let power = &mut Power { left: None, random: 1, misreads: 0 };
    for (number, secret) in [(1, 0xA1), (2, 0xB2)] {
        let secret = Secret::new([secret; 16]);
        let keys = KeysRecord { group: secret, own: secret, ..keys_of(FLEET, issue(number)) };
        drone.page = Some(keys.encode(0).unwrap().to_vec());
        assert!(matches!(drone.boot(power), Ok(Fate::Speaks(..))));
    }
    assert!(!drone.eeprom.bytes.windows(4).any(|bytes| bytes == [0xA1; 4]));
}
