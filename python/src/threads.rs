//! Work on other threads, while the thread that asked for it listens to Python.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

use crate::limit::Limit;
use crate::policy::Raised;

/// How long the thread that waits sleeps between two looks whether Python was interrupted.
const NAP: Duration = Duration::from_millis(10);

/// The time between two reports of the progress.
const REPORT: Duration = Duration::from_millis(200);

/// What the thread that waits listens to, and whom it tells of the progress.
pub(crate) struct Told {
    /// What the policies of Python have raised.
    pub(crate) raised: Raised,
    /// The limits on the time of their calls.
    pub(crate) limits: Vec<Arc<Limit>>,
    /// A callable of Python, which is told how many pieces of how many are done.
    pub(crate) progress: Option<Py<PyAny>>,
    /// The number of pieces.
    pub(crate) total: usize,
}

/// What the work and the thread that waits for it have in common.
#[derive(Default)]
pub(crate) struct Work {
    stop: AtomicBool,
    done: AtomicUsize,
}

impl Work {
    /// Whether the work is to end early.
    pub(crate) const fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// Counts a piece that is done.
    pub(crate) fn count_one(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl Told {
    fn report(&self, done: usize) -> PyResult<()> {
        let Some(progress) = &self.progress else { return Ok(()) };
        Python::attach(|py| progress.call1(py, (done, self.total)).map(drop))
    }

    /// Waits until the work is done; has it end early at an interrupt, which is returned, and after an
    /// error. A call of Python that cannot be ended is not waited for.
    fn wait<T>(&self, working: &JoinHandle<T>, work: &Work) -> PyResult<()> {
        let mut interrupt = Ok(());
        let mut reported = Instant::now();
        while !working.is_finished() {
            thread::sleep(NAP);
            interrupt = interrupt.and_then(|()| Python::attach(|py| py.check_signals()));
            if reported.elapsed() > REPORT {
                reported = Instant::now();
                interrupt = interrupt.and_then(|()| self.report(work.done.load(Ordering::Relaxed)));
            }
            if interrupt.is_err() || self.raised.is_set() {
                work.stop.store(true, Ordering::Relaxed);
            }
            if let Some(error) = self.limits.iter().find_map(|limit| limit.hanging()) {
                work.stop.store(true, Ordering::Relaxed);
                self.raised.set(error);
                return Ok(());
            }
        }
        interrupt
    }
}

/// Does the work on so many other threads, while this one looks whether Python was interrupted. The work
/// ends early where it is told to: by an interrupt, or when a policy has raised something, which then
/// comes out. Threads in which a call of Python hangs are left to themselves.
pub(crate) fn on_threads<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    told: Told,
    doing: impl FnOnce(&Work) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    py.detach(|| {
        let (pool, members) = pool(threads)?;
        let work = Arc::new(Work::default());
        let shared = Arc::clone(&work);
        let working = thread::Builder::new().spawn(move || {
            let done = pool.install(|| doing(&shared));
            drop(pool);
            // None of them is to be under way when the interpreter ends.
            let members =
                std::mem::take(&mut *members.lock().unwrap_or_else(PoisonError::into_inner));
            members.into_iter().for_each(|member| drop(member.join()));
            done
        })?;
        let interrupt = told.wait(&working, &work);
        told.raised.take()?;
        interrupt?;
        told.report(work.done.load(Ordering::Relaxed))?;
        let panicked = |_| PyRuntimeError::new_err("a mission panicked: this is a defect");
        working.join().map_err(panicked)?
    })
}

/// The threads of a pool.
type Members = Arc<Mutex<Vec<JoinHandle<()>>>>;

/// A pool of so many threads, and these threads. Each stays known to Python: to be made known for each call
/// would take longer than the call.
fn pool(threads: usize) -> PyResult<(ThreadPool, Members)> {
    let members = Members::default();
    let known = |thread: ThreadBuilder| Python::attach(|py| py.detach(|| thread.run()));
    let spawn = |thread: ThreadBuilder| {
        let member = thread::Builder::new().spawn(move || known(thread))?;
        members.lock().unwrap_or_else(PoisonError::into_inner).push(member);
        Ok(())
    };
    let pool = ThreadPoolBuilder::new().num_threads(threads).spawn_handler(spawn).build();
    let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok((pool, members))
}
