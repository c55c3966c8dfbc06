//! Executes the instructions that load and store, one register or several (DDI 0403, A4.6 and A4.7).

use super::access::is_system;
use crate::bus::{Bus, Width};
use crate::cpu::abort::Abort;
use crate::cpu::op::{Load, Mode, Op};
use crate::cpu::timing::REFILL_LOADED;
use crate::cpu::{Cpu, Fault};
use crate::memory::Memory;

impl Cpu {
    pub(super) fn load_literal<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        load: Load,
    ) {
        if let Some(value) = self.load(op, memory, bus, op.imm, load) {
            self.set(op.d, value);
        }
    }

    #[inline(always)]
    pub(super) fn load_and_update<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        load: Load,
        before: bool,
    ) {
        let base = self.get(op.n);
        let updated = base.wrapping_add(op.imm);
        let address = if before { updated } else { base };
        if let Some(value) = self.load(op, memory, bus, address, load) {
            self.update(op.n, updated);
            self.set(op.d, value);
        }
    }

    #[inline(always)]
    pub(super) fn store_and_update<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        width: Width,
        before: bool,
    ) {
        let base = self.get(op.n);
        let updated = base.wrapping_add(op.imm);
        let address = if before { updated } else { base };
        if self.store(op, memory, bus, address, width, self.get(op.d)) {
            self.update(op.n, updated);
        }
    }

    /// A base register, which may be SP.
    #[inline(always)]
    const fn update(&mut self, register: u8, value: u32) {
        self.set(register, if register == 13 { value & !3 } else { value });
    }

    /// The system's own space is not for the unprivileged (B3.1).
    fn is_privileged(&mut self, op: &Op, address: u32) -> bool {
        if is_system(address) {
            self.refuse(op, Abort::Fault(Fault::DataBus { address }));
        }
        is_system(address)
    }

    #[cold]
    pub(super) fn load_unprivileged<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        load: Load,
    ) {
        let address = self.get(op.n).wrapping_add(op.imm);
        if self.is_privileged(op, address) {
            return;
        }
        if let Some(value) = self.load(op, memory, bus, address, load) {
            self.set(op.d, value);
        }
    }

    #[cold]
    pub(super) fn store_unprivileged<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        width: Width,
    ) {
        let address = self.get(op.n).wrapping_add(op.imm);
        if !self.is_privileged(op, address) {
            self.store(op, memory, bus, address, width, self.get(op.d));
        }
    }

    /// The address, and what the base becomes.
    const fn addressed(&self, op: &Op, mode: Mode) -> (u32, Option<u32>) {
        let base = self.get(op.n);
        match mode {
            Mode::Offset => (base.wrapping_add(op.imm), None),
            Mode::Register => (self.indexed(op), None),
            Mode::Pre => (base.wrapping_add(op.imm), Some(base.wrapping_add(op.imm))),
            Mode::Post => (base, Some(base.wrapping_add(op.imm))),
            Mode::Literal => (op.imm, None),
        }
    }

    pub(super) fn load_pc<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        mode: Mode,
    ) {
        let (address, updated) = self.addressed(op, mode);
        if !self.aligned(op, address) {
            return;
        }
        let Some(target) = self.load(op, memory, bus, address, Load::Word) else { return };
        if let Some(base) = updated {
            self.update(op.n, base);
        }
        self.branch_exchange(memory, target, REFILL_LOADED);
    }

    #[cold]
    pub(super) fn load_sp<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        mode: Mode,
    ) {
        let (address, updated) = self.addressed(op, mode);
        let Some(value) = self.load(op, memory, bus, address, Load::Word) else { return };
        if let Some(base) = updated {
            self.update(op.n, base);
        }
        self.r[13] = value & !3;
    }

    pub(super) fn ldrd<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, mode: Mode) {
        let (address, updated) = self.addressed(op, mode);
        if !self.aligned(op, address) {
            return;
        }
        let Some(low) = self.load(op, memory, bus, address, Load::Word) else { return };
        let Some(high) = self.load(op, memory, bus, address.wrapping_add(4), Load::Word) else {
            return;
        };
        if let Some(base) = updated {
            self.update(op.n, base);
        }
        self.set(op.d, low);
        self.set(op.a, high);
    }

    pub(super) fn strd<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, mode: Mode) {
        let (address, updated) = self.addressed(op, mode);
        let (low, high) = (self.get(op.d), self.get(op.a));
        if self.aligned(op, address)
            && self.store(op, memory, bus, address, Width::Word, low)
            && self.store(op, memory, bus, address.wrapping_add(4), Width::Word, high)
            && let Some(base) = updated
        {
            self.update(op.n, base);
        }
    }

    /// Loads the registers at once, where all of their words lie in RAM; the base becomes what it
    /// will be before. Returns the last word, which may be for PC.
    #[inline(always)]
    fn load_at_once(
        &mut self,
        op: &Op,
        memory: &Memory,
        address: u32,
        base: Option<u32>,
    ) -> Option<u32> {
        let words = memory.words(address, op.imm.count_ones())?;
        let last = u32::from_le_bytes(*words.last()?);
        if let Some(base) = base {
            self.update(op.n, base);
        }
        for (register, word) in registers(op.imm & 0x7FFF).zip(words) {
            self.r[register] = u32::from_le_bytes(*word);
        }
        Some(last)
    }

    /// The same wherever they lie. No register changes where one of them cannot be loaded.
    #[cold]
    #[inline(never)]
    fn load_one_by_one<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        base: Option<u32>,
    ) -> Option<u32> {
        if !self.aligned(op, address) {
            return None;
        }
        let (mut loaded, mut last) = ([0; 16], 0);
        for (register, address) in registers(op.imm).zip((0..).map(|n| address.wrapping_add(4 * n)))
        {
            last = self.load(op, memory, bus, address, Load::Word)?;
            loaded[register] = last;
        }
        if let Some(base) = base {
            self.update(op.n, base);
        }
        for register in registers(op.imm & 0x7FFF) {
            self.r[register] = loaded[register];
        }
        Some(last)
    }

    /// False if the instruction was abandoned.
    #[inline(always)]
    fn store_many<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
    ) -> bool {
        let count = op.imm.count_ones();
        if let Some(words) = memory.words_mut(address, count) {
            for (register, word) in registers(op.imm).zip(words) {
                *word = self.r[register].to_le_bytes();
            }
            return true;
        }
        self.aligned(op, address)
            && registers(op.imm).zip((0..).map(|n| address.wrapping_add(4 * n))).all(
                |(register, address)| {
                    let value = self.r[register];
                    self.store(op, memory, bus, address, Width::Word, value)
                },
            )
    }

    /// Loads the registers from an address on; the base becomes what it will be before. A branch
    /// comes last.
    #[inline(always)]
    fn load_registers<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        base: Option<u32>,
    ) {
        let last = match self.load_at_once(op, memory, address, base) {
            Some(last) => last,
            None => match self.load_one_by_one(op, memory, bus, address, base) {
                Some(last) => last,
                None => return,
            },
        };
        if op.imm & 1 << 15 != 0 {
            self.branch_exchange(memory, last, REFILL_LOADED);
        }
    }

    pub(super) fn ldm<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, down: bool) {
        let base = self.get(op.n);
        let size = 4 * op.imm.count_ones();
        let end = if down { base.wrapping_sub(size) } else { base.wrapping_add(size) };
        let address = if down { end } else { base };
        self.load_registers(op, memory, bus, address, (op.a != 0).then_some(end));
    }

    pub(super) fn stm<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, down: bool) {
        let base = self.get(op.n);
        let size = 4 * op.imm.count_ones();
        let end = if down { base.wrapping_sub(size) } else { base.wrapping_add(size) };
        let address = if down { end } else { base };
        if self.store_many(op, memory, bus, address) && op.a != 0 {
            self.update(op.n, end);
        }
    }

    #[inline(always)]
    pub(super) fn push<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B) {
        let address = self.r[13].wrapping_sub(4 * op.imm.count_ones());
        if self.store_many(op, memory, bus, address) {
            self.r[13] = address;
        }
    }

    #[inline(always)]
    pub(super) fn pop<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B) {
        let address = self.r[13];
        let end = address.wrapping_add(4 * op.imm.count_ones());
        self.load_registers(op, memory, bus, address, Some(end));
    }

    #[inline(always)]
    pub(super) fn pop_pc<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B) {
        self.pop(op, memory, bus);
    }

    /// The local monitor of this core holds no address: any store answers any load (Cortex-M4
    /// TRM, "Exclusive monitor"). It is kept for a debugger to see.
    pub(super) fn ldrex<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        width: Width,
    ) {
        let address = self.get(op.n).wrapping_add(op.imm);
        let load = match width {
            Width::Byte => Load::Byte,
            Width::Half => Load::Half,
            Width::Word => Load::Word,
        };
        if !self.aligned_to(op, address, width) {
            return;
        }
        if let Some(value) = self.load(op, memory, bus, address, load) {
            self.exclusive = Some(address);
            self.set(op.d, value);
        }
    }

    pub(super) fn strex<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        width: Width,
    ) {
        let address = self.get(op.n).wrapping_add(op.imm);
        if !self.aligned_to(op, address, width) {
            return;
        }
        if self.exclusive.is_none() {
            self.set(op.d, 1);
        } else if self.store(op, memory, bus, address, width, self.get(op.a)) {
            self.exclusive = None;
            self.set(op.d, 0);
        }
    }

    fn aligned_to(&mut self, op: &Op, address: u32, width: Width) -> bool {
        if address.is_multiple_of(width.bytes()) {
            return true;
        }
        self.refuse(op, Abort::Fault(Fault::Unaligned { address }));
        false
    }
}

/// The numbers of the registers in a list, in ascending order.
#[inline(always)]
fn registers(list: u32) -> impl Iterator<Item = usize> {
    let mut rest = list & 0xFFFF;
    std::iter::from_fn(move || {
        let register = rest.trailing_zeros() as usize & 15;
        let some = rest != 0;
        rest &= rest.wrapping_sub(1);
        some.then_some(register)
    })
}
