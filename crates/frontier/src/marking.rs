//! What a robot says of the tiles of its map.

use grid_map::CellState;
use heapless::Vec;
use units::Instant;

use crate::atlas::{Ground, is_large};
use crate::explorer::{Config, Explorer, MOST_TARGETS};
use crate::list::filled;
use crate::rule::{Distance, Overlap};
use crate::tile::{Gain, Mark, Tile};

/// A frontier whose gain has changed by fewer classes is not told anew. Our own number: it halves
/// the bytes.
const TOLD_CLASSES: u8 = 3;

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Compares marks with the map from a row of tiles on, and, after the last one, answers what others
    /// ask; returns the row with which it goes on.
    #[inline(never)]
    pub(crate) fn refresh(&mut self, now: Instant, row: u16) -> Option<u16> {
        let frame = *self.ground.frame();
        let rows = Tile::rows(&frame);
        let end = row + rows.div_ceil(u16::from(self.config.refresh_steps.max(1)));
        for tile in Tile::in_rows(&frame, row..end.min(rows)) {
            let mark = self.mark_of(tile, now);
            self.mark(tile, mark);
        }
        if end < rows {
            return Some(end);
        }
        if self.config.rule.overlap == Overlap::Asked {
            let asked: Vec<Tile, MOST_TARGETS> =
                filled(self.team.board.to_look_up(self.config.number));
            for tile in asked {
                if self.is_known(tile) {
                    self.mark(tile, Mark::Settled);
                }
            }
        }
        self.ledger.forget_gone(self.team.known_to_all(self.ledger.version()));
        None
    }

    /// What the robot has to say of a tile by its map.
    fn mark_of(&self, tile: Tile, now: Instant) -> Mark {
        let rule = &self.config.rule;
        let frame = *self.ground.frame();
        let was = self.ledger.mark(tile);
        if was == Mark::Settled {
            return was;
        }
        if let Some(most) = self.gains(tile).max() {
            let gain = Gain::of_cells(most);
            let is_told = rule.reachability && rule.distance == Distance::Straight;
            return match was {
                _ if is_told && self.barred.holds(tile, now) => Mark::Unreachable,
                Mark::Frontier(told) if told.classes_to(gain) < TOLD_CLASSES => was,
                _ => Mark::Frontier(gain),
            };
        }
        let has_walls = matches!(rule.overlap, Overlap::Points(_));
        let is_wall = |cell| self.ground.state(cell) == CellState::Occupied;
        if has_walls && tile.cells(&frame).any(is_wall) { Mark::Wall } else { Mark::Gone }
    }

    pub(crate) fn mark(&mut self, tile: Tile, mark: Mark) {
        if self.ledger.set(tile, mark) {
            self.team.board.apply(self.config.number, tile, mark);
        }
    }

    /// Whether the robot knows what lies beyond another's frontier: some of the tile is free in its
    /// own map, and none of it is a frontier.
    pub(crate) fn is_known(&self, tile: Tile) -> bool {
        let frame = *self.ground.frame();
        let is_free = |cell| self.ground.state(cell) == CellState::Free;
        tile.cells(&frame).any(is_free) && !self.has_frontier(tile)
    }

    /// The gains of those cells of a tile that are frontiers which count.
    fn gains(&self, tile: Tile) -> impl Iterator<Item = u8> {
        let Config { least_gain, rule, .. } = self.config;
        let cells = tile.cells(self.ground.frame()).filter(|&cell| self.ground.is_frontier(cell));
        let large = cells.filter(move |&cell| is_large(&self.ground, cell, rule.least_frontier));
        large.map(|cell| self.ground.gain(cell)).filter(move |gain| *gain >= least_gain)
    }

    pub(crate) fn has_frontier(&self, tile: Tile) -> bool {
        self.gains(tile).next().is_some()
    }
}
