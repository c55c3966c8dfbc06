//! Reads the radio chip's firmware: an ELF file, an Intel hex file, or the plain image that goes to
//! 0x1B000.

mod hex;

use std::fmt;
use std::path::{Path, PathBuf};

use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader as _, ProgramHeader as _};
use object::{Endianness, Object as _};

use crate::core::{Op, Width, decode};

/// The size of the flash.
const SIZE: usize = 256 * 1024;
/// The address of the application behind Nordic's S130 (crazyflie2-nrf-firmware,
/// `crazyflie2_nrf_firmware.ld`).
pub const APPLICATION: u32 = 0x1B000;
/// The address of the string that names the device (the same, `platform.h`), and its room.
const DEVICE: usize = 0x3FFE0;
const DEVICE_ROOM: usize = 32;

/// The reason why a file is not the radio chip's firmware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// The file cannot be read.
    Unreadable(PathBuf, String),
    /// The file is an ELF file that is damaged or for another machine.
    BadElf(String),
    /// The file is an Intel hex file, and a line of it is damaged.
    BadHex {
        /// The number of the line, from 1 on.
        line: usize,
    },
    /// A part of the file is to be loaded where the chip has no flash.
    OutsideFlash {
        /// The address of the part.
        address: u64,
        /// The size of the part in bytes.
        size: usize,
    },
    /// There are no vectors at the application's address.
    NoVectors,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(path, why) => write!(f, "{}: {why}", path.display()),
            Self::BadElf(why) => write!(f, "this is no ELF file for ARM: {why}"),
            Self::BadHex { line } => write!(f, "line {line} of this Intel hex file is damaged"),
            Self::OutsideFlash { address, size } => {
                write!(f, "{size} bytes at {address:#x} are outside of the chip's flash")
            }
            Self::NoVectors => {
                write!(f, "there are no vectors at {APPLICATION:#x}, where the application begins")
            }
        }
    }
}

impl std::error::Error for ImageError {}

/// The flash: its bytes, and the instruction at each even address.
pub struct Program {
    bytes: Box<[u8]>,
    ops: Box<[Op]>,
}

impl fmt::Debug for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Program").finish_non_exhaustive()
    }
}

impl Program {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// An [`ImageError`] where the file cannot be read or is not the radio chip's firmware.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let read = std::fs::read(path);
        let file = read.map_err(|why| ImageError::Unreadable(path.to_owned(), why.to_string()))?;
        Self::of(&file)
    }

    /// Loads an ELF file, an Intel hex file, or anything else as the image of the application.
    ///
    /// # Errors
    ///
    /// An [`ImageError`] where it is not the radio chip's firmware.
    pub fn of(file: &[u8]) -> Result<Self, ImageError> {
        let mut flash = vec![0xFF; SIZE];
        if file.starts_with(b"\x7FELF") {
            load_elf(file, &mut flash)?;
        } else if file.first() == Some(&b':') {
            hex::load(file, &mut flash)?;
        } else {
            load(file, APPLICATION.into(), &mut flash)?;
        }
        Self::with_flash(flash)
    }

    fn with_flash(mut flash: Vec<u8>) -> Result<Self, ImageError> {
        // An erased string stands for a Crazyflie 2.0, whose radio has no amplifier.
        let name = b"0;CF21\0";
        if flash[DEVICE..DEVICE + DEVICE_ROOM].iter().all(|byte| *byte == 0xFF) {
            flash[DEVICE..DEVICE + name.len()].copy_from_slice(name);
        }
        let program = Self { ops: decoded(&flash), bytes: flash.into_boxed_slice() };
        let [stack, entry] = [0, 4].map(|at| program.read(APPLICATION + at, Width::Word));
        let is_stack = stack.is_some_and(|it| it >> 24 == 0x20 && it & 3 == 0);
        let is_code = entry.is_some_and(|it| it & 1 != 0 && (it as usize) < SIZE);
        if is_stack && is_code { Ok(program) } else { Err(ImageError::NoVectors) }
    }

    #[inline]
    pub(crate) fn read(&self, address: u32, width: Width) -> Option<u32> {
        let at = address as usize;
        let bytes = self.bytes.get(at..at + width.bytes() as usize)?;
        Some(bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte)))
    }

    /// The instruction at an even address.
    #[inline]
    pub(crate) fn op(&self, address: u32) -> Option<Op> {
        self.ops.get(address as usize / 2).copied()
    }
}

/// The instructions at the even addresses; the last halfword has none behind it.
fn decoded(flash: &[u8]) -> Box<[Op]> {
    let halves: Vec<_> = flash.as_chunks().0.iter().map(|it| u16::from_le_bytes(*it)).collect();
    let seconds = halves.iter().skip(1).chain(&[0]);
    halves.iter().zip(seconds).map(|(first, second)| decode(*first, *second)).collect()
}

/// Copies bytes to their place in the flash.
fn load(bytes: &[u8], address: u64, flash: &mut [u8]) -> Result<(), ImageError> {
    let outside = ImageError::OutsideFlash { address, size: bytes.len() };
    let Ok(start) = usize::try_from(address) else { return Err(outside) };
    let place = start.checked_add(bytes.len()).and_then(|end| flash.get_mut(start..end));
    place.ok_or(outside)?.copy_from_slice(bytes);
    Ok(())
}

fn load_elf(file: &[u8], flash: &mut [u8]) -> Result<(), ImageError> {
    let bad = |why: object::Error| ImageError::BadElf(why.to_string());
    let elf = ElfFile32::<Endianness>::parse(file).map_err(bad)?;
    if elf.architecture() != object::Architecture::Arm {
        return Err(ImageError::BadElf("it is for another machine".to_owned()));
    }
    let endian = elf.endian();
    let headers = FileHeader32::<Endianness>::parse(file).map_err(bad)?;
    for part in headers.program_headers(endian, file).map_err(bad)? {
        if part.p_type(endian) != PT_LOAD {
            continue;
        }
        let Ok(bytes) = part.data(endian, file) else {
            return Err(ImageError::BadElf("a part of it is cut off".to_owned()));
        };
        if !bytes.is_empty() {
            load(bytes, part.p_paddr(endian).into(), flash)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image that begins with a stack pointer and an entry.
    fn image(stack: u32, entry: u32) -> Vec<u8> {
        [stack, entry].map(u32::to_le_bytes).concat()
    }

    #[test]
    fn an_image_is_loaded_at_the_applications_address() {
        let program = Program::of(&image(0x2000_4000, 0x1B009)).unwrap();
        assert_eq!(program.read(APPLICATION, Width::Word), Some(0x2000_4000));
        assert_eq!(program.read(APPLICATION + 8, Width::Half), Some(0xFFFF));
        assert_eq!(program.read(DEVICE as u32, Width::Word), Some(u32::from_le_bytes(*b"0;CF")));
    }

    #[test]
    fn what_is_no_firmware_is_refused() {
        assert_eq!(Program::of(b"").unwrap_err(), ImageError::NoVectors);
        assert_eq!(Program::of(&image(0x2000_4000, 0x1B008)).unwrap_err(), ImageError::NoVectors);
        let large = vec![0; SIZE];
        assert!(matches!(Program::of(&large), Err(ImageError::OutsideFlash { .. })));
        assert!(matches!(Program::of(b"\x7FELF and more"), Err(ImageError::BadElf(_))));
    }
}
