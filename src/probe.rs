//! The probe: a static that shows the inputs and decisions of the drone to an emulator or a debugger.

use onboard::probe::Probe;

/// The probe. Tasks write it; no code of the firmware reads it.
#[expect(unsafe_code, reason = "a name without its module is unsafe as such")]
// SAFETY: nothing else has this name, which is `onboard::probe::SYMBOL`.
#[unsafe(no_mangle)]
#[used]
pub(crate) static UCHAIN_PROBE: Probe = Probe::new();
