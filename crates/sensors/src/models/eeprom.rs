//! Model of a 24AA64, the EEPROM: a write beyond the end of a page wraps to its beginning, and
//! while the memory stores a page it acknowledges nothing.

use super::{Fault, I2cModel, peek};
use crate::eeprom::{ADDRESS, PAGE, SIZE};

/// The progress of a write.
#[derive(Clone, Copy)]
enum Phase {
    Idle,
    High,
    Low { high: u8 },
    Data { written: bool },
}

/// The model of the memory.
pub struct EepromModel {
    /// The memory's fault.
    pub fault: Fault,
    /// The time in µs to store a page. The data sheet says 5000 at most.
    pub write_micros: u32,
    bytes: [u8; SIZE as usize],
    at: u16,
    phase: Phase,
    busy: u32,
    pages: u32,
}

impl EepromModel {
    /// A memory as it leaves the factory, with all bytes 0xFF.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            fault: Fault::None,
            write_micros: 3_000,
            bytes: [0xFF; SIZE as usize],
            at: 0,
            phase: Phase::Idle,
            busy: 0,
            pages: 0,
        }
    }

    /// The content of the memory.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; SIZE as usize] {
        &self.bytes
    }

    /// The content of the memory, to be changed.
    pub const fn bytes_mut(&mut self) -> &mut [u8; SIZE as usize] {
        &mut self.bytes
    }

    /// Number of page writes so far.
    #[must_use]
    pub const fn pages_written(&self) -> u32 {
        self.pages
    }
}

impl Default for EepromModel {
    fn default() -> Self {
        Self::new()
    }
}

impl I2cModel for EepromModel {
    fn start(&mut self, address: u8, read: bool) -> bool {
        self.phase = if read { Phase::Idle } else { Phase::High };
        address == ADDRESS && self.busy == 0 && self.fault.acknowledges()
    }

    fn write(&mut self, byte: u8) -> bool {
        if !self.fault.acknowledges() {
            return false;
        }
        self.phase = match self.phase {
            Phase::Idle => return false,
            Phase::High => Phase::Low { high: byte },
            Phase::Low { high } => {
                self.at = u16::from_be_bytes([high, byte]) % SIZE;
                Phase::Data { written: false }
            }
            Phase::Data { .. } => {
                if let Some(slot) = self.bytes.get_mut(usize::from(self.at)) {
                    *slot = byte;
                }
                let page = self.at / PAGE * PAGE;
                self.at = page + (self.at + 1) % PAGE;
                Phase::Data { written: true }
            }
        };
        true
    }

    fn read(&mut self) -> u8 {
        let byte = peek(&self.bytes, self.at.into());
        self.at = (self.at + 1) % SIZE;
        self.fault.read(byte)
    }

    fn stop(&mut self) {
        if let Phase::Data { written: true } = self.phase {
            self.busy = self.write_micros;
            self.pages += 1;
        }
        self.phase = Phase::Idle;
    }

    fn advance(&mut self, micros: u32) {
        self.busy = self.busy.saturating_sub(micros);
    }
}
