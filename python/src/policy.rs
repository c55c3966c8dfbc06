//! Movement policies: the built-in ones to be called from Python, and those of Python to be called by
//! the simulator.

use std::sync::{Arc, Mutex, PoisonError};

use chain::policy::{LinkEnd, NAMES, Policy as BuiltIn, PolicyConfig};
use input::suggest;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sim_harness::mission::Law;
use units::{Db, Dbm, MetresPerSecond};

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

/// The speed law of a callable of Python. After an error it is not called again.
pub(crate) fn law(policy: Py<PyAny>) -> (Box<Law>, Raised) {
    let raised = Raised::default();
    let told = raised.clone();
    let law = move |drone: usize, front: LinkEnd, back: LinkEnd| {
        if told.is_set() {
            return MetresPerSecond::ZERO;
        }
        let asked = Python::attach(|py| {
            let ends = (drone, front.rssi.0, front.velocity.0, back.rssi.0, back.velocity.0);
            let speed: f32 = policy.call1(py, ends)?.extract(py)?;
            if speed.is_finite() {
                return Ok(MetresPerSecond(speed));
            }
            let text =
                format!("the policy returned {speed} for drone {drone}; give a velocity in m/s");
            Err(PyValueError::new_err(text))
        });
        asked.unwrap_or_else(|error| {
            told.set(error);
            MetresPerSecond::ZERO
        })
    };
    (Box::new(law), raised)
}
