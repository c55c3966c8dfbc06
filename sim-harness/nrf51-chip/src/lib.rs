//! An nRF51822 that is all software: it runs the firmware of the Crazyflie's radio chip from a file.
//!
//! | module | what it holds |
//! |---|---|
//! | [`core`] | a Cortex-M0: the instructions of ARMv6-M, exceptions, the NVIC |
//! | `peripherals` | RADIO, UART0, the timers, CLOCK and POWER, ADC, TEMP, GPIO |
//! | [`air`] | packets on the air |
//! | [`image`] | a file with the firmware, loaded |
//! | `chip` | all of it together, run up to a moment |
//!
//! The crate knows neither a Crazyflie's other processor nor what the packets mean. The same firmware
//! with the same inputs at the same moments ends in the same state, bit for bit.
//!
//! The registers of the peripherals are those of Nordic's device header `nrf51.h`. What they do was
//! not held to Nordic's reference manual nor to hardware: its witness is the firmware, which boots and
//! whose times agree with those of an emulator that others wrote. Cycles are those of ARM's Cortex-M0
//! Technical Reference Manual. What the firmware uses and is not modelled is in [`Chip::unknown`].

pub mod air;
mod chip;
pub mod core;
pub mod image;
mod peripherals;

pub use chip::{Chip, Config, Radio};
pub use peripherals::{PinChange, PinLevel, SentByte, Unknown};

/// Cycles of the 16 MHz clock, from which the core and every peripheral take theirs.
pub type Cycles = u64;

/// The cycles of a microsecond.
pub const MICROSECOND: Cycles = 16;

/// A moment that never comes.
const NEVER: Cycles = Cycles::MAX;
