//! The flat image: the firmware's bytes as they lie in flash, the first at 0x08004000.

use std::ops::Range;

use object::Endianness;
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};

use crate::Result;

/// Flash between the bootloader and the page for keys (`memory.x`).
pub(crate) const FLASH: Range<u32> = 0x0800_4000..0x080E_0000;

/// Main memory (`memory.x`).
pub(crate) const RAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// What erased flash reads as.
const ERASED: u8 = 0xFF;

/// The flat image of an ELF file, checked.
pub(crate) fn flatten(elf: &[u8]) -> Result<Vec<u8>> {
    let header = FileHeader32::<Endianness>::parse(elf).map_err(|why| format!("no ELF: {why}"))?;
    let endian = header.endian().map_err(|why| why.to_string())?;
    let headers = header.program_headers(endian, elf).map_err(|why| why.to_string())?;
    let mut pieces = Vec::new();
    for header in headers {
        let bytes = header.data(endian, elf).map_err(|()| "a segment lies outside the file")?;
        if header.p_type(endian) == PT_LOAD && !bytes.is_empty() {
            // Where it is loaded from, which for initial values is not where they are used.
            pieces.push((header.p_paddr(endian), bytes));
        }
    }
    let image = join(&mut pieces)?;
    check(&image)?;
    Ok(image)
}

/// Puts the pieces where they belong.
fn join(pieces: &mut [(u32, &[u8])]) -> Result<Vec<u8>> {
    pieces.sort_by_key(|(at, _)| *at);
    match pieces.first() {
        None => return Err("there is nothing to load".into()),
        Some((at, _)) if *at != FLASH.start => {
            return Err(format!("it begins at {at:#010x}, not at {:#010x}", FLASH.start));
        }
        Some(_) => {}
    }
    let mut image = Vec::new();
    for (at, bytes) in pieces {
        let offset = (*at - FLASH.start) as usize;
        let end = offset.saturating_add(bytes.len());
        if end > FLASH.len() {
            return Err(format!(
                "{} bytes at {at:#010x} do not fit the flash, which ends at {:#010x}",
                bytes.len(),
                FLASH.end
            ));
        }
        if offset < image.len() {
            return Err(format!("two segments lie at {at:#010x}"));
        }
        image.resize(offset, ERASED);
        image.extend_from_slice(bytes);
    }
    Ok(image)
}

/// What the bootloader relies on.
fn check(image: &[u8]) -> Result<()> {
    let word = |at: usize| {
        let bytes = image.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(stack), Some(reset)) = (word(0), word(4)) else {
        return Err("it is shorter than a vector table".into());
    };
    if stack <= RAM.start || stack > RAM.end || stack % 8 != 0 {
        return Err(format!("the initial stack pointer, {stack:#010x}, is not in RAM"));
    }
    if reset % 2 == 0 {
        return Err(format!("the reset vector, {reset:#010x}, is no Thumb address"));
    }
    let code = FLASH.start..FLASH.start + image.len() as u32;
    if !code.contains(&reset) {
        return Err(format!("the reset vector, {reset:#010x}, is not in the image"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(stack: u32, reset: u32) -> Vec<u8> {
        [stack.to_le_bytes(), reset.to_le_bytes()].concat()
    }

    /// What is wrong with an image of one piece.
    fn wrong(at: u32, bytes: &[u8]) -> String {
        join(&mut [(at, bytes)]).and_then(|image| check(&image)).unwrap_err()
    }

    #[test]
    fn a_sound_image_passes_and_gaps_read_as_erased() {
        let vectors = table(0x2002_0000, 0x0800_4009);
        let image = join(&mut [(0x0800_400C, &[7, 8]), (0x0800_4000, &vectors)]).unwrap();
        assert_eq!(&image[8..], [0xFF, 0xFF, 0xFF, 0xFF, 7, 8]);
        check(&image).unwrap();
    }

    #[test]
    fn what_the_bootloader_would_not_run_is_refused() {
        let good = table(0x2002_0000, 0x0800_4001);
        assert!(wrong(0x0800_0000, &good).contains("begins at 0x08000000"));
        assert!(wrong(FLASH.start, &[0; 7]).contains("shorter"));
        assert!(wrong(FLASH.start, &vec![0; FLASH.len() + 1]).contains("do not fit"));
        let bad = |stack, reset| wrong(FLASH.start, &table(stack, reset));
        assert!(bad(0x1000_0000, 0x0800_4001).contains("stack pointer"));
        assert!(bad(0x2002_0004, 0x0800_4001).contains("stack pointer"));
        assert!(bad(0xFFFF_FFFF, 0x0800_4001).contains("stack pointer"));
        assert!(bad(0x2002_0000, 0x0800_4000).contains("Thumb"));
        assert!(bad(0x2002_0000, 0x0800_4009).contains("not in the image"));
        let twice: &mut [(u32, &[u8])] = &mut [(FLASH.start, &good), (FLASH.start + 4, &[1])];
        assert!(join(twice).unwrap_err().contains("two segments"));
        assert!(join(&mut []).is_err());
    }

    #[test]
    fn what_is_no_elf_file_is_refused() {
        assert!(flatten(b"").is_err());
        assert!(flatten(&[0x7F; 200]).unwrap_err().contains("no ELF"));
    }
}
