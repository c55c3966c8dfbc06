//! Routes loads and stores to memory, to the core's own registers or to the bus (DDI 0403, B3.1).
//!
//! Aligned accesses to RAM and loads from flash are nearly all there are: they are made at once.
//! Everything else goes [`slowly`](Cpu::load_slowly).

use crate::bus::{Bus, Refused, Width};
use crate::cpu::abort::Abort;
use crate::cpu::op::{Load, Op};
use crate::cpu::{Cpu, Fault};
use crate::memory::Memory;

/// A bit of memory or of a register that has an address of its own (B3.1.1).
struct BitBand {
    address: u32,
    bit: u32,
}

impl BitBand {
    /// The address that an alias stands for.
    const fn of(alias: u32, width: Width) -> Option<Self> {
        if !matches!(alias >> 25, 0x11 | 0x21) {
            return None;
        }
        let offset = alias & 0x01FF_FFFF;
        let byte = alias & 0xF000_0000 | offset >> 5;
        let inside = byte % width.bytes();
        Some(Self { address: byte - inside, bit: 8 * inside + (offset >> 2 & 7) })
    }
}

/// The private peripheral bus, but for DBGMCU: that is the chip's (RM0090, "MCU debug component").
pub(super) const fn is_system(address: u32) -> bool {
    address >> 20 == 0xE00 && address >> 12 != 0xE0042
}

impl Cpu {
    /// Rn + (Rm << a).
    #[inline(always)]
    pub(super) const fn indexed(&self, op: &Op) -> u32 {
        self.get(op.n).wrapping_add(self.get(op.m) << (op.a & 31))
    }

    #[inline(always)]
    pub(super) fn load<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        load: Load,
    ) -> Option<u32> {
        let width = load.width();
        let value = match memory.load_aligned(address, width) {
            Some(value) => value,
            None => match memory.load_flash_aligned(address, width) {
                Some(value) => {
                    self.cycles += self.timing.load(address);
                    value
                }
                None => self.load_slowly(op, memory, bus, address, width)?,
            },
        };
        Some(load.extend(value))
    }

    /// False if the store was refused.
    #[inline(always)]
    pub(super) fn store<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
    ) -> bool {
        memory.store_aligned(address, width, value)
            || self.store_slowly(op, memory, bus, address, width, value)
    }

    /// An access that is not aligned takes longer, where it is allowed.
    fn admits(&mut self, op: &Op, address: u32, width: Width) -> bool {
        if address.is_multiple_of(width.bytes()) {
            return true;
        }
        if self.control.traps_unaligned() {
            self.refuse(op, Abort::Fault(Fault::Unaligned { address }));
            return false;
        }
        self.cycles += 1;
        true
    }

    #[cold]
    #[inline(never)]
    fn load_slowly<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        width: Width,
    ) -> Option<u32> {
        if !self.admits(op, address, width) {
            return None;
        }
        if let Some(value) = memory.load(address, width) {
            return Some(value);
        }
        let loaded = if let Some(BitBand { address, bit }) = BitBand::of(address, width) {
            self.load_beyond(memory, bus, address, width).map(|value| value >> bit & 1)
        } else {
            self.load_beyond(memory, bus, address, width)
        };
        match loaded {
            Ok(value) => Some(value),
            Err(why) => {
                self.refuse_access(op, address, false, width, why);
                None
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn store_slowly<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
    ) -> bool {
        if !self.admits(op, address, width) {
            return false;
        }
        if memory.store(address, width, value) {
            return true;
        }
        let stored = if let Some(BitBand { address, bit }) = BitBand::of(address, width) {
            self.load_beyond(memory, bus, address, width).and_then(|old| {
                let new = old & !(1 << bit) | (value & 1) << bit;
                self.store_beyond(memory, bus, address, width, new)
            })
        } else {
            self.store_beyond(memory, bus, address, width, value)
        };
        if let Err(why) = stored {
            self.refuse_access(op, address, true, width, why);
        }
        stored.is_ok()
    }

    fn load_beyond<B: Bus>(
        &mut self,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        width: Width,
    ) -> Result<u32, Refused> {
        if let Some(value) = memory.load(address, width) {
            return Ok(value);
        }
        beyond_memory(address, width)?;
        if is_system(address) {
            self.deadline = 0;
            self.system_load(address, width)
        } else {
            let value = bus.load(memory, self.cycles, address, width)?;
            self.look_at(bus);
            Ok(value)
        }
    }

    fn store_beyond<B: Bus>(
        &mut self,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        if memory.store(address, width, value) {
            return Ok(());
        }
        beyond_memory(address, width)?;
        if is_system(address) {
            self.deadline = 0;
            self.system_store(address, width, value)
        } else {
            bus.store(memory, self.cycles, address, width, value)?;
            self.timing.set_wait_states(bus.flash_wait_states());
            self.look_at(bus);
            Ok(())
        }
    }

    /// To be called after an access: an interrupt may have become pending, or an event may be due
    /// earlier.
    fn look_at<B: Bus>(&mut self, bus: &B) {
        self.set_lines(bus.lines());
        self.deadline = if bus.resets() { 0 } else { self.deadline.min(bus.due()) };
    }

    #[cold]
    fn refuse_access(&mut self, op: &Op, address: u32, store: bool, width: Width, why: Refused) {
        self.refuse(
            op,
            match why {
                Refused::Fault => Abort::Fault(Fault::DataBus { address }),
                Refused::Unmodelled { .. } => Abort::Refused { address, store, width, why },
            },
        );
    }

    /// Whether an address is one of a word. All but plain loads and stores fault where it is not
    /// (A3.2.1).
    #[inline(always)]
    pub(super) fn aligned(&mut self, op: &Op, address: u32) -> bool {
        if address.is_multiple_of(4) {
            return true;
        }
        self.refuse(op, Abort::Fault(Fault::Unaligned { address }));
        false
    }
}

/// The error of an access whose effect the manual leaves open (A3.2.1).
const fn beyond_memory(address: u32, width: Width) -> Result<(), Refused> {
    if address.is_multiple_of(width.bytes()) {
        Ok(())
    } else {
        Err(Refused::Unmodelled { what: "an access that is not aligned, outside memory" })
    }
}
