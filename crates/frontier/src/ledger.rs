//! What a robot says of tiles, with versions, so that only what has changed is sent.

use heapless::Vec;

use crate::packet::{Changes, MOST_CHANGES};
use crate::tile::{Mark, Tile};

#[derive(Clone, Copy, Debug)]
struct Record {
    tile: Tile,
    mark: Mark,
    /// The ledger's version when the mark was set.
    version: u16,
}

/// The marks of one robot, at most `RECORDS`. A ledger changes at most 65,535 times; a robot of the
/// simulator changes its own 3 to 10 times a second.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger<const RECORDS: usize> {
    /// In the order of tiles.
    records: Vec<Record, RECORDS>,
    version: u16,
    /// Whether there was no room for a mark since this was last asked.
    lacked_room: bool,
}

impl<const RECORDS: usize> Ledger<RECORDS> {
    pub(crate) const fn new() -> Self {
        Self { records: Vec::new(), version: 0, lacked_room: false }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.records.clear();
        self.version = 0;
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
        at.ok().and_then(|at| self.records.get(at)).map_or(Mark::Gone, |record| record.mark)
    }

    /// Sets the mark of a tile; says whether it did, for which it must differ and there must be
    /// room.
    pub(crate) fn set(&mut self, tile: Tile, mark: Mark) -> bool {
        let Some(version) = self.version.checked_add(1) else { return false };
        let fresh = Record { tile, mark, version };
        match self.records.binary_search_by_key(&tile, |record| record.tile) {
            Ok(at) => {
                let Some(record) = self.records.get_mut(at) else { return false };
                if record.mark == mark {
                    return false;
                }
                *record = fresh;
            }
            Err(_) if mark == Mark::Gone => return false,
            Err(at) => {
                if self.records.insert(at, fresh).is_err() {
                    self.lacked_room = true;
                    return false;
                }
            }
        }
        self.version = version;
        true
    }

    /// The oldest changes after `base`, as many as a packet carries; `None` where there are none.
    pub(crate) fn changes_after(&self, base: u16) -> Option<Changes> {
        let mut changes = Changes { base, upto: base, marks: Vec::new() };
        while changes.marks.len() < MOST_CHANGES {
            let is_later = |record: &&Record| record.version > changes.upto;
            let Some(next) = self.records.iter().filter(is_later).min_by_key(|r| r.version) else {
                break;
            };
            changes.upto = next.version;
            // There is room for as many as the packet carries.
            let _ = changes.marks.push((next.tile, next.mark));
        }
        if changes.marks.len() < MOST_CHANGES {
            changes.upto = self.version;
        }
        (changes.upto > base).then_some(changes)
    }

    /// Forgets what was taken back up to a version that every robot has.
    pub(crate) fn forget_gone(&mut self, known_to_all: u16) {
        self.records.retain(|record| record.mark != Mark::Gone || record.version > known_to_all);
    }
}
