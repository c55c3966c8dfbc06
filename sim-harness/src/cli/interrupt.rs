//! Ctrl-C, and a polite `kill`: what they leave, and the exit status after them.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use super::complain;
use crate::output::{Folder, Staging};

/// The exit status after Ctrl-C, as shells have it: 128 and the signal's number.
pub(super) const STATUS: u8 = 130;

/// From here on Ctrl-C ends the command at once. What it has written is removed.
pub(super) fn ends(folder: Option<&Folder>) {
    let staging = folder.map(Folder::staging);
    handle(move || end(staging.as_ref()));
}

/// From here on the first Ctrl-C sets the flag that is returned, and says `notice`; a second one
/// ends the command at once. What it has written is removed then.
pub(super) fn asks(folder: Option<&Folder>, notice: &'static str) -> &'static AtomicBool {
    static ASKED: AtomicBool = AtomicBool::new(false);
    let staging = folder.map(Folder::staging);
    handle(move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            end(staging.as_ref());
        }
        complain(notice);
    });
    &ASKED
}

fn handle(act: impl FnMut() + 'static + Send) {
    // Where the system knows no such signals, Ctrl-C ends the program by itself.
    let _ = ctrlc::set_handler(act);
}

fn end(staging: Option<&Staging>) {
    if let Some(staging) = staging {
        staging.discard();
        complain("interrupted; nothing was written");
    } else {
        complain("interrupted");
    }
    process::exit(STATUS.into());
}
