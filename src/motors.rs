//! The four motor pins. Nothing drives them yet; they are held low from the first instruction of
//! `main`, because a floating gate is a motor that may turn.
//!
//! | motor | pin | timer |
//! |---|---|---|
//! | M1, front right | PA1 | TIM2, channel 2 |
//! | M2, back right | PB11 | TIM2, channel 4 |
//! | M3, back left | PA15 | TIM2, channel 1 |
//! | M4, front left | PB9 | TIM4, channel 4 |
//!
//! From crazyflie-firmware, `motors.h` and `motors_def.c`; a motor turns while its pin is high.

use embassy_stm32::pac::gpio::vals::{Moder, Ot};
use embassy_stm32::pac::{GPIOA, GPIOB, RCC};

/// Takes the pins from whatever drives them and holds them low. It needs no set-up, keeps no
/// state and takes microseconds, so it may be called at any moment: from a fault handler too.
pub(crate) fn stop() {
    RCC.ahb1enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpioben(true);
    });
    // A peripheral answers two cycles after its clock is enabled (STM32F405 errata sheet ES0182,
    // "Delay after an RCC peripheral clock enabling"); reading the register back takes them.
    let _ = RCC.ahb1enr().read();

    // The level first and the mode second, so that a pin is low as soon as it is an output.
    GPIOA.bsrr().write(|w| {
        w.set_br(1, true);
        w.set_br(15, true);
    });
    GPIOB.bsrr().write(|w| {
        w.set_br(11, true);
        w.set_br(9, true);
    });
    GPIOA.otyper().modify(|w| {
        w.set_ot(1, Ot::PUSH_PULL);
        w.set_ot(15, Ot::PUSH_PULL);
    });
    GPIOB.otyper().modify(|w| {
        w.set_ot(11, Ot::PUSH_PULL);
        w.set_ot(9, Ot::PUSH_PULL);
    });
    GPIOA.moder().modify(|w| {
        w.set_moder(1, Moder::OUTPUT);
        w.set_moder(15, Moder::OUTPUT);
    });
    GPIOB.moder().modify(|w| {
        w.set_moder(11, Moder::OUTPUT);
        w.set_moder(9, Moder::OUTPUT);
    });

    // The timers too: a task that comes back to life must find them unconfigured.
    RCC.apb1rstr().modify(|w| {
        w.set_tim2rst(true);
        w.set_tim4rst(true);
    });
    RCC.apb1rstr().modify(|w| {
        w.set_tim2rst(false);
        w.set_tim4rst(false);
    });
}
