//! Replays the kept outcomes and counts them.

use std::collections::BTreeSet;
use std::fmt;

use crate::rig::Rig;
use crate::{forms, vectors};

/// The result of replaying the kept outcomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Forms of instructions,
    pub forms: usize,
    /// instructions of these forms,
    pub encodings: usize,
    /// and states in which one of them was executed and compared.
    pub states: usize,
    /// Outcomes that were not those of the other core.
    pub mismatches: usize,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { forms, encodings, states, mismatches } = self;
        write!(f, "{forms} forms, {encodings} encodings, {states} states, {mismatches} mismatches")
    }
}

/// Replays them. `None` if the file that comes with this crate is none.
#[must_use]
pub fn replay() -> Option<Summary> {
    let kept = vectors::read(include_bytes!("../core.bin"))?;
    let mut rig = Rig::new();
    let forms: BTreeSet<_> =
        kept.iter().filter_map(|vector| Some(&forms::of(vector.encoding)?.name)).collect();
    let states = |vector: &vectors::Vector| vector.compared.count_ones() as usize;
    Some(Summary {
        forms: forms.len(),
        encodings: kept.iter().filter(|vector| states(vector) > 0).count(),
        states: kept.iter().map(states).sum(),
        mismatches: kept.iter().map(|vector| vector.wrong(&mut rig).len()).sum(),
    })
}
