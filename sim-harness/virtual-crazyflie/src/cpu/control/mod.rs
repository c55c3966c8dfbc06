//! The system control space, and what else is on the private peripheral bus (DDI 0403, B3 and C1).
//!
//! | module | addresses |
//! |---|---|
//! | [`debug`] | 0xE000_0000: ITM; 0xE000_1000: DWT; 0xE000_EDF0: debug registers as software sees them |
//! | [`systick`] | 0xE000_E010: SysTick |
//! | [`nvic`] | 0xE000_E100: interrupts |
//! | [`scb`] | 0xE000_ED00: the core itself |
//! | [`fpu`] | 0xE000_ED88, 0xE000_EF34: the floating-point unit |
//!
//! A register that would do something that is not modelled is refused by name, and so is a bit of
//! one. Registers are words. Bytes and halfwords are taken where the manual lets them be.

mod debug;
mod fpu;
mod nvic;
mod scb;
mod systick;

use super::Cpu;
use crate::bus::{Refused, Width};
use debug::Debug;
pub(super) use fpu::FpControl;
use scb::FaultStatus;
use systick::SysTick;

/// The registers of the system control space that no other module keeps.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    vtor: u32,
    scr: u32,
    ccr: u32,
    actlr: u32,
    reset: bool,
    pub(super) faults: FaultStatus,
    pub(super) fp: FpControl,
    systick: SysTick,
    debug: Debug,
}

impl Control {
    /// The registers after a reset.
    pub(crate) fn new() -> Self {
        Self {
            vtor: 0,
            scr: 0,
            ccr: scb::STKALIGN,
            actlr: 0,
            reset: false,
            faults: FaultStatus::default(),
            fp: FpControl::default(),
            systick: SysTick::default(),
            debug: Debug::default(),
        }
    }

    /// A reset of the core. What the chip does to its clocks is not the core's.
    pub(super) fn reset(&mut self) {
        *self = Self { debug: self.debug.after_reset(), ..Self::new() };
    }
}

/// The refusal of a register or bit that is not modelled.
const fn unmodelled<T>(what: &'static str) -> Result<T, Refused> {
    Err(Refused::Unmodelled { what })
}

/// A store to a register, or to a part of one.
#[derive(Clone, Copy, Debug)]
struct Store {
    /// The register.
    address: u32,
    /// The stored value, shifted to its place in the word.
    value: u32,
    /// Which bits are stored.
    mask: u32,
}

impl Store {
    /// Each byte that is stored, with its address.
    fn bytes(self) -> impl Iterator<Item = (u32, u8)> {
        (0..4)
            .filter(move |byte| self.mask >> (8 * byte) & 0xFF != 0)
            .map(move |byte| (self.address + byte, (self.value >> (8 * byte)) as u8))
    }
}

/// Registers of which parts can be accessed (B3.2.2, B3.4.2, C1.7.3): SHPR1 to SHPR3, CFSR,
/// NVIC_IPRn and ITM_STIMn.
const fn takes_parts(register: u32) -> bool {
    matches!(
        register,
        0xE000_ED18..=0xE000_ED20
            | 0xE000_ED28
            | 0xE000_E400..=0xE000_E5EC
            | debug::STIMULUS..debug::STIMULUS_END
    )
}

impl Cpu {
    /// A load from 0xE000_0000 to 0xE00F_FFFF.
    pub(crate) fn system_load(&mut self, address: u32, width: Width) -> Result<u32, Refused> {
        if !self.special.privileged() {
            return Err(Refused::Fault);
        }
        let (register, shift, mask) = part(address, width)?;
        let value = match register {
            debug::STIMULUS..debug::STIMULUS_END => Ok(debug::load_stimulus()),
            0xE000_1000..=0xE000_1FFF => self.load_dwt(register),
            0xE000_E010..=0xE000_E01F => Ok(self.load_systick(register)),
            0xE000_E004 | 0xE000_E100..=0xE000_E5EF | nvic::STIR => self.load_nvic(register),
            0xE000_ED88 | 0xE000_EF34..=0xE000_EF44 => self.load_fpu(register),
            0xE000_EDF0..=0xE000_EDFF => self.load_debug(register),
            0xE000_E008 | 0xE000_ED00..=0xE000_EDEF => self.load_scb(register),
            _ => unmodelled(name(register)),
        }?;
        Ok((value & mask) >> shift)
    }

    /// A store to 0xE000_0000 to 0xE00F_FFFF.
    pub(crate) fn system_store(
        &mut self,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        let lets_pend = address == nvic::STIR && self.control.lets_users_pend();
        if !self.special.privileged() && !lets_pend {
            return Err(Refused::Fault);
        }
        let (register, shift, mask) = part(address, width)?;
        let store = Store { address: register, value: value << shift & mask, mask };
        match register {
            // The instrumentation trace is never enabled here: nothing leaves the core.
            debug::STIMULUS..debug::STIMULUS_END => Ok(()),
            0xE000_1000..=0xE000_1FFF => self.store_dwt(store),
            0xE000_E010..=0xE000_E01F => self.store_systick(store),
            0xE000_E004 | 0xE000_E100..=0xE000_E5EF | nvic::STIR => self.store_nvic(store),
            0xE000_ED88 | 0xE000_EF34..=0xE000_EF44 => self.store_fpu(store),
            0xE000_EDF0..=0xE000_EDFF => self.store_debug(store),
            0xE000_E008 | 0xE000_ED00..=0xE000_EDEF => self.store_scb(store),
            _ => unmodelled(name(register)),
        }?;
        // Nearly all of them may change what is due, or what may come in.
        self.deadline = 0;
        Ok(())
    }
}

/// The register at an address, how far the part of it is shifted, and which bits the part is.
fn part(address: u32, width: Width) -> Result<(u32, u32, u32), Refused> {
    let (register, offset) = (address & !3, address & 3);
    if width == Width::Word && offset == 0 {
        return Ok((register, 0, !0));
    }
    if offset % width.bytes() != 0 {
        return unmodelled("an unaligned access to the system control space");
    }
    if !takes_parts(register) {
        return unmodelled("a part of a register of the system control space");
    }
    let mask = if width == Width::Byte { 0xFF } else { 0xFFFF };
    Ok((register, 8 * offset, mask << (8 * offset)))
}

/// The name of the register at an address that is not modelled.
const fn name(address: u32) -> &'static str {
    match address {
        0xE000_0000..=0xE000_0FFF => "ITM: a register other than its stimulus ports",
        0xE000_2000..=0xE000_2FFF => "FPB",
        0xE000_EF50..=0xE000_EF78 => "cache maintenance: there is no cache",
        0xE000_EFD0..=0xE000_EFFF => "CoreSight identification of the system control space",
        0xE000_E000..=0xE000_EFFF => "a reserved register of the system control space",
        0xE004_0000..=0xE004_0FFF => "TPIU",
        0xE004_1000..=0xE004_1FFF => "ETM",
        0xE004_2000..=0xE004_23FF => "DBGMCU, which is the chip's and not the core's",
        0xE00F_F000..=0xE00F_FFFF => "the ROM table",
        _ => "a reserved part of the private peripheral bus",
    }
}

#[cfg(test)]
mod tests;
