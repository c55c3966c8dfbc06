//! Measures how long a leader's round takes with up to 64 robots in a map of 100 by 100 m.

use explorers::{SCALE_ROBOTS, SCALE_TILES, Scale, scale};
use frontier::RuleEntry;
use input::InputError;
use serde_json::{Value, json};

use super::measure::{OURS, STACK, THESIS, no_threads};

/// The most processor time of a round of `ours` with [`BOUND_ROBOTS`] robots or fewer, ms; with more of
/// them it may take longer in proportion.
pub const BOUND_MS: f32 = 10.0;
/// The robots for which [`BOUND_MS`] is meant.
pub const BOUND_ROBOTS: usize = 16;

/// The steps of a leader, with its rule.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The name of the rule.
    pub rule: &'static str,
    /// What was measured.
    pub scale: Scale,
}

impl Row {
    /// The bound of the round, ms; `None` for rules that are only compared.
    #[must_use]
    pub fn bound_ms(&self) -> Option<f32> {
        let robots = self.scale.robots.max(BOUND_ROBOTS) as f32;
        (self.rule == OURS).then_some(BOUND_MS * robots / BOUND_ROBOTS as f32)
    }

    /// What is to be complained of.
    #[must_use]
    pub fn missed(&self) -> Option<String> {
        let Scale { robots, frontier_cells, round_ms, .. } = self.scale;
        let bound = self.bound_ms().filter(|bound| round_ms > *bound)?;
        Some(format!(
            "explore: a round with {robots} robots and {frontier_cells} frontier cells: {round_ms:.1} ms, \
             must be {bound:.0}"
        ))
    }

    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let Scale { robots, frontier_cells, assigned, round_ms, map_ms } = self.scale;
        json!({
            "rule": self.rule,
            "robots": robots,
            "frontier_cells": frontier_cells,
            "assigned": assigned,
            "round_ms": round_ms,
            "bound_ms": self.bound_ms(),
            "map_ms": map_ms,
        })
    }
}

/// Measures `ours` and `thesis` with all numbers of robots and frontiers, one after the other, because
/// the times are those of one core.
///
/// # Errors
/// [`InputError`] where the machine has no memory for the thread.
pub fn run(after_each: impl Fn() + Send) -> Result<Vec<Row>, InputError> {
    let measure = move || {
        let mut rows = Vec::new();
        for entry in [OURS, THESIS].into_iter().filter_map(RuleEntry::named) {
            for tiles in SCALE_TILES {
                for robots in SCALE_ROBOTS {
                    rows.push(Row { rule: entry.name, scale: scale(entry.rule, robots, tiles) });
                    after_each();
                }
            }
        }
        rows
    };
    // The robots' maps are built on the stack.
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK);
        let thread = thread.spawn_scoped(scope, measure).map_err(no_threads)?;
        thread.join().map_err(|_| no_threads("the thread ended early"))
    })
}

/// The number of rows.
#[must_use]
pub const fn count() -> usize {
    2 * SCALE_TILES.len() * SCALE_ROBOTS.len()
}
