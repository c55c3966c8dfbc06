//! Plans several relays by the way through the cave.

use grid_map::{Cell, Planner};
use heapless::Vec;

use super::{MOST_PLANNED, Plan};
use crate::ground::Ground;
use crate::network::Network;
use crate::place::{Demand, Place};
use crate::score::{Disc, Score};
use crate::squares::{Squares, Sums, visit};

impl Plan {
    /// Plans as many relays by the way through the cave, each where it covers most of what those before
    /// it leave: the places that [`Rule::OursGeodesic`](crate::Rule::OursGeodesic) chooses one after the
    /// other where no goal is near. The network's relays are to be added by [`Network::add_by_way`].
    #[must_use]
    pub fn by_way<const CELLS: usize, const MARKS: usize, const POOL: usize>(
        ground: &Ground<CELLS>,
        network: &Network<CELLS>,
        planner: &mut Planner<MARKS, POOL>,
        demand: &Demand,
        nodes: usize,
    ) -> Self {
        let mut network = network.clone();
        let mut squares = Squares::new(ground);
        let mut places = Vec::new();
        while places.len() < nodes.min(MOST_PLANNED) {
            let mut ways = Ways::new(ground, &network, planner, demand);
            let chosen = squares.choose(ground, demand, &mut ways);
            let Some((cell, gain)) = chosen.filter(|(_, gain)| *gain > 0) else { break };
            let _ = places.push(Place::new(ground, cell, gain, network.ratio(cell)));
            // A search without room has added the nearest cells, which are those that count.
            let _ = network.add_by_way(ground, planner, cell);
        }
        Self { places }
    }
}

/// The new coverage of places by the way through the cave.
struct Ways<'a, const CELLS: usize, const MARKS: usize, const POOL: usize> {
    ground: &'a Ground<CELLS>,
    network: &'a Network<CELLS>,
    planner: &'a mut Planner<MARKS, POOL>,
    /// The cells that are not covered, and those within the reach of a relay.
    gains: Score<CELLS>,
    disc: Disc,
    /// The reach of a relay, cells.
    reach: f32,
    /// The ratio of a link.
    least: f32,
}

impl<'a, const CELLS: usize, const MARKS: usize, const POOL: usize> Ways<'a, CELLS, MARKS, POOL> {
    fn new(
        ground: &'a Ground<CELLS>,
        network: &'a Network<CELLS>,
        planner: &'a mut Planner<MARKS, POOL>,
        demand: &Demand,
    ) -> Self {
        let curve = network.curve();
        let reach = curve.knee.0 / ground.frame().resolution().0;
        let gains = Score::of_reached(ground, |cell| i16::from(!network.covers(cell)));
        // Where no place has the margin, it is given up.
        let margin = curve.covered.0 + demand.margin.0.max(0.0);
        let has_margin = ground.reached().any(|cell| network.ratio(cell).0 >= margin);
        let least = if has_margin { margin } else { curve.covered.0 };
        let disc = Disc::by_way(reach);
        Self { ground, network, planner, gains, disc, reach, least }
    }
}

impl<const CELLS: usize, const MARKS: usize, const POOL: usize> Sums
    for Ways<'_, CELLS, MARKS, POOL>
{
    fn is_candidate(&self, cell: Cell) -> bool {
        self.network.ratio(cell).0 >= self.least
    }

    fn value(&self, _: Cell, sum: i32) -> i32 {
        sum
    }

    fn bound(&self, cell: Cell) -> i32 {
        self.gains.around(self.ground, cell, &self.disc)
    }

    fn sum(&mut self, cell: Cell) -> i32 {
        let (network, mut sum) = (self.network, 0);
        // A search without room has visited the nearest cells.
        let _ = visit(self.ground, self.planner, cell, self.reach, |cell, _| {
            sum += i32::from(!network.covers(cell));
        });
        sum
    }
}
