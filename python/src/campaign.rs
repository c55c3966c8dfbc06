//! Many missions, on all cores.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use arrow_array::{
    ArrayRef, BooleanArray, Float32Array, Float64Array, Int64Array, StringArray, UInt32Array,
    UInt64Array,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sim_harness::measure::campaign::grid::{self, Axis};
use sim_harness::measure::campaign::{COLUMNS, Cell, Column, Kind, Row, fly_rows};
use sim_harness::scenario::{Scenario, Setting};
use toml::Value;

use crate::mission::on_the_host;
use crate::table::Table;
use crate::{keys, open, value_error};

/// How long the main thread sleeps between two looks whether Python was interrupted.
const NAP: Duration = Duration::from_millis(10);

/// Flies the missions of these seeds at every place of the grid.
#[pyfunction]
pub(crate) fn fly_campaign(
    py: Python<'_>,
    scenario: &str,
    seeds: Vec<u64>,
    vary: &Bound<'_, PyDict>,
    threads: usize,
    keys: &Bound<'_, PyDict>,
) -> PyResult<Table> {
    let settings = keys::settings(keys)?;
    let axes = axes(vary)?;
    let points = grid::points(&axes).map_err(value_error)?;
    let scenarios = points.iter().map(|point| {
        let settings = settings.iter().chain(point).cloned().collect();
        open(scenario, settings).map_err(value_error)
    });
    let scenarios = scenarios.collect::<PyResult<Vec<_>>>()?;
    scenarios.iter().try_for_each(on_the_host)?;
    let rows = fly(py, &scenarios, &seeds, threads)?;
    py.detach(|| table(&axes, &points, &rows))
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

/// Flies all of them on other threads, while this one looks whether Python was interrupted.
fn fly(
    py: Python<'_>,
    scenarios: &[Scenario],
    seeds: &[u64],
    threads: usize,
) -> PyResult<Vec<Row>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let flights = scope.spawn(|| {
            pool.install(|| {
                let all = scenarios.iter().enumerate();
                all.flat_map(|(n, scenario)| fly_rows(&stop, scenario, n, seeds, |_| ())).collect()
            })
        });
        while !flights.is_finished() {
            py.detach(|| std::thread::sleep(NAP));
            if let Err(interrupt) = py.check_signals() {
                stop.store(true, Ordering::Relaxed);
                let _ = py.detach(|| flights.join());
                return Err(interrupt);
            }
        }
        flights.join().map_err(|_| PyRuntimeError::new_err("a mission panicked: this is a defect"))
    })
}

/// The rows with a column for each key of the grid.
pub(crate) fn table(axes: &[Axis], points: &[Vec<Setting>], rows: &[Row]) -> PyResult<Table> {
    let mut columns = Vec::new();
    for (n, axis) in axes.iter().enumerate() {
        let values: Vec<&Value> = rows.iter().map(|row| points[row.point][n].value()).collect();
        columns.push((axis.key().to_owned(), of_values(&values)));
    }
    let seeds = rows.iter().map(|row| row.seed);
    columns.push(("seed".to_owned(), Arc::new(UInt64Array::from_iter_values(seeds))));
    let cells = |column: &Column| (column.name.to_owned(), of_cells(column, rows));
    columns.extend(COLUMNS.iter().map(cells));
    Table::new(columns)
}

/// The narrowest column that has all of the values.
fn of_values(values: &[&Value]) -> ArrayRef {
    if let Some(whole) = values.iter().map(|value| value.as_integer()).collect::<Option<Vec<_>>>() {
        return Arc::new(Int64Array::from(whole));
    }
    let number = |value: &&Value| value.as_float().or(value.as_integer().map(|it| it as f64));
    if let Some(numbers) = values.iter().map(number).collect::<Option<Vec<_>>>() {
        return Arc::new(Float64Array::from(numbers));
    }
    if let Some(flags) = values.iter().map(|value| value.as_bool()).collect::<Option<Vec<_>>>() {
        return Arc::new(BooleanArray::from(flags));
    }
    let text = |value: &&Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    Arc::new(StringArray::from_iter_values(values.iter().map(text)))
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
