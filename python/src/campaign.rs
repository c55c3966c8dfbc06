//! Many missions, on all cores.

use std::sync::Arc;

use arrow_array::{
    ArrayRef, BooleanArray, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray,
    UInt32Array, UInt64Array,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sim_harness::measure::campaign::grid::{self, Axis};
use sim_harness::measure::campaign::{CHUNK, COLUMNS, Cell, Column, Kind, Place, Row};
use sim_harness::mission::with_called_law;
use sim_harness::scenario::{Scenario, Setting};
use toml::Value;

use crate::mission::{asks_a_policy, on_the_host};
use crate::policy::Laws;
use crate::table::{Table, batch};
use crate::threads::{Told, on_threads};
use crate::{keys, open, value_error};

/// Flies the missions of these seeds at every place of the grid, with the policy of Python if there is
/// one. `progress` is told how many missions of how many are flown.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are those of the function in Python")]
pub(crate) fn fly_campaign(
    py: Python<'_>,
    scenario: &str,
    seeds: Vec<u64>,
    vary: &Bound<'_, PyDict>,
    threads: usize,
    policy: Option<(Py<PyAny>, f64)>,
    keys: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Table> {
    let settings = keys::settings(keys)?;
    let axes = axes(vary)?;
    let points = grid::points(&axes).map_err(value_error)?;
    let laws = policy.map(|(policy, timeout_s)| Laws::new(py, policy, timeout_s)).transpose()?;
    let scenarios = points.iter().map(|point| {
        let settings = settings.iter().chain(point).cloned().collect();
        flown(scenario, settings, laws.is_some())
    });
    let scenarios = scenarios.collect::<PyResult<Vec<_>>>()?;
    let total = scenarios.len().saturating_mul(seeds.len());
    let raised = laws.as_ref().map(Laws::raised).unwrap_or_default();
    let told = Told { raised, limits: laws.iter().map(Laws::limit).collect(), progress, total };
    let batches = on_threads(py, threads, told, move |work| {
        let stop = work.stop();
        let count = |_: &Row| work.count_one();
        let mut table = Rows::new(&axes, &points);
        for (n, scenario) in scenarios.iter().enumerate() {
            let place = Place::new(scenario, n);
            for chunk in seeds.chunks(CHUNK) {
                let rows = match &laws {
                    None => place.fly(stop, chunk, count),
                    Some(laws) => place.fly_with(
                        |mission, seed| mission.by_law(laws.law(format!(" of seed {seed}"))),
                        stop,
                        chunk,
                        count,
                    ),
                };
                table.add(&rows)?;
            }
        }
        if table.batches.is_empty() {
            table.add(&[])?;
        }
        Ok(table.batches)
    })?;
    Table::of(batches)
}

/// The scenario that is flown with these settings, by a policy of Python or its own.
fn flown(scenario: &str, settings: Vec<Setting>, is_called: bool) -> PyResult<Scenario> {
    let scenario = open(scenario, settings).map_err(value_error)?;
    on_the_host(&scenario)?;
    if !is_called {
        return Ok(scenario);
    }
    asks_a_policy(&scenario)?;
    Ok(with_called_law(&scenario))
}

pub(crate) fn axes(vary: &Bound<'_, PyDict>) -> PyResult<Vec<Axis>> {
    let axis = |(key, values): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        let values = values.try_iter().map_err(|_| {
            PyValueError::new_err(format!("{key}: vary takes a list of values for each key"))
        })?;
        let values = values.map(|value| keys::value(&key, &value?));
        Axis::new(key.clone(), values.collect::<PyResult<_>>()?).map_err(value_error)
    };
    vary.iter().map(axis).collect()
}

/// The table of a campaign while its rows come, piece by piece, so that they need not wait in memory as
/// anything else.
pub(crate) struct Rows<'a> {
    axes: &'a [Axis],
    points: &'a [Vec<Setting>],
    pub(crate) batches: Vec<RecordBatch>,
}

impl<'a> Rows<'a> {
    /// No rows yet of a campaign with these keys varied.
    pub(crate) const fn new(axes: &'a [Axis], points: &'a [Vec<Setting>]) -> Self {
        Self { axes, points, batches: Vec::new() }
    }

    /// Adds rows.
    pub(crate) fn add(&mut self, rows: &[Row]) -> PyResult<()> {
        let mut columns = Vec::new();
        for (n, axis) in self.axes.iter().enumerate() {
            let values = rows.iter().map(|row| self.points[row.point][n].value());
            columns.push((axis.key().to_owned(), of_values(axis, values)));
        }
        let seeds = rows.iter().map(|row| row.seed);
        columns.push(("seed".to_owned(), Arc::new(UInt64Array::from_iter_values(seeds))));
        let cells = |column: &Column| (column.name.to_owned(), of_cells(column, rows));
        columns.extend(COLUMNS.iter().map(cells));
        self.batches.push(batch(columns)?);
        Ok(())
    }
}

/// The narrowest column that has all values of the key.
fn of_values<'v>(axis: &Axis, values: impl Iterator<Item = &'v Value>) -> ArrayRef {
    let all = |is: fn(&Value) -> bool| axis.values().iter().all(is);
    if all(Value::is_integer) {
        return Arc::new(Int64Array::from_iter(values.map(Value::as_integer)));
    }
    if all(|value| value.is_integer() || value.is_float()) {
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|it| it as f64));
        return Arc::new(Float64Array::from_iter(values.map(number)));
    }
    if all(Value::is_bool) {
        return Arc::new(BooleanArray::from_iter(values.map(Value::as_bool)));
    }
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    Arc::new(StringArray::from_iter_values(values.map(text)))
}

fn of_cells(column: &Column, rows: &[Row]) -> ArrayRef {
    let cells = rows.iter().map(|row| column.cell(row));
    match column.kind {
        Kind::Flag => Arc::new(BooleanArray::from_iter(cells.map(|cell| match cell {
            Cell::Flag(flag) => Some(flag),
            _ => None,
        }))),
        Kind::Text => Arc::new(StringArray::from_iter(cells.map(|cell| match cell {
            Cell::Text(text) => Some(text),
            _ => None,
        }))),
        Kind::Number => Arc::new(Float32Array::from_iter(cells.map(|cell| match cell {
            Cell::Number(number) => Some(number),
            _ => None,
        }))),
        Kind::Count => Arc::new(UInt32Array::from_iter(cells.map(|cell| match cell {
            Cell::Count(count) => Some(count),
            _ => None,
        }))),
    }
}
