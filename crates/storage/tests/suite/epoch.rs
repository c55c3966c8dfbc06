//! That no epoch is ever used twice: the record's bytes, each state that two slots can be in, and
//! drones that are switched on, cut off and provisioned in any order.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{Cut, Memory, Power, mended, seeded};
use proptest::prelude::*;
use storage::epoch::{EpochError, EpochRecord, Issue, LENGTH, Next, Provisioned, next};
use storage::keys::{KeysRecord, Secret};
use storage::{Record, Slot, Slots};
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
fn next_of(
    a: &[u8],
    b: &[u8],
    keys: &KeysRecord,
    provisioned: Provisioned,
) -> Result<Next, EpochError> {
    next(&Slots::read(a, b), keys, provisioned)
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
    let next = next_of(&golden(first(3) + 4, FLEET), &BLANK, &keys, BEFORE);
    assert_eq!(next.unwrap().write.bytes(), record);
}

const BEFORE: Provisioned = Provisioned::Before;
const NOW: Provisioned = Provisioned::Now;

/// The slot and the epoch that `next` chooses under issue 3.
fn of(a: &[u8], b: &[u8], provisioned: Provisioned) -> Result<(Slot, u32), EpochError> {
    let next = next_of(a, b, &keys_of(FLEET, issue(3)), provisioned)?;
    Ok((next.write.slot(), next.kept(next.write.bytes()).unwrap().get()))
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
    for provisioned in [BEFORE, NOW] {
        let of = |a: &[u8], b: &[u8]| of(a, b, provisioned);
        assert_eq!(of(&ours(5), &ours(4)), Ok((Slot::B, fresh + 6)));
        assert_eq!(of(&ours(4), &ours(5)), Ok((Slot::A, fresh + 6)));
        assert_eq!(of(&ours(5), &ours(5)), Ok((Slot::B, fresh + 6)));
        for other in [BLANK, GARBAGE, old, foreign] {
            assert_eq!(of(&ours(5), &other), Ok((Slot::B, fresh + 6)));
            assert_eq!(of(&other, &ours(5)), Ok((Slot::A, fresh + 6)));
        }
        // Nothing of this issue yet.
        assert_eq!(of(&BLANK, &BLANK), Ok((Slot::A, fresh)));
        for other in [BLANK, GARBAGE, foreign] {
            assert_eq!(of(&old, &other), Ok((Slot::B, fresh)));
            assert_eq!(of(&other, &old), Ok((Slot::A, fresh)));
        }
        assert_eq!(of(&foreign, &foreign), Ok((Slot::A, fresh)));
        assert_eq!(of(&foreign, &GARBAGE), Ok((Slot::B, fresh)));
        assert_eq!(of(&GARBAGE, &foreign), Ok((Slot::A, fresh)));
        assert_eq!(of(&BLANK, &GARBAGE), Ok((Slot::A, fresh)));
        assert_eq!(of(&GARBAGE, &BLANK), Ok((Slot::A, fresh)));
        // An old page on a drone that has had a later one.
        assert_eq!(of(&later, &ours(5)), Err(EpochError::Older));
        assert_eq!(of(&BLANK, &later), Err(EpochError::Older));
        // The last of an issue, and none of the next.
        assert_eq!(of(&ours(Issue::EPOCHS - 2), &BLANK), Ok((Slot::B, first(4) - 1)));
        assert_eq!(of(&ours(Issue::EPOCHS - 1), &BLANK), Err(EpochError::Spent));
    }
    // What may hide a higher epoch: closed, unless nothing of the issue can have been used.
    assert_eq!(of(&GARBAGE, &GARBAGE, BEFORE), Err(EpochError::Lost));
    assert_eq!(of(&GARBAGE, &GARBAGE, NOW), Ok((Slot::A, fresh)));
    assert_eq!(of(&[], &[], BEFORE), Err(EpochError::Lost));
    assert_eq!(of(&ours(5), &version, BEFORE), Err(EpochError::Version(2)));
    assert_eq!(of(&version, &BLANK, BEFORE), Err(EpochError::Version(2)));
    assert_eq!(of(&version, &old, NOW), Ok((Slot::A, fresh)));
}

