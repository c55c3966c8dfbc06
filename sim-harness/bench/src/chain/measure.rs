//! Measures how well the chain holds under each movement policy: how equal, calm and quick it is,
//! how far from the best chain, how it is launched, repaired and called home. All policies fly the
//! same seeds, and figures of a hold are of the hold alone.

use agent::AgentConfig;
use chain::policy::{NAMES, PolicyConfig};
use input::{InputError, suggest};
use rayon::prelude::*;
use serde_json::{Value, json};
use units::{MetresPerSecond, Order};
use world::World;

use bodies::emulated::Emulated;
use measure::campaign::{figures, fraction};
use measure::metrics::{Reference, RunMetrics, watched};
use mission::Mission;
use scenario::RadioPreset;
use scenario::{Fidelity, PilotStep, Scenario};

use super::ablation;
use super::cases::{self, Bound, COMPARED, Case, Target};
use super::contender::Contender;
pub use super::unknown::UnknownGaps;

/// What to fly.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The rows, by name; all where none is named.
    pub scenarios: Vec<String>,
    /// The policies; those of the scenario where there are none.
    pub policies: Vec<Contender>,
    /// Missions in each row.
    pub runs: usize,
    /// The first seed.
    pub seed: u64,
    /// How closely the drones are simulated.
    pub fidelity: Fidelity,
    /// The radio in place of the scenarios' own.
    pub radio: Option<&'static RadioPreset>,
}

/// Makes the virtual drones of the mission of a seed.
pub type MakeDrones<'a> = dyn Fn(&Scenario, u64) -> Result<Vec<Emulated>, InputError> + Sync + 'a;

/// One scenario under one policy.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scenario's name.
    pub scenario: &'static str,
    /// The policy's name.
    pub policy: String,
    /// The number of missions.
    pub runs: usize,
    /// Name and value of each figure; an infinite value is `None`.
    pub figures: Vec<(&'static str, Option<f64>)>,
    /// The least time in which any policy could bring the relays to their places, s, where they
    /// begin in the air.
    pub bound_s: Option<f64>,
    /// How far below the oracle the best chains are that do not know the shadows and fades, where
    /// there are any.
    pub unknown: Option<UnknownGaps>,
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
            if let Some(UnknownGaps { local_mean_db, law_db }) = self.unknown {
                object.insert("gap_of_local_mean_db".into(), json!(local_mean_db));
                object.insert("gap_of_law_db".into(), json!(law_db));
            }
            object.insert("targets".into(), Value::Object(targets));
        }
        object
    }
}

/// The missions of one row, before they are flown.
struct Campaign {
    case: &'static Case,
    policy: Contender,
}

