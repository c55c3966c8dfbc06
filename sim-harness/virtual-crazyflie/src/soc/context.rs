//! The interface of a peripheral, and the context that it gets with every access.
//!
//! Time is in cycles of the core, which is HCLK. A bus cycle of APB1 is
//! [`Clocks::apb1`] of them, one of APB2 [`Clocks::apb2`], so what is clocked by a bus stays right
//! when the frequency changes; only what happens outside the chip is in nanoseconds.

use crate::bus::{Refused, Width};
use crate::memory::Memory;
use crate::soc::clocks::Clocks;
use crate::soc::gpio::Pins;
use crate::soc::wiring::{Board, Nanos, Pin};

/// The world as a peripheral sees it at one moment.
pub(crate) struct Context<'a, B> {
    /// The cycle of the core. It never runs backwards.
    pub(crate) now: u64,
    /// The clocks, and the conversion of cycles to nanoseconds and back.
    pub(crate) clocks: &'a Clocks,
    /// The board at the pins, already advanced to `now`.
    pub(crate) board: &'a mut B,
    /// The pins' modes.
    pub(crate) pins: &'a Pins,
}

impl<B: Board> Context<'_, B> {
    /// The moment, for the board.
    pub(crate) fn nanos(&self) -> Nanos {
        self.clocks.nanos(self.now)
    }

    /// Whether a pin is in this alternate function (GPIO_MODER, GPIO_AFRL): whether a peripheral
    /// reaches the board through it.
    pub(crate) fn connected(&self, pin: Pin, function: u8) -> bool {
        self.pins.alternate(pin) == Some(function)
    }
}

/// A peripheral of 1 KiB or so of registers. `offset` is a multiple of four below its size; a
/// narrower store to a peripheral of an APB comes with the value repeated in all lanes, as the
/// bridge does it (RM0090, "Memory and bus architecture").
pub(crate) trait Peripheral<B: Board> {
    /// A load of the whole register.
    fn read(&mut self, offset: u32, context: &mut Context<'_, B>) -> Result<u32, Refused>;

    /// A store to the whole register.
    fn write(
        &mut self,
        offset: u32,
        value: u32,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused>;

    /// The cycle at which something will happen by itself; `u64::MAX` for never. It may change
    /// with every call of another method.
    fn due(&self) -> u64;

    /// Everything happens that is due at `context.now`. Called at or soon after [`Self::due`]; more
    /// than one thing may be due, each at its own moment.
    fn advance(&mut self, context: &mut Context<'_, B>);

    /// The levels of its interrupt lines, as bits of the NVIC's numbers.
    fn lines(&self) -> u128;

    /// As after a reset: RCC's bit for it, or the whole chip's. Nothing that it has driven stays.
    fn reset(&mut self);
}

/// A peripheral's request to DMA.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    I2cReceive(usize),
    I2cTransmit(usize),
    Spi1Receive,
    Spi1Transmit,
    Usart6Receive,
    Usart6Transmit,
}

/// The ports of a DMA controller besides memory. The moment is the same throughout one call.
pub(crate) trait Reach {
    /// Whether the peripheral wants a transfer now.
    fn requests(&self, request: Request) -> bool;
    /// A load from a peripheral's address.
    fn load(&mut self, address: u32, width: Width) -> Result<u32, Refused>;
    /// A store to one.
    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), Refused>;
    /// The stream that serves this request has one transfer left (I2C_CR2, LAST).
    fn one_left(&mut self, request: Request);
    /// Stops the machine: a unit needs a function that this emulator does not model.
    /// A problem that arises in an access is [`Refused`] instead.
    fn complain(&mut self, what: &'static str);
}

/// A DMA controller. Its registers are words, and it drives nothing outside the chip, so it needs
/// no [`Context`]: `now` is the cycle.
pub(crate) trait Transfers {
    fn read(&mut self, offset: u32, now: u64) -> Result<u32, Refused>;
    fn write(&mut self, offset: u32, value: u32, now: u64) -> Result<(), Refused>;
    /// The cycle at which it wants [`Self::advance`] for what it has begun. A request that comes up
    /// needs no moment: `advance` follows each access and each event.
    fn due(&self) -> u64;
    /// Serves requests as far as there is time up to `now`; whether anything was moved.
    fn advance<R: Reach>(&mut self, now: u64, memory: &mut Memory, reach: &mut R) -> bool;
    /// The levels of its eight interrupt lines, stream 0 in bit 0.
    fn lines(&self) -> u8;
    fn reset(&mut self);
}
