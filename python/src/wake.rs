//! A signal that ends a wait of the main thread outside of Python: for a lock, a server, in a sleep.
//!
//! It is not that of Ctrl-C, which a program in the background ignores, and for which others have handlers
//! of their own.

use pyo3::prelude::*;

/// The signal, which does nothing where there is no handler of it, and which programs seldom use.
const SIGNAL: &str = "SIGURG";

/// While it is kept, the main thread is woken from its waits by the signal.
pub(crate) struct Wakeable(Option<Py<PyAny>>);

impl Wakeable {
    /// Has the signal raise an error in this thread, if that is the main one.
    pub(crate) fn new(py: Python<'_>) -> Self {
        // Without such a signal, as on Windows, waits end by themselves.
        Self(listen(py).ok().flatten().map(Bound::unbind))
    }
}

impl Drop for Wakeable {
    fn drop(&mut self) {
        let Some(before) = self.0.take() else { return };
        let _ = Python::attach(|py| {
            let module = py.import("signal")?;
            module.call_method1("signal", (module.getattr(SIGNAL)?, before)).map(drop)
        });
    }
}

/// Sets the handler; returns the one before. `None` in another thread than the main one, and where the
/// handler before cannot be put back.
fn listen(py: Python<'_>) -> PyResult<Option<Bound<'_, PyAny>>> {
    let module = py.import("signal")?;
    let (signal, handler) = (module.getattr(SIGNAL)?, module.getattr("default_int_handler")?);
    if !is_main(py, py.import("threading")?.call_method0("get_ident")?.extract()?)?
        || module.call_method1("getsignal", (&signal,))?.is_none()
    {
        return Ok(None);
    }
    module.call_method1("signal", (signal, handler)).map(Some)
}

fn is_main(py: Python<'_>, thread: u64) -> PyResult<bool> {
    let main = py.import("threading")?.call_method0("main_thread")?.getattr("ident")?;
    Ok(main.extract::<u64>()? == thread)
}

/// Sends the thread of this number the signal, if it is the main one and listens, and is to get it; returns
/// whether the thread needs no other help.
pub(crate) fn wake(
    py: Python<'_>,
    thread: u64,
    is_to: impl Fn() -> bool,
    is_signalled: impl Fn(),
) -> PyResult<bool> {
    let module = py.import("signal")?;
    let signal = module.getattr(SIGNAL)?;
    let handler = module.call_method1("getsignal", (&signal,))?;
    if !is_main(py, thread)? || !handler.is(&module.getattr("default_int_handler")?) {
        return Ok(false);
    }
    if is_to() {
        is_signalled();
        module.call_method1("pthread_kill", (thread, signal))?;
    }
    Ok(true)
}
