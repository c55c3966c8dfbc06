//! Ctrl-C, and a polite `kill`: what they leave, and the exit status after them.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::complain;
use report::Staging;

/// The exit status after Ctrl-C, as shells have it: 128 and the signal's number.
pub(super) const STATUS: u8 = 130;

/// The temporary directory that a command which is ended at once has to remove.
static STAGING: Mutex<Option<Staging>> = Mutex::new(None);

/// From here on Ctrl-C ends the command at once.
pub(super) fn ends() {
    handle(end);
}

/// From here on the first Ctrl-C sets the flag that is returned, and says `notice`; a second one
/// ends the command at once.
pub(super) fn asks(notice: &'static str) -> &'static AtomicBool {
    static ASKED: AtomicBool = AtomicBool::new(false);
    handle(move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            end();
        }
        complain(notice);
    });
    &ASKED
}

/// A command that is ended at once removes this directory.
pub(super) fn discards(staging: Staging) {
    *STAGING.lock().unwrap_or_else(PoisonError::into_inner) = Some(staging);
}

fn handle(act: impl FnMut() + 'static + Send) {
    // Where the system knows no such signals, Ctrl-C ends the program by itself.
    #[cfg(any(unix, windows))]
    let _ = ctrlc::set_handler(act);
    #[cfg(not(any(unix, windows)))]
    drop(act);
}

fn end() {
    let staging = STAGING.lock().unwrap_or_else(PoisonError::into_inner).take();
    let removed = staging.is_some_and(|staging| staging.discard_at_exit());
    complain(if removed { "interrupted; nothing was written" } else { "interrupted" });
    process::exit(STATUS.into());
}
