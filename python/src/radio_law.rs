//! Radio laws of Python: the table of losses that a callable gives.

use pyo3::prelude::*;

use crate::called::Called;
use crate::limit::Limit;
use crate::wake::Wakeable;

/// The losses by a callable at these distances, with a row for each number of walls from none on.
#[pyfunction]
pub(crate) fn tabulate(
    py: Python<'_>,
    law: Py<PyAny>,
    distances: Vec<f64>,
    rows: u32,
    timeout_s: f64,
) -> PyResult<Vec<Vec<f32>>> {
    let called = Called::new("radio law", law, &Limit::new(timeout_s)?);
    let _wakeable = Wakeable::new(py);
    let row = |walls: u32| {
        let loss = |distance: &f64| {
            let of = || format!("{distance} m and {walls} walls");
            called.call(py, (*distance, walls), of)
        };
        distances.iter().map(loss).collect::<PyResult<Vec<_>>>()
    };
    (0..rows).map(row).collect()
}
