//! Stops the four motors in any state of the firmware, and drives them.
//!
//! The board names their pins and timers; a motor turns while its pin is high. The pins are held low
//! from the first instruction of `main`, because a motor may turn while its gate floats, and are
//! handed to the timers when the control task takes [`Motors`].
//!
//! This module writes the registers itself: embassy's driver checks each duty with an assertion, and
//! a control step must not panic.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Ot};
use flight::Duties;

use crate::board::motor::{self, PINS, STEPS};

/// Takes the pins from whatever drives them and holds them low. It needs no set-up, keeps no
/// state and takes microseconds, so it may be called at any moment: from a fault handler too.
pub(crate) fn stop() {
    motor::power_ports();
    for pin in &PINS {
        let number = pin.number % 16;
        // The level first and the mode last, so that a pin is low as soon as it is an output.
        pin.port.bsrr().write(|w| w.set_br(number, true));
        pin.port.otyper().modify(|w| w.set_ot(number, Ot::PUSH_PULL));
        pin.port.moder().modify(|w| w.set_moder(number, Moder::OUTPUT));
    }
    // The timers too: a task that runs once more must find them unconfigured.
    motor::reset_timers();
}

/// Whether the motors are locked.
static LOCKED: AtomicBool = AtomicBool::new(false);

/// Locks the motors until the next reset: the pins are taken from the timers and held low, and
/// [`Motors`] drives them no more.
pub(crate) fn lock() {
    cortex_m::interrupt::free(|_| {
        LOCKED.store(true, Ordering::Relaxed);
        stop();
    });
}

/// Whether the motors are locked.
pub(crate) fn are_locked() -> bool {
    LOCKED.load(Ordering::Relaxed)
}

/// The right to drive the motors: there is one, in the control task.
pub(crate) struct Motors(());

impl Motors {
    /// Sets the timers up, with all motors off, and hands them the pins.
    pub(crate) fn take() -> Self {
        cortex_m::interrupt::free(|_| {
            motor::start();
            for pin in &PINS {
                let number = pin.number % 16;
                // A step of the timer is 12 ns; the slowest edge, which a pin has after a reset, takes
                // 100. The vendor's firmware sets the fastest, too (`motors.c`).
                pin.port.ospeedr().modify(|w| w.set_ospeedr(number, Ospeedr::VERY_HIGH_SPEED));
                pin.port.afr(number / 8).modify(|w| w.set_afr(number % 8, pin.alternate));
                pin.port.moder().modify(|w| w.set_moder(number, Moder::ALTERNATE));
            }
        });
        Self(())
    }

    /// Drives each motor at its part of the battery's voltage; a NaN stops its motor. Locked motors
    /// stay off.
    pub(crate) fn set(&mut self, duties: Duties) {
        if are_locked() {
            return;
        }
        motor::compare(duties.0.map(|duty| {
            let steps = duty.clamp(0.0, 1.0) * f32::from(STEPS) + 0.5;
            // The conversion saturates, and gives zero for a NaN.
            steps as u16
        }));
    }
}
