//! How many cycles an instruction takes: a model, which is right on average and not to the cycle.
//!
//! The source is ARM's Cortex-M4 Technical Reference Manual (r0p1), "Instruction set summary" and
//! "Load/store timings", and RM0090, "Adaptive real-time memory accelerator".
//!
//! | instruction | cycles |
//! |---|---|
//! | arithmetic, logic, every multiplication, saturation | 1 |
//! | SDIV, UDIV | 2 to 12, by how many more bits the dividend has |
//! | branch, not taken | 1 |
//! | branch to a fixed target, taken | 2 |
//! | BX, BLX, MOV to PC | 3 |
//! | TBB, TBH | 4 |
//! | LDR | 2; 1 where another load or store follows that does not need its result |
//! | LDR to PC | 5 |
//! | STR with an immediate | 1 |
//! | STR with a register, LDREX, STREX | 2 |
//! | LDM, STM, PUSH, POP, LDRD, VLDM … of N words | 1 + N, with PC 3 more |
//! | IT, hints, CPS | 1 |
//! | MRS, MSR, barriers | 2, 2 and 3 |
//! | VADD, VMUL, VCMP, VCVT, VMOV … | 1 |
//! | VMOV of two core registers | 2 |
//! | VMLA, VFMA … | 3 |
//! | VDIV, VSQRT | 14 |
//! | exception entry, return | see `exceptions` |
//!
//! The refill of the pipeline, 1 to 3 cycles by the manual, is 1 where the decoder knows the target
//! and 2 where a register holds it. Left out: the cycle that a floating-point instruction waits for
//! the result of the one before it, that VDIV lets integer instructions pass, folded ITs, the
//! alignment of a target, and that DMA and the core wait for each other at the bus matrix.
//!
//! Flash is modelled in three ways ([`FlashTiming`]), of which the first and the last are bounds.

use super::op::{Kind, Op};

/// What the flash adds to the core's own cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlashTiming {
    /// Nothing: the accelerator always has what is wanted. A lower bound.
    #[default]
    Ideal,
    /// As the accelerator works: 64 lines of instructions, 8 of data, and the next line fetched
    /// ahead.
    Accelerated,
    /// As without it: each line of 16 bytes costs the wait states. An upper bound.
    Off,
}

/// Cycles of a taken branch besides its own one, where the target is in the instruction.
pub(super) const REFILL: u64 = 1;
/// Where a register holds it.
pub(super) const REFILL_REGISTER: u64 = 2;
/// Where it is loaded.
pub(super) const REFILL_LOADED: u64 = 3;

/// Cycles of an instruction that executes, without refills and what operands decide.
pub(super) fn cycles(op: &Op) -> u8 {
    let words = |count: u32| 1 + count as u8;
    match op.kind {
        Kind::LdrImm
        | Kind::LdrReg
        | Kind::LdrLiteral
        | Kind::LdrbImm
        | Kind::LdrbReg
        | Kind::LdrhImm
        | Kind::LdrhReg
        | Kind::LdrsbImm
        | Kind::LdrsbReg
        | Kind::LdrshImm
        | Kind::LdrshReg
        | Kind::LoadLiteral(_)
        | Kind::LoadPre(_)
        | Kind::LoadPost(_)
        | Kind::LoadUnprivileged(_)
        | Kind::LoadPc(_)
        | Kind::LoadSp(_)
        | Kind::StrReg
        | Kind::StrbReg
        | Kind::StrhReg
        | Kind::Ldrex
        | Kind::LdrexNarrow(_)
        | Kind::Strex
        | Kind::StrexNarrow(_)
        | Kind::Vldr
        | Kind::VldrLiteral
        | Kind::Vstr
        | Kind::VmovToCores
        | Kind::VmovFromCores
        | Kind::Tbb
        | Kind::Tbh
        | Kind::Sdiv
        | Kind::Udiv
        | Kind::Mrs
        | Kind::Msr => 2,
        Kind::Ldrd(_)
        | Kind::Strd(_)
        | Kind::VldrDouble
        | Kind::VstrDouble
        | Kind::VldrDoubleLiteral
        | Kind::Barrier
        | Kind::Vmla
        | Kind::Vmls
        | Kind::Accumulate(_) => 3,
        Kind::LdmIa
        | Kind::LdmDb
        | Kind::StmIa
        | Kind::StmDb
        | Kind::Push
        | Kind::Pop
        | Kind::PopPc => words(op.imm.count_ones()),
        Kind::Vldm(_) | Kind::Vstm(_) => words(u32::from(op.a)),
        Kind::Vdiv | Kind::Vsqrt => 14,
        _ => 1,
    }
}

/// Of a division, what comes on top of the least.
#[inline]
pub(super) fn division(dividend: u32, divisor: u32) -> u64 {
    let bits = divisor.leading_zeros().saturating_sub(dividend.leading_zeros());
    u64::from(bits * 10 / 31)
}

/// The register that an address comes from, and the other one, of what can be pipelined behind a
/// load; 15 for none.
fn address_of(op: &Op) -> Option<(u8, u8)> {
    match op.kind {
        Kind::LdrImm
        | Kind::LdrbImm
        | Kind::LdrhImm
        | Kind::LdrsbImm
        | Kind::LdrshImm
        | Kind::StrImm
        | Kind::StrbImm
        | Kind::StrhImm
        | Kind::Vldr
        | Kind::Vstr => Some((op.n, 15)),
        Kind::LdrReg
        | Kind::LdrbReg
        | Kind::LdrhReg
        | Kind::LdrsbReg
        | Kind::LdrshReg
        | Kind::StrReg
        | Kind::StrbReg
        | Kind::StrhReg => Some((op.n, op.m)),
        Kind::LdrLiteral | Kind::LoadLiteral(_) | Kind::VldrLiteral => Some((15, 15)),
        _ => None,
    }
}

