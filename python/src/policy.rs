//! Movement policies: the built-in ones to be called from Python, and those of Python to be called by
//! the simulator.

use std::sync::{Arc, Mutex, PoisonError};

use chain::policy::{LinkEnd, NAMES, Policy as BuiltIn, PolicyConfig};
use input::suggest;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sim_harness::mission::Law;
use units::{Db, Dbm, MetresPerSecond};

use crate::called::Called;

/// A built-in movement policy as a function.
#[pyclass(frozen, module = "uchain")]
pub(crate) struct Policy {
    config: PolicyConfig,
}

fn end(rssi: f32, velocity: f32) -> LinkEnd {
    LinkEnd { rssi: Dbm(rssi), velocity: MetresPerSecond(velocity) }
}

#[pymethods]
impl Policy {
    #[new]
    #[pyo3(signature = (name, loss_at_1m_db = 40.0))]
    fn new(name: &str, loss_at_1m_db: f32) -> PyResult<Self> {
        let policy = BuiltIn::named(name).ok_or_else(|| {
            let remedy = suggest::one_of(name, &NAMES);
            PyValueError::new_err(format!("there is no policy \"{name}\"; {remedy}"))
        })?;
        Ok(Self { config: policy.config.for_loss_at_1m(Db(loss_at_1m_db)) })
    }

    /// The forward velocity of a relay, m/s.
    fn __call__(
        &self,
        drone: usize,
        front_dbm: f32,
        front_mps: f32,
        back_dbm: f32,
        back_mps: f32,
    ) -> f32 {
        let _ = drone;
        self.config.velocity(end(front_dbm, front_mps), end(back_dbm, back_mps)).0
    }
}

/// What a policy of Python has raised, if anything.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// The error, once.
    pub(crate) fn take(&self) -> PyResult<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// The speed law of a callable of Python, each call of which may take so many seconds. After an error it
/// is not called again.
pub(crate) fn law(
    py: Python<'_>,
    policy: Py<PyAny>,
    timeout_s: f64,
) -> PyResult<(Box<Law>, Raised)> {
    let called = Called::new(py, "policy", policy, timeout_s)?;
    let raised = Raised::default();
    let told = raised.clone();
    let law = move |drone: usize, front: LinkEnd, back: LinkEnd| {
        if told.is_set() {
            return MetresPerSecond::ZERO;
        }
        let asked = Python::attach(|py| {
            let ends = (drone, front.rssi.0, front.velocity.0, back.rssi.0, back.velocity.0);
            called.call(py, ends, || format!("drone {drone}"))
        });
        asked.map_or_else(
            |error| {
                told.set(error);
                MetresPerSecond::ZERO
            },
            MetresPerSecond,
        )
    };
    Ok((Box::new(law), raised))
}
