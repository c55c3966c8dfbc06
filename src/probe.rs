//! The probe: what the drone was told and has decided, shown in memory to an emulator or a debugger.

use onboard::probe::Probe;

/// Nothing in the firmware reads it.
#[expect(unsafe_code, reason = "a name without its module is unsafe as such")]
// SAFETY: nothing else has this name, which is `onboard::probe::SYMBOL`.
#[unsafe(no_mangle)]
#[used]
pub(crate) static UCHAIN_PROBE: Probe = Probe::new();
