//! Timers as embassy's time driver uses TIM5 and as the motors use TIM2 and TIM4.

use super::{Chip, at, unmodelled};
use virtual_crazyflie::bus::Width;
use virtual_crazyflie::soc::{Pin, PinOutput};

const CR1: u32 = 0x00;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCMR2: u32 = 0x1C;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const CCR1: u32 = 0x34;
const CCR2: u32 = 0x38;
const CCR4: u32 = 0x40;

/// NVIC's number.
const TIM5_LINE: u32 = 50;
const UIF: u32 = 1;
const CC1IF: u32 = 2;
const CC2IF: u32 = 4;

/// A chip at 168 MHz, and TIM5 as embassy's time driver leaves it: 1 MHz, 16 bits.
fn time_driver() -> Chip {
    let mut chip = Chip::new();
    chip.start_clocks();
    chip.modify(at::RCC_APB1ENR, 0, 1 << 3);
    chip.modify(at::RCC_APB1RSTR, 0, 1 << 3);
    chip.modify(at::RCC_APB1RSTR, 1 << 3, 0);
    chip.modify(at::TIM5 + CR1, 1, 0);
    chip.store(at::TIM5 + CNT, 0);
    chip.store(at::TIM5 + PSC, 83);
    chip.store(at::TIM5 + ARR, 0xFFFF);
    chip.modify(at::TIM5 + CR1, 0, 1 << 2);
    chip.store(at::TIM5 + EGR, 1);
    chip.modify(at::TIM5 + CR1, 1 << 2, 0);
    chip.store(at::TIM5 + CCR1, 0x8000);
    chip.store(at::TIM5 + DIER, UIF | CC1IF);
    chip.modify(at::TIM5 + CR1, 0, 1);
    chip
}

#[test]
fn an_update_that_software_makes_is_not_flagged_when_urs_says_so() {
    let mut chip = time_driver();
    assert_eq!(chip.load(at::TIM5 + SR), 0);
    assert!(!chip.line(TIM5_LINE));
    // Without URS it is.
    chip.store(at::TIM5 + EGR, 1);
    assert_eq!(chip.load(at::TIM5 + SR) & UIF, UIF);
}

#[test]
fn a_microsecond_is_168_cycles() {
    let mut chip = time_driver();
    let start = chip.now;
    for (cycles, count) in [(167, 0), (168, 1), (335, 1), (168_000, 1000), (168 * 65_535, 65_535)] {
        chip.pass_to(start + cycles);
        assert_eq!(chip.load(at::TIM5 + CNT), count, "after {cycles} cycles");
    }
}

#[test]
fn half_and_full_periods_interrupt_at_their_cycles() {
    let mut chip = time_driver();
    let start = chip.now;
    assert_eq!(chip.soc.watchdog_due(), None);
    chip.pass_to(start + 168 * 0x8000 - 1);
    assert!(!chip.line(TIM5_LINE));
    chip.pass(1);
    assert!(chip.line(TIM5_LINE));
    assert_eq!(chip.load(at::TIM5 + SR) & (UIF | CC1IF), CC1IF);
    chip.store(at::TIM5 + SR, !CC1IF);
    assert!(!chip.line(TIM5_LINE));
    chip.pass_to(start + 168 * 0x1_0000 - 1);
    assert!(!chip.line(TIM5_LINE));
    chip.pass(1);
    assert!(chip.line(TIM5_LINE));
    assert_eq!(chip.load(at::TIM5 + SR) & (UIF | CC1IF), UIF);
    assert_eq!(chip.load(at::TIM5 + CNT), 0);
}

#[test]
fn an_alarm_comes_when_the_counter_reaches_it_and_not_when_it_has_passed() {
    let mut chip = time_driver();
    let start = chip.now;
    chip.store(at::TIM5 + CCR2, 100);
    chip.modify(at::TIM5 + DIER, 0, CC2IF);
    chip.pass_to(start + 168 * 100 - 1);
    assert!(!chip.line(TIM5_LINE));
    chip.pass(1);
    assert!(chip.line(TIM5_LINE));
    chip.store(at::TIM5 + SR, !CC2IF);
    // One that lies behind comes a whole period later.
    chip.store(at::TIM5 + CCR2, 50);
    chip.pass_to(start + 168 * 0x7FFF);
    assert!(!chip.line(TIM5_LINE));
    chip.pass_to(start + 168 * 0x1_0000);
    chip.store(at::TIM5 + SR, !(UIF | CC1IF));
    assert!(!chip.line(TIM5_LINE));
    chip.pass_to(start + 168 * (0x1_0000 + 50));
    assert!(chip.line(TIM5_LINE));
}

