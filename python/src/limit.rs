//! The limit on the time of calls of Python, which one thread watches for all missions of a campaign.
//!
//! One thread at a time runs Python, so a call also waits while other missions' calls run. Those waits
//! are not the call's own time: of each nap of the watch, every call under way is charged an equal share.
//! The calls themselves only count up a number, so that the limit costs them nearly nothing.
//!
//! A call that runs Python is ended by an error that Python raises at its next step. One that waits outside
//! of Python, such as a sleep or a lock, does not take a step: when it was told in vain, the main thread is
//! [sent a signal](crate::wake), which ends such waits; for another thread, the thread that waits for
//! its mission waits no longer, and raises the error.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::{self, Thread};
use std::time::Duration;

use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;

use crate::wake::wake;

/// The calls that are under way in this process, of whatever campaign: they share the interpreter.
static UNDER_WAY: AtomicUsize = AtomicUsize::new(0);

/// How often a call is told that it took too long before it counts as one that hangs outside of Python.
const TELLINGS: u32 = 3;

/// The longest time of a call, and the clocks of those who call.
pub(crate) struct Limit {
    longest: Duration,
    clocks: Mutex<Vec<Watched>>,
    /// The thread that watches.
    watch: Mutex<Option<Thread>>,
    /// Whether a call of a thread that no signal reaches hangs.
    hangs: AtomicBool,
}

/// A clock with what the watch knows of it.
struct Watched {
    clock: Weak<Clock>,
    /// The clock's count at the last look.
    count: u64,
    /// How long the call under way has taken since it began, or since it was told last.
    taken: Duration,
    /// How often the call under way was told that it took too long.
    told: u32,
}

/// The clock of one who makes one call after the other.
#[derive(Default)]
pub(crate) struct Clock {
    /// Odd while a call is under way; each beginning and each end adds one.
    count: AtomicU64,
    /// The number in Python of the thread that called last: a simulation may be stepped by several.
    caller: AtomicU64,
    /// The count during the last call that took too long; zero before there is one.
    late: AtomicU64,
    /// Whether that call was sent a signal.
    signalled: AtomicBool,
}

impl Limit {
    /// A limit of so many seconds.
    pub(crate) fn new(longest_s: f64) -> PyResult<Arc<Self>> {
        let longest = Duration::try_from_secs_f64(longest_s).ok().filter(|it| !it.is_zero());
        let longest = longest.ok_or_else(|| {
            let text = format!("timeout_s={longest_s} is out of range; give seconds, more than 0");
            PyValueError::new_err(text)
        })?;
        let (clocks, watch) = (Mutex::new(Vec::new()), Mutex::new(None));
        let hangs = AtomicBool::new(false);
        let limit = Arc::new(Self { longest, clocks, watch, hangs });
        let watched = Arc::downgrade(&limit);
        let nap = (longest / 10).clamp(Duration::from_millis(1), Duration::from_millis(100));
        let watch = thread::Builder::new().spawn(move || {
            while let Some(limit) = watched.upgrade() {
                limit.look(nap);
                drop(limit);
                thread::park_timeout(nap);
            }
        })?;
        *limit.watch.lock().unwrap_or_else(PoisonError::into_inner) = Some(watch.thread().clone());
        Ok(limit)
    }

    /// The limit in seconds.
    pub(crate) fn seconds(&self) -> f64 {
        self.longest.as_secs_f64()
    }

    /// The error of a call that goes on though it was told, in a thread that no signal reaches, if there
    /// is one: it can only be left alone.
    pub(crate) fn hanging(&self) -> Option<PyErr> {
        let text = format!(
            "a call of the policy took longer than {} s, and waits for something outside of Python, so \
             that it cannot be ended; give what it waits for a limit of time",
            self.seconds()
        );
        self.hangs.load(Ordering::Relaxed).then(|| PyTimeoutError::new_err(text))
    }

    /// A new clock, which is watched as long as it is kept.
    pub(crate) fn clock(&self) -> Arc<Clock> {
        let clock = Arc::new(Clock::default());
        let watched =
            Watched { clock: Arc::downgrade(&clock), count: 0, taken: Duration::ZERO, told: 0 };
        self.clocks.lock().unwrap_or_else(PoisonError::into_inner).push(watched);
        clock
    }

    /// Charges the nap to the calls under way, and ends those that take too long.
    fn look(&self, nap: Duration) {
        let sharing = UNDER_WAY.load(Ordering::Relaxed).max(1);
        let share = nap / u32::try_from(sharing).unwrap_or(u32::MAX);
        let mut late = Vec::new();
        let mut clocks = self.clocks.lock().unwrap_or_else(PoisonError::into_inner);
        clocks.retain_mut(|watched| {
            let Some(clock) = watched.clock.upgrade() else { return false };
            if watched.passes(&clock, share, self.longest) {
                late.push((clock, watched.told >= TELLINGS));
            }
            true
        });
        drop(clocks);
        // A caller that has the interpreter may want the list of clocks.
        for (clock, is_hanging) in late {
            if !clock.end(is_hanging) && is_hanging {
                self.hangs.store(true, Ordering::Relaxed);
            }
        }
    }
}

