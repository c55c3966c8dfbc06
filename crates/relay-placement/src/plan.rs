//! Plans several relays together.
//!
//! The places are first chosen greedily: each is, of the cells that have a link to the network or to
//! a relay chosen before, the one that covers most. Then they are exchanged: one relay after the
//! other is taken out, and put where it covers most while all of them stay linked. Where the margin
//! of the link leaves no place that covers more, it is given up for the relays that remain. A greedy
//! choice alone is held by the link: it takes the place that covers most now, not the one from which the
//! next relay reaches farther.

use grid_map::Cell;
use heapless::Vec;
use units::Db;

use crate::ground::{Ground, index};
use crate::network::{Network, distance};
use crate::place::{Demand, Place, Shortlist};
use crate::score::{Disc, Score};

mod by_way;

/// The most relays of a plan.
pub const MOST_PLANNED: usize = 16;
/// Of the rows and columns every sixth one is looked at, and then the cells around the one that was
/// found. On seeds 100000 to 100039 of `cave-worlds`, eight relays planned so and then exchanged
/// cover 0.6 % more than by looking at each cell without an exchange.
const STRIDE: u16 = 6;

/// Relays that are put down one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    places: Vec<Place, MOST_PLANNED>,
}

impl Plan {
    /// Plans at most `nodes` relays, and no more than [`MOST_PLANNED`], that extend a network.
    /// There are fewer, or none, where no linked place is left that covers more. After a relay is
    /// lost, a plan for the [`Network`] of those that are left says where to put others.
    #[must_use]
    pub fn new<const CELLS: usize>(
        ground: &Ground<CELLS>,
        network: &Network<CELLS>,
        demand: &Demand,
        nodes: usize,
    ) -> Self {
        let mut draft = Draft::new(ground, network, demand);
        let nodes = nodes.min(MOST_PLANNED);
        draft.extend(nodes);
        draft.exchange();
        draft.ask(Db(0.0));
        draft.extend(nodes);
        Self { places: draft.in_order() }
    }

    /// The places, in an order in which each has a link to the network and the relays before it.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The number of cells that become covered.
    #[must_use]
    pub fn gain_cells(&self) -> usize {
        self.places.iter().map(|place| place.gain_cells).sum()
    }

    /// A number of new cells that no set of so many relays exceeds in a straight line, linked or not.
    /// Coverage is submodular: to the plan's, each relay of another set adds no more than the best single
    /// cell does (Nemhauser, Wolsey and Fisher, "An analysis of approximations for maximizing submodular
    /// set functions", 1978).
    #[must_use]
    pub fn at_most_cells<const CELLS: usize>(
        &self,
        ground: &Ground<CELLS>,
        network: &Network<CELLS>,
        nodes: usize,
    ) -> usize {
        let mut draft = Draft::new(ground, network, &Demand::DEFAULT);
        let uncovered = draft.uncovered();
        self.places.iter().for_each(|place| draft.put(place.cell));
        let gains = draft.gains();
        let most = ground.reached().map(|cell| draft.gain(&gains, cell)).max().unwrap_or(0);
        let more = nodes.saturating_mul(usize::try_from(most).unwrap_or(0));
        (uncovered - draft.uncovered()).saturating_add(more).min(uncovered)
    }
}

/// The numbers of the relays among which there is a link, as bits; bit 0 is the network.
type Members = u32;

/// A plan in the making.
struct Draft<'a, const CELLS: usize> {
    ground: &'a Ground<CELLS>,
    network: &'a Network<CELLS>,
    demand: &'a Demand,
    /// The cells that a relay covers.
    disc: Disc,
    /// The ratio of a link, and the distance at which a relay gives it, m.
    least: f32,
    range: f32,
    chosen: Vec<Cell, MOST_PLANNED>,
    /// How many of the chosen relays cover each cell, one more where the network covers it, or no
    /// robot gets there.
    counts: [u8; CELLS],
}

impl<'a, const CELLS: usize> Draft<'a, CELLS> {
    fn new(ground: &'a Ground<CELLS>, network: &'a Network<CELLS>, demand: &'a Demand) -> Self {
        let curve = network.curve();
        let mut counts = [1; CELLS];
        for cell in ground.reached().filter(|&cell| !network.covers(cell)) {
            if let Some(slot) = counts.get_mut(index(ground.frame(), cell)) {
                *slot = 0;
            }
        }
        let mut draft = Self {
            ground,
            network,
            demand,
            disc: Disc::new(curve.knee.0 / ground.frame().resolution().0),
            least: 0.0,
            range: 0.0,
            chosen: Vec::new(),
            counts,
        };
        draft.ask(demand.margin);
        draft
    }

    /// Asks of the next links the ratio of a covered cell, and so much more.
    fn ask(&mut self, margin: Db) {
        let curve = self.network.curve();
        self.least = curve.covered.0 + margin.0.max(0.0);
        self.range = curve.reach(Db(self.least)).0;
    }

    /// Adds relays greedily until there are `nodes`, or no linked place covers more.
    fn extend(&mut self, nodes: usize) {
        while self.chosen.len() < nodes
            && let Some(cell) = self.next()
        {
            self.put(cell);
        }
    }

    fn put(&mut self, cell: Cell) {
        if self.chosen.push(cell).is_ok() {
            self.count(cell, |n| n.saturating_add(1));
        }
    }

    fn count(&mut self, at: Cell, change: impl Fn(u8) -> u8) {
        let frame = self.ground.frame();
        for (row, west, east) in self.disc.rows(frame, at) {
            for column in west..=east {
                if let Some(slot) = self.counts.get_mut(index(frame, Cell::new(column, row))) {
                    *slot = change(*slot);
                }
            }
        }
    }

