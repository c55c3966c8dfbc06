//! The flat image: the firmware's bytes as they lie in flash, the first at 0x08004000.

use std::ops::Range;

use virtual_crazyflie::image::Image;

use crate::Result;

/// Flash between the bootloader and the page for keys (`memory.x`).
pub(crate) const FLASH: Range<u32> = 0x0800_4000..0x080E_0000;

/// Main memory (`memory.x`).
pub(crate) const RAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// The flat image of an ELF file, checked for what the bootloader relies on beyond what any chip
/// does: where the image begins and ends, and that the stack is in main memory.
pub(crate) fn flatten(image: &Image) -> Result<Vec<u8>> {
    let (start, bytes) = image.flat();
    check(start, bytes.len(), image.vector_table(), image.word(start).unwrap_or(0))?;
    Ok(bytes)
}

fn check(start: u32, size: usize, vector_table: u32, stack: u32) -> Result<()> {
    if start != FLASH.start {
        return Err(format!("it begins at {start:#010x}, not at {:#010x}", FLASH.start));
    }
    if size > FLASH.len() {
        return Err(format!(
            "{size} bytes at {start:#010x} do not fit the flash, which ends at {:#010x}",
            FLASH.end
        ));
    }
    if vector_table != start {
        return Err(format!("its vector table is at {vector_table:#010x}, not at its beginning"));
    }
    if stack <= RAM.start || stack > RAM.end {
        return Err(format!("the initial stack pointer, {stack:#010x}, is not in RAM"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_that_the_bootloader_would_not_run_is_refused() {
        let (flash, stack) = (FLASH.start, RAM.end);
        assert_eq!(check(flash, FLASH.len(), flash, stack), Ok(()));
        for (start, size, table, stack, part) in [
            (0x0800_0000, 8, 0x0800_0000, stack, "begins at 0x08000000"),
            (flash, FLASH.len() + 1, flash, stack, "do not fit"),
            (flash, 0x400, flash + 0x100, stack, "vector table"),
            (flash, 8, flash, 0x1000_0000, "stack pointer"),
            (flash, 8, flash, 0xFFFF_FFF8, "stack pointer"),
        ] {
            let wrong = check(start, size, table, stack).unwrap_err();
            assert!(wrong.contains(part), "{part}: {wrong}");
        }
    }
}
