//! A model of the cycles that an instruction takes, by the published timings; it is not exact.
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

use super::op::{Kind, NO_LINE, Op};

/// The cycles that the flash adds to the core's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlashTiming {
    /// No cycles: the accelerator has every line at hand. A lower bound.
    #[default]
    Ideal,
    /// As the accelerator works: 64 lines of instructions, 8 of data, and the next line fetched
    /// ahead.
    Accelerated,
    /// The flash without the accelerator: each line of 16 bytes costs the wait states. An upper
    /// bound.
    Off,
}

/// Cycles of a taken branch besides its own one, where the target is in the instruction.
pub(super) const REFILL: u64 = 1;
/// Where a register holds it.
pub(super) const REFILL_REGISTER: u64 = 2;
/// Where it is loaded.
pub(super) const REFILL_LOADED: u64 = 3;

/// Whether an instruction is a load of one register that leaves its base alone.
const fn loads_one(kind: Kind) -> bool {
    matches!(
        kind,
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
    )
}

/// Cycles of an instruction that executes, without refills and what operands decide.
pub(super) fn cycles(op: &Op) -> u8 {
    let words = |count: u32| 1 + count as u8;
    match op.kind {
        kind if loads_one(kind) => 2,
        Kind::LoadPre(_)
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

/// The cycles of a division above the least.
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
        kind if loads_one(kind) => op.d,
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
/// None of data.
const NOWHERE: u32 = u32::MAX;
/// The lines of 1 MiB of flash.
const FLASH_LINES: usize = 1 << 16;

/// The same of an instruction, counted from where flash begins.
pub(super) const fn line_of_code(address: u32) -> u16 {
    line(address) as u16
}

/// Lines of instructions that are held, the one used longest ago going first.
#[derive(Clone, Debug)]
struct Lines {
    /// The lines, by slot.
    held: [u16; LINES],
    /// When each slot was used, with its number in the lowest bits, so that the least of them tells
    /// which slot it is. What is written to `NO_SLOT` does not matter.
    used: [i32; 256],
    /// A multiple of `TICK`.
    clock: i32,
    /// The slot of each line, or [`NO_SLOT`].
    slots: Box<[u8; FLASH_LINES]>,
}

const NO_SLOT: u8 = LINES as u8;
const TICK: i32 = LINES as i32;

impl Lines {
    fn new() -> Self {
        let slots = vec![NO_SLOT; FLASH_LINES].into_boxed_slice();
        let mut lines = Self {
            held: [NO_LINE; LINES],
            used: [0; 256],
            clock: 0,
            slots: slots.try_into().expect("the size is what it was made with"),
        };
        for (slot, used) in (0..).zip(&mut lines.used[..LINES]) {
            *used = slot;
        }
        lines
    }

    /// The slot of a line.
    #[inline(always)]
    fn find(&self, line: u16) -> u8 {
        self.slots[usize::from(line)]
    }

    /// Notes that the line in a slot is used.
    #[inline(always)]
    fn touch(&mut self, slot: u8) {
        self.clock = match self.clock.checked_add(TICK) {
            Some(clock) => clock,
            None => self.renumber(),
        };
        self.used[usize::from(slot)] = self.clock | i32::from(slot);
    }

    /// A line that is not held is put where the oldest one was.
    #[inline(never)]
    fn insert(&mut self, line: u16) {
        let oldest = self.used[..LINES].iter().fold(i32::MAX, |least, &used| least.min(used));
        let slot = (oldest % TICK) as u8;
        let gone = std::mem::replace(&mut self.held[usize::from(slot)], line);
        self.slots[usize::from(gone)] = NO_SLOT;
        self.slots[usize::from(line)] = slot;
        self.touch(slot);
    }

    /// The clock starts again, and nothing but the order is kept.
    #[cold]
    fn renumber(&mut self) -> i32 {
        let mut order = self.used;
        order[..LINES].sort_unstable();
        for (time, used) in (0..).zip(&order[..LINES]) {
            let slot = used % TICK;
            self.used[slot as usize] = time * TICK + slot;
        }
        TICK * TICK
    }
}

/// The flash as the core waits for it.
#[derive(Clone, Debug)]
pub(crate) struct Timing {
    flash: FlashTiming,
    wait_states: u8,
    /// The line that instructions come from.
    line: u16,
    /// When the line behind it has been fetched ahead.
    ahead: u64,
    instructions: Lines,
    /// The lines of data that are held, the one used last first.
    data: [u32; DATA_LINES],
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            flash: FlashTiming::Ideal,
            wait_states: 0,
            line: NO_LINE,
            ahead: 0,
            instructions: Lines::new(),
            data: [NOWHERE; DATA_LINES],
        }
    }
}

impl Timing {
    pub(super) fn set_flash(&mut self, flash: FlashTiming, wait_states: u8) {
        *self = Self { flash, wait_states, ..Self::default() };
    }

    #[inline(always)]
    pub(super) fn is_ideal(&self) -> bool {
        self.flash == FlashTiming::Ideal
    }

    pub(super) const fn set_wait_states(&mut self, wait_states: u8) {
        self.wait_states = wait_states;
    }

    /// The line that instructions come from.
    #[inline(always)]
    pub(super) const fn line(&self) -> u16 {
        self.line
    }

    /// Cycles until an instruction of another line is there. The one behind the last was fetched
    /// ahead, and is not kept when it is used.
    #[inline(always)]
    pub(super) fn fetch(&mut self, line: u16, now: u64) -> u64 {
        let is_next = u32::from(line) == u32::from(self.line) + 1;
        self.line = line;
        let wait = u64::from(self.wait_states);
        if self.flash != FlashTiming::Accelerated {
            return if self.is_ideal() || line == NO_LINE { 0 } else { wait };
        }
        let slot = self.instructions.find(line);
        let stall = if slot != NO_SLOT {
            self.instructions.touch(slot);
            0
        } else if is_next {
            self.ahead.saturating_sub(now)
        } else if line == NO_LINE {
            return 0;
        } else {
            self.instructions.insert(line);
            wait
        };
        self.ahead = now + stall + wait + 1;
        stall
    }

    /// Cycles until data is there.
    #[inline(always)]
    pub(super) fn load(&mut self, address: u32) -> u64 {
        let line = line(address);
        match self.flash {
            FlashTiming::Ideal => 0,
            FlashTiming::Accelerated if self.data[0] == line => 0,
            _ => self.load_another(line),
        }
    }

    /// From another line than the one before.
    fn load_another(&mut self, line: u32) -> u64 {
        let wait = u64::from(self.wait_states);
        if self.flash == FlashTiming::Off {
            return wait;
        }
        let held = self.data.iter().position(|&held| held == line);
        self.data[..=held.unwrap_or(DATA_LINES - 1)].rotate_right(1);
        self.data[0] = line;
        if held.is_some() { 0 } else { wait }
    }
}

#[cfg(test)]
mod tests;
