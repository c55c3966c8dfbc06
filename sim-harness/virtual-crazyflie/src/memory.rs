//! The memories of an STM32F405RG, as the core and the DMA see them (RM0090, "Memory map").

/// The size of a load or store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Half,
    /// 32 bits.
    Word,
}

impl Width {
    /// The size in bytes.
    #[must_use]
    pub const fn bytes(self) -> u32 {
        match self {
            Self::Byte => 1,
            Self::Half => 2,
            Self::Word => 4,
        }
    }
}

/// The addresses and sizes of the memories.
pub mod map {
    /// Flash: 1 MiB.
    pub const FLASH: u32 = 0x0800_0000;
    /// The size of flash.
    pub const FLASH_SIZE: u32 = 1024 * 1024;
    /// SRAM1 and SRAM2, one after the other.
    pub const RAM: u32 = 0x2000_0000;
    /// The size of SRAM1 and SRAM2 together.
    pub const RAM_SIZE: u32 = 128 * 1024;
    /// Core-coupled memory: no DMA reaches it.
    pub const CCM: u32 = 0x1000_0000;
    /// The size of the core-coupled memory.
    pub const CCM_SIZE: u32 = 64 * 1024;
}

/// The value of RAM before it is written, which no program should rely on.
const GARBAGE: u8 = 0xA5;

/// A stretch of memory. Its size is part of its type, so that a look at an offset that has been
/// compared with it needs no second comparison.
struct Region<const BASE: u32, const SIZE: usize> {
    bytes: Box<[u8; SIZE]>,
}

impl<const BASE: u32, const SIZE: usize> Region<BASE, SIZE> {
    fn new(fill: u8) -> Self {
        let bytes = vec![fill; SIZE].into_boxed_slice();
        Self { bytes: bytes.try_into().expect("the size is what it was made with") }
    }

    #[inline(always)]
    const fn offset(address: u32, bytes: usize) -> Option<usize> {
        let offset = address.wrapping_sub(BASE) as usize;
        if offset <= SIZE - bytes { Some(offset) } else { None }
    }

    /// Of what is aligned: rotated, an offset that is not looks like one that is far too large.
    #[inline(always)]
    const fn aligned_offset(address: u32, width: Width) -> Option<usize> {
        let shift = width.bytes().trailing_zeros();
        let index = address.wrapping_sub(BASE).rotate_right(shift) as usize;
        if index < SIZE >> shift { Some(index << shift) } else { None }
    }

    #[inline(always)]
    fn read(&self, offset: usize, width: Width) -> u32 {
        let bytes = &self.bytes;
        match width {
            Width::Byte => u32::from(bytes[offset]),
            Width::Half => u32::from(u16::from_le_bytes([bytes[offset], bytes[offset + 1]])),
            Width::Word => u32::from_le_bytes([
                bytes[offset],
                bytes[offset + 1],
                bytes[offset + 2],
                bytes[offset + 3],
            ]),
        }
    }

    #[inline(always)]
    fn write(&mut self, offset: usize, width: Width, value: u32) {
        let value = value.to_le_bytes();
        match width {
            Width::Byte => self.bytes[offset] = value[0],
            Width::Half => self.bytes[offset..offset + 2].copy_from_slice(&value[..2]),
            Width::Word => self.bytes[offset..offset + 4].copy_from_slice(&value),
        }
    }

    fn look(&self, address: u32, count: u32) -> Option<&[u8]> {
        let offset = address.wrapping_sub(BASE) as usize;
        self.bytes.get(offset..offset.checked_add(count as usize)?)
    }
}

type Ram = Region<{ map::RAM }, { map::RAM_SIZE as usize }>;
type Flash = Region<{ map::FLASH }, { map::FLASH_SIZE as usize }>;
type BootFlash = Region<0, { map::FLASH_SIZE as usize }>;
type Ccm = Region<{ map::CCM }, { map::CCM_SIZE as usize }>;

/// All of them.
pub struct Memory {
    ram: Ram,
    flash: Flash,
    ccm: Ccm,
}

impl Memory {
    /// The memories after power-up of an empty chip: flash erased, RAM full of `0xA5`.
    #[must_use]
    pub fn new() -> Self {
        Self { ram: Region::new(GARBAGE), flash: Region::new(0xFF), ccm: Region::new(GARBAGE) }
    }

