//! The four motors: how to stop them, whatever else has happened, and how to drive them.
//!
//! Which pins and timers these are is the board's to say; a motor turns while its pin is high. The
//! pins are held low from the first instruction of `main`, because a floating gate is a motor that
//! may turn, and go to the timers when the control task takes [`Motors`].
//!
//! By registers, not by embassy's driver: that one checks each duty with an assertion, and a panic
//! is the last thing wanted between the controller and a motor.

use embassy_stm32::pac::gpio::vals::{Moder, Ot};
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
    // The timers too: a task that comes back to life must find them unconfigured.
    motor::reset_timers();
}

/// The right to drive them: there is one, in the control task.
pub(crate) struct Motors(());

impl Motors {
    /// Sets the timers up, with all motors off, and hands them the pins.
    pub(crate) fn take() -> Self {
        cortex_m::interrupt::free(|_| {
            motor::start();
            for pin in &PINS {
                let number = pin.number % 16;
                pin.port.afr(number / 8).modify(|w| w.set_afr(number % 8, pin.alternate));
                pin.port.moder().modify(|w| w.set_moder(number, Moder::ALTERNATE));
            }
        });
        Self(())
    }

    /// Drives each at its part of the battery's voltage; what is not a number stops its motor.
    pub(crate) fn set(&mut self, duties: Duties) {
        motor::compare(duties.0.map(|duty| {
            let steps = duty.clamp(0.0, 1.0) * f32::from(STEPS) + 0.5;
            // Saturates, and makes zero of what is not a number.
            steps as u16
        }));
    }
}
