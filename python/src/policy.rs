//! Movement policies: the built-in ones to be called from Python, and those of Python to be called by
//! the simulator.

use std::sync::{Arc, Mutex, PoisonError};

use chain::policy::{LinkEnd, NAMES, Policy as BuiltIn, PolicyConfig};
use input::suggest;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use sim_harness::mission::Law;
use units::{Db, Dbm, MetresPerSecond};

use crate::called::Called;
use crate::limit::Limit;

/// A built-in movement policy as a function: `Policy(name)(drone, front_dbm, front_mps, back_dbm,
/// back_mps)`.
///
/// It is called as a policy of Python is, with the relay's number (which has no effect), the filtered
/// strength of the link to the neighbour in front, dBm, that neighbour's velocity along the tunnel, m/s,
/// positive towards the head, and both of the neighbour behind, and returns the relay's velocity towards
/// the head, m/s. `loss_at_1m_db` is the loss over the first metre that it assumes, dB.
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

    pub(crate) fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Keeps an error, if there is none yet.
    pub(crate) fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// The speed laws of a callable of Python, for missions that fly one after the other or at the same time;
/// of a class, an object is made for each mission. After an error the callable is not called again.
pub(crate) struct Laws {
    policy: Py<PyAny>,
    is_class: bool,
    limit: Arc<Limit>,
    /// The callables with their clocks that no mission uses now: each thread needs one of its own.
    idle: Idle,
    raised: Raised,
}

type Idle = Arc<Mutex<Vec<Called>>>;

/// A callable that is used by a mission, and given back after it.
struct Borrowed {
    called: Option<Called>,
    idle: Idle,
}

impl Drop for Borrowed {
    fn drop(&mut self) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.extend(self.called.take());
    }
}

impl Laws {
    /// The laws of a callable, each call of which may take so many seconds.
    pub(crate) fn new(py: Python<'_>, policy: Py<PyAny>, timeout_s: f64) -> PyResult<Self> {
        Self::told(py, policy, timeout_s, Raised::default())
    }

    /// The same, of which what the callable raises is put here, too.
    pub(crate) fn told(
        py: Python<'_>,
        policy: Py<PyAny>,
        timeout_s: f64,
        raised: Raised,
    ) -> PyResult<Self> {
        let is_class = policy.bind(py).is_instance_of::<PyType>();
        Ok(Self { policy, is_class, limit: Limit::new(timeout_s)?, idle: Idle::default(), raised })
    }

    /// The limit on the time of its calls.
    pub(crate) fn limit(&self) -> Arc<Limit> {
        Arc::clone(&self.limit)
    }

    /// What the callable has raised.
    pub(crate) fn raised(&self) -> Raised {
        self.raised.clone()
    }

    /// The speed law of a mission; `of` names the mission in messages.
    pub(crate) fn law(&self, of: String) -> Box<Law> {
        let borrowed = self.borrow(&of);
        let told = self.raised.clone();
        let law = move |drone: usize, front: LinkEnd, back: LinkEnd| {
            let Some(called) = borrowed.called.as_ref().filter(|_| !told.is_set()) else {
                return MetresPerSecond::ZERO;
            };
            let asked = Python::attach(|py| {
                let ends = (drone, front.rssi.0, front.velocity.0, back.rssi.0, back.velocity.0);
                let asked = called.call(py, ends, || format!("drone {drone}{of}"));
                asked.inspect_err(|error| {
                    note(py, error, &of, &format!("the policy was called for drone {drone}{of}"));
                })
            });
            asked.map_or_else(
                |error| {
                    told.set(error);
                    MetresPerSecond::ZERO
                },
                MetresPerSecond,
            )
        };
        Box::new(law)
    }

    fn borrow(&self, of: &str) -> Borrowed {
        if self.raised.is_set() {
            return Borrowed { called: None, idle: Idle::default() };
        }
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let called = idle.or_else(|| {
            let made = Python::attach(|py| {
                let policy = match self.is_class {
                    true => self.policy.call0(py).inspect_err(|error| {
                        note(py, error, of, &format!("the policy was made for the mission{of}"));
                    })?,
                    false => self.policy.clone_ref(py),
                };
                PyResult::Ok(Called::new("policy", policy, &self.limit))
            });
            made.map_err(|error| self.raised.set(error)).ok()
        });
        // An object of a class is of one mission.
        let idle = if self.is_class { Idle::default() } else { Arc::clone(&self.idle) };
        Borrowed { called, idle }
    }
}

/// Says in an error of a campaign of which mission it is, by this text, where it does not say so itself.
/// Python before 3.11 has no notes.
fn note(py: Python<'_>, error: &PyErr, of: &str, text: &str) {
    if !of.is_empty() && !error.to_string().contains(of) {
        let _ = error.value(py).call_method1("add_note", (text,));
    }
}
