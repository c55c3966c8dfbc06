//! Holds back what is sent to the radio chip while the chip's receiver is full.
//!
//! The chip's "wait" pin is the RTS of its serial port (crazyflie2-nrf-firmware, `uart.c`). It tells
//! of the six bytes of the port and not of the queue behind them: it rises when there is room for
//! four more, in the middle of a frame too, whenever the chip's core is slow to read. A task would
//! notice too late, as would one that checks between frames. So an interrupt of both edges stops the
//! DMA's requests and lets them go on, as in the vendor's firmware (`uart_syslink.c`, which stops the
//! DMA stream). Two bytes that the serial port has already taken are still sent.
//!
//! embassy's driver is not used for this pin, because it masks a line at each edge. It also handles
//! and masks all lines that are pending when another line's interrupt runs, so this one has a higher
//! priority than they, and is unmasked again before each frame.

use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::pac::gpio::vals::{Idr, Pupdr};
use embassy_stm32::pac::{EXTI, GPIOA, SYSCFG, USART6};
use embassy_stm32::peripherals::{EXTI4, PA4};
use embassy_stm32::{Peri, interrupt as handler};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// The pin PA4, and the interrupt line of that number.
const LINE: usize = 4;
/// The selection of port A for an interrupt line.
const PORT_A: u8 = 0;

/// The chip has room again.
static ROOM: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// The right to send to the chip: there is one.
pub(crate) struct FlowControl(());

impl FlowControl {
    /// Sets pin and interrupt up. A chip that is not driving its pin has no room.
    #[expect(
        unsafe_code,
        reason = "an interrupt is enabled; it shares nothing that it could break"
    )]
    pub(crate) fn new(_pin: Peri<'static, PA4>, _line: Peri<'static, EXTI4>) -> Self {
        cortex_m::interrupt::free(|_| {
            GPIOA.pupdr().modify(|w| w.set_pupdr(LINE, Pupdr::PULL_UP));
            SYSCFG.exticr(LINE / 4).modify(|w| w.set_exti(LINE % 4, PORT_A));
            EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
            EXTI.ftsr(0).modify(|w| w.set_line(LINE, true));
        });
        unmask();
        // SAFETY: the handler changes one bit of a register, and signals.
        unsafe { interrupt::EXTI4.enable() };
        Self(())
    }

    /// Waits until the chip has room.
    pub(crate) async fn wait_for_room(&mut self) {
        unmask();
        while is_full() {
            ROOM.wait().await;
        }
    }

    /// Polls something that may begin to send. A chip that has filled up meanwhile gets no more.
    pub(crate) fn guard<T>(&self, poll: impl FnOnce() -> T) -> T {
        guarded(poll)
    }
}

/// Polls something that writes the serial port's control register, without the interrupt in between,
/// whose change of that register would be lost. embassy's driver writes it where it begins to send,
/// and where it begins to receive again after an error.
pub(crate) fn guarded<T>(poll: impl FnOnce() -> T) -> T {
    cortex_m::interrupt::free(|_| {
        let result = poll();
        hold_or_send();
        result
    })
}

fn unmask() {
    cortex_m::interrupt::free(|_| EXTI.imr(0).modify(|w| w.set_line(LINE, true)));
}

fn is_full() -> bool {
    GPIOA.idr().read().idr(LINE) == Idr::HIGH
}

/// Lets the DMA feed the serial port while the chip has room.
fn hold_or_send() {
    let full = is_full();
    USART6.cr3().modify(|w| w.set_dmat(!full));
}

#[handler]
fn EXTI4() {
    EXTI.pr(0).write(|w| w.set_line(LINE, true));
    hold_or_send();
    if !is_full() {
        ROOM.signal(());
    }
}
