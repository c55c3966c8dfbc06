//! Counts the connected components of a survey as `cavern` counts them.
//!
//! `cavern` counts loops as legs and equates, less stations, plus components, and it counts a
//! component anew where fixed points hang together in another order than they were read in: a
//! station keeps at most three legs, and one with more is split into several that are joined by
//! legs of no length. A fixed station with five legs so makes two components, and a loop more than
//! there is. The number of loops is compared with `cavern`'s wherever surveys are, so the same
//! count is made here; the positions do not depend on it.

use crate::draft::{Draft, Joining};
use crate::sets::Sets;

/// One of the pieces of a fixed station.
struct Piece {
    legs: [Option<Target>; 3],
}

/// The far end of a leg.
#[derive(Clone, Copy)]
enum Target {
    /// Another piece of a fixed station, and which of its legs leads back.
    Piece(usize, usize),
    /// The stations that are not fixed and hang together with this point.
    Region(usize),
}

#[derive(Default)]
struct Pieces {
    all: Vec<Piece>,
    /// The piece of each station to which its next leg is joined.
    of: Vec<Option<usize>>,
}

impl Pieces {
    fn piece(&mut self, station: usize) -> usize {
        if let Some(piece) = self.of[station] {
            return piece;
        }
        self.all.push(Piece { legs: [None; 3] });
        self.of[station] = Some(self.all.len() - 1);
        self.all.len() - 1
    }

    /// A piece of the station with a free leg, and that leg.
    fn free(&mut self, station: usize) -> (usize, usize) {
        let piece = self.piece(station);
        if let Some(leg) = self.all[piece].legs.iter().position(Option::is_none) {
            return (piece, leg);
        }
        let new = self.all.len();
        let moved = self.all[piece].legs[0].replace(Target::Piece(new, 0));
        if let Some(Target::Piece(other, leg)) = moved {
            self.all[other].legs[leg] = Some(Target::Piece(new, 1));
        }
        self.all.push(Piece { legs: [Some(Target::Piece(piece, 0)), moved, None] });
        self.of[station] = Some(new);
        (new, 2)
    }

    fn join(&mut self, a: usize, b: usize) {
        let (first, leg) = self.free(a);
        // Taken, so that a second leg of the same piece is another one.
        self.all[first].legs[leg] = Some(Target::Region(usize::MAX));
        let (second, back) = self.free(b);
        self.all[first].legs[leg] = Some(Target::Piece(second, back));
        self.all[second].legs[back] = Some(Target::Piece(first, leg));
    }
}

impl Draft {
    /// The number of components, where `fixed` says of each point whether it is fixed and `points`
    /// has the point of each station.
    pub(crate) fn components(&self, points: &[usize], fixed: &[bool]) -> usize {
        let is_fixed = |station: usize| fixed[points[station]];
        let mut regions = Sets::new(fixed.len());
        let mut pieces = Pieces { all: Vec::new(), of: vec![None; points.len()] };
        for joining in &self.joinings {
            match *joining {
                Joining::Leg(a, b) | Joining::Equate(a, b) if !is_fixed(a) && !is_fixed(b) => {
                    regions.join(points[a], points[b]);
                }
                Joining::Leg(a, b) if is_fixed(a) && is_fixed(b) => pieces.join(a, b),
                Joining::Equate(a, b) => {
                    if pieces.of[a].is_none() {
                        pieces.piece(b);
                    }
                    pieces.join(a, b);
                }
                Joining::Leg(a, b) => {
                    let (here, there) = if is_fixed(a) { (a, b) } else { (b, a) };
                    let (piece, leg) = pieces.free(here);
                    pieces.all[piece].legs[leg] = Some(Target::Region(points[there]));
                }
                Joining::Fix(station) if is_fixed(station) => {
                    pieces.piece(station);
                }
                Joining::Fix(_) => {}
            }
        }
        count(&pieces.all, &mut regions, fixed.len())
    }
}

fn count(pieces: &[Piece], regions: &mut Sets, points: usize) -> usize {
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); points];
    for (number, piece) in pieces.iter().enumerate() {
        for target in piece.legs.iter().flatten() {
            if let Target::Region(point) = *target {
                around[regions.root(point)].push(number);
            }
        }
    }
    let mut seen = vec![false; pieces.len()];
    let mut components = 0;
    for (number, piece) in pieces.iter().enumerate() {
        if !std::mem::replace(&mut seen[number], true) {
            components += 1;
        }
        for target in piece.legs.iter().flatten() {
            match *target {
                Target::Piece(other, _) => seen[other] = true,
                // A region is looked through once.
                Target::Region(point) => {
                    for other in std::mem::take(&mut around[regions.root(point)]) {
                        seen[other] = true;
                    }
                }
            }
        }
    }
    components
}
