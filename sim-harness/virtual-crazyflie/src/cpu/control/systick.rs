//! SysTick (DDI 0403, B3.3), exact to the cycle, and computed when it is read.
//!
//! The counter runs with the core's clock, in sleep too, or with an eighth of it (RM0090, "SysTick
//! external clock"), whose edges are at every eighth cycle since power-up.

use super::{Store, unmodelled};
use crate::bus::Refused;
use crate::cpu::Cpu;
use crate::cpu::exceptions::priorities::{bit, number};

const ENABLE: u32 = 1;
const TICKINT: u32 = 1 << 1;
const CLKSOURCE: u32 = 1 << 2;
const COUNTFLAG: u32 = 1 << 16;
const RELOAD: u32 = 0x00FF_FFFF;

/// SKEW, and 18750 for 1 ms at 18.75 MHz (RM0090, "SysTick calibration value register").
const CALIB: u32 = 1 << 30 | 18_750;

/// The timer.
#[derive(Clone, Debug)]
pub(super) struct SysTick {
    control: u32,
    reload: u32,
    /// The value of the counter at `since`.
    current: u32,
    /// A tick, in ticks since power-up.
    since: u64,
    /// COUNTFLAG.
    counted: bool,
    /// The cycle at which the interrupt comes next.
    due: u64,
}

impl Default for SysTick {
    fn default() -> Self {
        Self { control: 0, reload: 0, current: 0, since: 0, counted: false, due: u64::MAX }
    }
}

impl SysTick {
    const fn divider(&self) -> u64 {
        if self.control & CLKSOURCE == 0 { 8 } else { 1 }
    }

    /// Counts up to cycle `now`. Says whether the interrupt is asked for.
    fn count(&mut self, now: u64) -> bool {
        let tick = now / self.divider();
        let ticks = tick - self.since;
        self.since = tick;
        if self.control & ENABLE == 0 || ticks == 0 {
            return false;
        }
        let (current, reached_zero) = after(self.current, self.reload, ticks);
        self.current = current;
        self.counted |= reached_zero;
        reached_zero && self.control & TICKINT != 0
    }

    /// When the interrupt comes next, from now on.
    fn plan(&mut self) {
        let ticks = match (self.current, self.reload) {
            _ if self.control & (ENABLE | TICKINT) != ENABLE | TICKINT => None,
            (0, 0) => None,
            (0, reload) => Some(u64::from(reload) + 1),
            (current, _) => Some(u64::from(current)),
        };
        self.due = ticks.map_or(u64::MAX, |ticks| (self.since + ticks) * self.divider());
    }

    /// The clock may have been changed: from now on its ticks are counted.
    fn set_control(&mut self, value: u32, now: u64) {
        self.control = value & (ENABLE | TICKINT | CLKSOURCE);
        self.since = now / self.divider();
    }
}

/// The counter after so many ticks, and whether it came from one to zero meanwhile. From zero it
/// goes on with the reload value; with none it stays there.
fn after(current: u32, reload: u32, ticks: u64) -> (u32, bool) {
    let to_zero = match (current, reload) {
        (0, 0) => return (0, false),
        (0, reload) => u64::from(reload) + 1,
        (current, _) => u64::from(current),
    };
    let Some(beyond) = ticks.checked_sub(to_zero) else {
        let from = if current == 0 { reload + 1 } else { current };
        return (from - ticks as u32, false);
    };
    let period = u64::from(reload) + 1;
    let into = (beyond % period) as u32;
    (if into == 0 { 0 } else { reload + 1 - into }, true)
}

impl Cpu {
    /// The cycle of the next event of SysTick; `u64::MAX` for none.
    #[inline]
    pub(crate) const fn system_due(&self) -> u64 {
        self.control.systick.due
    }

    /// Everything happens that is due by now.
    pub(crate) fn system_advance(&mut self) {
        if self.control.systick.count(self.cycles) {
            self.pend(bit(number::SYS_TICK));
        }
        self.control.systick.plan();
    }

    pub(super) fn load_systick(&mut self, address: u32) -> u32 {
        self.system_advance();
        let systick = &mut self.control.systick;
        match address {
            0xE000_E010 => {
                let flag = if std::mem::take(&mut systick.counted) { COUNTFLAG } else { 0 };
                systick.control | flag
            }
            0xE000_E014 => systick.reload,
            0xE000_E018 => systick.current,
            _ => CALIB,
        }
    }

    pub(super) fn store_systick(&mut self, store: Store) -> Result<(), Refused> {
        self.system_advance();
        let systick = &mut self.control.systick;
        match store.address {
            0xE000_E010 => systick.set_control(store.value, self.cycles),
            0xE000_E014 => systick.reload = store.value & RELOAD,
            // Any value clears.
            0xE000_E018 => {
                systick.current = 0;
                systick.counted = false;
            }
            _ => return unmodelled("a store to a read-only register"),
        }
        systick.plan();
        Ok(())
    }
}
