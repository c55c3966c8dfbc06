//! The command `uchain`, which the package brings along, and the results that it writes.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use input::InputError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sim_harness::cli;
use sim_harness::measure::campaign::grid::{self, Axis};
use sim_harness::measure::campaign::{CHUNK, Row};
use sim_harness::report::{Folder, Origin};
use sim_harness::scenario::Setting;

use crate::campaign::{Rows, axes};
use crate::table::Table;
use crate::{keys, value_error};

/// Carries out a command line, whose first argument is the program's name; returns the exit status.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::main_with(arguments))
}

/// The options of the command for the keys and for the values that they take.
#[pyfunction]
pub(crate) fn options(vary: &Bound<'_, PyDict>, keys: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let set = keys::settings(keys)?.into_iter().flat_map(|it| ["--set".into(), it.to_string()]);
    let vary = axes(vary)?.into_iter().flat_map(|axis| ["--vary".into(), axis.to_string()]);
    Ok(set.chain(vary).collect())
}

/// The runs of a campaign that the command has written into a folder.
#[pyfunction]
pub(crate) fn read_runs(py: Python<'_>, folder: PathBuf) -> PyResult<Table> {
    py.detach(|| read(&folder))
}

fn read(folder: &Path) -> PyResult<Table> {
    Folder::is_as_written(folder).map_err(value_error)?;
    let (origin, _) = Origin::read(folder).map_err(value_error)?;
    let path = folder.join("runs.csv");
    let wrong = |what: String| {
        let remedy = "give a folder that uchain campaign has written with --out";
        value_error(InputError::new(what, remedy).in_file(&path))
    };
    let campaign = origin.campaign.ok_or_else(|| wrong("this is no campaign".into()))?;
    let axes = campaign.vary.iter().map(|text| Axis::parse(text));
    let axes = axes.collect::<Result<Vec<_>, _>>().map_err(value_error)?;
    let points = grid::points(&axes).map_err(value_error)?;
    let reader = csv::Reader::from_path(&path);
    let mut reader = reader.map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let texts = |point: &Vec<Setting>| point.iter().map(|it| text(it.value())).collect();
    let texts: Vec<Vec<String>> = points.iter().map(texts).collect();
    let (mut table, mut rows, mut place) = (Rows::new(&axes, &points), Vec::new(), 0);
    for (n, record) in reader.records().enumerate() {
        let row = record.ok().and_then(|record| row(&record, &texts, &mut place));
        rows.push(row.ok_or_else(|| wrong(format!("row {} is damaged", n + 1)))?);
        if rows.len() == CHUNK {
            table.add(&rows)?;
            rows.clear();
        }
    }
    if !rows.is_empty() || table.batches.is_empty() {
        table.add(&rows)?;
    }
    Table::of(table.batches)
}

/// The row of a record. The values of its keys tell the place of the grid, at which the row before was or
/// which comes after that.
fn row(record: &csv::StringRecord, places: &[Vec<String>], place: &mut usize) -> Option<Row> {
    let keys = places.first()?.len();
    let is_there =
        |values: &Vec<String>| values.iter().map(String::as_str).eq(record.iter().take(keys));
    *place += places.get(*place..)?.iter().position(is_there)?;
    let seed = record.get(keys)?.parse().ok()?;
    let values: Vec<&str> = record.iter().skip(keys + 1).collect();
    Row::read(*place, seed, values.into_iter())
}

/// A value as `runs.csv` has it.
fn text(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