/// The rows that a choice asks for.
fn campaigns(choice: &Choice) -> Result<Vec<Campaign>, InputError> {
    let cases = cases::at(choice.fidelity);
    let mut wanted = Vec::new();
    for name in &choice.scenarios {
        let found = cases.iter().find(|case| case.name == name);
        wanted.push(found.ok_or_else(|| {
            let names: Vec<_> = cases.iter().map(|case| case.name).collect();
            let level = choice.fidelity.name();
            let wrong =
                format!("the benchmark \"chain\" has no scenario \"{name}\" at level {level}");
            InputError::new(wrong, suggest::one_of(name, &names))
        })?);
    }
    if wanted.is_empty() {
        wanted.extend(cases);
    }
    let flown = wanted.into_iter().flat_map(|case| {
        let own: &[&str] = match choice.fidelity {
            Fidelity::Point if case.is_for_all => &NAMES,
            Fidelity::Point => &COMPARED,
            Fidelity::Flight | Fidelity::Virtual => &["chain"],
        };
        let policies = match choice.policies.as_slice() {
            [] => own.iter().map(|name| Contender::BuiltIn(name)).collect(),
            chosen => chosen.to_vec(),
        };
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

/// Flies the scenarios under the policies that are asked for, with virtual drones where `drones`
/// makes some.
///
/// # Errors
/// [`InputError`] for a scenario or a policy that there is not, for a virtual drone that cannot go on, and
/// that of `after_each`, which is called after each mission.
pub fn run(
    choice: &Choice,
    drones: Option<&MakeDrones<'_>>,
    after_each: impl Fn() -> Result<(), InputError> + Sync,
) -> Result<Vec<Row>, InputError> {
    let campaigns = campaigns(choice)?;
    let mut rows = Vec::with_capacity(campaigns.len());
    for of_case in campaigns.chunk_by(|one, next| one.case.name == next.case.name) {
        let Some(case) = of_case.first().map(|first| first.case) else { continue };
        let ground = Ground::of(case.scenario, choice.fidelity, choice.radio)?;
        let unknown = UnknownGaps::of(&ground.world, &ground.reference);
        for Campaign { policy, .. } in of_case {
            let scenario = policy.flies(&ground.plain)?;
            let (name, policy) = (policy.name(), Some(policy));
            let flown = ground.fly(case, &scenario, choice, drones, policy, &after_each)?;
            rows.push(Row { unknown, ..row(case, name, &flown) });
        }
    }
    Ok(rows)
}

/// Flies the policy `chain` with one ingredient removed at a time.
///
/// # Errors
/// [`InputError`] for a scenario that the comparison does not have, and that of `after_each`.
pub fn run_ablation(
    choice: &Choice,
    after_each: impl Fn() -> Result<(), InputError> + Sync,
) -> Result<Vec<Row>, InputError> {
    let mut rows = Vec::new();
    for case in ablated(choice)? {
        let ground = Ground::of(case.scenario, Fidelity::Point, choice.radio)?;
        let unknown = UnknownGaps::of(&ground.world, &ground.reference);
        for variant in ablation::variants() {
            let scenario = with_config(&ground.plain, variant.config);
            let flown = ground.fly(case, &scenario, choice, None, None, &after_each)?;
            rows.push(Row { unknown, ..row(case, variant.name, &flown) });
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
    let cases = cases::at(Fidelity::Point)
        .iter()
        .filter(|case| names.contains(&case.name) && wanted(case.name));
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
    fn of(name: &str, fidelity: Fidelity, radio: Option<&RadioPreset>) -> Result<Self, InputError> {
        let mut plain = Scenario::open(name)?.at(fidelity);
        if let Some(preset) = radio {
            plain.radio = preset.applied(&plain.radio);
        }
        let world = plain.world();
        let reference = Reference::of(&plain, &world);
        Ok(Self { plain, world, reference })
    }

    fn fly(
        &self,
        case: &Case,
        scenario: &Scenario,
        choice: &Choice,
        drones: Option<&MakeDrones<'_>>,
        policy: Option<&Contender>,
        after_each: &(impl Fn() -> Result<(), InputError> + Sync),
    ) -> Result<Vec<RunMetrics>, InputError> {
        let scenario = case.holds_s.map_or_else(|| scenario.clone(), |at| held(scenario, at));
        let all = (0..choice.runs as u64).into_par_iter().map(|n| {
            let seed = choice.seed.wrapping_add(n);
            let metrics = match drones {
                Some(make) => self.fly_virtual(&scenario, seed, make)?,
                None if case.is_recalled => self.measure(&recalled(&scenario, seed), seed, policy),
                None => self.measure(&scenario, seed, policy),
            };
            after_each()?;
            Ok(metrics)
        });
        all.collect()
    }

    fn measure(&self, scenario: &Scenario, seed: u64, policy: Option<&Contender>) -> RunMetrics {
        let mission = Mission::new(scenario, &self.world, seed);
        let mut mission = match policy {
            Some(policy) => policy.begin(mission, seed),
            None => mission,
        };
        watched(scenario, &self.world, &self.reference, &mut mission)
    }

    fn fly_virtual(
        &self,
        scenario: &Scenario,
        seed: u64,
        make: &MakeDrones<'_>,
    ) -> Result<RunMetrics, InputError> {
        let drones = make(scenario, seed)?;
        let mut mission = Mission::emulated(scenario, &self.world, seed, drones);
        let metrics = watched(scenario, &self.world, &self.reference, &mut mission);
        match mission.halted() {
            None => Ok(metrics),
            Some(why) => {
                let wrong = format!("{}, seed {seed}: {why}", scenario.name);
                Err(InputError::new(wrong, "fly it with `uchain run --fidelity virtual --log`"))
            }
        }
    }
}

/// The same mission, in which the operator lets the chain hold from and until these moments, s.
fn held(scenario: &Scenario, [from_s, until_s]: [u64; 2]) -> Scenario {
    let still = Order::explore(MetresPerSecond::ZERO);
    let mut pilot = scenario.pilot.clone();
    pilot.retain(|step| step.task != still && step.task != Order::Return);
    pilot.push(PilotStep { at_us: from_s * 1_000_000, task: still });
    pilot.push(PilotStep { at_us: until_s * 1_000_000, task: Order::Return });
    Scenario { pilot, ..scenario.clone() }
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

fn row(case: &'static Case, policy: &str, flown: &[RunMetrics]) -> Row {
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
        policy: policy.to_owned(),
        runs: flown.len(),
        figures: figures.collect(),
        bound_s: value("bound_s").filter(|value| value.is_finite()),
        unknown: None,
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
