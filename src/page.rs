//! The page in flash through which keys come in: loaded by cable, taken over into the EEPROM at the
//! next boot ([`crate::store`]), and then made unreadable.
//!
//! It has the last sector of the flash for itself (`memory.x`). To make it unreadable its bits are
//! programmed to zero, which needs no erasing (RM0090, "Embedded Flash memory interface", bits go
//! from one to zero by programming): an erase takes a second or two, and the processor stands still
//! meanwhile, a word takes 16 µs, 100 µs at most (STM32F405 data sheet, t_prog).
#![expect(unsafe_code, reason = "reads and programs flash that is nobody's variable")]

use core::sync::atomic::{Ordering, fence};

use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::vals::Psize;

/// Bytes that are looked at, and made unreadable: any record fits, with room to spare.
pub(crate) const LENGTH: usize = 64;

const WORDS: usize = LENGTH / 4;

/// Opens the control register (RM0090, "Unlocking the Flash control register").
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Turns of the loop that waits for a word: 10 cycles of 168 MHz or more each, so 600 µs or more.
const TURNS: u32 = 10_000;

unsafe extern "C" {
    /// A symbol of `memory.x`; its address is what is meant.
    static _keys_page: u32;
}

/// What the page holds.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Content {
    /// Nothing: erased, or made unreadable.
    Nothing,
    /// Something.
    Something,
}

fn word(index: usize) -> *const u32 {
    (&raw const _keys_page).wrapping_add(index)
}

/// The page's first bytes.
pub(crate) fn read() -> ([u8; LENGTH], Content) {
    let mut bytes = [0; LENGTH];
    let mut content = Content::Nothing;
    for (index, place) in bytes.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        // SAFETY: the symbol is the beginning of a sector of 128 KiB, aligned, of which these are
        // the first words; every bit pattern is a number; and as others may program it (this
        // module, a probe), it is read as what may change.
        let value = unsafe { word(index).read_volatile() };
        if value != 0 && value != u32::MAX {
            content = Content::Something;
        }
        *place = value.to_le_bytes();
    }
    (bytes, content)
}

/// Makes what [`read`] sees zeros; false when they are not. For the ground only: while a word is
/// programmed, the processor waits for each instruction that it has to fetch from flash.
#[must_use]
pub(crate) fn wipe() -> bool {
    // Left on, the cache may return what was there before (RM0090, "Program/erase in Flash").
    let cached = FLASH.acr().read().dcen();
    FLASH.acr().modify(|w| w.set_dcen(false));
    if FLASH.cr().read().lock() {
        for key in KEYS {
            FLASH.keyr().write_value(key);
        }
    }
    // Errors of whoever was here before are cleared by writing them back.
    FLASH.sr().modify(|_| {});
    FLASH.cr().write(|w| {
        w.set_pg(true);
        // The board's supply is 3 V, and this wants 2.7 V (RM0090, "Program/erase parallelism").
        w.set_psize(Psize::PSIZE32);
    });
    let done = is_ready() && (0..WORDS).all(clear);
    FLASH.cr().write(|w| w.set_pg(false));
    FLASH.cr().modify(|w| w.set_lock(true));
    FLASH.acr().modify(|w| w.set_dcrst(true));
    FLASH.acr().modify(|w| w.set_dcrst(false));
    FLASH.acr().modify(|w| w.set_dcen(cached));
    let (bytes, _) = read();
    done && bytes == [0; LENGTH]
}

/// Programs one word to zero.
fn clear(index: usize) -> bool {
    fence(Ordering::SeqCst);
    // SAFETY: it is a word of the page, as in `read`, where the program has no variable, constant
    // or instruction; what the bus makes of the write is the flash controller's business, and an
    // error shows in its status.
    unsafe { word(index).cast_mut().write_volatile(0) };
    fence(Ordering::SeqCst);
    is_ready()
}

/// Waits until a word is programmed; false when that took too long or went wrong.
fn is_ready() -> bool {
    let ready = (0..TURNS).any(|_| !FLASH.sr().read().bsy());
    let status = FLASH.sr().read();
    ready && !status.wrperr() && !status.pgaerr() && !status.pgperr() && !status.pgserr()
}
