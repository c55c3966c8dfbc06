//! The chip's random number generator, which is used once a boot.

use embassy_stm32::pac::{RCC, RNG};

use crate::board::clock;

/// Polls of the status before the generator counts as broken. A number takes 40 cycles of its clock
/// of 48 MHz (RM0090, "RNG main features"), under a microsecond; a poll takes about as long.
const POLLS: u32 = 1_000;

/// A random number; the time since boot in µs where the generator reports a fault.
pub(crate) fn draw() -> u32 {
    RCC.ahb2enr().modify(|w| w.set_rngen(true));
    RNG.cr().write(|w| w.set_rngen(true));
    // The first number must not be used (RM0090, "RNG operation").
    let number = next().and_then(|first| next().filter(|number| *number != first));
    RNG.cr().write(|w| w.set_rngen(false));
    RCC.ahb2enr().modify(|w| w.set_rngen(false));
    number.unwrap_or(clock::now().as_micros() as u32)
}

fn next() -> Option<u32> {
    let ready = (0..POLLS).any(|_| RNG.sr().read().drdy());
    let status = RNG.sr().read();
    (ready && !status.seis() && !status.ceis()).then(|| RNG.dr().read())
}