    /// The cells that would become covered.
    fn gains(&self) -> Score<CELLS> {
        let new = self.counts.iter().map(|count| i16::from(*count == 0));
        Score::new(self.ground.frame(), new)
    }

    fn gain(&self, gains: &Score<CELLS>, cell: Cell) -> i32 {
        gains.around(self.ground, cell, &self.disc)
    }

    /// The members with which a relay in this cell has a link.
    fn links(&self, cell: Cell) -> Members {
        let frame = self.ground.frame();
        let at = frame.centre(cell);
        let mut members = Members::from(self.network.ratio(cell).0 >= self.least);
        for (n, other) in self.chosen.iter().enumerate() {
            let is_near = distance(frame.centre(*other), at).0 <= self.range;
            members |= Members::from(is_near) << (n + 1);
        }
        members
    }

    /// The parts into which the network and the chosen relays fall.
    fn parts(&self) -> Vec<Members, { MOST_PLANNED + 1 }> {
        let mut parts: Vec<Members, { MOST_PLANNED + 1 }> = Vec::new();
        let _ = parts.push(1);
        for (n, cell) in self.chosen.iter().enumerate() {
            let mut joined = self.links(*cell) | 1 << (n + 1);
            parts.retain(|part| {
                let is_joined = part & joined != 0;
                joined |= if is_joined { *part } else { 0 };
                !is_joined
            });
            let _ = parts.push(joined);
        }
        parts
    }

    /// The cell of the next relay; `None` where no linked one covers more.
    fn next(&self) -> Option<Cell> {
        if self.uncovered() == 0 {
            return None;
        }
        let (gains, parts) = (self.gains(), self.parts());
        let covers_more = |&(_, gain): &(Cell, i32)| gain > 0;
        let found = self.choose(&gains, &parts).filter(covers_more);
        // Passages narrower than the stride may lie between the cells that are looked at.
        let all = || self.pick(self.ground.reached(), &gains, &parts).filter(covers_more);
        found.or_else(all).map(|(cell, _)| cell)
    }

    /// The cell to put a relay in that has a link to each of the parts, and its gain: the best of
    /// each [`STRIDE`]th row and column, or one of those around it.
    fn choose(&self, gains: &Score<CELLS>, parts: &[Members]) -> Option<(Cell, i32)> {
        let frame = self.ground.frame();
        let every = |end: u16| (0..end).step_by(usize::from(STRIDE));
        let rows = every(frame.rows());
        let grid = rows.flat_map(|row| every(frame.columns()).map(move |n| Cell::new(n, row)));
        let reached = |cell: &Cell| self.ground.is_reached(*cell);
        let (found, _) = self.pick(grid.filter(reached), gains, parts)?;
        let off = 1 - STRIDE as i16..STRIDE as i16;
        let around = off.clone().flat_map(|north| off.clone().map(move |east| (east, north)));
        let cells = around.filter_map(|(east, north)| frame.beside(found, east, north));
        self.pick(cells.filter(reached), gains, parts)
    }

    /// Of some cells with a link to each of the parts the one that the [`Shortlist`] picks.
    fn pick(
        &self,
        cells: impl Iterator<Item = Cell>,
        gains: &Score<CELLS>,
        parts: &[Members],
    ) -> Option<(Cell, i32)> {
        let mut shortlist = Shortlist::default();
        for cell in cells {
            let links = self.links(cell);
            if parts.iter().all(|part| part & links != 0) {
                shortlist.offer(self.ground, self.demand, cell, self.gain(gains, cell));
            }
        }
        shortlist.pick()
    }

    /// Puts each relay where it covers most, the others being left where they are.
    fn exchange(&mut self) {
        for _ in 0..self.chosen.len() {
            // The relay that has waited longest is the first of the list, and becomes the last.
            let old = self.chosen.remove(0);
            self.count(old, |n| n.saturating_sub(1));
            let gains = self.gains();
            let before = self.gain(&gains, old);
            let better = self.choose(&gains, &self.parts()).filter(|(_, gain)| *gain > before);
            self.put(better.map_or(old, |(cell, _)| cell));
        }
    }

    fn uncovered(&self) -> usize {
        self.counts.iter().filter(|count| **count == 0).count()
    }

    /// The places, of those that have a link to the ones before always the one that covers most, and
    /// of those with the margin where there is one.
    fn in_order(mut self) -> Vec<Place, MOST_PLANNED> {
        let mut left = core::mem::take(&mut self.chosen);
        for cell in &left {
            self.count(*cell, |n| n.saturating_sub(1));
        }
        let mut places = Vec::new();
        loop {
            self.ask(self.demand.margin);
            let mut next = self.next_of(&left);
            if next.is_none() {
                self.ask(Db(0.0));
                next = self.next_of(&left);
            }
            let Some((n, gain)) = next else { return places };
            let cell = left.swap_remove(n);
            let link = self.link(cell);
            self.put(cell);
            let _ = places.push(Place::new(self.ground, cell, gain, link));
        }
    }

    fn next_of(&self, left: &[Cell]) -> Option<(usize, i32)> {
        let gains = self.gains();
        let linked = left.iter().enumerate().filter(|(_, cell)| self.links(**cell) != 0);
        linked.map(|(n, cell)| (n, self.gain(&gains, *cell))).max_by_key(|(_, gain)| *gain)
    }

    /// The best ratio that the network and the chosen relays give in a cell.
    fn link(&self, cell: Cell) -> Db {
        let frame = self.ground.frame();
        let of = |other: &Cell| distance(frame.centre(*other), frame.centre(cell));
        let ratios = self.chosen.iter().map(|other| self.network.curve().at(of(other)).0);
        Db(ratios.fold(self.network.ratio(cell).0, f32::max))
    }
}
