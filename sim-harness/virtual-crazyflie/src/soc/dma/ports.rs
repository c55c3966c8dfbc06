//! The two ports of a controller (RM0090, "System architecture"): it reaches memory by the one,
//! peripherals by the other.

use super::requests::DMA2;
use crate::bus::{Refused, Width};
use crate::memory::{Memory, map};
use crate::soc::context::Reach;

/// The transfer has failed: the stream is disabled and TEIF set.
pub(super) struct Failed;

/// Flash and SRAM1 and 2, at their own addresses. The core-coupled memory is on no bus of theirs.
const fn reaches_memory(address: u32, size: u32) -> bool {
    const fn within(address: u32, size: u32, base: u32, length: u32) -> bool {
        address >= base && address - base <= length - size
    }
    within(address, size, map::FLASH, map::FLASH_SIZE)
        || within(address, size, map::RAM, map::RAM_SIZE)
}

/// DMA1's peripheral port is wired to APB1 and to nothing else.
fn reaches_peripheral(controller: usize, address: u32) -> bool {
    controller == DMA2 || (0x4000_0000..0x4000_8000).contains(&address)
}

/// A load by the memory port.
pub(super) fn load_memory(address: u32, width: Width, memory: &Memory) -> Result<u32, Failed> {
    if !reaches_memory(address, width.bytes()) {
        return Err(Failed);
    }
    memory.load(address, width).ok_or(Failed)
}

/// A store by the memory port.
pub(super) fn store_memory(
    address: u32,
    width: Width,
    value: u32,
    memory: &mut Memory,
    reach: &mut impl Reach,
) -> Result<(), Failed> {
    if (map::FLASH..map::FLASH + map::FLASH_SIZE).contains(&address) {
        reach.complain("DMA: a store to flash");
        return Err(Failed);
    }
    let is_there = reaches_memory(address, width.bytes()) && memory.store(address, width, value);
    if is_there { Ok(()) } else { Err(Failed) }
}

/// A load by the peripheral port, which DMA2's copies read memory by.
pub(super) fn load_peripheral(
    controller: usize,
    address: u32,
    width: Width,
    memory: &Memory,
    reach: &mut impl Reach,
) -> Result<u32, Failed> {
    if !reaches_peripheral(controller, address) {
        return Err(Failed);
    }
    if reaches_memory(address, width.bytes()) {
        return load_memory(address, width, memory);
    }
    reach.load(address, width).map_err(|refused| failed(refused, reach))
}

/// A store by the peripheral port.
pub(super) fn store_peripheral(
    controller: usize,
    address: u32,
    width: Width,
    value: u32,
    reach: &mut impl Reach,
) -> Result<(), Failed> {
    if !reaches_peripheral(controller, address) {
        return Err(Failed);
    }
    reach.store(address, width, value).map_err(|refused| failed(refused, reach))
}

/// Sorts a refusal: a bus error concerns the stream, an access that is not modelled stops the
/// machine.
fn failed(refused: Refused, reach: &mut impl Reach) -> Failed {
    if let Refused::Unmodelled { what } = refused {
        reach.complain(what);
    }
    Failed
}
