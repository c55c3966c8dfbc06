//! Flies missions of swarms, and counts what came of them.

use std::path::Path;

use input::InputError;
use measure::metrics::SwarmMetrics;
use measure::verdict::{Failure, Judgement};
use scenario::{Fidelity, Scenario};
use serde_json::{Value, json};

use super::places::Place;
use crate::missions::{self, mean};

/// A swarm of so many drones at one place.
pub(super) struct Case {
    pub(super) place: &'static str,
    pub(super) drones: usize,
    scenario: Scenario,
    /// The scenario as a file.
    pub(super) text: String,
}

impl Case {
    /// The case of so many drones at a place, flown at this level.
    pub(super) fn of(
        place: &Place,
        drones: usize,
        loses_one: bool,
        fidelity: Fidelity,
    ) -> Result<Self, InputError> {
        let text = place.text(drones, loses_one, fidelity);
        let file = format!("{}-{drones}.toml", place.name);
        let scenario = Scenario::of_text(Path::new(&file), &text)?;
        Ok(Self { place: place.name, drones, scenario, text })
    }
}

/// One mission.
pub(super) struct Flown {
    seed: u64,
    pub(super) swarm: SwarmMetrics,
    pub(super) judgement: Judgement,
}

impl Flown {
    fn json(&self) -> Value {
        let number = |value: f32| value.is_finite().then_some(value);
        let it = &self.swarm;
        json!({
            "seed": self.seed,
            "covered": it.covered,
            "lost": it.lost,
            "surveyed_s": number(it.surveyed_s),
            "gathered_s": number(it.gathered_s),
            "landed_s": number(it.across_s),
            "closest_m": number(it.closest_drones_m),
            "unfinished": it.unfinished,
            "wrong": self.judgement.failures.iter().map(Failure::name).collect::<Vec<_>>(),
        })
    }
}

/// The missions of one case.
pub(super) struct Row {
    pub(super) case: Case,
    pub(super) flown: Vec<Flown>,
}

impl Row {
    /// The number of missions that succeeded.
    pub(super) fn good(&self) -> usize {
        self.flown.iter().filter(|flown| flown.judgement.is_success()).count()
    }

    /// The number of missions in which a drone touched a wall or another drone.
    pub(super) fn touched(&self) -> usize {
        self.flown.iter().filter(|flown| flown.judgement.touched()).count()
    }

    /// The mean of a time over the missions that came so far, s.
    pub(super) fn mean_s(&self, of: fn(&SwarmMetrics) -> f32) -> Option<f64> {
        mean(self.flown.iter().map(|flown| of(&flown.swarm)).filter(|time| time.is_finite()))
    }

    /// The mean part of both areas that was covered.
    pub(super) fn covered(&self) -> f64 {
        mean(self.flown.iter().map(|flown| flown.swarm.covered)).unwrap_or(f64::NAN)
    }

    /// The least distance of two flying drones in all missions, m.
    pub(super) fn closest_m(&self) -> f32 {
        let distances = self.flown.iter().map(|flown| flown.swarm.closest_drones_m);
        distances.fold(f32::INFINITY, f32::min)
    }

    /// Why missions failed, by name.
    pub(super) fn wrong(&self) -> String {
        let failures = self.flown.iter().flat_map(|flown| &flown.judgement.failures);
        missions::tally(failures.map(Failure::name))
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "place": self.case.place,
            "drones": self.case.drones,
            "fidelity": self.case.scenario.fidelity.name(),
            "runs": self.flown.len(),
            "good": self.good(),
            "covered": self.covered(),
            "touched": self.touched(),
            "surveyed_s": self.mean_s(|swarm| swarm.surveyed_s),
            "landed_s": self.mean_s(|swarm| swarm.across_s),
            "closest_m": self.closest_m(),
            "missions": self.flown.iter().map(Flown::json).collect::<Vec<_>>(),
        })
    }
}

/// Flies so many missions of a case, with seeds from the first on.
pub(super) fn fly(case: Case, seeds: (usize, u64), after_each: impl Fn() + Sync) -> Row {
    let flown = |mission: missions::Mission| {
        let missions::Mission { seed, metrics, judgement } = mission;
        metrics.swarm.map(|swarm| Flown { seed, swarm, judgement })
    };
    let flown = missions::fly(&case.scenario, seeds, after_each).into_iter().filter_map(flown);
    Row { flown: flown.collect(), case }
}