#[test]
fn a_flag_is_set_whether_or_not_its_interrupt_is_enabled() {
    let mut chip = time_driver();
    chip.store(at::TIM5 + CCR2, 10);
    chip.pass(168 * 20);
    assert!(!chip.line(TIM5_LINE));
    assert_eq!(chip.load(at::TIM5 + SR) & CC2IF, CC2IF);
    chip.modify(at::TIM5 + DIER, 0, CC2IF);
    assert!(chip.line(TIM5_LINE));
}

#[test]
fn flags_are_cleared_by_zeros_alone() {
    let mut chip = time_driver();
    chip.store(at::TIM5 + EGR, UIF | CC1IF | CC2IF);
    chip.store(at::TIM5 + SR, !CC1IF);
    assert_eq!(chip.load(at::TIM5 + SR), UIF | CC2IF);
    chip.store(at::TIM5 + SR, u32::MAX);
    assert_eq!(chip.load(at::TIM5 + SR), UIF | CC2IF);
}

#[test]
fn no_microsecond_is_lost_in_an_hour_of_polling_or_of_none() {
    let mut looked_at = time_driver();
    let mut left_alone = time_driver();
    let start = looked_at.now;
    let mut periods = 0_u64;
    for step in 1..=20_000_u64 {
        looked_at.pass_to(start + step * 30_240_001);
        if looked_at.load(at::TIM5 + SR) & UIF != 0 {
            looked_at.store(at::TIM5 + SR, !UIF);
            periods += 1;
        }
    }
    assert!(periods > 10_000);
    left_alone.pass_to(looked_at.now);
    let count = looked_at.load(at::TIM5 + CNT);
    assert_eq!(u64::from(count), (looked_at.now - start) / 168 % 0x1_0000);
    assert_eq!(left_alone.load(at::TIM5 + CNT), count);
}

#[test]
fn a_prescaler_comes_into_force_at_the_update() {
    let mut chip = time_driver();
    let start = chip.now;
    chip.store(at::TIM5 + PSC, 41);
    chip.pass_to(start + 168 * 1000);
    assert_eq!(chip.load(at::TIM5 + CNT), 1000);
    chip.pass_to(start + 168 * 0x1_0000 + 84 * 10);
    assert_eq!(chip.load(at::TIM5 + CNT), 10);
}

#[test]
fn a_timer_follows_its_clock() {
    let mut chip = time_driver();
    let start = chip.now;
    chip.pass_to(start + 168 * 10);
    // PCLK1 is HCLK over 8 instead of 4.
    chip.store(at::RCC_CFGR, 2 | 6 << 10 | 4 << 13);
    chip.pass(336 * 5);
    assert_eq!(chip.load(at::TIM5 + CNT), 15);
}

#[test]
fn a_timer_whose_gate_is_shut_stands_still() {
    let mut chip = time_driver();
    let start = chip.now;
    chip.pass_to(start + 168 * 10);
    chip.modify(at::RCC_APB1ENR, 1 << 3, 0);
    chip.pass(168 * 1000);
    chip.modify(at::RCC_APB1ENR, 0, 1 << 3);
    assert_eq!(chip.load(at::TIM5 + CNT), 10);
    chip.pass(168);
    assert_eq!(chip.load(at::TIM5 + CNT), 11);
}

#[test]
fn widths_are_32_bits_for_tim2_and_tim5_and_16_for_the_others() {
    let mut chip = Chip::new();
    chip.modify(at::RCC_APB1ENR, 0, 5);
    chip.modify(at::RCC_APB2ENR, 0, 1 << 17);
    for (timer, full) in [(at::TIM2, u32::MAX), (at::TIM4, 0xFFFF), (at::TIM10, 0xFFFF)] {
        assert_eq!(chip.load(timer + ARR), full);
        chip.store(timer + CNT, u32::MAX);
        assert_eq!(chip.load(timer + CNT), full);
    }
    // TIM10 has one channel.
    assert!(unmodelled(chip.try_load(at::TIM10 + CCR2, Width::Word)).contains("does not have"));
}

#[test]
fn what_is_not_modelled_is_refused() {
    let mut chip = Chip::new();
    chip.modify(at::RCC_APB1ENR, 0, 1);
    for (register, value, what) in [
        (CR1, 1 << 3, "one-pulse"),
        (CR1, 1 << 4, "down"),
        (CR1, 1 << 5, "down"),
        (SMCR, 7, "slave"),
        (DIER, 1 << 8, "DMA"),
        (CCMR1, 1, "capture"),
        (CCMR1, 3 << 4, "toggle"),
        (0x48, 1, "bursts"),
        (0x50, 1 << 10, "remapping"),
    ] {
        let refused = unmodelled(chip.try_store(at::TIM2 + register, Width::Word, value));
        assert!(refused.contains(what), "{register:#x} {value:#x}: {refused}");
    }
}