/// The cycles of an instruction before another one: loads are pipelined.
pub(super) fn cycles_before(op: &Op, next: &Op) -> u8 {
    let target = match op.kind {
        Kind::LdrImm
        | Kind::LdrReg
        | Kind::LdrLiteral
        | Kind::LdrbImm
        | Kind::LdrbReg
        | Kind::LdrhImm
        | Kind::LdrhReg
        | Kind::LdrsbImm
        | Kind::LdrsbReg
        | Kind::LdrshImm
        | Kind::LdrshReg
        | Kind::LoadLiteral(_) => op.d,
        Kind::Vldr | Kind::VldrLiteral => 15,
        _ => return op.cycles,
    };
    match address_of(next) {
        Some((n, m)) if target == 15 || n != target && m != target => 1,
        _ => op.cycles,
    }
}

/// Which line of 16 bytes an address is in.
pub(super) const fn line(address: u32) -> u32 {
    address >> 4
}

const LINES: usize = 64;
const DATA_LINES: usize = 8;
const NOWHERE: u32 = u32::MAX;

/// Lines of flash that are held, the one used longest ago going first.
#[derive(Clone, Debug)]
struct Lines<const N: usize> {
    held: [u32; N],
    used: [u32; N],
    tick: u32,
    /// Where each line of 1 MiB is held; N where it is not. Allocated when first needed.
    slots: Vec<u8>,
}

const FLASH_LINES: usize = 1 << 16;

impl<const N: usize> Lines<N> {
    const fn new() -> Self {
        Self { held: [NOWHERE; N], used: [0; N], tick: 0, slots: Vec::new() }
    }

    /// Whether it is held; it is from now on.
    fn take(&mut self, line: u32) -> bool {
        if self.slots.is_empty() {
            self.slots = vec![N as u8; FLASH_LINES];
        }
        self.tick = self.tick.wrapping_add(1);
        let slot = usize::from(self.slots[line as usize % FLASH_LINES]);
        if slot < N && self.held[slot] == line {
            self.used[slot] = self.tick;
            return true;
        }
        self.insert(line);
        false
    }

    #[cold]
    fn insert(&mut self, line: u32) {
        let age = |slot: &usize| self.tick.wrapping_sub(self.used[*slot]);
        let oldest = (0..N).max_by_key(age).expect("there are lines");
        self.held[oldest] = line;
        self.used[oldest] = self.tick;
        self.slots[line as usize % FLASH_LINES] = oldest as u8;
    }

    /// Whether it is held.
    fn touch(&mut self, line: u32) -> bool {
        let slot = self.slots.get(line as usize % FLASH_LINES).copied().map_or(N, usize::from);
        let held = slot < N && self.held[slot] == line;
        if held {
            self.tick = self.tick.wrapping_add(1);
            self.used[slot] = self.tick;
        }
        held
    }
}

/// The flash as the core waits for it.
#[derive(Clone, Debug)]
pub(crate) struct Timing {
    flash: FlashTiming,
    wait_states: u8,
    /// The line that instructions come from.
    line: u32,
    /// When the line behind it has been fetched ahead.
    ahead: u64,
    instructions: Lines<LINES>,
    data: Lines<DATA_LINES>,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            flash: FlashTiming::Ideal,
            wait_states: 0,
            line: NOWHERE,
            ahead: 0,
            instructions: Lines::new(),
            data: Lines::new(),
        }
    }
}

impl Timing {
    pub(super) fn set_flash(&mut self, flash: FlashTiming, wait_states: u8) {
        *self = Self { flash, wait_states, ..Self::default() };
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.flash == FlashTiming::Ideal
    }

    pub(super) const fn set_wait_states(&mut self, wait_states: u8) {
        self.wait_states = wait_states;
    }

    /// Cycles until an instruction of a line is there, which may be the line of the one before.
    #[inline]
    pub(super) fn fetch(&mut self, line: u32, now: u64) -> u64 {
        if line == self.line {
            return 0;
        }
        let next = line == self.line.wrapping_add(1);
        self.line = line;
        let wait = u64::from(self.wait_states);
        let stall = match self.flash {
            FlashTiming::Ideal => return 0,
            FlashTiming::Off => return wait,
            FlashTiming::Accelerated if self.instructions.touch(line) => 0,
            // A line that was fetched ahead is used, and not kept.
            FlashTiming::Accelerated if next => self.ahead.saturating_sub(now),
            FlashTiming::Accelerated => {
                self.instructions.take(line);
                wait
            }
        };
        self.ahead = now + stall + wait + 1;
        stall
    }

    /// Cycles until data is there.
    #[cold]
    pub(super) fn load(&mut self, address: u32) -> u64 {
        let wait = u64::from(self.wait_states);
        match self.flash {
            FlashTiming::Ideal => 0,
            FlashTiming::Off => wait,
            FlashTiming::Accelerated if self.data.take(line(address)) => 0,
            FlashTiming::Accelerated => wait,
        }
    }
}
