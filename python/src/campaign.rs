//! Many missions, on all cores.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, ScopedJoinHandle};
use std::time::Duration;

use arrow_array::{
    ArrayRef, BooleanArray, Float32Array, Float64Array, Int64Array, RecordBatch, StringArray,
    UInt32Array, UInt64Array,
};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadBuilder;
use sim_harness::measure::campaign::grid::{self, Axis};
use sim_harness::measure::campaign::{CHUNK, COLUMNS, Cell, Column, Kind, Place, Row};
use sim_harness::mission::with_called_law;
use sim_harness::scenario::Setting;
use toml::Value;

use crate::mission::on_the_host;
use crate::policy::{Laws, Raised};
use crate::table::{Table, batch};
use crate::{keys, open, value_error};

/// How long the main thread sleeps between two looks whether Python was interrupted.
const NAP: Duration = Duration::from_millis(10);

/// Flies the missions of these seeds at every place of the grid, with the policy of Python if there is
/// one.
#[pyfunction]
pub(crate) fn fly_campaign(
    py: Python<'_>,
    scenario: &str,
    seeds: Vec<u64>,
    vary: &Bound<'_, PyDict>,
    threads: usize,
    policy: Option<(Py<PyAny>, f64)>,
    keys: &Bound<'_, PyDict>,
) -> PyResult<Table> {
    let settings = keys::settings(keys)?;
    let axes = axes(vary)?;
    let points = grid::points(&axes).map_err(value_error)?;
    let laws = policy.map(|(policy, timeout_s)| Laws::new(py, policy, timeout_s)).transpose()?;
    let scenarios = points.iter().map(|point| {
        let settings = settings.iter().chain(point).cloned().collect();
        let scenario = open(scenario, settings).map_err(value_error)?;
        on_the_host(&scenario)?;
        Ok(if laws.is_some() { with_called_law(&scenario) } else { scenario })
    });
    let scenarios = scenarios.collect::<PyResult<Vec<_>>>()?;
    let raised = laws.as_ref().map(Laws::raised).unwrap_or_default();
    let batches = on_threads(py, threads, &raised, |stop| {
        let mut table = Rows::new(&axes, &points);
        for (n, scenario) in scenarios.iter().enumerate() {
            let place = Place::new(scenario, n);
            for chunk in seeds.chunks(CHUNK) {
                let rows = match &laws {
                    None => place.fly(stop, chunk, |_| ()),
                    Some(laws) => place.fly_with(
                        |mission, seed| mission.by_law(laws.law(format!(" of seed {seed}"))),
                        stop,
                        chunk,
                        |_| (),
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

/// Does the work on so many other threads, while this one looks whether Python was interrupted. The work
/// ends early where the flag is set: by an interrupt, or when a policy has raised something, which then
/// comes out.
pub(crate) fn on_threads<T: Send>(
    py: Python<'_>,
    threads: usize,
    raised: &Raised,
    work: impl FnOnce(&AtomicBool) -> PyResult<T> + Send,
) -> PyResult<T> {
    let stop = AtomicBool::new(false);
    // Each thread stays known to Python: to be made known for each call would take longer than the call.
    let known = |thread: ThreadBuilder| Python::attach(|py| py.detach(|| thread.run()));
    let done = py.detach(|| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_scoped(known, |pool| {
            thread::scope(|scope| {
                let working = scope.spawn(|| pool.install(|| work(&stop)));
                let interrupt = wait(&working, raised, &stop);
                let done = working.join();
                interrupt?;
                done.map_err(|_| PyRuntimeError::new_err("a mission panicked: this is a defect"))?
            })
        })
    });
    raised.take()?;
    done.map_err(|error| PyRuntimeError::new_err(error.to_string()))?
}

/// Waits until the work is done; sets the flag at an interrupt, which is returned, and after an error.
fn wait<T>(working: &ScopedJoinHandle<'_, T>, raised: &Raised, stop: &AtomicBool) -> PyResult<()> {
    let mut interrupt = Ok(());
    while !working.is_finished() {
        thread::sleep(NAP);
        interrupt = interrupt.and_then(|()| Python::attach(|py| py.check_signals()));
        if interrupt.is_err() || raised.is_set() {
            stop.store(true, Ordering::Relaxed);
        }
    }
    interrupt
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
