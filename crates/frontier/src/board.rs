//! What a robot knows of all robots' marks.

use heapless::Vec;

use crate::cluster::RobotSet;
use crate::tile::{Gain, Mark, Tile};

/// The marks of all robots on one tile: the code of one for each robot. Sets of robots would take
/// four times the memory of a drone.
#[derive(Clone, Copy, Debug)]
struct Entry<const ROBOTS: usize> {
    tile: Tile,
    marks: [u8; ROBOTS],
    /// The gain as it was last told.
    gain: Gain,
}

impl<const ROBOTS: usize> Entry<ROBOTS> {
    fn new(tile: Tile) -> Self {
        Self { tile, marks: [Mark::Gone.code(); ROBOTS], gain: Gain::default() }
    }

    fn set(&mut self, robot: u8, mark: Mark) {
        if let Some(code) = self.marks.get_mut(usize::from(robot)) {
            *code = mark.code();
        }
    }

    fn mark_of(&self, robot: u8) -> Option<Mark> {
        self.marks.get(usize::from(robot)).copied().and_then(Mark::of_code)
    }

    /// The robots whose mark is one of these.
    fn robots(&self, is_one: impl Fn(Mark) -> bool) -> RobotSet {
        let marks = (0..).zip(&self.marks);
        let of = marks.filter(|(_, code)| Mark::of_code(**code).is_some_and(&is_one));
        of.map(|(robot, _)| robot).collect()
    }

    fn open(&self) -> RobotSet {
        self.robots(|mark| matches!(mark, Mark::Frontier(_)))
    }

    fn is_settled(&self) -> bool {
        self.marks.contains(&Mark::Settled.code())
    }

    fn is_candidate(&self) -> bool {
        !self.is_settled() && !self.open().is_empty()
    }

    fn is_empty(&self) -> bool {
        self.marks.iter().all(|code| *code == Mark::Gone.code())
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
pub(crate) struct Board<const ROBOTS: usize, const RECORDS: usize> {
    /// In the order of tiles.
    entries: Vec<Entry<ROBOTS>, RECORDS>,
}

impl<const ROBOTS: usize, const RECORDS: usize> Board<ROBOTS, RECORDS> {
    pub(crate) const fn new() -> Self {
        Self { entries: Vec::new() }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Takes in a robot's mark. Where there is no room for another tile, it does nothing.
    pub(crate) fn apply(&mut self, robot: u8, tile: Tile, mark: Mark) {
        let at = match self.entries.binary_search_by_key(&tile, |entry| entry.tile) {
            Ok(at) => at,
            Err(_) if mark == Mark::Gone => return,
            Err(at) => {
                if self.entries.insert(at, Entry::new(tile)).is_err() {
                    return;
                }
                at
            }
        };
        let Some(entry) = self.entries.get_mut(at) else { return };
        entry.set(robot, mark);
        if let Mark::Frontier(gain) = mark {
            entry.gain = gain;
        }
        if entry.is_empty() {
            self.entries.remove(at);
        }
    }

    /// Forgets all marks of a robot.
    pub(crate) fn forget(&mut self, robot: u8) {
        for entry in &mut self.entries {
            entry.set(robot, Mark::Gone);
        }
        self.entries.retain(|entry| !entry.is_empty());
    }

    /// The frontiers that no robot has settled, in the order of tiles.
    pub(crate) fn candidates(&self) -> impl Iterator<Item = Candidate> {
        self.entries.iter().filter(|entry| entry.is_candidate()).map(|entry| Candidate {
            tile: entry.tile,
            gain: entry.gain,
            open: entry.open(),
            unreachable: entry.robots(|mark| mark == Mark::Unreachable),
        })
    }

    /// Whether a tile is a candidate.
    pub(crate) fn is_candidate(&self, tile: Tile) -> bool {
        self.entry(tile).is_some_and(Entry::is_candidate)
    }

    /// The frontiers of other robots that this one has not settled, from a tile on in their order, and then
    /// those before it.
    pub(crate) fn to_look_up(&self, robot: u8, from: Tile) -> impl Iterator<Item = Tile> {
        let is_asked = move |entry: &&Entry<ROBOTS>| {
            let own = entry.mark_of(robot);
            !matches!(own, Some(Mark::Settled | Mark::Frontier(_))) && !entry.open().is_empty()
        };
        let (before, on) = self.entries.split_at(self.entries.partition_point(|e| e.tile < from));
        on.iter().chain(before).filter(is_asked).map(|entry| entry.tile)
    }

    /// Whether there is room for a mark on a tile.
    pub(crate) fn has_room_for(&self, tile: Tile) -> bool {
        !self.entries.is_full() || self.entry(tile).is_some()
    }

    /// Whether more than half of the room is taken.
    pub(crate) fn is_half_full(&self) -> bool {
        self.entries.len() > RECORDS / 2
    }

    /// The tiles of which a robot's mark tells the others nothing: its frontiers that another one has
    /// settled, and what it has settled that is no robot's frontier.
    pub(crate) fn told(&self, robot: u8) -> impl Iterator<Item = Tile> {
        let is_told = move |entry: &&Entry<ROBOTS>| match entry.mark_of(robot) {
            Some(Mark::Frontier(_)) => entry.is_settled(),
            Some(Mark::Settled) => entry.open().is_empty(),
            _ => false,
        };
        self.entries.iter().filter(is_told).map(|entry| entry.tile)
    }

    /// The tiles at the edge of what a robot has seen: its frontiers and its walls.
    #[cfg(feature = "straight")]
    pub(crate) fn edge(&self, robot: u8) -> impl Iterator<Item = Tile> + Clone {
        let is_edge = move |entry: &&Entry<ROBOTS>| {
            let own = entry.mark_of(robot);
            matches!(own, Some(Mark::Wall | Mark::Frontier(_)))
        };
        self.entries.iter().filter(is_edge).map(|entry| entry.tile)
    }

    fn entry(&self, tile: Tile) -> Option<&Entry<ROBOTS>> {
        let at = self.entries.binary_search_by_key(&tile, |entry| entry.tile).ok()?;
        self.entries.get(at)
    }
}