#[test]
fn an_epoch_that_is_not_read_back_is_none() {
    let next = next_of(&BLANK, &BLANK, &keys_of(FLEET, issue(1)), NOW).unwrap();
    assert_eq!(next.kept(next.write.bytes()), Epoch::new(first(1)));
    assert_eq!(next.kept(&BLANK), None);
    assert_eq!(next.kept(&next.write.bytes()[..LENGTH - 1]), None);
    for bit in 0..8 * LENGTH {
        let mut read_back = next.write.bytes().to_vec();
        read_back[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(next.kept(&read_back), None);
    }
}

/// Each issue's epochs lie between its first and the next issue's, and all of them fit.
#[test]
fn issues_share_no_epoch_and_the_last_one_fits() {
    let mut issue = Issue::FIRST;
    let mut number = 1;
    loop {
        assert_eq!(issue.get(), number);
        let epoch = |record: &[u8]| {
            let next = next_of(record, &BLANK, &keys_of(FLEET, issue), BEFORE)?;
            Ok::<_, EpochError>(next.kept(next.write.bytes()).unwrap().get())
        };
        assert_eq!(epoch(&BLANK), Ok(first(number)));
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

/// A packet names an epoch by its lower 16 bits: what was recorded under one issue must name
/// nothing of the next ones, for as many boots as there are between their beginnings.
#[test]
fn the_short_name_of_an_epoch_does_not_come_back_with_the_next_issue() {
    let mut names = BTreeSet::new();
    for number in 1..=254 {
        for boot in 0..257 {
            assert!(names.insert((first(number) + boot) as u16), "issue {number}, boot {boot}");
        }
    }
}

/// A drone's memory, and the page that lies in its flash.
struct Drone {
    eeprom: Memory,
    page: Option<Vec<u8>>,
}

impl Drone {
    fn new() -> Self {
        Self { eeprom: Memory::filled_with(0xFF, 32), page: None }
    }

    fn keys(&self) -> Option<KeysRecord> {
        self.eeprom.slots().newest().copied()
    }

    /// As the firmware does it.
    fn take_page(&mut self, power: &mut Power) -> Result<Provisioned, Cut> {
        let Some((page, _)) = self.page.as_ref().and_then(|page| KeysRecord::decode(page).ok())
        else {
            return Ok(Provisioned::Before);
        };
        let mut provisioned = Provisioned::Before;
        if page.supersedes(self.keys().as_ref()) {
            let write = self.eeprom.slots().write(&page).unwrap();
            self.eeprom.write(write.address(), write.bytes(), power)?;
            assert_eq!(self.keys(), Some(page));
            provisioned = Provisioned::Now;
        }
        // Wiping it can be cut short, too; torn it is no record.
        let wiped = power.spend();
        if wiped || power.draw().is_multiple_of(2) {
            self.page = None;
        }
        if wiped { Ok(provisioned) } else { Err(Cut) }
    }

    /// Switched on: the keys and the epoch that it then seals with, unless power goes first.
    fn boot(&mut self, power: &mut Power) -> Result<Option<(KeysRecord, Epoch)>, Cut> {
        let provisioned = self.take_page(power)?;
        let Some(keys) = self.keys() else { return Ok(None) };
        let Ok(next) = next(&self.eeprom.slots(), &keys, provisioned) else { return Ok(None) };
        let address = next.write.address();
        self.eeprom.write(address, next.write.bytes(), power)?;
        let read_back = self.eeprom.at(address, EpochRecord::LENGTH);
        Ok(next.kept(read_back).map(|epoch| (keys, epoch)))
    }
}

#[derive(Clone, Copy, Debug)]
enum Act {
    /// Switched on, perhaps cut off after so many bytes.
    Boot { drone: usize, cut: Option<usize>, random: u64 },
    /// A page of this fleet for this node is made and loaded.
    Provision { drone: usize, fleet: u32, node: u8 },
    /// The page that was loaded so many pages ago is loaded once more into the same drone.
    Reload { drone: usize, back: usize },
}

const DRONES: usize = 3;

fn acts() -> impl Strategy<Value = Vec<Act>> {
    let boot = (0..DRONES, prop::option::of(0..90_usize), any::<u64>())
        .prop_map(|(drone, cut, random)| Act::Boot { drone, cut, random });
    let provision = (0..DRONES, 0..2_u32, 0..2_u8)
        .prop_map(|(drone, fleet, node)| Act::Provision { drone, fleet, node });
    let reload = (0..DRONES, 0..3_usize).prop_map(|(drone, back)| Act::Reload { drone, back });
    prop::collection::vec(prop_oneof![8 => boot, 2 => provision, 1 => reload], 1..120)
}

/// Everything that happens to a bag of drones, and what came of it.
struct Fleet {
    drones: Vec<Drone>,
    /// The last issue of either fleet.
    issued: [Option<Issue>; 2],
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
            issued: [None; 2],
            pages: vec![Vec::new(); DRONES],
            used: BTreeMap::new(),
            last: BTreeMap::new(),
        }
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Boot { drone, cut, random } => {
                let mut power = Power { left: cut, random };
                if let Ok(Some((keys, epoch))) = self.drones[drone].boot(&mut power) {
                    self.uses(drone, &keys, epoch.get());
                }
            }
            Act::Provision { drone, fleet, node } => {
                let issued = &mut self.issued[fleet as usize];
                let issue = issued.map_or(Some(Issue::FIRST), Issue::next).unwrap();
                *issued = Some(issue);
                let keys = KeysRecord { node: NodeId(node), ..keys_of(fleet, issue) };
                self.drones[drone].page = Some(keys.encode(0).unwrap().to_vec());
                self.pages[drone].push(keys);
            }
            // A page of the fleet that it is in: that it was in another in between, and what it
            // used before, is no longer written anywhere.
            Act::Reload { drone, back } => {
                let pages = &self.pages[drone];
                let Some(old) = pages.len().checked_sub(1 + back).map(|at| pages[at]) else {
                    return;
                };
                if pages[pages.len() - 1 - back..].iter().all(|page| page.fleet == old.fleet) {
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
        cuts in prop::collection::vec((0..90_usize, any::<u64>()), 0..40), spare in any::<bool>(),
    ) {
        let mut fleet = Fleet::new();
        fleet.act(Act::Provision { drone: 0, fleet: 0, node: 1 });
        if spare {
            fleet.act(Act::Boot { drone: 0, cut: None, random: 1 });
        }
        for (cut, random) in cuts {
            fleet.act(Act::Boot { drone: 0, cut: Some(cut), random });
        }
        let spoke = fleet.drones[0].boot(&mut Power { left: None, random: 0 });
        prop_assert!(matches!(spoke, Ok(Some(_))));
    }

    #[test]
    fn any_bytes_in_the_slots_give_an_epoch_of_the_issue_or_an_error(
        a in prop::collection::vec(any::<u8>(), 0..20), b in any::<[u8; LENGTH]>(), n in 1_u8..=254,
    ) {
        if let Ok(next) = next_of(&a, &b, &keys_of(FLEET, issue(n)), NOW) {
            let epoch = next.kept(next.write.bytes()).unwrap().get();
            prop_assert!((first(n)..first(n) + Issue::EPOCHS).contains(&epoch));
        }
    }
}

/// Every byte at which a boot can be cut, and every byte of the boot after it.
#[test]
fn no_byte_is_a_bad_moment() {
    for (cut, again) in (0..=80).flat_map(|cut| (0..=80).map(move |again| (cut, again))) {
        let mut fleet = Fleet::new();
        fleet.act(Act::Provision { drone: 0, fleet: 0, node: 1 });
        for cut in [Some(cut), Some(again), None, Some(cut), Some(again), None] {
            fleet.act(Act::Boot { drone: 0, cut, random: 7 });
        }
        assert!(fleet.used[&(0, 1)].len() >= 2, "cut after {cut}, then {again}");
    }
}
