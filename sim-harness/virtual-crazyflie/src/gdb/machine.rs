//! The interface that a debugger needs of a machine.

use std::fmt;
use std::ops::RangeInclusive;

use crate::bus::Width;
use crate::cpu::Cpu;
use crate::cpu::fp::Fpscr;
use crate::image::State;
use crate::machine::{Halt, Machine, Pause};
use crate::memory::{Memory, map};
use crate::soc::{Board, Nanos, ResetCause};

use super::Register;

/// The private peripheral bus (DDI 0403, B3.1).
const PRIVATE: RangeInclusive<u32> = 0xE000_0000..=0xE00F_FFFF;
/// SysTick's control and status, of which a bit is cleared by being read.
const SYST_CSR: u32 = 0xE000_E010;

/// A machine that can be debugged.
pub trait Debuggee {
    /// Why it cannot go on.
    type Halt: fmt::Display;

    /// Attaches a debugger, or detaches it, which the firmware can see.
    fn set_debugger(&mut self, is_attached: bool);

    /// The moment that it has come to.
    fn now(&self) -> Nanos;

    /// The value of a register.
    fn register(&self, register: Register) -> u64;

    /// Sets it.
    fn set_register(&mut self, register: Register, value: u64);

    /// Reads from an address on, and says how many bytes it could.
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> usize;

    /// Writes; false where it cannot.
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool;

    /// Runs up to a moment or a trap.
    ///
    /// # Errors
    /// If it cannot go on.
    fn advance_to(&mut self, moment: Nanos) -> Result<Pause, Self::Halt>;

    /// Executes one instruction, whether or not there is a trap; asleep, it sleeps on, at most to
    /// the moment.
    ///
    /// # Errors
    /// If it cannot go on.
    fn step(&mut self, moment: Nanos) -> Result<Pause, Self::Halt>;

    /// Sets a breakpoint at the instruction of this address; false where that is not possible.
    fn trap(&mut self, address: u32) -> bool;

    /// No longer.
    fn untrap(&mut self, address: u32);

    /// Whether it does.
    fn is_trapped(&mut self, address: u32) -> bool;

    /// Resets the machine as its reset button does.
    fn reset(&mut self);

    /// The back-trace, in words.
    fn backtrace(&self) -> String;

    /// The memory that a log is in.
    fn memory_mut(&mut self) -> &mut Memory;
}

impl<B: Board> Debuggee for Machine<B> {
    type Halt = Halt;

    fn set_debugger(&mut self, is_attached: bool) {
        self.cpu_mut().set_debugger(is_attached);
    }

    fn now(&self) -> Nanos {
        Self::now(self)
    }

    fn register(&self, register: Register) -> u64 {
        let cpu = self.cpu();
        match register {
            Register::R(n) => cpu.register(n.into()).into(),
            Register::Xpsr => cpu.xpsr().into(),
            Register::D(n) => {
                let n = 2 * usize::from(n);
                u64::from(cpu.s(n)) | u64::from(cpu.s(n + 1)) << 32
            }
            Register::Fpscr => cpu.fpscr().bits().into(),
            Register::Special(number) => cpu.mrs(number).into(),
        }
    }

    fn set_register(&mut self, register: Register, value: u64) {
        let cpu = self.cpu_mut();
        let low = value as u32;
        match register {
            Register::R(n) => cpu.set_register(n.into(), low),
            Register::Xpsr => cpu.set_xpsr(low),
            Register::D(n) => {
                let n = 2 * usize::from(n);
                cpu.set_s(n, low);
                cpu.set_s(n + 1, (value >> 32) as u32);
            }
            Register::Fpscr => cpu.set_fpscr(Fpscr::from_bits(low)),
            Register::Special(number) => cpu.msr(number, 0, low),
        }
    }

    /// Memory and the core's own registers: to read a peripheral's may change it.
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> usize {
        let mut count = 0;
        for (byte, at) in bytes.iter_mut().zip(address..) {
            let of_memory = self.memory().load(at, Width::Byte);
            let of_core = || system_byte(self.cpu_mut(), at);
            let Some(value) = of_memory.or_else(of_core) else { break };
            *byte = value as u8;
            count += 1;
        }
        count
    }

    /// RAM only: what is in flash has been decoded already.
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        let mut all = bytes.iter().zip(address..);
        all.all(|(byte, at)| self.memory_mut().store(at, Width::Byte, (*byte).into()))
    }

    fn advance_to(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        Self::advance_to(self, moment)
    }

    fn step(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        Self::step(self, moment)
    }

    fn trap(&mut self, address: u32) -> bool {
        self.program_mut().trap(address)
    }

    fn untrap(&mut self, address: u32) {
        self.program_mut().untrap(address);
    }

    fn is_trapped(&mut self, address: u32) -> bool {
        self.program_mut().is_trapped(address)
    }

    fn reset(&mut self) {
        Self::reset(self, ResetCause::Pin);
    }

    fn backtrace(&self) -> String {
        let load = |address| self.memory().load(address, Width::Word);
        self.image().backtrace(&State::of(self.cpu()), &load).to_string()
    }

    fn memory_mut(&mut self) -> &mut Memory {
        Self::memory_mut(self)
    }
}

/// A byte of the core's own registers; GDB needs some to find its way out of an exception.
fn system_byte(cpu: &mut Cpu, address: u32) -> Option<u32> {
    let word = address & !3;
    if !PRIVATE.contains(&word) || word == SYST_CSR {
        return None;
    }
    let value = cpu.system_load(word, Width::Word).ok()?;
    Some(value >> (8 * (address & 3)) & 0xFF)
}

/// Where memory is, for GDB: in what it may not write it sets hardware breakpoints by itself. The
/// peripherals are there so that it asks and is refused, instead of giving up by itself.
pub(super) fn memory_map() -> String {
    let areas = [
        ("rom", 0, map::FLASH_SIZE),
        ("rom", map::FLASH, map::FLASH_SIZE),
        ("ram", map::CCM, map::CCM_SIZE),
        ("ram", map::RAM, map::RAM_SIZE),
        ("ram", 0x4000_0000, 0x2000_0000),
        ("ram", 0xE000_0000, 0x0010_0000),
    ];
    let areas = areas.map(|(kind, start, length)| {
        format!("<memory type=\"{kind}\" start=\"{start:#x}\" length=\"{length:#x}\"/>")
    });
    format!("<?xml version=\"1.0\"?><memory-map>{}</memory-map>", areas.concat())
}
