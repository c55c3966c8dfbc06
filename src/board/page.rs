//! The provisioning page: keys are loaded into this page of the flash by cable, copied into the
//! EEPROM at the next boot ([`crate::tasks::store`]), and then wiped from the page.
//!
//! The page has the last sector of the flash for itself (`memory.x`). It is wiped by programming
//! its bits to zero, which needs no erasing (RM0090, "Embedded Flash memory interface", bits go
//! from one to zero by programming): an erase takes a second or two, during which the processor
//! stands still; a word takes 16 µs, 100 µs at most (STM32F405 data sheet, t_prog).
#![expect(unsafe_code, reason = "reads and programs flash outside of every variable")]

use core::sync::atomic::{Ordering, fence};

use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::vals::Psize;

/// Bytes of the page that are read and wiped.
pub(crate) const LENGTH: usize = storage::keys::PAGE_LENGTH;

const _: () = assert!(LENGTH.is_multiple_of(4), "flash is programmed in words");

const WORDS: usize = LENGTH / 4;

/// The sequence that unlocks the control register (RM0090, "Unlocking the Flash control register").
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

/// Polls of the status before a word counts as failed: each takes 10 cycles of 168 MHz or more, so
/// 600 µs or more in all.
const POLLS: u32 = 10_000;

unsafe extern "C" {
    /// A symbol of `memory.x` whose address is the page's.
    static _keys_page: u32;
}

fn word(index: usize) -> *const u32 {
    (&raw const _keys_page).wrapping_add(index)
}

/// The page's first bytes.
pub(crate) fn read() -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    for (index, place) in bytes.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        // SAFETY: the symbol is the beginning of a sector of 128 KiB, aligned, of which these are
        // the first words; every bit pattern is a number; and the read is volatile because this
        // module or a probe may program the page.
        let value = unsafe { word(index).read_volatile() };
        *place = value.to_le_bytes();
    }
    bytes
}

/// Programs every byte that [`read`] returns to zero; false when one of them is not zero
/// afterwards. For the ground only: while a word is programmed, the processor waits for each
/// instruction that it has to fetch from flash.
#[must_use]
pub(crate) fn wipe() -> bool {
    // The data cache could return the old contents (RM0090, "Program/erase in Flash").
    let cached = FLASH.acr().read().dcen();
    FLASH.acr().modify(|w| w.set_dcen(false));
    if FLASH.cr().read().lock() {
        for key in KEYS {
            FLASH.keyr().write_value(key);
        }
    }
    // Error flags of earlier operations are cleared by writing them back.
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
    done && read() == [0; LENGTH]
}

/// Programs one word to zero; false when that failed.
fn clear(index: usize) -> bool {
    fence(Ordering::SeqCst);
    // SAFETY: the address is a word of the page, as in `read`, where the program has no variable,
    // constant or instruction; the flash controller carries out the write, and reports an error in
    // its status.
    unsafe { word(index).cast_mut().write_volatile(0) };
    fence(Ordering::SeqCst);
    is_ready()
}

/// Waits until a word is programmed; false when that took too long or failed.
fn is_ready() -> bool {
    let ready = (0..POLLS).any(|_| !FLASH.sr().read().bsy());
    let status = FLASH.sr().read();
    ready && !status.wrperr() && !status.pgaerr() && !status.pgperr() && !status.pgserr()
}
