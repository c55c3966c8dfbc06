//! Clocks as firmware sets them up: what comes out, what takes time, and what is an error.

use super::{Chip, at, unmodelled};
use virtual_crazyflie::bus::{Refused, Width};
use virtual_crazyflie::soc::{ResetCause, SocConfig};

const WORD: Width = Width::Word;

#[test]
fn the_chip_starts_at_16_mhz_and_the_firmware_makes_168_of_it() {
    let mut chip = Chip::new();
    assert_eq!(chip.soc.core_hz(), 16e6);
    chip.start_clocks();
    assert_eq!(chip.soc.core_hz(), 168e6);
    assert_eq!(chip.soc.bus_dividers(), (4, 2));
}

#[test]
fn the_crystal_takes_2_ms_and_the_pll_some_time_more() {
    let mut chip = Chip::new();
    chip.modify(at::RCC_CR, 0, 1 << 16);
    chip.pass_until(1_990_000);
    assert_eq!(chip.load(at::RCC_CR) & 1 << 17, 0);
    chip.pass_until(2_010_000);
    assert_ne!(chip.load(at::RCC_CR) & 1 << 17, 0);
    chip.store(at::RCC_PLLCFGR, 8 | 336 << 6 | 1 << 22 | 7 << 24);
    chip.modify(at::RCC_CR, 0, 1 << 24);
    assert_eq!(chip.load(at::RCC_CR) & 1 << 25, 0);
    chip.pass_until(2_300_000);
    assert_ne!(chip.load(at::RCC_CR) & 1 << 25, 0);
}

#[test]
fn a_broken_crystal_never_comes() {
    let mut chip = Chip::with(SocConfig { hse_hz: None, ..SocConfig::default() });
    chip.modify(at::RCC_CR, 0, 1 << 16);
    chip.pass_until(1_000_000_000);
    assert_eq!(chip.load(at::RCC_CR) & 1 << 17, 0);
}

#[test]
fn a_moment_is_the_same_before_and_after_the_change() {
    let mut chip = Chip::new();
    chip.start_clocks();
    let (now, before) = (chip.now, chip.nanos());
    assert_eq!(chip.soc.nanos(now + 168_000) - before, 1_000_000);
}

#[test]
fn a_switch_waits_for_an_oscillator_that_is_not_ready() {
    let mut chip = Chip::new();
    chip.modify(at::RCC_CR, 0, 1 << 16);
    chip.store(at::RCC_CFGR, 1);
    assert_eq!(chip.load(at::RCC_CFGR) & 15, 1, "asked for, and not there");
    chip.pass_until(2_000_001);
    assert_eq!(chip.load(at::RCC_CFGR) & 15, 5);
    assert_eq!(chip.soc.core_hz(), 8e6);
    // What drives the system cannot be switched off.
    chip.modify(at::RCC_CR, 1 << 16, 0);
    assert_ne!(chip.load(at::RCC_CR) & 1 << 17, 0);
}

#[test]
fn a_pll_outside_its_limits_is_an_error() {
    // M, N and Q, from 16 MHz.
    for (m, n, q, what) in [
        (1, 100, 7, "PLLM below 2"),
        (16, 433, 7, "PLLN"),
        (16, 49, 7, "PLLN"),
        (7, 100, 7, "0.95 to 2.1 MHz"),
        (20, 400, 7, "0.95 to 2.1 MHz"),
        (16, 99, 7, "100 to 432 MHz"),
        (8, 336, 7, "100 to 432 MHz"),
        (16, 336, 1, "PLLQ below 2"),
    ] {
        let mut chip = Chip::new();
        chip.store(at::RCC_PLLCFGR, m | n << 6 | q << 24);
        let refused = unmodelled(chip.try_store(at::RCC_CR, WORD, 0x0100_0083));
        assert!(refused.contains(what), "{m} {n} {q}: {refused}");
    }
}

#[test]
fn too_few_wait_states_are_an_error() {
    for (states, is_enough) in [(4, false), (5, true)] {
        let mut chip = Chip::new();
        chip.store(at::RCC_PLLCFGR, 16 | 336 << 6 | 7 << 24);
        chip.modify(at::RCC_CR, 0, 1 << 24);
        chip.pass_until(1_000_000);
        chip.store(at::FLASH_ACR, states);
        chip.store(at::RCC_CFGR, 2 | 5 << 10 | 4 << 13);
        assert_eq!(chip.soc.trouble().is_none(), is_enough, "{states} wait states");
    }
}

#[test]
fn buses_and_core_have_their_limits() {
    for (prescalers, what) in [(4 << 10 | 4 << 13, "PCLK1"), (5 << 10, "PCLK2"), (0, "PCLK1")] {
        let mut chip = Chip::new();
        chip.store(at::RCC_PLLCFGR, 16 | 336 << 6 | 7 << 24);
        chip.modify(at::RCC_CR, 0, 1 << 24);
        chip.pass_until(1_000_000);
        chip.store(at::FLASH_ACR, 5);
        let refused = unmodelled(chip.try_store(at::RCC_CFGR, WORD, 2 | prescalers));
        assert!(refused.contains(what), "{refused}");
    }
    let mut chip = Chip::new();
    chip.store(at::RCC_PLLCFGR, 16 | 400 << 6 | 7 << 24);
    chip.modify(at::RCC_CR, 0, 1 << 24);
    chip.pass_until(1_000_000);
    chip.store(at::FLASH_ACR, 6);
    let refused = unmodelled(chip.try_store(at::RCC_CFGR, WORD, 2 | 5 << 10 | 5 << 13));
    assert!(refused.contains("HCLK above 168 MHz"), "{refused}");
}

