//! What a robot knows of all robots' marks.

use heapless::Vec;

use crate::cluster::RobotSet;
use crate::tile::{Gain, Mark, Tile};

/// The marks of all robots on one tile.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    tile: Tile,
    open: RobotSet,
    settled: RobotSet,
    walls: RobotSet,
    unreachable: RobotSet,
    /// The gain as it was last told.
    gain: Gain,
}

impl Entry {
    fn forget(&mut self, robot: u8) {
        for set in [&mut self.open, &mut self.settled, &mut self.walls, &mut self.unreachable] {
            *set = set.without(robot);
        }
    }

    fn is_empty(&self) -> bool {
        let sets = [self.open, self.settled, self.walls, self.unreachable];
        sets.iter().all(|set| set.is_empty())
    }
}

/// A frontier that a robot may be sent to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The tile.
    pub tile: Tile,
    /// The gain.
    pub gain: Gain,
    /// The robots whose frontier it is.
    pub open: RobotSet,
    /// The robots that have found no way to it.
    pub unreachable: RobotSet,
}

/// The marks of all robots on at most `RECORDS` tiles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Board<const RECORDS: usize> {
    /// In the order of tiles.
    entries: Vec<Entry, RECORDS>,
}

impl<const RECORDS: usize> Board<RECORDS> {
    pub(crate) const fn new() -> Self {
        Self { entries: Vec::new() }
    }

    /// Takes in a robot's mark. Where there is no room for another tile, it does nothing.
    pub(crate) fn apply(&mut self, robot: u8, tile: Tile, mark: Mark) {
        let at = match self.entries.binary_search_by_key(&tile, |entry| entry.tile) {
            Ok(at) => at,
            Err(_) if mark == Mark::Gone => return,
            Err(at) => {
                if self.entries.insert(at, Entry { tile, ..Entry::default() }).is_err() {
                    return;
                }
                at
            }
        };
        let Some(entry) = self.entries.get_mut(at) else { return };
        entry.forget(robot);
        match mark {
            Mark::Gone => {}
            Mark::Settled => entry.settled = entry.settled.with(robot),
            Mark::Wall => entry.walls = entry.walls.with(robot),
            Mark::Unreachable => entry.unreachable = entry.unreachable.with(robot),
            Mark::Frontier(gain) => {
                entry.open = entry.open.with(robot);
                entry.gain = gain;
            }
        }
        if entry.is_empty() {
            self.entries.remove(at);
        }
    }

    /// Forgets all marks of a robot.
    pub(crate) fn forget(&mut self, robot: u8) {
        for entry in &mut self.entries {
            entry.forget(robot);
        }
        self.entries.retain(|entry| !entry.is_empty());
    }

    /// The frontiers that no robot has settled, in the order of tiles.
    pub(crate) fn candidates(&self) -> impl Iterator<Item = Candidate> {
        let open = self.entries.iter().filter(|e| !e.open.is_empty() && e.settled.is_empty());
        open.map(|entry| Candidate {
            tile: entry.tile,
            gain: entry.gain,
            open: entry.open,
            unreachable: entry.unreachable,
        })
    }

    /// Whether a tile is a candidate.
    pub(crate) fn is_candidate(&self, tile: Tile) -> bool {
        let entry = self.entry(tile);
        entry.is_some_and(|entry| !entry.open.is_empty() && entry.settled.is_empty())
    }

    /// The frontiers of other robots that this one has not settled.
    pub(crate) fn to_look_up(&self, robot: u8) -> impl Iterator<Item = Tile> {
        let is_asked = move |entry: &&Entry| {
            !entry.open.without(robot).is_empty()
                && !entry.open.contains(robot)
                && !entry.settled.contains(robot)
        };
        self.entries.iter().filter(is_asked).map(|entry| entry.tile)
    }

    /// The tiles at the edge of what a robot has seen: its frontiers and its walls.
    pub(crate) fn edge(&self, robot: u8) -> impl Iterator<Item = Tile> + Clone {
        let is_edge = move |e: &&Entry| e.open.contains(robot) || e.walls.contains(robot);
        self.entries.iter().filter(is_edge).map(|entry| entry.tile)
    }

    fn entry(&self, tile: Tile) -> Option<&Entry> {
        let at = self.entries.binary_search_by_key(&tile, |entry| entry.tile).ok()?;
        self.entries.get(at)
    }
}
