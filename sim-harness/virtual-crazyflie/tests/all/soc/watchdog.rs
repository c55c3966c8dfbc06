//! The independent watchdog: when it bites, by its own oscillator.

use super::{Chip, at, unmodelled};
use virtual_crazyflie::bus::{Bus, Width};
use virtual_crazyflie::soc::{Nanos, ResetCause, SocConfig};

/// A watchdog as the firmware starts it: 189 counts of a 32nd of its oscillator.
fn started(lsi_hz: u32) -> Chip {
    let mut chip = Chip::with(SocConfig { lsi_hz, ..SocConfig::default() });
    chip.store(at::IWDG_KR, 0x5555);
    chip.store(at::IWDG_KR, 0xCCCC);
    chip.store(at::IWDG_KR, 0x5555);
    chip.store(at::IWDG_PR, 3);
    chip.store(at::IWDG_RLR, 188);
    let mut turns = 0;
    while chip.load(at::IWDG_SR) != 0 {
        chip.pass(16);
        turns += 1;
    }
    assert!((1..10_000).contains(&turns));
    chip.store(at::IWDG_KR, 0xAAAA);
    chip
}

/// How long until it bites, in µs.
fn bites_after(chip: &mut Chip) -> Nanos {
    let start = chip.nanos();
    chip.pass(16_000_000);
    assert!(chip.soc.watchdog_bites());
    (chip.nanos() - start) / 1000
}

#[test]
fn it_bites_when_its_own_oscillator_says_so() {
    for (lsi_hz, micros) in [(32_000, 189_000), (17_000, 355_764), (47_000, 128_680)] {
        assert_eq!(bites_after(&mut started(lsi_hz)), micros, "at {lsi_hz} Hz");
    }
}

#[test]
fn fed_in_time_it_does_not_bite() {
    let mut chip = started(32_000);
    for _ in 0..100 {
        chip.pass(16_000 * 188);
        chip.store(at::IWDG_KR, 0xAAAA);
    }
    assert!(!chip.soc.watchdog_bites());
    assert_eq!(bites_after(&mut chip), 189_000);
}

#[test]
fn its_time_does_not_follow_the_cores_clock() {
    let mut chip = started(32_000);
    let start = chip.nanos();
    chip.start_clocks();
    chip.pass(168_000_000);
    assert!(chip.soc.watchdog_bites());
    assert_eq!((chip.nanos() - start) / 1000, 189_000);
}

#[test]
fn a_bite_holds_the_chip_in_reset_and_leaves_a_flag() {
    let mut chip = started(32_000);
    bites_after(&mut chip);
    assert!(chip.soc.resets());
    chip.reset(ResetCause::Watchdog);
    assert!(!chip.soc.resets());
    assert_ne!(chip.load(at::RCC_CSR) & 1 << 29, 0);
    chip.pass(16_000_000);
    assert!(!chip.soc.watchdog_bites(), "it has stopped");
}

#[test]
fn registers_are_protected_until_they_are_unlocked() {
    let mut chip = Chip::new();
    chip.store(at::IWDG_PR, 3);
    chip.store(at::IWDG_RLR, 188);
    assert_eq!((chip.load(at::IWDG_PR), chip.load(at::IWDG_RLR)), (0, 0xFFF));
    chip.store(at::IWDG_KR, 0x5555);
    chip.store(at::IWDG_RLR, 188);
    assert_eq!(chip.load(at::IWDG_SR), 2);
    assert!(unmodelled(chip.try_store(at::IWDG_RLR, Width::Word, 7)).contains("update"));
    chip.store(at::IWDG_KR, 0xAAAA);
    chip.store(at::IWDG_PR, 3);
    assert_eq!(chip.load(at::IWDG_PR), 0, "locked again");
}

#[test]
fn an_update_takes_five_periods_of_the_oscillator() {
    let mut chip = Chip::new();
    chip.store(at::IWDG_KR, 0x5555);
    chip.store(at::IWDG_PR, 3);
    chip.pass_until(156_000);
    assert_eq!(chip.load(at::IWDG_SR), 1);
    chip.pass_until(157_000);
    assert_eq!(chip.load(at::IWDG_SR), 0);
}

#[test]
fn fed_before_the_reload_value_is_there_it_takes_the_old_one() {
    let mut chip = Chip::new();
    chip.store(at::IWDG_KR, 0xCCCC);
    chip.store(at::IWDG_KR, 0x5555);
    chip.store(at::IWDG_RLR, 188);
    chip.store(at::IWDG_KR, 0xAAAA);
    // 4096 counts of a quarter of 32 kHz.
    assert_eq!(bites_after(&mut chip) / 1000, 512);
}
