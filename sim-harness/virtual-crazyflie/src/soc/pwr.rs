//! PWR: the regulator's scale, and access to the backup domain (RM0090, "Power controller").

use crate::bus::Refused;

/// Bits of PWR_CR.
mod cr {
    pub(super) const LPDS: u32 = 1 << 0;
    pub(super) const PDDS: u32 = 1 << 1;
    pub(super) const CWUF: u32 = 1 << 2;
    pub(super) const CSBF: u32 = 1 << 3;
    pub(super) const PVDE: u32 = 1 << 4;
    pub(super) const PLS: u32 = 7 << 5;
    pub(super) const DBP: u32 = 1 << 8;
    pub(super) const FPDS: u32 = 1 << 9;
    pub(super) const VOS: u32 = 1 << 14;
}

/// The registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pwr {
    cr: u32,
}

impl Pwr {
    pub(crate) const fn new() -> Self {
        Self { cr: cr::VOS }
    }

    /// Whether the backup domain may be written (DBP).
    pub(crate) const fn opens_backup(&self) -> bool {
        self.cr & cr::DBP != 0
    }

    /// The highest HCLK that the regulator's scale allows: scale 2 or scale 1.
    pub(crate) const fn highest(&self) -> u64 {
        if self.cr & cr::VOS == 0 { 144_000_000 } else { 168_000_000 }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        match offset {
            0x00 => Ok(self.cr),
            // VOSRDY: the regulator is there when the firmware is.
            0x04 => Ok(1 << 14),
            _ => Err(Refused::Unmodelled { what: "PWR: a reserved register" }),
        }
    }

    /// `pll` is on.
    pub(crate) fn write(&mut self, offset: u32, value: u32, pll: bool) -> Result<(), Refused> {
        match offset {
            0x00 if value & cr::PVDE != 0 => {
                Err(Refused::Unmodelled { what: "PWR_CR: the voltage detector" })
            }
            0x00 if pll && (value ^ self.cr) & cr::VOS != 0 => {
                Err(Refused::Unmodelled { what: "PWR_CR: VOS changed while the PLL is on" })
            }
            0x00 if value & (cr::LPDS | cr::PDDS | cr::FPDS) != 0 => {
                Err(Refused::Unmodelled { what: "PWR_CR: stop and standby" })
            }
            0x00 => {
                // CWUF and CSBF clear flags that are never set.
                let _ = cr::CWUF | cr::CSBF;
                self.cr = value & (cr::PLS | cr::DBP | cr::VOS);
                Ok(())
            }
            0x04 if value & (1 << 8 | 1 << 9) != 0 => {
                Err(Refused::Unmodelled { what: "PWR_CSR: wake-up pin, backup regulator" })
            }
            0x04 => Ok(()),
            _ => Err(Refused::Unmodelled { what: "PWR: a reserved register" }),
        }
    }
}
