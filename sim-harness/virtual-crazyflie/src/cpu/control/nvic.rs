//! The NVIC's registers (DDI 0403, B3.4).

use super::{Store, unmodelled};
use crate::bus::Refused;
use crate::cpu::Cpu;
use crate::cpu::exceptions::priorities::INTERRUPTS;

/// Software trigger interrupt register.
pub(super) const STIR: u32 = 0xE000_EF00;
/// The number of the exception that is interrupt 0.
const FIRST: u32 = 16;

/// Which set of interrupts a register shows, and from which interrupt on.
#[derive(Clone, Copy)]
enum Register {
    SetEnable(u32),
    ClearEnable(u32),
    SetPending(u32),
    ClearPending(u32),
    Active(u32),
    /// The interrupt whose priority is lowest in the word.
    Priority(u32),
    TypeOf,
    Trigger,
}

impl Register {
    fn at(address: u32) -> Result<Self, Refused> {
        let first = |base| 8 * (address - base);
        Ok(match address {
            0xE000_E004 => Self::TypeOf,
            0xE000_E100..=0xE000_E13C => Self::SetEnable(first(0xE000_E100)),
            0xE000_E180..=0xE000_E1BC => Self::ClearEnable(first(0xE000_E180)),
            0xE000_E200..=0xE000_E23C => Self::SetPending(first(0xE000_E200)),
            0xE000_E280..=0xE000_E2BC => Self::ClearPending(first(0xE000_E280)),
            0xE000_E300..=0xE000_E33C => Self::Active(first(0xE000_E300)),
            0xE000_E400..=0xE000_E5EC => Self::Priority(address - 0xE000_E400),
            STIR => Self::Trigger,
            _ => return unmodelled("a reserved register of the NVIC"),
        })
    }
}

/// A register's word as a set of exceptions. Interrupts that there are not are dropped.
fn set(word: u32, first: u32) -> u128 {
    if first >= u32::from(INTERRUPTS) {
        return 0;
    }
    let all = (1 << INTERRUPTS) - 1;
    (u128::from(word) << first & all) << FIRST
}

/// A set of exceptions as a register's word.
fn word(set: u128, first: u32) -> u32 {
    if first >= u32::from(INTERRUPTS) { 0 } else { (set >> (FIRST + first)) as u32 }
}

impl Cpu {
    pub(super) fn load_nvic(&self, address: u32) -> Result<u32, Refused> {
        let priorities = &self.exceptions.priorities;
        Ok(match Register::at(address)? {
            Register::TypeOf => u32::from(INTERRUPTS - 1) / 32,
            Register::SetEnable(first) | Register::ClearEnable(first) => {
                word(priorities.enabled(), first)
            }
            Register::SetPending(first) | Register::ClearPending(first) => {
                word(priorities.pending(), first)
            }
            Register::Active(first) => word(priorities.active(), first),
            Register::Priority(first) => (first..first + 4)
                .rev()
                .filter_map(|n| u16::try_from(n).ok())
                .fold(0, |word, n| word << 8 | u32::from(self.interrupt_priority(n))),
            Register::Trigger => return unmodelled("a load from STIR, which is write-only"),
        })
    }

    fn interrupt_priority(&self, interrupt: u16) -> u8 {
        if interrupt < INTERRUPTS {
            self.exceptions.priorities.priority(16 + interrupt) as u8
        } else {
            0
        }
    }

    pub(super) fn store_nvic(&mut self, store: Store) -> Result<(), Refused> {
        let priorities = &mut self.exceptions.priorities;
        match Register::at(store.address)? {
            Register::SetEnable(first) => priorities.set_enabled(set(store.value, first), true),
            Register::ClearEnable(first) => priorities.set_enabled(set(store.value, first), false),
            Register::SetPending(first) => self.pend(set(store.value, first)),
            Register::ClearPending(first) => priorities.unpend(set(store.value, first)),
            Register::Priority(_) => {
                for (address, byte) in store.bytes() {
                    priorities.set_priority((FIRST + address - 0xE000_E400) as u16, byte);
                }
            }
            Register::Trigger => {
                let interrupt = store.value & 0x1FF;
                self.pend(set(1 << (interrupt % 32), interrupt & !31));
            }
            // Read only.
            Register::TypeOf | Register::Active(_) => {}
        }
        Ok(())
    }
}
