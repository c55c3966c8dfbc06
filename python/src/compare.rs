//! A movement policy of Python beside built-in ones, by the measures of `uchain bench chain`.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use arrow_array::{ArrayRef, Float64Array, StringArray, UInt32Array};
use input::InputError;
use pyo3::prelude::*;
use sim_harness::bench::chain::{Contender, drawn, measure};
use sim_harness::scenario::Fidelity;

use crate::policy::{Laws, Raised};
use crate::table::Table;
use crate::threads::{Told, Work, on_threads};
use crate::value_error;

/// What is compared: the scenarios of the benchmark, or places that the seeds draw.
#[derive(Clone, Copy)]
struct Asked {
    runs: usize,
    seed: u64,
    fidelity: Fidelity,
}

/// Flies policies through the scenarios of the benchmark, or where `drawn` says so, in drawn places.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are those of the function in Python")]
pub(crate) fn fly_comparison(
    py: Python<'_>,
    own: Vec<(String, Py<PyAny>)>,
    built_in: Vec<String>,
    scenarios: Vec<String>,
    is_drawn: bool,
    runs: usize,
    seed: u64,
    fidelity: &str,
    threads: usize,
    timeout_s: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Table> {
    let fidelity = match fidelity {
        "flight" => Fidelity::Flight,
        _ => Fidelity::Point,
    };
    let raised = Raised::default();
    let mut policies = Vec::new();
    let mut limits = Vec::new();
    for (name, policy) in own {
        let laws = Laws::told(py, policy, timeout_s, raised.clone())?;
        limits.push(laws.limit());
        let law = move |seed| laws.law(format!(" of seed {seed}"));
        policies.push(Contender::Called { name, law: Arc::new(law) });
    }
    policies.extend(Contender::all(&built_in).map_err(value_error)?);
    let asked = Asked { runs, seed, fidelity };
    if is_drawn {
        let total = runs.saturating_mul(policies.len());
        let told = Told { raised, limits, progress, total };
        return on_threads(py, threads, told, move |work| of_places(asked, policies, work));
    }
    let Asked { runs, seed, fidelity } = asked;
    let choice = measure::Choice { scenarios, policies, runs, seed, fidelity, radio: None };
    let total = measure::count(&choice).map_err(value_error)?;
    let told = Told { raised, limits, progress, total };
    on_threads(py, threads, told, move |work| of_scenarios(&choice, work))
}

/// Counts a mission; an error once the work is to end. The caller drops it, and returns what Python raised instead.
fn go_on(work: &Work) -> Result<(), InputError> {
    work.count_one();
    match work.stop().load(Ordering::Relaxed) {
        false => Ok(()),
        true => Err(InputError::new("the comparison was stopped", "begin it again")),
    }
}

/// A row for each scenario and policy, with the figures that matter in the scenario.
fn of_scenarios(choice: &measure::Choice, work: &Work) -> PyResult<Table> {
    let rows = measure::run(choice, None, || go_on(work)).map_err(value_error)?;
    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let names = rows.iter().map(|row| Some(row.scenario));
    columns.push(("scenario".into(), Arc::new(StringArray::from_iter(names))));
    let names = rows.iter().map(|row| Some(row.policy.as_str()));
    columns.push(("policy".into(), Arc::new(StringArray::from_iter(names))));
    let counts = rows.iter().map(|row| u32::try_from(row.runs).unwrap_or(u32::MAX));
    columns.push(("runs".into(), Arc::new(UInt32Array::from_iter_values(counts))));
    let mut figures: Vec<&str> = Vec::new();
    for (name, _) in rows.iter().flat_map(|row| &row.figures) {
        if !figures.contains(name) {
            figures.push(name);
        }
    }
    for name in figures {
        // A figure that the scenario does not have is null; a time that never comes is infinite.
        let values = rows.iter().map(|row| {
            let (_, value) = row.figures.iter().find(|(own, _)| *own == name)?;
            Some(value.unwrap_or(f64::INFINITY))
        });
        columns.push((name.to_owned(), Arc::new(Float64Array::from_iter(values))));
    }
    Table::new(columns)
}

/// A row for each policy, with its figures over all places and the limits of their intervals.
fn of_places(
    Asked { runs, seed, fidelity }: Asked,
    policies: Vec<Contender>,
    work: &Work,
) -> PyResult<Table> {
    let choice = drawn::measure::Choice { places: runs, seed, fidelity, policies };
    let rows = drawn::measure::run(&choice, || go_on(work)).map_err(value_error)?;
    let totals = drawn::totals(&choice, &rows);
    let mut columns: Vec<(String, ArrayRef)> = Vec::new();
    let names = totals.iter().map(|totals| Some(totals.policy.as_str()));
    columns.push(("policy".into(), Arc::new(StringArray::from_iter(names))));
    let counts = totals.iter().map(|it| u32::try_from(it.missions).unwrap_or(u32::MAX));
    columns.push(("missions".into(), Arc::new(UInt32Array::from_iter_values(counts))));
    let count = totals.first().map_or(0, |totals| totals.figures.len());
    for n in 0..count {
        let figures = || totals.iter().filter_map(|totals| totals.figures.get(n));
        let Some(name) = figures().next().map(|figure| figure.name) else { continue };
        let limits = || figures().map(|figure| figure.estimate.interval);
        let known = |value: f64| Some(value).filter(|value| !value.is_nan());
        let mut put = |ending: &str, values: Vec<Option<f64>>| {
            let array: ArrayRef = Arc::new(Float64Array::from(values));
            columns.push((format!("{name}{ending}"), array));
        };
        put("", figures().map(|figure| known(figure.estimate.value)).collect());
        put("_low", limits().map(|it| it.and_then(|(low, _)| known(low))).collect());
        put("_high", limits().map(|it| it.and_then(|(_, high)| known(high))).collect());
    }
    Table::new(columns)
}
