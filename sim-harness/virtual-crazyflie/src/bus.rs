//! The interface between the core and everything that is not memory.
//!
//! The core keeps the time, in its own cycles, and calls: a load or a store at an address where no
//! memory is goes to the [`Bus`]. In the other direction the bus has interrupt lines, which the core
//! samples after each access and whenever the bus has let something happen by itself.

use crate::memory::Memory;

pub use crate::memory::Width;

/// Why an access was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The chip answers it with a bus error: there is nothing at this address.
    Fault,
    /// The chip would answer, but this emulator does not know how: it must stop, loudly.
    Unmodelled {
        /// The peripheral and register, or what was wanted of it.
        what: &'static str,
    },
}

/// Everything that is not the core and not plain memory. Addresses of the private peripheral bus
/// (0xE000_0000 and on) never come here: they are the core's own.
pub trait Bus {
    /// A load at cycle `now`.
    ///
    /// # Errors
    /// Where there is nothing, or nothing that is known.
    fn load(
        &mut self,
        memory: &mut Memory,
        now: u64,
        address: u32,
        width: Width,
    ) -> Result<u32, Refused>;

    /// A store at cycle `now`. Stores to flash come here too.
    ///
    /// # Errors
    /// Where there is nothing, or nothing that is known.
    fn store(
        &mut self,
        memory: &mut Memory,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused>;

    /// The cycle at which something will happen by itself; `u64::MAX` for never. It may change
    /// with every access.
    fn due(&self) -> u64;

    /// Everything happens that is due at cycle `now`.
    fn advance(&mut self, memory: &mut Memory, now: u64);

    /// The levels of the interrupt lines, one bit each.
    fn lines(&self) -> u128;

    /// The number of wait states of the flash (FLASH_ACR.LATENCY).
    fn flash_wait_states(&self) -> u8 {
        0
    }

    /// Whether the chip is held in reset by something outside the core: a watchdog.
    fn resets(&self) -> bool;
}

/// A bus without peripherals: memory answers, every other address is a bus error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryOnly {
    /// The flash's wait states.
    pub flash_wait_states: u8,
}

impl Bus for MemoryOnly {
    fn load(&mut self, _: &mut Memory, _: u64, _: u32, _: Width) -> Result<u32, Refused> {
        Err(Refused::Fault)
    }

    fn store(&mut self, _: &mut Memory, _: u64, _: u32, _: Width, _: u32) -> Result<(), Refused> {
        Err(Refused::Fault)
    }

    fn due(&self) -> u64 {
        u64::MAX
    }

    fn advance(&mut self, _: &mut Memory, _: u64) {}

    fn lines(&self) -> u128 {
        0
    }

    fn flash_wait_states(&self) -> u8 {
        self.flash_wait_states
    }

    fn resets(&self) -> bool {
        false
    }
}
