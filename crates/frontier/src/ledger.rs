//! What a robot says of tiles, with versions, so that only what has changed is sent.

use heapless::Vec;

use crate::list::insert;
use crate::packet::{Changes, MOST_CHANGES};
use crate::tile::{Mark, Tile};

#[derive(Clone, Copy, Debug)]
struct Record {
    tile: Tile,
    /// The mark's code: a mark takes two bytes, and there are hundreds.
    code: u8,
    /// Whether an earlier mark of the tile was put into a packet.
    was_told: bool,
    /// The ledger's version when the mark was set.
    version: u16,
}

impl Record {
    fn mark(&self) -> Mark {
        // Each code is that of a mark.
        Mark::of_code(self.code).unwrap_or(Mark::Gone)
    }
}

/// The marks of one robot, at most `RECORDS`. A ledger changes at most 65,535 times; a robot of the
/// simulator changes its own 3 to 10 times a second.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger<const RECORDS: usize> {
    /// In the order of tiles.
    records: Vec<Record, RECORDS>,
    version: u16,
    /// The version up to which changes were put into packets, and that up to which each robot of the cluster
    /// has them.
    told: u16,
    acknowledged: u16,
    /// Whether there was no room for a mark since this was last asked.
    lacked_room: bool,
}

impl<const RECORDS: usize> Ledger<RECORDS> {
    pub(crate) const fn new() -> Self {
        Self { records: Vec::new(), version: 0, told: 0, acknowledged: 0, lacked_room: false }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.records.clear();
        (self.version, self.told, self.acknowledged) = (0, 0, 0);
        self.lacked_room = false;
    }

    /// Whether there was no room for a mark since this was last asked.
    pub(crate) const fn take_lacked_room(&mut self) -> bool {
        core::mem::replace(&mut self.lacked_room, false)
    }

    pub(crate) const fn version(&self) -> u16 {
        self.version
    }

    /// The mark of a tile; [`Mark::Gone`] where none was set.
    pub(crate) fn mark(&self, tile: Tile) -> Mark {
        let at = self.records.binary_search_by_key(&tile, |record| record.tile);
        at.ok().and_then(|at| self.records.get(at)).map_or(Mark::Gone, Record::mark)
    }

    /// Sets the mark of a tile; says whether it did, for which it must differ and there must be
    /// room.
    pub(crate) fn set(&mut self, tile: Tile, mark: Mark) -> bool {
        let Some(version) = self.version.checked_add(1) else { return false };
        let mut fresh = Record { tile, code: mark.code(), was_told: false, version };
        match self.records.binary_search_by_key(&tile, |record| record.tile) {
            Ok(at) => {
                let Some(record) = self.records.get_mut(at) else { return false };
                if record.mark() == mark {
                    return false;
                }
                fresh.was_told = record.was_told || record.version <= self.told;
                if mark == Mark::Gone && !fresh.was_told {
                    // No packet has told of the tile.
                    self.forget(tile);
                    return true;
                }
                *record = fresh;
            }
            Err(_) if mark == Mark::Gone => return false,
            Err(_) => {
                if self.records.is_full() {
                    self.make_room();
                }
                let at = self.records.partition_point(|record| record.tile < tile);
                if !insert(&mut self.records, at, fresh) {
                    self.lacked_room = true;
                    return false;
                }
            }
        }
        self.version = version;
        true
    }

    /// Forgets the mark that was taken back last among those of which the whole cluster knows that they were.
    /// A robot that is out of range most likely never heard of that tile; if it did, it takes it for a frontier
    /// when it is back, flies there and sees that it is none.
    fn make_room(&mut self) {
        let is_free = |r: &&Record| r.mark() == Mark::Gone && r.version <= self.acknowledged;
        let last = self.records.iter().filter(is_free).max_by_key(|record| record.version);
        if let Some(tile) = last.map(|record| record.tile) {
            self.forget(tile);
        }
    }

    fn forget(&mut self, tile: Tile) {
        self.records.retain(|record| record.tile != tile);
    }

    /// The oldest changes after `base`, as many as a packet carries; `None` where there are none.
    pub(crate) fn changes_after(&mut self, base: u16) -> Option<Changes> {
        let mut changes = Changes { base, upto: base, marks: Vec::new() };
        while changes.marks.len() < MOST_CHANGES {
            let is_later = |record: &&Record| record.version > changes.upto;
            let Some(next) = self.records.iter().filter(is_later).min_by_key(|r| r.version) else {
                break;
            };
            changes.upto = next.version;
            // There is room for as many as the packet carries.
            let _ = changes.marks.push((next.tile, next.mark()));
        }
        if changes.marks.len() < MOST_CHANGES {
            changes.upto = self.version;
        }
        if changes.upto <= base {
            return None;
        }
        self.told = self.told.max(changes.upto);
        Some(changes)
    }

    /// Notes that there was no room for a mark elsewhere.
    pub(crate) const fn lack_room(&mut self) {
        self.lacked_room = true;
    }

    /// Forgets what was taken back up to a version that every robot has, and notes up to which version those
    /// of the cluster have the changes.
    pub(crate) fn forget_gone(&mut self, known_to_all: u16, acknowledged: u16) {
        self.acknowledged = acknowledged;
        self.records.retain(|record| record.mark() != Mark::Gone || record.version > known_to_all);
    }
}