#[test]
fn the_pll_is_not_set_while_it_runs() {
    let mut chip = Chip::new();
    chip.start_clocks();
    let refused =
        unmodelled(chip.try_store(at::RCC_PLLCFGR, WORD, 8 | 192 << 6 | 1 << 22 | 7 << 24));
    assert!(refused.contains("while the PLL is on"), "{refused}");
}

#[test]
fn a_peripheral_without_a_clock_is_an_error_and_one_that_is_missing_a_fault() {
    let mut chip = Chip::new();
    assert!(unmodelled(chip.try_load(at::TIM5, WORD)).contains("clock is off"));
    assert!(unmodelled(chip.try_store(0x4002_0018, WORD, 1)).contains("GPIO port whose clock"));
    assert!(unmodelled(chip.try_load(0x4001_2000, WORD)).contains("ADC"));
    assert!(unmodelled(chip.try_load(0x4000_6400, WORD)).contains("CAN1"));
    assert!(unmodelled(chip.try_load(0x5006_0800, WORD)).contains("clock is off"));
    assert!(unmodelled(chip.try_load(0x4000_7400, WORD)).contains("DAC"));
    // Ethernet, the camera and the hash unit are in other chips of the family.
    for nothing in [0x4002_8000, 0x5005_0000, 0x5006_0400, 0x4000_2400, 0x3000_0000] {
        assert_eq!(chip.try_load(nothing, WORD), Err(Refused::Fault), "{nothing:#x}");
    }
}

#[test]
fn reset_causes_add_up_until_they_are_cleared() {
    let mut chip = Chip::new();
    assert_eq!(chip.load(at::RCC_CSR), 0x0E00_0000);
    chip.reset(ResetCause::Software);
    assert_eq!(chip.load(at::RCC_CSR), 0x1E00_0000);
    chip.store(at::RCC_CSR, 1 << 24);
    assert_eq!(chip.load(at::RCC_CSR), 0);
    chip.reset(ResetCause::Watchdog);
    assert_eq!(chip.load(at::RCC_CSR), 0x2400_0000);
    chip.store(at::RCC_CSR, 1 << 24);
    chip.reset(ResetCause::BrownOut);
    assert_eq!(chip.load(at::RCC_CSR), 0x0600_0000);
    chip.store(at::RCC_CSR, 1 << 24);
    chip.reset(ResetCause::Pin);
    assert_eq!(chip.load(at::RCC_CSR), 0x0400_0000);
    chip.reset(ResetCause::PowerOn);
    assert_eq!(chip.load(at::RCC_CSR), 0x0E00_0000);
}

#[test]
fn a_reset_takes_the_clocks_back() {
    let mut chip = Chip::new();
    chip.start_clocks();
    let before = chip.nanos();
    chip.reset(ResetCause::Software);
    assert_eq!(chip.soc.core_hz(), 16e6);
    assert_eq!(chip.nanos(), before);
    assert_eq!(chip.load(at::RCC_CFGR), 0);
    assert_eq!(chip.load(at::FLASH_ACR), 0);
}

#[test]
fn backup_registers_are_written_when_they_may_be_and_outlive_resets() {
    const BKP0: u32 = 0x4000_2850;
    let mut chip = Chip::new();
    chip.store(BKP0, 1);
    assert_eq!(chip.load(BKP0), 0, "protected");
    chip.modify(at::RCC_APB1ENR, 0, 1 << 28);
    chip.modify(at::PWR_CR, 0, 1 << 8);
    chip.store(BKP0, 0x1234);
    chip.reset(ResetCause::Watchdog);
    assert_eq!(chip.load(BKP0), 0x1234);
    chip.reset(ResetCause::PowerOn);
    assert_eq!(chip.load(BKP0), 0);
}

#[test]
fn the_chip_says_what_it_is() {
    let mut chip = Chip::new();
    assert_eq!(chip.load(0xE004_2000) & 0xFFF, 0x413);
    assert_eq!(chip.try_load(0x1FFF_7A22, Width::Half), Ok(1024));
    assert_eq!(chip.load(0x1FFF_7A10), SocConfig::default().unique_id[0]);
    // Reserved bits read as one; BOR is off, and the chip is not protected.
    assert_eq!(chip.try_load(0x1FFF_C000, Width::Half), Ok(0xAAEF));
}

#[test]
fn the_machine_is_notified_of_what_concerns_the_core() {
    let mut chip = Chip::new();
    chip.soc.take_change();
    chip.store(at::FLASH_ACR, 7 << 8);
    assert!(chip.soc.take_change());
    assert_eq!(chip.soc.flash_accelerator(), (true, true, true));
    assert!(!chip.soc.counts_in_sleep());
    chip.store(0xE004_2004, 7);
    assert!(chip.soc.take_change());
    assert!(chip.soc.counts_in_sleep());
    // The debugger's registers outlive all but power-on.
    chip.reset(ResetCause::Software);
    assert!(chip.soc.counts_in_sleep());
    chip.reset(ResetCause::PowerOn);
    assert!(!chip.soc.counts_in_sleep());
}
