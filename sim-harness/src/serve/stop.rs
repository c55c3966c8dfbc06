//! Ctrl-C as a flag: the loop ends after its step, and what was flown is written. A second Ctrl-C
//! ends the program where it stands.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// What a shell calls the end by Ctrl-C: 128 and the signal's number.
const INTERRUPTED: i32 = 130;

/// From here on Ctrl-C, or a polite `kill`, sets the flag that is returned. Where there is no such
/// thing Ctrl-C ends the program at once.
pub fn on_interrupt() -> &'static AtomicBool {
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            process::exit(INTERRUPTED);
        }
    });
    &ASKED
}