/// M1, M2 and M3 of TIM2, M4 of TIM4, with the pins' ports on.
const M1: Pin = Pin::new('A', 1);
const M4: Pin = Pin::new('B', 9);
const GPIOA: u32 = 0x4002_0000;
const GPIOB: u32 = 0x4002_0400;

/// As the firmware starts its motors: 256 steps, PWM mode 1, preloaded.
fn motors() -> Chip {
    let mut chip = Chip::new();
    chip.start_clocks();
    chip.modify(at::RCC_AHB1ENR, 0, 3);
    chip.modify(at::RCC_APB1ENR, 0, 5);
    chip.store(at::TIM2 + CCMR1, 0x6868);
    chip.store(at::TIM2 + CCMR2, 0x6800);
    chip.store(at::TIM2 + CCER, 0x1011);
    chip.store(at::TIM4 + CCMR2, 0x6800);
    chip.store(at::TIM4 + CCER, 0x1000);
    for timer in [at::TIM2, at::TIM4] {
        chip.store(timer + ARR, 255);
        chip.store(timer + CCR2, 0);
        chip.store(timer + CCR4, 0);
        chip.store(timer + EGR, 1);
        chip.modify(timer + CR1, 0, 1);
    }
    chip.modify(GPIOA + 0x20, 0xF0, 0x10);
    chip.modify(GPIOA, 0xC, 8);
    chip.modify(GPIOB + 0x24, 0xF0, 0x20);
    chip.modify(GPIOB, 3 << 18, 2 << 18);
    chip
}

fn output(chip: &Chip, pin: Pin) -> PinOutput {
    chip.soc.output(pin, chip.now)
}

#[test]
fn a_motor_sees_the_duty_from_the_next_period_on() {
    let mut chip = motors();
    assert_eq!(output(&chip, M1), PinOutput::Low);
    chip.store(at::TIM2 + CCR2, 64);
    assert_eq!(output(&chip, M1), PinOutput::Low, "this period");
    chip.pass(2 * 256);
    assert_eq!(output(&chip, M1), PinOutput::Pwm { duty: 0.25, hz: 328_125.0 });
    assert_eq!(output(&chip, M4), PinOutput::Low);
    chip.store(at::TIM4 + CCR4, 192);
    chip.store(at::TIM2 + CCR2, 256);
    chip.pass(2 * 256);
    assert_eq!(output(&chip, M1), PinOutput::High, "all of the period");
    assert_eq!(output(&chip, M4), PinOutput::Pwm { duty: 0.75, hz: 328_125.0 });
}

#[test]
fn a_pin_that_is_an_output_is_what_it_says_whatever_the_timer_does() {
    let mut chip = motors();
    chip.store(at::TIM2 + CCR2, 128);
    chip.pass(1000);
    assert!(matches!(output(&chip, M1), PinOutput::Pwm { .. }));
    // As `motors::stop` does it.
    chip.store(GPIOA + 0x18, 1 << 17);
    chip.modify(GPIOA, 0xC, 4);
    assert_eq!(output(&chip, M1), PinOutput::Low);
    chip.store(GPIOA + 0x18, 1 << 1);
    assert_eq!(output(&chip, M1), PinOutput::High);
    chip.modify(GPIOA, 0xC, 0);
    assert_eq!(output(&chip, M1), PinOutput::Input);
}

#[test]
fn a_timer_that_is_reset_turns_no_motor() {
    let mut chip = motors();
    chip.store(at::TIM2 + CCR2, 128);
    chip.pass(1000);
    chip.modify(at::RCC_APB1RSTR, 0, 5);
    assert_eq!(output(&chip, M1), PinOutput::Input, "its channel is off");
    assert!(unmodelled(chip.try_load(at::TIM2, Width::Word)).contains("held in reset"));
    chip.modify(at::RCC_APB1RSTR, 5, 0);
    assert_eq!(chip.load(at::TIM2 + CCR2), 0);
}

#[test]
fn a_wrong_clock_is_a_wrong_frequency() {
    let mut chip = motors();
    chip.store(at::TIM2 + CCR2, 128);
    chip.store(at::RCC_CFGR, 2 | 6 << 10 | 4 << 13);
    chip.pass(4096);
    assert_eq!(output(&chip, M1), PinOutput::Pwm { duty: 0.5, hz: 164_062.5 });
}
