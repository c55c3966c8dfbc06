//! Callables of Python that the simulator calls, with a limit on the time of each call.

use std::sync::Arc;

use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyTimeoutError, PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::limit::{Clock, Limit};

/// A callable that returns a number. It makes one call at a time.
pub(crate) struct Called {
    /// The name of its kind for messages, such as "policy".
    kind: &'static str,
    function: Py<PyAny>,
    limit: Arc<Limit>,
    clock: Arc<Clock>,
}

impl Called {
    /// A callable whose calls are ended after this limit.
    pub(crate) fn new(kind: &'static str, function: Py<PyAny>, limit: &Arc<Limit>) -> Self {
        Self { kind, function, limit: Arc::clone(limit), clock: limit.clock() }
    }

    /// Calls it, and returns the number, which is finite. `of` says for what it was called.
    pub(crate) fn call<'py>(
        &self,
        py: Python<'py>,
        arguments: impl PyCallArgs<'py>,
        of: impl Fn() -> String,
    ) -> PyResult<f32> {
        self.clock.begin(py)?;
        let returned = self.function.bind(py).call1(arguments);
        if self.clock.stop(py)? {
            let (kind, limit_s) = (self.kind, self.limit.seconds());
            let text = format!(
                "the {kind} took longer than {limit_s} s for {}; make it faster, or give timeout_s",
                of()
            );
            return Err(PyTimeoutError::new_err(text));
        }
        let returned = returned?;
        let number =
            returned.extract::<f32>().map_err(|error| self.no_number(&returned, &of(), error))?;
        if number.is_finite() {
            return Ok(number);
        }
        let text =
            format!("the {} returned {number} for {}; give a finite number", self.kind, of());
        Err(PyValueError::new_err(text))
    }

    /// The error for a value that is no number; another error of its conversion comes out as it is.
    fn no_number(&self, returned: &Bound<'_, PyAny>, of: &str, error: PyErr) -> PyErr {
        let py = returned.py();
        let Ok(kind) = returned.get_type().name() else { return error };
        if !error.is_instance_of::<PyTypeError>(py) {
            return error;
        }
        let kind = match returned.is_none() {
            true => "None".to_owned(),
            false => format!("a value of the type {kind}"),
        };
        let text = format!("the {} returned {kind} for {of}; give a number", self.kind);
        PyTypeError::new_err(text)
    }
}
