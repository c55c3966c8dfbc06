//! A Crazyflie 2.1 that is all software: it runs the very ELF that is flashed.
//!
//! | module | what it holds |
//! |---|---|
//! | [`cpu`] | an ARMv7E-M core with a single-precision FPU: a Cortex-M4F |
//! | [`soc`] | the peripherals of an STM32F405 that the firmware uses |
//! | [`board`] | what is wired to the chip: sensors, memory, LEDs, motors, the radio chip |
//! | [`memory`], [`bus`] | what the core reads and writes |
//! | [`image`] | an ELF: what is flashed, and what its addresses are called |
//! | [`machine`] | all of it together, run up to a moment |
//! | [`rtt`] | the channels between firmware and debug probe |
//! | [`log`] | what the firmware logs by defmt, decoded |
//! | [`profile`] | which task has the processor, how long, and how late |
//! | [`gdb`] | a debugger's way in |
//! | [`speed`] | how many instructions a second the core executes |
//!
//! The crate knows neither tunnels nor physics. A simulator sets what the sensors measure, runs the
//! machine to the next moment, and reads what the motors and the radio do. The same ELF
//! with the same inputs at the same moments ends in the same state, bit for bit.
//!
//! An access that is not modelled is an error with an address and a symbol, never a silent zero.

pub mod board;
pub mod bus;
pub mod cpu;
pub mod gdb;
pub mod image;
pub mod log;
pub mod machine;
pub mod memory;
pub mod profile;
pub mod rtt;
pub mod soc;
pub mod speed;
