//! Measures how fast the core executes: a compiled kernel of floating-point arithmetic and
//! checksums, of which `examples/mips/kernel.rs` is the source, on nothing but a core and its
//! memory.

use std::time::Instant;

use crate::bus::{MemoryOnly, Width};
use crate::cpu::{Cpu, FlashTiming, Program, Stop};
use crate::memory::Memory;

const KERNEL: &[u8] = include_bytes!("../examples/mips/kernel.bin");
/// The address of the kernel, at which it begins.
const CODE: u32 = 0x0800_4000;
/// The address at which the kernel counts its rounds.
const ROUNDS: u32 = 0x2000_0000;
/// Wait states of the flash at 168 MHz and 3.3 V (RM0090, table 10).
const WAIT_STATES: u8 = 5;
/// Two seconds of the real thing.
const CYCLES: u64 = 2 * 168_000_000;

/// The result of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// Millions of instructions a second.
    pub mips: f64,
    /// Seconds of a core at 168 MHz in a second of this one.
    pub times: f64,
    /// Cycles of the emulated core over its instructions.
    pub cycles_per_instruction: f64,
    /// The number of the kernel's rounds.
    pub rounds: u32,
}

/// Runs the kernel once. `None` when it did not run to its end, which it always does.
#[must_use]
pub fn measure(timing: FlashTiming) -> Option<Speed> {
    let program = Program::new(CODE, KERNEL);
    let mut memory = Memory::new();
    memory.program(CODE, KERNEL);
    memory.store(ROUNDS, Width::Word, 0);
    let mut cpu = Cpu::new();
    cpu.set_register(13, 0x2000_8000);
    cpu.set_register(15, CODE);
    cpu.set_flash_timing(timing, WAIT_STATES);
    let mut bus = MemoryOnly { flash_wait_states: WAIT_STATES };
    let begun = Instant::now();
    let stop = cpu.run(&program, &mut memory, &mut bus, CYCLES);
    let took = begun.elapsed().as_secs_f64();
    let rounds = memory.load(ROUNDS, Width::Word)?;
    (stop == Stop::Until).then(|| Speed {
        mips: cpu.instructions() as f64 / took / 1e6,
        times: CYCLES as f64 / 168e6 / took,
        cycles_per_instruction: cpu.cycles() as f64 / cpu.instructions() as f64,
        rounds,
    })
}
