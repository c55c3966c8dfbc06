//! What a robot says of the tiles of its map.

use grid_map::{Area, CellState};
use heapless::Vec;
use units::Instant;

use crate::atlas::{Ground, has_room, is_large};
use crate::explorer::{Config, Explorer, MOST_TARGETS};
use crate::list::filled;
use crate::rule::{Distance, Overlap};
use crate::tile::{Gain, Mark, Tile};

/// A frontier whose gain has changed by fewer classes is not told anew. Our own number: it halves
/// the bytes.
const TOLD_CLASSES: u8 = 3;
/// How far from a tile a cell may lie that decides its mark: three cells for the gain, and one more for
/// whether one of those is a frontier, where frontiers of fewer than seven cells do not count.
const SEEN_AROUND: u16 = 4;

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Begins to compare marks with the map, where that has changed since the last time, or everywhere
    /// where a mark depends on something else.
    pub(crate) fn begin_to_compare(&mut self) {
        let frame = *self.ground.frame();
        let has_lost_marks = self.team.take_lost_marks();
        if has_lost_marks {
            // What another robot had settled may be what it alone had seen.
            self.ground.open_all();
        }
        let lacked_room = self.ledger.take_lacked_room();
        let has_to_see_all = has_lost_marks || lacked_room || self.tells_what_is_barred();
        let whole = has_to_see_all.then(|| Area::whole(&frame));
        let changed = self.ground.take_changed().map(|area| area.grown(SEEN_AROUND, &frame));
        // What was not compared yet is still to be compared.
        let areas = [self.to_compare, whole, changed].into_iter().flatten();
        self.to_compare = areas.reduce(Area::and);
        self.is_comparing = true;
    }

    /// Compares as many marks with the map as a step has time for, and, after the last one, answers what
    /// others ask.
    #[inline(never)]
    pub(crate) fn compare(&mut self, now: Instant) {
        if let Some(area) = self.to_compare {
            let (tiles, rest) = Tile::split(area, self.config.most_tiles());
            for tile in Tile::in_area(area).take(tiles) {
                let mark = self.mark_of(tile, now);
                self.mark(tile, mark);
            }
            self.to_compare = rest;
        }
        if self.to_compare.is_some() {
            return;
        }
        self.is_comparing = false;
        if self.config.rule.overlap == Overlap::Asked {
            self.answer();
        }
        if self.team.board.is_half_full() {
            self.let_go();
        }
        let (version, members) = (self.ledger.version(), self.team.cluster(now));
        let acknowledged = self.team.least_acknowledged(members).unwrap_or(version);
        self.ledger.forget_gone(self.team.known_to_all(version), acknowledged);
    }

    /// Says of others' frontiers where the robot knows what lies beyond.
    fn answer(&mut self) {
        let from = self.look_up_from;
        let asked: Vec<Tile, MOST_TARGETS> =
            filled(self.team.board.to_look_up(self.config.number, from));
        // Where there is no room for all, it goes on with the last the next time.
        self.look_up_from =
            asked.last().copied().filter(|_| asked.is_full()).unwrap_or(Tile::FIRST);
        for tile in asked {
            if self.is_known(tile) {
                self.mark(tile, Mark::Settled);
            }
        }
    }

    /// Takes marks back that tell the others nothing, so that there is room for others; that there is
    /// nothing more to see there, the ground remembers.
    fn let_go(&mut self) {
        let told: Vec<Tile, MOST_TARGETS> = filled(self.team.board.told(self.config.number));
        for tile in told {
            if self.ground.close(tile) {
                self.mark(tile, Mark::Gone);
            }
        }
    }

    /// Whether the robot tells others from which frontiers it is barred.
    fn tells_what_is_barred(&self) -> bool {
        let rule = &self.config.rule;
        rule.reachability && rule.distance == Distance::Straight
    }

    /// What the robot has to say of a tile by its map.
    fn mark_of(&self, tile: Tile, now: Instant) -> Mark {
        let frame = *self.ground.frame();
        let was = self.ledger.mark(tile);
        if was == Mark::Settled {
            return was;
        }
        if self.ground.is_closed(tile) {
            return Mark::Gone;
        }
        if let Some(most) = self.gains(tile).max() {
            let gain = Gain::of_cells(most);
            return match was {
                _ if self.tells_what_is_barred() && self.barred.holds(tile, now) => {
                    Mark::Unreachable
                }
                Mark::Frontier(told) if told.classes_to(gain) < TOLD_CLASSES => was,
                _ => Mark::Frontier(gain),
            };
        }
        let has_walls = matches!(self.config.rule.overlap, Overlap::Points(_));
        let is_wall = |cell| self.ground.state(cell) == CellState::Occupied;
        if has_walls && tile.cells(&frame).any(is_wall) { Mark::Wall } else { Mark::Gone }
    }

    pub(crate) fn mark(&mut self, tile: Tile, mark: Mark) {
        if !self.team.board.has_room_for(tile) {
            self.ledger.lack_room();
        } else if self.ledger.set(tile, mark) {
            self.team.board.apply(self.config.number, tile, mark);
        }
    }

    /// Whether the robot knows what lies beyond another's frontier: some of the tile is free in its
    /// own map, and none of it is a frontier. Of a closed tile it knows that there is nothing to see.
    pub(crate) fn is_known(&self, tile: Tile) -> bool {
        let frame = *self.ground.frame();
        let is_free = |cell| self.ground.state(cell) == CellState::Free;
        self.ground.is_closed(tile) || tile.cells(&frame).any(is_free) && !self.has_frontier(tile)
    }

    /// The gains of those cells of a tile that are frontiers which count.
    fn gains(&self, tile: Tile) -> impl Iterator<Item = u8> {
        let Config { least_gain, frontier_room, rule, .. } = self.config;
        let cells = tile.cells(self.ground.frame()).filter(|&cell| self.ground.is_frontier(cell));
        let cells = cells.filter(move |&cell| has_room(&self.ground, cell, frontier_room));
        let large = cells.filter(move |&cell| is_large(&self.ground, cell, rule.least_frontier));
        large.map(|cell| self.ground.gain(cell)).filter(move |gain| *gain >= least_gain)
    }

    pub(crate) fn has_frontier(&self, tile: Tile) -> bool {
        self.gains(tile).next().is_some()
    }
}
