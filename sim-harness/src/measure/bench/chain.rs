//! Measures how well the chain holds under each movement policy: how equal, calm and quick it is,
//! how far from the best chain, how it is launched, repaired and called home. All policies fly the
//! same seeds, at point level, and figures of a hold are of the hold alone.

pub mod ablation;
pub mod cases;

use agent::AgentConfig;
use chain::policy::{NAMES, PolicyConfig};
use rayon::prelude::*;
use serde_json::{Value, json};
use units::Order;

use crate::input_error::InputError;
use crate::measure::campaign::{figures, fly, fraction};
use crate::measure::metrics::{Reference, RunMetrics, measure};
use crate::mission::World;
use crate::scenario::{Fidelity, PilotStep, Scenario};
use crate::suggest;

use cases::{Bound, CASES, COMPARED, Case, Target};

/// What to fly.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The rows, by name; all where none is named.
    pub scenarios: Vec<String>,
    /// The policies, by name; those of the scenario where none is named.
    pub policies: Vec<String>,
    /// Missions in each row.
    pub runs: usize,
    /// The first seed.
    pub seed: u64,
}

/// One scenario under one policy.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scenario's name.
    pub scenario: &'static str,
    /// The policy's name.
    pub policy: &'static str,
    /// The number of missions.
    pub runs: usize,
    /// Name and value of each figure; an infinite value is `None`.
    pub figures: Vec<(&'static str, Option<f64>)>,
    /// The least time in which any policy could bring the relays to their places, s, where they
    /// begin in the air.
    pub bound_s: Option<f64>,
    /// The values that the figures are to reach.
    pub targets: &'static [Target],
}

impl Row {
    /// The target of a figure, if it has one.
    #[must_use]
    pub fn target(&self, figure: &str) -> Option<Bound> {
        self.targets.iter().find(|target| target.figure == figure).map(|target| target.bound)
    }

    /// Whether a figure of this value misses its target.
    #[must_use]
    pub fn misses(&self, figure: &str, value: Option<f64>) -> bool {
        self.target(figure).is_some_and(|bound| !bound.is_met_by(value))
    }

    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let targets = self.targets.iter().filter_map(|target| {
            let (_, value) = self.figures.iter().find(|(name, _)| *name == target.figure)?;
            let (which, bound) = match target.bound {
                Bound::Most(bound) => ("most", bound),
                Bound::Least(bound) => ("least", bound),
            };
            let met = target.bound.is_met_by(*value);
            Some((target.figure.to_owned(), json!({ which: bound, "met": met })))
        });
        let targets: serde_json::Map<_, _> = targets.collect();
        let mut object =
            json!({ "scenario": self.scenario, "policy": self.policy, "runs": self.runs });
        if let Some(object) = object.as_object_mut() {
            object.extend(self.figures.iter().map(|(name, value)| ((*name).into(), json!(value))));
            object.insert("bound_s".into(), json!(self.bound_s));
            object.insert("targets".into(), Value::Object(targets));
        }
        object
    }
}

/// The missions of one row, before they are flown.
struct Campaign {
    case: &'static Case,
    policy: &'static str,
}

/// The rows that a choice asks for.
fn campaigns(choice: &Choice) -> Result<Vec<Campaign>, InputError> {
    let mut wanted = Vec::new();
    for name in &choice.scenarios {
        let found = CASES.iter().find(|case| case.name == name);
        wanted.push(found.ok_or_else(|| {
            let names: Vec<_> = CASES.iter().map(|case| case.name).collect();
            let wrong = format!("the benchmark \"chain\" has no scenario \"{name}\"");
            InputError::new(wrong, suggest::one_of(name, &names))
        })?);
    }
    let mut policies = Vec::new();
    for name in &choice.policies {
        let found = NAMES.into_iter().find(|known| known == name);
        policies.push(found.ok_or_else(|| {
            let wrong = format!("there is no policy \"{name}\"");
            InputError::new(wrong, suggest::one_of(name, &NAMES))
        })?);
    }
    if wanted.is_empty() {
        wanted.extend(&CASES);
    }
    let flown = wanted.into_iter().flat_map(|case| {
        let own: &[&str] = if case.is_for_all { &NAMES } else { &COMPARED };
        let policies = if policies.is_empty() { own.to_vec() } else { policies.clone() };
        policies.into_iter().map(move |policy| Campaign { case, policy })
    });
    Ok(flown.collect())
}

/// The number of missions that a choice asks for.
///
/// # Errors
/// [`InputError`] for a scenario or a policy that there is not.
pub fn count(choice: &Choice) -> Result<usize, InputError> {
    Ok(campaigns(choice)?.len() * choice.runs)
}

/// Flies the scenarios under the policies that are asked for.
///
/// # Errors
/// [`InputError`] for a scenario or a policy that there is not.
pub fn run(choice: &Choice, after_each: impl Fn() + Sync) -> Result<Vec<Row>, InputError> {
    let campaigns = campaigns(choice)?;
    let mut rows = Vec::with_capacity(campaigns.len());
    for of_case in campaigns.chunk_by(|one, next| one.case.name == next.case.name) {
        let Some(case) = of_case.first().map(|first| first.case) else { continue };
        let ground = Ground::of(case.scenario)?;
        for Campaign { policy, .. } in of_case {
            let Some(scenario) = ground.plain.with_policy(policy) else { continue };
            let flown = ground.fly(case, &scenario, choice, &after_each);
            rows.push(row(case, policy, &flown));
        }
    }
    Ok(rows)
}

