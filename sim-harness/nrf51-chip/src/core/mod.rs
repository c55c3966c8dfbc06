//! A Cortex-M0: registers, the instructions of ARMv6-M, exceptions and the NVIC.
//!
//! The core reads and writes through [`Memory`], except its own registers at 0xE000E000. It has no
//! VTOR; the address of its vector table is given, because the programs in front of the
//! application forward its exceptions (Nordic's S130 SoftDevice specification, "Interrupt forwarding").

mod alu;
mod cycles;
mod decode;
mod exceptions;
mod execute;
mod nvic;
mod op;

use std::fmt;

pub use decode::{decode, is_wide};
use exceptions::EXCEPTION_RETURN;
use nvic::Nvic;
pub use op::{Access, Alu, Change, Op, Register, Shift};

/// The width of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// One byte.
    Byte,
    /// Two bytes.
    Half,
    /// Four bytes.
    Word,
}

impl Width {
    /// The number of bytes.
    #[must_use]
    pub const fn bytes(self) -> u32 {
        match self {
            Self::Byte => 1,
            Self::Half => 2,
            Self::Word => 4,
        }
    }
}

/// An access that no memory or peripheral answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMemory;

/// What the core reads, writes and executes. Addresses are aligned to the width.
pub trait Memory {
    /// The value at an address, in the lowest bits.
    ///
    /// # Errors
    ///
    /// [`NoMemory`] where there is neither memory nor a peripheral.
    fn read(&mut self, address: u32, width: Width) -> Result<u32, NoMemory>;

    /// Writes the lowest bits of a value to an address.
    ///
    /// # Errors
    ///
    /// [`NoMemory`] where there is neither memory nor a peripheral, or what is there cannot be written.
    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), NoMemory>;

    /// The instruction at an address.
    ///
    /// # Errors
    ///
    /// [`NoMemory`] where there is no memory.
    fn fetch(&mut self, address: u32) -> Result<Op, NoMemory>;
}

/// The reason why the core cannot go on; a real one would enter its HardFault handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// There is no memory at the address of an instruction.
    Fetch,
    /// An instruction that ARMv6-M does not have, BKPT, or UDF.
    Undefined,
    /// A load or store at an address that answers nothing.
    Access(u32),
    /// A load or store at an address that is not a multiple of its width.
    Unaligned(u32),
    /// A branch to code of the other instruction set.
    NotThumb(u32),
    /// SVC where exceptions of its priority are masked.
    MaskedCall,
}

/// The end of execution, with the address of the instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The address of the instruction that failed.
    pub pc: u32,
    /// Why it failed.
    pub cause: Cause,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pc = self.pc;
        match self.cause {
            Cause::Fetch => write!(f, "no code at {pc:#010x}"),
            Cause::Undefined => write!(f, "undefined instruction at {pc:#010x}"),
            Cause::Access(address) => write!(f, "no memory at {address:#010x}, used at {pc:#010x}"),
            Cause::Unaligned(address) => {
                write!(f, "unaligned access to {address:#010x} at {pc:#010x}")
            }
            Cause::NotThumb(address) => {
                write!(f, "branch to {address:#010x}, which is no Thumb code, at {pc:#010x}")
            }
            Cause::MaskedCall => write!(f, "SVC with exceptions masked at {pc:#010x}"),
        }
    }
}

impl std::error::Error for Fault {}

/// The condition flags.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Negative.
    pub n: bool,
    /// Zero.
    pub z: bool,
    /// Carry.
    pub c: bool,
    /// Overflow.
    pub v: bool,
}

/// The core.
#[derive(Clone, Debug)]
pub struct Core {
    /// R0 to R12, SP, LR, PC. PC is the address of the next instruction.
    registers: [u32; 16],
    /// The stack pointer that is not in use.
    other_stack: u32,
    flags: Flags,
    /// PRIMASK: no interrupt is taken.
    masked: bool,
    /// Thread mode uses the process stack (CONTROL.SPSEL).
    process_stack: bool,
    nvic: Nvic,
    vectors: u32,
    reset_wanted: bool,
}

