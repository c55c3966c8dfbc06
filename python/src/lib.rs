//! The simulator as a Python extension: the thin side of the package `uchain`, whose other side is in
//! `python/uchain`.

mod called;
mod campaign;
mod command;
mod compare;
mod keys;
mod limit;
mod mission;
mod policy;
mod radio_law;
mod simulation;
mod steered;
mod table;
mod threads;
mod wake;

use input::InputError;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sim_harness::scenario::{Changes, Scenario, Setting, builtin};

/// The error of Python for input that cannot be used: the line that the command prints.
fn value_error(error: InputError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The scenario of a built-in name, a path, or a text.
fn open(scenario: &str, settings: Vec<Setting>) -> Result<Scenario, InputError> {
    let changes = Changes { settings, ..Changes::default() };
    match scenario.contains('\n') {
        true => Scenario::of_text_with("scenario", scenario, &changes),
        false => Scenario::open_with(scenario, &changes),
    }
}

/// The names and the titles of the built-in scenarios.
#[pyfunction]
fn scenarios() -> Vec<(&'static str, String)> {
    builtin::titles().collect()
}

#[pymodule]
fn _uchain(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(scenarios, module)?)?;
    module.add_function(wrap_pyfunction!(mission::fly, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::fly_campaign, module)?)?;
    module.add_function(wrap_pyfunction!(compare::fly_comparison, module)?)?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_function(wrap_pyfunction!(command::options, module)?)?;
    module.add_function(wrap_pyfunction!(command::read_runs, module)?)?;
    module.add_function(wrap_pyfunction!(radio_law::tabulate, module)?)?;
    module.add_class::<mission::Flown>()?;
    module.add_class::<policy::Policy>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<steered::Steered>()?;
    module.add_class::<table::Table>()?;
    Ok(())
}
