//! The marks that outlive a reset: whether the drone flew, and whether a stop stood.
//!
//! The cause of a reset does not show that: the radio chip may pull the reset pin, or a battery's
//! plug may lose contact, and both look like a reset on the bench. So marks are stored in memory
//! that no start-up code clears (`memory.x`). They outlive a reset, and a supply that was gone for less time than the RAM's
//! retention. Switching the drone off by its button clears the mark of a stop.

use core::sync::atomic::{AtomicU32, Ordering};

/// The mark of a drone in the air. One start in 2³² from random memory finds it by chance.
const ALOFT: u32 = 0xA10F_7A10;
/// The mark of a stop, likewise.
const STOPPED: u32 = 0x5709_9ED0;

#[expect(unsafe_code, reason = "naming a section of the linker script is unsafe as such")]
// `used` keeps the compiler from believing that the memory begins with the value written here.
#[used]
// SAFETY: the section is reserved by memory.x, in memory; and as nothing writes this value there,
// the static holds whatever bits it held before the reset, all of which are valid for its type.
#[unsafe(link_section = ".outlives_reset.marks")]
static MARKS: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];

/// How the last run ended, by its marks.
#[derive(Clone, Copy)]
pub(crate) struct RestartMark {
    /// In the air.
    pub(crate) aloft: bool,
    /// While a stop stood.
    pub(crate) stopped: bool,
}

/// Notes whether the drone flies.
pub(crate) fn note_aloft(flies: bool) {
    let [aloft, _] = &MARKS;
    aloft.store(if flies { ALOFT } else { 0 }, Ordering::Relaxed);
}

/// Notes whether a stop stands.
pub(crate) fn note_stopped(stands: bool) {
    let [_, stopped] = &MARKS;
    stopped.store(if stands { STOPPED } else { 0 }, Ordering::Relaxed);
}

/// Takes the marks of the last run. That of the air is cleared, so that a second boot does not report
/// it again; that of a stop stays.
pub(crate) fn take() -> RestartMark {
    let [aloft, stopped] = &MARKS;
    RestartMark {
        aloft: aloft.swap(0, Ordering::Relaxed) == ALOFT,
        stopped: stopped.load(Ordering::Relaxed) == STOPPED,
    }
}