/// Flies the policy `chain` with one ingredient removed at a time.
///
/// # Errors
/// [`InputError`] for a scenario that the comparison does not have.
pub fn run_ablation(choice: &Choice, after_each: impl Fn() + Sync) -> Result<Vec<Row>, InputError> {
    let mut rows = Vec::new();
    for case in ablated(choice)? {
        let ground = Ground::of(case.scenario)?;
        for variant in ablation::variants() {
            let scenario = with_config(&ground.plain, variant.config);
            let flown = ground.fly(case, &scenario, choice, &after_each);
            rows.push(row(case, variant.name, &flown));
        }
    }
    Ok(rows)
}

/// The scenarios that the ablation flies, as a choice asks for them.
fn ablated(choice: &Choice) -> Result<Vec<&'static Case>, InputError> {
    let names = ablation::SCENARIOS;
    if let Some(other) = choice.scenarios.iter().find(|name| !names.contains(&name.as_str())) {
        let wrong = format!("the ablation has no scenario \"{other}\"");
        return Err(InputError::new(wrong, suggest::one_of(other, &names)));
    }
    let wanted = |name: &str| {
        choice.scenarios.is_empty() || choice.scenarios.iter().any(|asked| asked == name)
    };
    let cases = CASES.iter().filter(|case| names.contains(&case.name) && wanted(case.name));
    Ok(cases.collect())
}

/// The number of missions of the ablation.
///
/// # Errors
/// [`InputError`] for a scenario that the comparison does not have.
pub fn count_ablation(choice: &Choice) -> Result<usize, InputError> {
    Ok(ablated(choice)?.len() * ablation::variants().len() * choice.runs)
}

/// The same scenario under a policy that has no name.
fn with_config(plain: &Scenario, config: PolicyConfig) -> Scenario {
    let policy = config.for_loss_at_1m(plain.assumed_loss_at_1m);
    Scenario { agent: AgentConfig { policy, ..plain.agent }, ..plain.clone() }
}

/// A scenario with what is solved once for all of its missions.
struct Ground {
    plain: Scenario,
    world: World,
    reference: Reference,
}

impl Ground {
    fn of(name: &str) -> Result<Self, InputError> {
        let plain = Scenario::open(name)?.at(Fidelity::Point);
        let world = World::of(&plain);
        let reference = Reference::of(&plain, &world);
        Ok(Self { plain, world, reference })
    }

    fn fly(
        &self,
        case: &Case,
        scenario: &Scenario,
        choice: &Choice,
        after_each: &(impl Fn() + Sync),
    ) -> Vec<RunMetrics> {
        let Choice { seed, runs, .. } = *choice;
        if !case.is_recalled {
            return fly(scenario, &self.world, &self.reference, seed, runs, after_each);
        }
        let all = (0..runs as u64).into_par_iter().map(|n| {
            let seed = seed.wrapping_add(n);
            let metrics = measure(&recalled(scenario, seed), &self.world, &self.reference, seed);
            after_each();
            metrics
        });
        all.collect()
    }
}

/// The same mission, called home earlier: each seed at another moment, and many seeds evenly over
/// the whole time before the operator's own call.
fn recalled(scenario: &Scenario, seed: u64) -> Scenario {
    /// Multiples of the golden ratio fill the unit interval evenly.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let ends = scenario.pilot.iter().find(|step| step.task == Order::Return);
    let latest_us = ends.map_or(scenario.duration_us / 2, |step| step.at_us);
    let at_us = ((seed as f64 * GOLDEN).fract() * latest_us as f64) as u64;
    let mut pilot = scenario.pilot.clone();
    pilot.retain(|step| step.at_us < at_us);
    pilot.push(PilotStep { at_us, task: Order::Return });
    Scenario { pilot, ..scenario.clone() }
}

fn row(case: &'static Case, policy: &'static str, flown: &[RunMetrics]) -> Row {
    let measured = figures(flown);
    let value = |wanted: &str| {
        let found = measured.iter().find(|figure| figure.name == wanted);
        found.map(|figure| figure.estimate.value)
    };
    let own = |wanted: &str| match wanted {
        "touched" => Some(fraction(flown, |run| run.wall_contacts + run.drone_contacts > 0).value),
        "stuck" => Some(fraction(flown, is_stuck).value),
        _ => value(wanted),
    };
    // A figure that the scenario does not have is left out.
    let figures = case.figures.iter().filter_map(|name| {
        let value = own(name)?;
        Some((*name, value.is_finite().then_some(value)))
    });
    Row {
        scenario: case.name,
        policy,
        runs: flown.len(),
        figures: figures.collect(),
        bound_s: value("bound_s").filter(|value| value.is_finite()),
        targets: case.targets,
    }
}

/// Whether a chain settled far from the best one.
fn is_stuck(run: &RunMetrics) -> bool {
    /// dB.
    const FAR: f32 = 3.0;
    // A chain without a hold is as far as can be.
    !run.held(|hold| hold.gap_db).le(&FAR)
}
