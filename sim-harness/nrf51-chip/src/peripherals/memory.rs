//! The chip's RAM: 16 KB.

use crate::core::Width;

/// The address and the size of the RAM.
pub(super) const START: u32 = 0x2000_0000;
const SIZE: u32 = 16 * 1024;

/// The RAM.
#[derive(Clone)]
pub(super) struct Ram(Box<[u8; SIZE as usize]>);

impl Ram {
    pub(super) fn new() -> Self {
        Self(Box::new([0; SIZE as usize]))
    }

    /// The place of an address, if it and the bytes behind it are in the RAM.
    #[inline]
    const fn place(address: u32, bytes: u32) -> Option<usize> {
        let at = address.wrapping_sub(START);
        if at <= SIZE - bytes { Some(at as usize) } else { None }
    }

    /// A byte; outside of the RAM it is zero.
    pub(super) fn byte(&self, address: u32) -> u8 {
        Self::place(address, 1).map_or(0, |at| self.0[at])
    }

    /// Sets a byte; outside of the RAM nothing happens.
    pub(super) fn set_byte(&mut self, address: u32, value: u8) {
        if let Some(at) = Self::place(address, 1) {
            self.0[at] = value;
        }
    }

    #[inline]
    pub(super) fn read(&self, address: u32, width: Width) -> Option<u32> {
        let at = Self::place(address, width.bytes())?;
        Some(match width {
            Width::Byte => self.0[at].into(),
            Width::Half => u16::from_le_bytes([self.0[at], self.0[at + 1]]).into(),
            Width::Word => {
                let bytes = [self.0[at], self.0[at + 1], self.0[at + 2], self.0[at + 3]];
                u32::from_le_bytes(bytes)
            }
        })
    }

    #[inline]
    pub(super) fn write(&mut self, address: u32, width: Width, value: u32) -> Option<()> {
        let at = Self::place(address, width.bytes())?;
        let size = width.bytes() as usize;
        self.0[at..at + size].copy_from_slice(&value.to_le_bytes()[..size]);
        Some(())
    }
}
