//! Callables of Python that the simulator calls, with a limit on the time of each call.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A callable that returns a number.
pub(crate) struct Called {
    /// The name of its kind for messages, such as "policy".
    kind: &'static str,
    function: Py<PyAny>,
    limit: Duration,
    clock: Arc<Clock>,
}

/// When the call under way began.
struct Clock {
    origin: Instant,
    /// The milliseconds from the origin to the beginning of the call, plus one; zero while no call is
    /// under way.
    began_ms: AtomicU64,
    /// The thread that calls, and its number in Python.
    caller: Mutex<Option<(ThreadId, u64)>>,
}

impl Clock {
    fn now_ms(&self) -> u64 {
        u64::try_from(self.origin.elapsed().as_millis()).unwrap_or(u64::MAX - 1)
    }

    /// How long the call under way has taken.
    fn taken(&self) -> Option<Duration> {
        let began_ms = self.began_ms.load(Ordering::Acquire).checked_sub(1)?;
        Some(Duration::from_millis(self.now_ms().saturating_sub(began_ms)))
    }

    /// Notes that this thread calls: a simulation may be stepped by another one than made it.
    fn note_caller(&self, py: Python<'_>) -> PyResult<()> {
        let own = thread::current().id();
        let mut caller = self.caller.lock().unwrap_or_else(PoisonError::into_inner);
        if caller.is_none_or(|(known, _)| known != own) {
            *caller = Some((own, number_of_thread(py)?));
        }
        Ok(())
    }

    /// The number in Python of the thread that calls.
    fn caller(&self) -> Option<u64> {
        self.caller.lock().unwrap_or_else(PoisonError::into_inner).map(|(_, number)| number)
    }
}

/// The number in Python of this thread.
fn number_of_thread(py: Python<'_>) -> PyResult<u64> {
    py.import("threading")?.call_method0("get_ident")?.extract()
}

impl Called {
    /// A callable whose calls are ended after `limit_s` seconds.
    pub(crate) fn new(
        py: Python<'_>,
        kind: &'static str,
        function: Py<PyAny>,
        limit_s: f64,
    ) -> PyResult<Self> {
        let limit = Duration::try_from_secs_f64(limit_s).ok().filter(|limit| !limit.is_zero());
        let limit = limit.ok_or_else(|| {
            let text = format!("timeout_s={limit_s} is out of range; give seconds, more than 0");
            PyValueError::new_err(text)
        })?;
        let (began_ms, caller) = (AtomicU64::new(0), Mutex::new(None));
        let clock = Arc::new(Clock { origin: Instant::now(), began_ms, caller });
        clock.note_caller(py)?;
        let watched = Arc::downgrade(&clock);
        thread::Builder::new().spawn(move || watch(&watched, limit))?;
        Ok(Self { kind, function, limit, clock })
    }

    /// Calls it, and returns the number, which is finite. `of` says for what it was called.
    pub(crate) fn call<'py>(
        &self,
        py: Python<'py>,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
        of: impl Fn() -> String,
    ) -> PyResult<f32> {
        self.clock.note_caller(py)?;
        self.clock.began_ms.store(self.clock.now_ms() + 1, Ordering::Release);
        let arguments = arguments.into_pyobject(py)?;
        let returned = self.function.bind(py).call1(arguments);
        let taken = self.clock.taken().unwrap_or_default();
        self.clock.began_ms.store(0, Ordering::Release);
        if taken >= self.limit {
            // Where the call ended by itself at that moment, the interruption is still to come.
            interrupt(py, None)?;
            let (kind, limit_s) = (self.kind, self.limit.as_secs_f64());
            let text = format!(
                "the {kind} took longer than {limit_s} s for {}; make it faster, or give timeout_s",
                of()
            );
            return Err(PyTimeoutError::new_err(text));
        }
        let number: f32 = returned?.extract()?;
        if number.is_finite() {
            return Ok(number);
        }
        let text =
            format!("the {} returned {number} for {}; give a finite number", self.kind, of());
        Err(PyValueError::new_err(text))
    }
}

/// Raises an error in the thread of a call that takes too long, so that a loop without end ends.
fn watch(clock: &Weak<Clock>, limit: Duration) {
    let nap = (limit / 10).clamp(Duration::from_millis(1), Duration::from_millis(100));
    loop {
        thread::sleep(nap);
        let Some(clock) = clock.upgrade() else { return };
        if clock.taken().is_none_or(|taken| taken < limit) {
            continue;
        }
        let raised = Python::attach(|py| match clock.taken().is_some_and(|taken| taken >= limit) {
            true => interrupt(py, clock.caller()),
            false => Ok(()),
        });
        if raised.is_err() {
            return;
        }
        // The call is told once; one that sleeps outside of Python hears it when it comes back.
        while clock.taken().is_some_and(|taken| taken >= limit) {
            thread::sleep(nap);
        }
    }
}

/// Has Python raise `TimeoutError` in the thread of this number at its next step; `None` takes back an
/// error that is still to be raised in the calling thread.
fn interrupt(py: Python<'_>, thread: Option<u64>) -> PyResult<()> {
    let ctypes = py.import("ctypes")?;
    let raise = ctypes.getattr("pythonapi")?.getattr("PyThreadState_SetAsyncExc")?;
    let number = ctypes.getattr("c_ulong")?;
    match thread {
        Some(thread) => {
            let error = ctypes.call_method1("py_object", (py.get_type::<PyTimeoutError>(),))?;
            raise.call1((number.call1((thread,))?, error))?;
        }
        None => {
            raise.call1((number.call1((number_of_thread(py)?,))?, py.None()))?;
        }
    }
    Ok(())
}
