//! Why the chip started, and the watchdog that makes it start again.
//!
//! The independent watchdog has an oscillator of its own, and once started only a reset stops it.
//! Only the control task feeds it ([`crate::tasks::control`]), so it resets the chip when the control
//! executor no longer runs. [`crate::tasks::health`] checks the other tasks.

use embassy_stm32::pac::gpio::vals::Idr;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use embassy_stm32::pac::{DBGMCU, FLASH, GPIOA, GPIOC, IWDG, RCC};

/// The cause of a reset.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Cause {
    /// It was switched on.
    PowerOn,
    /// The supply dipped below the brown-out level.
    BrownOut,
    /// The watchdog was not fed.
    Watchdog,
    /// Software requested it: [`crate::safety::panic`], or the bootloader.
    Software,
    /// The reset pin: a probe, or the radio chip.
    Pin,
    /// A source that this firmware does not use.
    Other,
}

impl Cause {
    /// Whether the reset was unintended.
    pub(crate) const fn is_fault(self) -> bool {
        matches!(self, Self::BrownOut | Self::Watchdog)
    }
}

/// Takes the cause of the reset: the flags are cleared for the next time.
pub(crate) fn take_cause() -> Cause {
    let flags = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    // Each reset pulls the pin low as well, and power-on raises the brown-out flag too (RM0090,
    // RCC_CSR), so the flags are read in this order.
    if flags.wdgrstf() {
        Cause::Watchdog
    } else if flags.sftrstf() {
        Cause::Software
    } else if flags.porrstf() {
        Cause::PowerOn
    } else if flags.borrstf() {
        Cause::BrownOut
    } else if flags.padrstf() {
        Cause::Pin
    } else {
        Cause::Other
    }
}

/// The supply in mV below which the chip holds itself in reset, as its option bytes say. Read, and
/// never written: a wrong option byte locks a chip for good.
pub(crate) fn brown_out_millivolts() -> u16 {
    // STM32F405 data sheet, "Embedded reset and power control block": V_BOR, typical, falling edge;
    // without it the power-down reset's.
    match FLASH.optcr().read().bor_lev() {
        0 => 2_850,
        1 => 2_550,
        2 => 2_230,
        _ => 1_680,
    }
}

/// Waits until the radio chip is not sending, to be called before a reset, with the motors off.
///
/// The vendor's bootloader reads two lines of the chip in its first microseconds
/// (crazyflie2-stm-bootloader, `bootpin.c`): where the serial line (PC7) is low, as in every zero
/// bit, and "wait" (PA4) low, it starts ST's loader for USB instead of the firmware; where both are
/// high, it waits for an image. Then the drone does not come back before it is switched off and on.
/// Bytes of one frame follow each other without a gap, so a line that is high for longer than the ten
/// bits of a byte is at rest.
pub(crate) fn wait_for_quiet_line() {
    /// A turn of the loop takes 10 cycles or more of 168 MHz: 30 µs.
    const REST: u32 = 500;
    /// 6 ms or more.
    const TURNS: u32 = 100_000;
    // Before the board is set up nothing was sent to the chip, and the pins cannot be read.
    if !RCC.ahb1enr().read().gpiocen() {
        return;
    }
    let mut rests = 0;
    for _ in 0..TURNS {
        let is_idle = GPIOC.idr().read().idr(7) == Idr::HIGH;
        let has_room = GPIOA.idr().read().idr(4) == Idr::LOW;
        rests = if is_idle && has_room { rests + 1 } else { 0 };
        if rests >= REST {
            return;
        }
    }
}

/// Turns of the loop that waits for the watchdog's registers, in its own oscillator's clock: five
/// periods of 32 kHz or less, 160 µs; a turn takes 0.1 µs or more.
const TURNS: u32 = 10_000;

/// Starts the watchdog: it resets the chip unless it is fed within 189 periods of 1 kHz. Its
/// oscillator runs at 17 to 47 kHz (STM32F405 data sheet, LSI), so that is 129 to 356 ms. The values
/// are those of crazyflie-firmware's `watchdog.h`.
///
/// While a probe has halted the processor, watchdog and time stand still, but the motors go on.
pub(crate) fn start_watchdog() {
    DBGMCU.apb1fzr().modify(|w| {
        w.set_iwdg(true);
        w.set_tim5(true);
    });
    IWDG.kr().write(|w| w.set_key(Key::START));
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY32));
    IWDG.rlr().write(|w| w.set_rl(188));
    // Feeding it earlier would load the old value: 4096 periods of 8 kHz, which is 512 ms.
    let _ = (0..TURNS).any(|_| !IWDG.sr().read().pvu() && !IWDG.sr().read().rvu());
    feed_watchdog();
}

/// Feeds the watchdog.
pub(crate) fn feed_watchdog() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}
