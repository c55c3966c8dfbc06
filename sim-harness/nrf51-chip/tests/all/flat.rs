//! A memory of code and RAM, without peripherals.

use nrf51_chip::core::{Memory, NoMemory, Op, Width, decode};

/// The address of the RAM.
pub(crate) const RAM: u32 = 0x2000_0000;
/// The size of either memory.
const SIZE: usize = 0x4000;

/// Code at 0 and RAM, 16 KB each.
#[derive(Clone)]
pub(crate) struct Flat {
    pub(crate) code: Vec<u8>,
    pub(crate) ram: Vec<u8>,
}

impl Flat {
    pub(crate) fn new() -> Self {
        Self { code: vec![0; SIZE], ram: vec![0; SIZE] }
    }

    /// A memory with words and halfwords at addresses in its code.
    pub(crate) fn with(words: &[(u32, u32)], halves: &[(u32, &[u16])]) -> Self {
        let mut flat = Self::new();
        for (address, word) in words {
            let at = *address as usize;
            flat.code[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        for (address, code) in halves {
            let bytes: Vec<_> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
            let at = *address as usize;
            flat.code[at..at + bytes.len()].copy_from_slice(&bytes);
        }
        flat
    }

    fn at(&mut self, address: u32, width: Width) -> Result<&mut [u8], NoMemory> {
        let (memory, start) =
            if address < RAM { (&mut self.code, 0) } else { (&mut self.ram, RAM) };
        let at = (address - start) as usize;
        memory.get_mut(at..at + width.bytes() as usize).ok_or(NoMemory)
    }
}

impl Memory for Flat {
    fn read(&mut self, address: u32, width: Width) -> Result<u32, NoMemory> {
        let bytes = self.at(address, width)?;
        Ok(bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte)))
    }

    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), NoMemory> {
        let bytes = self.at(address, width)?;
        bytes.iter_mut().zip(value.to_le_bytes()).for_each(|(to, from)| *to = from);
        Ok(())
    }

    fn fetch(&mut self, address: u32) -> Result<Op, NoMemory> {
        let first = self.read(address, Width::Half)? as u16;
        let second = self.read(address + 2, Width::Half).unwrap_or(0) as u16;
        Ok(decode(first, second))
    }
}
