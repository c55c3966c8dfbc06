//! Flies missions of drones that explore a plan, and counts what came of them.

use std::path::Path;

use agent::ExploreConfig;
use frontier::Rule;
use input::InputError;
use measure::metrics::ExploreMetrics;
use measure::verdict::{Failure, Judgement};
use scenario::Scenario;
use serde_json::{Value, json};

use crate::missions::{self, mean};

/// The maps are right whose walls, found and false ones, and whose free cells are right to this part: the
/// bounds of our own.
const RIGHT: f32 = 0.99;
/// Drones stop in time that are ended so long after 99 % were known, s: our own bound.
pub(super) const STOPS_S: f32 = 45.0;

/// A place to explore with so many drones, by one rule.
pub(super) struct Case {
    pub(super) plan: String,
    pub(super) rule: &'static str,
    pub(super) drones: usize,
    pub(super) scenario: Scenario,
    /// The scenario as a file.
    pub(super) text: String,
}

impl Case {
    /// The case of a scenario's text, flown by this rule.
    pub(super) fn of(
        plan: &str,
        text: String,
        drones: usize,
        (rule, constants): (&'static str, Rule),
    ) -> Result<Self, InputError> {
        let file = format!("{plan}.toml");
        let mut scenario = Scenario::of_text(Path::new(&file), &text)?;
        scenario.agent.explore.rule = ExploreConfig::on_board(constants);
        Ok(Self { plan: plan.to_owned(), rule, drones, scenario, text })
    }
}

/// One mission.
#[derive(Clone, Debug)]
pub(super) struct Flown {
    pub(super) seed: u64,
    pub(super) explore: ExploreMetrics,
    pub(super) judgement: Judgement,
}

impl Flown {
    pub(super) fn is_known(&self) -> bool {
        self.explore.explored >= RIGHT
    }

    /// Whether the maps show the walls, and none besides.
    pub(super) fn is_right(&self) -> bool {
        let ExploreMetrics { walls_found, false_walls, false_free, .. } = self.explore;
        walls_found >= RIGHT && false_walls <= 1.0 - RIGHT && false_free <= 1.0 - RIGHT
    }

    pub(super) fn is_good(&self) -> bool {
        self.judgement.is_success() && self.is_known() && self.is_right()
    }

    /// Whether the mission is called a success though not all is known.
    pub(super) fn is_false_success(&self) -> bool {
        self.judgement.is_success() && !self.is_known()
    }

    /// How long the drones went on after 99 % were known, s.
    fn stopped_after_s(&self) -> Option<f32> {
        let after = self.explore.ended_s - self.explore.t99_s;
        after.is_finite().then_some(after)
    }

    /// Why it failed, by name, and what else is not right.
    pub(super) fn wrong(&self) -> Vec<&'static str> {
        let failures = self.judgement.failures.iter().map(|failure| match failure {
            Failure::Unexplored { why, .. } => why.name(),
            failure => failure.name(),
        });
        let maps = (!self.is_right()).then_some("map");
        failures.chain(maps).collect()
    }

    pub(super) fn json(&self) -> Value {
        let number = |value: f32| value.is_finite().then_some(value);
        let it = &self.explore;
        json!({
            "seed": self.seed,
            "explored": it.explored,
            "walls_found": number(it.walls_found),
            "false_walls": number(it.false_walls),
            "false_free": number(it.false_free),
            "t99_s": number(it.t99_s),
            "ended_s": number(it.ended_s),
            "closest_m": number(it.closest_drones_m),
            "wrong": self.wrong(),
        })
    }
}

/// The missions of one case.
pub(super) struct Row {
    pub(super) case: Case,
    pub(super) flown: Vec<Flown>,
}

impl Row {
    /// The number of missions of which something is true.
    pub(super) fn count(&self, is: impl Fn(&Flown) -> bool) -> usize {
        self.flown.iter().filter(|flown| is(flown)).count()
    }

    pub(super) fn explored(&self) -> f64 {
        mean(self.flown.iter().map(|flown| flown.explore.explored)).unwrap_or(f64::NAN)
    }

    /// The mean time until 99 % were known, over the missions that came so far.
    pub(super) fn t99_s(&self) -> Option<f64> {
        let times = self.flown.iter().map(|flown| flown.explore.t99_s);
        mean(times.filter(|time| time.is_finite()))
    }

    /// The longest time that drones went on after 99 % were known.
    pub(super) fn stopped_after_s(&self) -> Option<f32> {
        self.flown.iter().filter_map(Flown::stopped_after_s).max_by(f32::total_cmp)
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "plan": self.case.plan,
            "rule": self.case.rule,
            "drones": self.case.drones,
            "fidelity": self.case.scenario.fidelity.name(),
            "runs": self.flown.len(),
            "good": self.count(Flown::is_good),
            "explored": self.explored(),
            "reached_99": self.count(Flown::is_known),
            "right": self.count(Flown::is_right),
            "touched": self.count(|flown| flown.judgement.touched()),
            "false_success": self.count(Flown::is_false_success),
            "t99_s": self.t99_s(),
            "stopped_after_s": self.stopped_after_s(),
            "missions": self.flown.iter().map(Flown::json).collect::<Vec<_>>(),
        })
    }
}

/// Flies so many missions of a case, with seeds from the first on.
pub(super) fn fly(case: Case, seeds: (usize, u64), after_each: impl Fn() + Sync) -> Row {
    let flown = |mission: missions::Mission| {
        let missions::Mission { seed, metrics, judgement } = mission;
        metrics.explore.map(|explore| Flown { seed, explore, judgement })
    };
    let flown = missions::fly(&case.scenario, seeds, after_each).into_iter().filter_map(flown);
    Row { flown: flown.collect(), case }
}
