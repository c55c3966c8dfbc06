//! Keeps when each peripheral is due next and which interrupt lines are high, as it noted itself
//! when it last changed. So the core's question after every access needs no look at the peripherals.

use crate::soc::map::TIMERS;

/// A peripheral that can be due or interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::soc) enum Slot {
    /// An index of [`TIMERS`].
    Timer(usize),
    /// I2C1 is 0.
    I2c(usize),
    Spi1,
    Usart6,
    /// The board; and EXTI, which watches its pins.
    Board,
    /// The units that run in nanoseconds: RCC, flash, the watchdog.
    Own,
    /// DMA1 is 0.
    Dma(usize),
}

const SLOTS: usize = TIMERS.len() + 9;

impl Slot {
    const fn index(self) -> usize {
        const REST: usize = TIMERS.len();
        match self {
            Self::Timer(index) => index,
            Self::I2c(index) => REST + index,
            Self::Spi1 => REST + 3,
            Self::Usart6 => REST + 4,
            Self::Board => REST + 5,
            Self::Own => REST + 6,
            Self::Dma(index) => REST + 7 + index,
        }
    }
}

/// The due times and interrupt lines of all peripherals.
pub(in crate::soc) struct Plan {
    due: [u64; SLOTS],
    lines: [u128; SLOTS],
    /// The least of `due`, and all of `lines`.
    next: u64,
    all: u128,
}

impl Plan {
    pub(super) const fn new() -> Self {
        Self { due: [u64::MAX; SLOTS], lines: [0; SLOTS], next: u64::MAX, all: 0 }
    }

    /// The next cycle at which a unit is due.
    #[inline(always)]
    pub(in crate::soc) const fn next(&self) -> u64 {
        self.next
    }

    /// The interrupt lines, by the NVIC's numbers.
    #[inline(always)]
    pub(in crate::soc) const fn lines(&self) -> u128 {
        self.all
    }

    /// When one is due.
    #[inline(always)]
    pub(in crate::soc) const fn due(&self, slot: Slot) -> u64 {
        self.due[slot.index()]
    }

    /// Notes when a peripheral is due and which interrupt lines it drives.
    #[inline(always)]
    pub(in crate::soc) fn note(&mut self, slot: Slot, due: u64, lines: u128) {
        let index = slot.index();
        // Most accesses change nothing about it.
        if self.due[index] != due || self.lines[index] != lines {
            self.change(index, due, lines);
        }
    }

    #[inline(never)]
    fn change(&mut self, index: usize, due: u64, lines: u128) {
        if self.lines[index] != lines {
            self.lines[index] = lines;
            self.all = self.lines.iter().fold(0, |all, lines| all | lines);
        }
        let before = std::mem::replace(&mut self.due[index], due);
        if due <= self.next {
            self.next = due;
        } else if before == self.next {
            self.next = self.due.iter().copied().fold(u64::MAX, u64::min);
        }
    }
}