impl Core {
    /// A core after its reset: SP and PC come from the vector table at an address.
    ///
    /// # Errors
    ///
    /// A [`Fault`] where there is no vector table, or it does not begin with Thumb code.
    pub fn new(memory: &mut impl Memory, vectors: u32) -> Result<Self, Fault> {
        let mut core = Self {
            registers: [0; 16],
            other_stack: 0,
            flags: Flags::default(),
            masked: false,
            process_stack: false,
            nvic: Nvic::default(),
            vectors,
            reset_wanted: false,
        };
        core.registers[14] = u32::MAX;
        core.registers[13] = core.load(memory, vectors, Width::Word)? & !3;
        let entry = core.load(memory, vectors + 4, Width::Word)?;
        core.branch(entry)?;
        Ok(core)
    }

    /// A register's value; PC is the address of the next instruction.
    #[must_use]
    pub fn register(&self, register: Register) -> u32 {
        self.registers[usize::from(register & 15)]
    }

    /// Sets a register.
    pub fn set_register(&mut self, register: Register, value: u32) {
        self.registers[usize::from(register & 15)] = value;
    }

    /// The condition flags.
    #[must_use]
    pub const fn flags(&self) -> Flags {
        self.flags
    }

    /// Sets the condition flags.
    pub const fn set_flags(&mut self, flags: Flags) {
        self.flags = flags;
    }

    /// Whether PRIMASK keeps interrupts away.
    #[must_use]
    pub const fn is_masked(&self) -> bool {
        self.masked
    }

    /// The number of the exception that is being handled, or 0 (IPSR).
    #[must_use]
    pub fn exception(&self) -> u8 {
        self.nvic.current()
    }

    /// Tells the levels of the 32 interrupt lines.
    pub fn set_lines(&mut self, lines: u32) {
        self.nvic.set_lines(lines);
    }

    /// Whether the program has asked for a reset of the chip (AIRCR), since this was last called.
    pub const fn take_reset(&mut self) -> bool {
        let wanted = self.reset_wanted;
        self.reset_wanted = false;
        wanted
    }

    /// Takes an exception that is due, or else executes one instruction. Returns the cycles.
    ///
    /// # Errors
    ///
    /// A [`Fault`], after which the core's state is that of the middle of the instruction.
    #[inline]
    pub fn step(&mut self, memory: &mut impl Memory) -> Result<u32, Fault> {
        if self.nvic.is_ready() && !self.masked {
            return self.enter_due(memory);
        }
        let pc = self.registers[15];
        let op = memory.fetch(pc).map_err(|NoMemory| Fault { pc, cause: Cause::Fetch })?;
        self.execute(memory, op)
    }

    const fn fault<T>(pc: u32, cause: Cause) -> Result<T, Fault> {
        Err(Fault { pc, cause })
    }

    /// Continues at an address whose lowest bit says that it is Thumb code.
    fn branch(&mut self, target: u32) -> Result<(), Fault> {
        if target & 1 == 0 {
            return Self::fault(self.registers[15], Cause::NotThumb(target));
        }
        self.registers[15] = target & !1;
        Ok(())
    }

    /// Whether an address is among the core's own registers.
    const fn is_own(address: u32) -> bool {
        address >> 12 == 0xE000E
    }

    #[inline]
    fn load(&mut self, memory: &mut impl Memory, address: u32, width: Width) -> Result<u32, Fault> {
        if address & (width.bytes() - 1) != 0 {
            return Self::fault(self.registers[15], Cause::Unaligned(address));
        }
        if Self::is_own(address) {
            let own = if width == Width::Word { self.nvic.read(address) } else { None };
            return own.map_or(Self::fault(self.registers[15], Cause::Access(address)), Ok);
        }
        let pc = self.registers[15];
        memory.read(address, width).map_err(|_| Fault { pc, cause: Cause::Access(address) })
    }

    #[inline]
    fn store(
        &mut self,
        memory: &mut impl Memory,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Fault> {
        if address & (width.bytes() - 1) != 0 {
            return Self::fault(self.registers[15], Cause::Unaligned(address));
        }
        let pc = self.registers[15];
        if !Self::is_own(address) {
            let written = memory.write(address, width, value);
            return written.map_err(|NoMemory| Fault { pc, cause: Cause::Access(address) });
        }
        match self.nvic.write(address, value) {
            Some(nvic::Written::Register) if width == Width::Word => Ok(()),
            Some(nvic::Written::ResetRequest) if width == Width::Word => {
                self.reset_wanted = true;
                Ok(())
            }
            _ => Self::fault(pc, Cause::Access(address)),
        }
    }
}