    /// RAM forgets what it held, as it does without power. Flash does not.
    pub fn lose_power(&mut self) {
        self.ram.bytes.fill(GARBAGE);
        self.ccm.bytes.fill(GARBAGE);
    }

    /// Little-endian, aligned or not; `None` where there is no memory. Flash can also be read at
    /// zero, where it is mapped at boot.
    #[inline(always)]
    #[must_use]
    pub fn load(&self, address: u32, width: Width) -> Option<u32> {
        let bytes = width.bytes() as usize;
        if let Some(offset) = Ram::offset(address, bytes) {
            return Some(self.ram.read(offset, width));
        }
        if let Some(offset) = Flash::offset(address, bytes) {
            return Some(self.flash.read(offset, width));
        }
        self.load_elsewhere(address, width)
    }

    #[cold]
    fn load_elsewhere(&self, address: u32, width: Width) -> Option<u32> {
        let bytes = width.bytes() as usize;
        if let Some(offset) = Ccm::offset(address, bytes) {
            return Some(self.ccm.read(offset, width));
        }
        let offset = BootFlash::offset(address, bytes)?;
        Some(self.flash.read(offset, width))
    }

    /// Of RAM and where it is aligned only: nearly all that a program does.
    #[inline(always)]
    pub(crate) fn load_aligned(&self, address: u32, width: Width) -> Option<u32> {
        let offset = Ram::aligned_offset(address, width)?;
        Some(self.ram.read(offset, width))
    }

    /// Loads from flash, where the address is aligned; none elsewhere.
    #[inline(always)]
    pub(crate) fn load_flash_aligned(&self, address: u32, width: Width) -> Option<u32> {
        let offset = Flash::aligned_offset(address, width)?;
        Some(self.flash.read(offset, width))
    }

    /// Little-endian, aligned or not; false where there is no RAM. Flash is not written this way.
    #[inline(always)]
    pub fn store(&mut self, address: u32, width: Width, value: u32) -> bool {
        let bytes = width.bytes() as usize;
        if let Some(offset) = Ram::offset(address, bytes) {
            self.ram.write(offset, width, value);
            true
        } else if let Some(offset) = Ccm::offset(address, bytes) {
            self.ccm.write(offset, width, value);
            true
        } else {
            false
        }
    }

    /// To RAM and where it is aligned only.
    #[inline(always)]
    pub(crate) fn store_aligned(&mut self, address: u32, width: Width, value: u32) -> bool {
        let Some(offset) = Ram::aligned_offset(address, width) else {
            return false;
        };
        self.ram.write(offset, width, value);
        true
    }

    /// Words of RAM, where all of them are.
    #[inline(always)]
    pub(crate) fn words(&self, address: u32, count: u32) -> Option<&[[u8; 4]]> {
        let offset = address.wrapping_sub(map::RAM) as usize;
        if !address.is_multiple_of(4) || offset >= map::RAM_SIZE as usize {
            return None;
        }
        self.ram.bytes.as_chunks::<4>().0.get(offset / 4..offset / 4 + count as usize)
    }

    /// The bytes, to be written.
    #[inline(always)]
    pub(crate) fn words_mut(&mut self, address: u32, count: u32) -> Option<&mut [[u8; 4]]> {
        let offset = address.wrapping_sub(map::RAM) as usize;
        if !address.is_multiple_of(4) || offset >= map::RAM_SIZE as usize {
            return None;
        }
        self.ram.bytes.as_chunks_mut::<4>().0.get_mut(offset / 4..offset / 4 + count as usize)
    }

    /// Writes bytes to flash as they are, for the flash controller and for loading an image. False,
    /// and nothing written, where there is no flash.
    pub fn program(&mut self, address: u32, bytes: &[u8]) -> bool {
        let offset = address.wrapping_sub(map::FLASH) as usize;
        let Some(end) = offset.checked_add(bytes.len()) else { return false };
        let Some(place) = self.flash.bytes.get_mut(offset..end) else { return false };
        place.copy_from_slice(bytes);
        true
    }

    /// A look at so many bytes, wherever they are.
    #[must_use]
    pub fn bytes(&self, address: u32, count: u32) -> Option<&[u8]> {
        self.ram
            .look(address, count)
            .or_else(|| self.flash.look(address, count))
            .or_else(|| self.ccm.look(address, count))
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}
