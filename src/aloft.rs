//! Whether the last run ended in the air.
//!
//! The reset's cause does not tell: the radio chip pulls the pin, a battery's plug has a bad contact,
//! and both look like somebody at a bench. So a mark is left where no start-up code clears it
//! (`memory.x`), as long as the drone flies. It outlives a reset, and a supply that was gone for less
//! time than a RAM forgets in.

use core::sync::atomic::{AtomicU32, Ordering};

/// "Aloft" in hexadecimal speech; one start in 2³² from scrambled memory would take it for a mark.
const MAGIC: u32 = 0xA10F_7A10;

#[expect(unsafe_code, reason = "naming a section of the linker script is unsafe as such")]
// `used` keeps the compiler from believing that the memory begins with the value written here.
#[used]
// SAFETY: the section is reserved by memory.x, in memory; and as nothing writes this value there,
// the static holds whatever bits it held before the reset, all of which are valid for its type.
#[unsafe(link_section = ".outlives_reset.aloft")]
static MARK: AtomicU32 = AtomicU32::new(0);

/// Notes whether the drone flies.
pub(crate) fn note(flies: bool) {
    MARK.store(if flies { MAGIC } else { 0 }, Ordering::Relaxed);
}

/// Whether the last run ended in the air, once: a second boot does not report it again.
pub(crate) fn take() -> bool {
    MARK.swap(0, Ordering::Relaxed) == MAGIC
}
