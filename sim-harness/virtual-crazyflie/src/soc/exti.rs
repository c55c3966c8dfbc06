//! EXTI and the part of SYSCFG that belongs to it: edges on pins, as interrupts (RM0090,
//! "External interrupt/event controller" and "System configuration controller").
//!
//! Lines 16 to 22 come from peripherals that are not modelled; they can be raised by EXTI_SWIER.

use crate::bus::Refused;
use crate::soc::wiring::Pin;

/// Lines that exist: 0 to 22.
const LINES: u32 = 0x007F_FFFF;

/// The registers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Exti {
    imr: u32,
    rtsr: u32,
    ftsr: u32,
    swier: u32,
    pr: u32,
    /// Levels of lines 0 to 15 when last looked at.
    levels: u32,
}

impl Exti {
    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        Ok(match offset {
            0x00 => self.imr,
            0x04 => 0,
            0x08 => self.rtsr,
            0x0C => self.ftsr,
            0x10 => self.swier,
            0x14 => self.pr,
            _ => return Err(Refused::Unmodelled { what: "EXTI: a reserved register" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        let value = value & LINES;
        match offset {
            0x00 => self.imr = value,
            0x04 if value == 0 => {}
            0x04 => return Err(Refused::Unmodelled { what: "EXTI_EMR: events" }),
            0x08 => self.rtsr = value,
            0x0C => self.ftsr = value,
            // A bit that goes from 0 to 1 raises its line, if that is not masked.
            0x10 => {
                self.pr |= value & !self.swier & self.imr;
                self.swier |= value;
            }
            // Written with 1 to clear; the software's bit goes with it.
            0x14 => {
                self.pr &= !value;
                self.swier &= !value;
            }
            _ => return Err(Refused::Unmodelled { what: "EXTI: a reserved register" }),
        }
        Ok(())
    }

    /// Lines 0 to 15 whose level matters.
    pub(crate) const fn watched(&self) -> u32 {
        (self.rtsr | self.ftsr) & 0xFFFF
    }

    /// The levels of the watched lines as they are now. Edges become pending whether masked or not.
    pub(crate) fn sample(&mut self, levels: u32) {
        let rising = levels & !self.levels;
        let falling = !levels & self.levels;
        self.pr |= (rising & self.rtsr | falling & self.ftsr) & 0xFFFF;
        self.levels = levels;
    }

    /// A line's level without an edge: it was not looked at before.
    pub(crate) fn settle(&mut self, line: u32, is_high: bool) {
        self.levels = self.levels & !(1 << line) | u32::from(is_high) << line;
    }

    /// The interrupt lines, by the NVIC's numbers.
    pub(crate) const fn lines(&self) -> u128 {
        let raised = self.pr & self.imr;
        if raised == 0 {
            return 0;
        }
        // EXTI0 to EXTI4 are interrupts 6 to 10.
        let mut lines = ((raised & 0x1F) as u128) << 6;
        let others: [(u32, u32); 9] = [
            (0x0000_03E0, 23),
            (0x0000_FC00, 40),
            (1 << 16, 1),
            (1 << 17, 41),
            (1 << 18, 42),
            (1 << 19, 62),
            (1 << 20, 76),
            (1 << 21, 2),
            (1 << 22, 3),
        ];
        let mut n = 0;
        while n < others.len() {
            if raised & others[n].0 != 0 {
                lines |= 1 << others[n].1;
            }
            n += 1;
        }
        lines
    }

    pub(crate) fn reset(&mut self) {
        *self = Self { levels: self.levels, ..Self::default() };
    }

    pub(crate) fn words(&self) -> [u32; 5] {
        [self.imr, self.rtsr, self.ftsr, self.swier, self.pr]
    }
}

/// SYSCFG: which port's pin each EXTI line watches.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Syscfg {
    exticr: [u32; 4],
}

impl Syscfg {
    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        Ok(match offset {
            // Booted from flash, and MII rather than RMII.
            0x00 | 0x04 => 0,
            0x08 | 0x0C | 0x10 | 0x14 => self.exticr[(offset as usize - 8) / 4],
            // The compensation cell is off.
            0x20 => 0,
            _ => return Err(Refused::Unmodelled { what: "SYSCFG: a reserved register" }),
        })
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        match offset {
            0x00 if value & 3 == 0 => {}
            0x00 => return Err(Refused::Unmodelled { what: "SYSCFG_MEMRMP: remapping" }),
            0x04 if value & 1 << 23 == 0 => {}
            0x04 => return Err(Refused::Unmodelled { what: "SYSCFG_PMC: Ethernet" }),
            0x08 | 0x0C | 0x10 | 0x14 => {
                let ports = [0, 4, 8, 12].map(|shift| value >> shift & 15);
                if ports.iter().any(|port| *port > 8) {
                    return Err(Refused::Unmodelled { what: "SYSCFG_EXTICR: no such port" });
                }
                self.exticr[(offset as usize - 8) / 4] = value & 0xFFFF;
            }
            0x20 if value & 1 == 0 => {}
            0x20 => return Err(Refused::Unmodelled { what: "SYSCFG_CMPCR: compensation cell" }),
            _ => return Err(Refused::Unmodelled { what: "SYSCFG: a reserved register" }),
        }
        Ok(())
    }

    /// The pin that an EXTI line watches.
    pub(crate) const fn pin(&self, line: usize) -> Pin {
        let line = line % 16;
        Pin::of((self.exticr[line / 4] >> (4 * (line % 4)) & 15) as usize, line)
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    pub(crate) const fn words(&self) -> [u32; 4] {
        self.exticr
    }
}