impl Drop for Limit {
    fn drop(&mut self) {
        let watch = self.watch.get_mut().unwrap_or_else(PoisonError::into_inner);
        // So that it ends now, and not after its nap.
        watch.iter().for_each(Thread::unpark);
    }
}

impl Watched {
    /// Takes the time since the last look; returns whether the call under way passes its limit with it.
    fn passes(&mut self, clock: &Clock, share: Duration, longest: Duration) -> bool {
        let count = clock.count.load(Ordering::Acquire);
        if count.is_multiple_of(2) || count != self.count {
            (self.count, self.taken, self.told) = (count, Duration::ZERO, 0);
            return false;
        }
        self.taken += share;
        if self.taken < longest {
            return false;
        }
        // One that goes on after its interruption is told again when it has taken as long once more.
        self.taken = Duration::ZERO;
        self.told = self.told.saturating_add(1);
        clock.late.store(count, Ordering::Release);
        true
    }
}

impl Clock {
    /// Begins a call of the thread that has the interpreter.
    pub(crate) fn begin(&self, py: Python<'_>) -> PyResult<()> {
        self.caller.store(number_of_thread(py)?, Ordering::Relaxed);
        UNDER_WAY.fetch_add(1, Ordering::Relaxed);
        self.count.fetch_add(1, Ordering::Release);
        Ok(())
    }

    /// Ends the call; returns whether it took too long. The caller has kept the interpreter since the
    /// call returned, so that the watch raises nothing any more.
    pub(crate) fn stop(&self, py: Python<'_>) -> PyResult<bool> {
        let count = self.count.fetch_add(1, Ordering::AcqRel);
        UNDER_WAY.fetch_sub(1, Ordering::Relaxed);
        let is_late = self.late.load(Ordering::Acquire) == count;
        if is_late {
            // Where the call ended by itself at that moment, the interruption is still to come.
            take_back(py, self.caller.load(Ordering::Relaxed))?;
            if self.signalled.swap(false, Ordering::Relaxed) {
                // So may its signal, of which this thread is to hear nothing more.
                let _ = py.check_signals();
            }
        }
        Ok(is_late)
    }

    /// Raises an error in the thread of the call that takes too long, if it is still under way, so that
    /// a loop without end ends. One that waits outside of Python hears it when it comes back; where it is
    /// to be woken, and the main thread waits, that is sent a signal. Returns whether the call has heard of
    /// it, or will.
    fn end(&self, is_to_wake: bool) -> bool {
        let is_late = || self.count.load(Ordering::Acquire) == self.late.load(Ordering::Acquire);
        let caller = self.caller.load(Ordering::Relaxed);
        Python::attach(|py| {
            // Without ctypes the call is told when it returns.
            let _ = interrupt(py, caller, is_late);
            if !is_to_wake {
                return true;
            }
            let is_signalled = || {
                self.signalled.store(true, Ordering::Relaxed);
            };
            wake(py, caller, is_late, is_signalled).unwrap_or(false)
        })
    }
}

thread_local! {
    /// The number in Python of this thread, once it is known.
    static NUMBER: Cell<Option<u64>> = const { Cell::new(None) };
}

fn number_of_thread(py: Python<'_>) -> PyResult<u64> {
    if let Some(number) = NUMBER.get() {
        return Ok(number);
    }
    let number = py.import("threading")?.call_method0("get_ident")?.extract()?;
    NUMBER.set(Some(number));
    Ok(number)
}

/// Python's function that sets the error that a thread is to raise at its next step, and the thread.
fn setting(py: Python<'_>, thread: u64) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let ctypes = py.import("ctypes")?;
    let set = ctypes.getattr("pythonapi")?.getattr("PyThreadState_SetAsyncExc")?;
    Ok((set, ctypes.getattr("c_ulong")?.call1((thread,))?))
}

/// Has Python raise `TimeoutError` in the thread of this number at its next step, if it is to.
fn interrupt(py: Python<'_>, thread: u64, is_to: impl Fn() -> bool) -> PyResult<()> {
    let (set, number) = setting(py, thread)?;
    let error =
        py.import("ctypes")?.call_method1("py_object", (py.get_type::<PyTimeoutError>(),))?;
    // Asked last: what is above may let other threads go on, and the call end.
    if is_to() {
        set.call1((number, error))?;
    }
    Ok(())
}

/// Takes back the error that the thread of this number is still to raise, if any.
fn take_back(py: Python<'_>, thread: u64) -> PyResult<()> {
    let (set, number) = setting(py, thread)?;
    set.call1((number, py.None()))?;
    Ok(())
}
