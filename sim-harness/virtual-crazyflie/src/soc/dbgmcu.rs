//! DBGMCU: which chip it is, and what stands still while a debugger has halted it (RM0090, "Debug
//! support"). Halting stops all time here, so the latter only remembers what is written.

use crate::bus::Refused;

/// An STM32F405 of revision 4.
const IDCODE: u32 = 0x100F_6413;

/// The registers. A system reset leaves them alone.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Dbgmcu {
    cr: u32,
    freeze: [u32; 2],
}

impl Dbgmcu {
    /// Whether the core's clocks go on while it sleeps (DBG_SLEEP), and with them its cycle counter.
    pub(crate) const fn counts_in_sleep(&self) -> bool {
        self.cr & 1 != 0
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        Ok(match offset {
            0x00 => IDCODE,
            0x04 => self.cr,
            0x08 => self.freeze[0],
            0x0C => self.freeze[1],
            _ => return Err(Refused::Unmodelled { what: "DBGMCU: a reserved register" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        match offset {
            0x00 => {}
            0x04 if value & 1 << 5 != 0 => {
                return Err(Refused::Unmodelled { what: "DBGMCU_CR: trace pins" });
            }
            0x04 => self.cr = value & 0xE7,
            0x08 => self.freeze[0] = value & 0x06E0_1DFF,
            0x0C => self.freeze[1] = value & 0x0007_0003,
            _ => return Err(Refused::Unmodelled { what: "DBGMCU: a reserved register" }),
        }
        Ok(())
    }
}
