//! The flash interface: locks, programming, erasing and every error.

use super::{Chip, at, unmodelled};
use virtual_crazyflie::bus::{Bus, Width};
use virtual_crazyflie::soc::SocConfig;

const PAGE: u32 = 0x080E_0000;
const BSY: u32 = 1 << 16;
const PG: u32 = 1;
const X32: u32 = 2 << 8;

fn unlocked() -> Chip {
    let mut chip = Chip::new();
    chip.store(at::FLASH_KEYR, 0x4567_0123);
    chip.store(at::FLASH_KEYR, 0xCDEF_89AB);
    chip
}

fn word(chip: &Chip, address: u32) -> u32 {
    chip.memory.load(address, Width::Word).expect("flash")
}

/// Stores a word and waits; what FLASH_SR says then.
fn program(chip: &mut Chip, address: u32, width: Width, value: u32) -> u32 {
    chip.try_store(address, width, value).expect("takes it");
    chip.pass(16 * 20);
    let status = chip.load(at::FLASH_SR);
    chip.store(at::FLASH_SR, 0xF3);
    status
}

#[test]
fn a_word_is_programmed_in_16_us() {
    let mut chip = unlocked();
    chip.store(at::FLASH_CR, PG | X32);
    chip.try_store(PAGE, Width::Word, 0x1234_5678).expect("programs");
    assert_eq!(chip.load(at::FLASH_SR), BSY);
    chip.pass(16 * 16 - 1);
    assert_eq!(chip.load(at::FLASH_SR), BSY);
    chip.pass(1);
    assert_eq!(chip.load(at::FLASH_SR), 0);
    assert_eq!(word(&chip, PAGE), 0x1234_5678);
}

#[test]
fn bits_go_from_one_to_zero_and_only_an_erase_brings_them_back() {
    let mut chip = unlocked();
    chip.store(at::FLASH_CR, PG | X32);
    program(&mut chip, PAGE, Width::Word, 0xFF00_FF00);
    program(&mut chip, PAGE, Width::Word, 0x0FF0_0FF0);
    assert_eq!(word(&chip, PAGE), 0x0F00_0F00);
    chip.store(at::FLASH_CR, 2 | 11 << 3 | X32);
    chip.store(at::FLASH_CR, 2 | 11 << 3 | X32 | 1 << 16);
    assert_eq!(chip.load(at::FLASH_SR), BSY);
    chip.pass(16_000 * 999);
    assert_eq!(chip.load(at::FLASH_SR), BSY);
    chip.pass(16_001);
    assert_eq!(chip.load(at::FLASH_SR), 0);
    assert_eq!(word(&chip, PAGE), u32::MAX);
}

#[test]
fn an_erase_takes_its_sector_and_no_other() {
    for (sector, start, size) in [
        (0_u32, 0x0800_0000_u32, 0x4000_u32),
        (3, 0x0800_C000, 0x4000),
        (4, 0x0801_0000, 0x1_0000),
        (5, 0x0802_0000, 0x2_0000),
        (11, 0x080E_0000, 0x2_0000),
    ] {
        let mut chip = unlocked();
        chip.memory.program(0x0800_0000, &vec![0; 1024 * 1024]);
        chip.store(at::FLASH_CR, 2 | sector << 3 | X32 | 1 << 16);
        let flash = chip.memory.bytes(0x0800_0000, 1024 * 1024).expect("flash");
        let erased = flash.iter().filter(|byte| **byte == 0xFF).count();
        assert_eq!(erased, size as usize, "sector {sector}");
        assert_eq!(word(&chip, start), u32::MAX);
        assert_eq!(word(&chip, start + size - 4), u32::MAX);
    }
}

#[test]
fn every_mistake_has_its_flag_and_changes_nothing() {
    const PGSERR: u32 = 1 << 7;
    const PGPERR: u32 = 1 << 6;
    const PGAERR: u32 = 1 << 5;
    const WRPERR: u32 = 1 << 4;
    let mut chip = unlocked();
    assert_eq!(program(&mut chip, PAGE, Width::Word, 0), PGSERR, "without PG");
    chip.store(at::FLASH_CR, PG | X32);
    assert_eq!(program(&mut chip, PAGE, Width::Byte, 0), PGPERR, "of another width");
    assert_eq!(program(&mut chip, PAGE + 14, Width::Word, 0), PGAERR, "over a row's end");
    chip.store(at::FLASH_CR, 2 | 12 << 3 | X32 | 1 << 16);
    assert_eq!(chip.load(at::FLASH_SR), PGSERR, "a sector that is not there");
    assert_eq!(word(&chip, PAGE), u32::MAX);

    let option_bytes = SocConfig::default().option_bytes & !(1 << 27);
    let mut chip = Chip::with(SocConfig { option_bytes, ..SocConfig::default() });
    chip.store(at::FLASH_KEYR, 0x4567_0123);
    chip.store(at::FLASH_KEYR, 0xCDEF_89AB);
    chip.store(at::FLASH_CR, PG | X32);
    assert_eq!(program(&mut chip, PAGE, Width::Word, 0), WRPERR);
    assert_eq!(word(&chip, PAGE), u32::MAX);
    assert_eq!(program(&mut chip, PAGE - 4, Width::Word, 0), 0, "another sector");
}

