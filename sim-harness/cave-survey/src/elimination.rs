//! Solves the normal equations of a survey's network: a sparse, symmetric, positive definite system
//! whose entries are 3 × 3 blocks.
//!
//! The unknowns are eliminated one after the other, always one with the fewest neighbours, which
//! keeps the system sparse: caves are nearly flat graphs.

use std::collections::{BTreeMap, BTreeSet};

use crate::matrix::{self, Matrix, Vector};

/// An end of an observed difference: the number of an unknown, or a known position.
pub(crate) type End = Result<usize, Vector>;

/// The most products of blocks, which take some ten seconds. 50,000 legs with 1,300 loops at random
/// need fewer; passages cross each other far more rarely.
const MOST_PRODUCTS: usize = 100_000_000;

/// The system of equations.
pub(crate) struct NormalEquations {
    diagonal: Vec<Matrix>,
    /// Row by row, the blocks beside the diagonal; each is in both of its rows.
    rows: Vec<BTreeMap<usize, Matrix>>,
    right: Vec<Vector>,
}

/// An unknown that was eliminated, with its equation at that time.
struct Eliminated {
    unknown: usize,
    inverse: Matrix,
    row: BTreeMap<usize, Matrix>,
}

impl NormalEquations {
    /// Makes a system of this many unknown points.
    pub(crate) fn new(unknowns: usize) -> Self {
        Self {
            diagonal: vec![matrix::ZERO; unknowns],
            rows: vec![BTreeMap::new(); unknowns],
            right: vec![[0.0; 3]; unknowns],
        }
    }

    /// Adds the observation that `to` lies at `vector` from `from`.
    pub(crate) fn observe(&mut self, from: End, to: End, vector: Vector, weight: &Matrix) {
        let pull = matrix::times(weight, vector);
        self.side(to, from, pull, weight);
        self.side(from, to, matrix::scaled(pull, -1.0), weight);
    }

    fn side(&mut self, here: End, there: End, pull: Vector, weight: &Matrix) {
        let Ok(here) = here else { return };
        self.diagonal[here] = matrix::sum(&self.diagonal[here], weight);
        let mut right = matrix::add(self.right[here], pull);
        match there {
            Ok(there) => {
                let block = self.rows[here].entry(there).or_insert(matrix::ZERO);
                *block = matrix::difference(block, weight);
            }
            Err(known) => right = matrix::add(right, matrix::times(weight, known)),
        }
        self.right[here] = right;
    }

    /// The unknowns; `None` where the loops are so entangled that it would take minutes.
    pub(crate) fn solve(mut self) -> Option<Vec<Vector>> {
        let mut queue: BTreeSet<(usize, usize)> =
            self.rows.iter().enumerate().map(|(n, row)| (row.len(), n)).collect();
        let mut order = Vec::with_capacity(self.rows.len());
        let mut work = 0usize;
        while let Some((neighbours, unknown)) = queue.pop_first() {
            work = work.saturating_add(neighbours * neighbours);
            if work > MOST_PRODUCTS {
                return None;
            }
            order.push(self.eliminate(unknown, &mut queue));
        }
        let mut solution = vec![[0.0; 3]; self.right.len()];
        for Eliminated { unknown, inverse, row } in order.into_iter().rev() {
            let others = row.iter().map(|(&other, block)| matrix::times(block, solution[other]));
            let rest = others.fold(self.right[unknown], matrix::sub);
            solution[unknown] = matrix::times(&inverse, rest);
        }
        Some(solution)
    }

    fn eliminate(&mut self, unknown: usize, queue: &mut BTreeSet<(usize, usize)>) -> Eliminated {
        let row = std::mem::take(&mut self.rows[unknown]);
        let inverse = matrix::inverse(&self.diagonal[unknown]);
        for (&a, block_a) in &row {
            queue.remove(&(self.rows[a].len(), a));
            self.rows[a].remove(&unknown);
            // The block of row a and column `unknown` is the transpose of the one here.
            let factor = matrix::product(&matrix::transposed(block_a), &inverse);
            let pull = matrix::times(&factor, self.right[unknown]);
            self.right[a] = matrix::sub(self.right[a], pull);
            for (&b, block_b) in &row {
                let change = matrix::product(&factor, block_b);
                let block = if a == b {
                    &mut self.diagonal[a]
                } else {
                    self.rows[a].entry(b).or_insert(matrix::ZERO)
                };
                *block = matrix::difference(block, &change);
            }
            queue.insert((self.rows[a].len(), a));
        }
        Eliminated { unknown, inverse, row }
    }
}
