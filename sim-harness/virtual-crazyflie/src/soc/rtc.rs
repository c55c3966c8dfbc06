//! The backup registers of the RTC, which outlive every reset (RM0090, "RTC_BKPxR"). The calendar
//! is not modelled: no Crazyflie has its crystal.

use crate::bus::Refused;

const BACKUP: std::ops::Range<u32> = 0x50..0xA0;

/// The registers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rtc {
    backup: [u32; 20],
}

impl Rtc {
    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        if BACKUP.contains(&offset) {
            return Ok(self.backup[(offset - BACKUP.start) as usize / 4]);
        }
        Err(Refused::Unmodelled { what: "RTC: the calendar" })
    }

    /// `open` is PWR_CR, DBP; without it nothing happens.
    pub(crate) fn write(&mut self, offset: u32, value: u32, open: bool) -> Result<(), Refused> {
        if BACKUP.contains(&offset) {
            if open {
                self.backup[(offset - BACKUP.start) as usize / 4] = value;
            }
            return Ok(());
        }
        Err(Refused::Unmodelled { what: "RTC: the calendar" })
    }

    pub(crate) const fn words(&self) -> [u32; 20] {
        self.backup
    }
}