#[test]
fn what_is_locked_stays_as_it_is() {
    let mut chip = Chip::new();
    assert_eq!(chip.load(at::FLASH_CR), 1 << 31);
    chip.store(at::FLASH_CR, PG | X32);
    assert_eq!(chip.load(at::FLASH_CR), 1 << 31);
    program(&mut chip, PAGE, Width::Word, 0);
    assert_eq!(word(&chip, PAGE), u32::MAX);
    let mut chip = unlocked();
    assert_eq!(chip.load(at::FLASH_CR), 0);
    chip.store(at::FLASH_CR, 1 << 31);
    assert_eq!(chip.load(at::FLASH_CR), 1 << 31);
}

#[test]
fn a_wrong_key_shuts_the_lock_until_the_next_reset() {
    for keys in [[0x4567_0123, 0], [0xCDEF_89AB, 0x4567_0123]] {
        let mut chip = Chip::new();
        for key in keys.into_iter().chain([0x4567_0123, 0xCDEF_89AB]) {
            chip.store(at::FLASH_KEYR, key);
        }
        assert_eq!(chip.load(at::FLASH_CR), 1 << 31, "{keys:x?}");
        chip.reset(virtual_crazyflie::soc::ResetCause::Software);
        chip.store(at::FLASH_KEYR, 0x4567_0123);
        chip.store(at::FLASH_KEYR, 0xCDEF_89AB);
        assert_eq!(chip.load(at::FLASH_CR), 0, "{keys:x?}");
    }
}

#[test]
fn the_end_of_an_operation_interrupts_where_it_is_asked_for() {
    let mut chip = unlocked();
    chip.store(at::FLASH_CR, PG | X32 | 1 << 24);
    chip.try_store(PAGE, Width::Word, 0).expect("programs");
    let due = chip.soc.due();
    assert_eq!(due, chip.now + 16 * 16);
    chip.pass_to(due);
    assert!(chip.line(4));
    chip.store(at::FLASH_SR, 1);
    assert!(!chip.line(4));
}

#[test]
fn the_running_program_cannot_be_changed() {
    let mut chip = unlocked();
    chip.soc.protect(0x0800_4000..0x0802_2000);
    chip.store(at::FLASH_CR, PG | X32);
    assert!(unmodelled(chip.try_store(0x0800_4000, Width::Word, 0)).contains("running program"));
    for (sector, is_refused) in [(0, false), (1, true), (4, true), (5, true), (6, false)] {
        let mut chip = unlocked();
        chip.soc.protect(0x0800_4000..0x0802_2000);
        let result = chip.try_store(at::FLASH_CR, Width::Word, 2 | sector << 3 | X32 | 1 << 16);
        assert_eq!(result.is_err(), is_refused, "sector {sector}");
    }
}

#[test]
fn the_brown_out_level_can_be_read_and_not_set() {
    let mut chip = Chip::new();
    assert_eq!(chip.load(at::FLASH_OPTCR), 0x0FFF_AAED);
    chip.store(0x4002_3C08, 0x0819_2A3B);
    chip.store(0x4002_3C08, 0x4C5D_6E7F);
    assert_eq!(chip.load(at::FLASH_OPTCR), 0x0FFF_AAEC);
    assert!(
        unmodelled(chip.try_store(at::FLASH_OPTCR, Width::Word, 0x0FFF_AAE0)).contains("option")
    );
}

#[test]
fn a_cache_is_reset_while_it_is_off() {
    let mut chip = Chip::new();
    chip.store(at::FLASH_ACR, 7 << 8);
    let refused = unmodelled(chip.try_store(at::FLASH_ACR, Width::Word, 7 << 8 | 1 << 12));
    assert!(refused.contains("FLASH_ACR"), "{refused}");
    chip.store(at::FLASH_ACR, 3 << 8 | 1 << 12);
    assert_eq!(chip.soc.flash_accelerator(), (true, true, false));
}
