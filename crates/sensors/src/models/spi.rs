//! A chip alone on an SPI bus, as the wires see it.

use core::cell::RefCell;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_async::spi::SpiDevice;

use super::Wires;

/// A device on an SPI bus.
pub trait SpiModel {
    /// The chip is selected.
    fn select(&mut self);
    /// A byte goes either way.
    fn transfer(&mut self, byte: u8) -> u8;
    /// The chip is let go.
    fn deselect(&mut self);
    /// Time passes.
    fn advance(&mut self, nanos: u32);
}

/// The bus that a driver takes. Its time is the chip's own, and that of the wires given with it.
pub struct ModelSpi<'a> {
    chip: &'a RefCell<dyn SpiModel + 'a>,
    clock: &'a Wires<'a>,
}

/// A byte at 1.3 MHz in ns, which is what the deck's bus runs at.
const BYTE_NS: u32 = 6_100;

impl<'a> ModelSpi<'a> {
    /// A bus with one chip.
    #[must_use]
    pub const fn new(chip: &'a RefCell<dyn SpiModel + 'a>, clock: &'a Wires<'a>) -> Self {
        Self { chip, clock }
    }
}

impl ErrorType for ModelSpi<'_> {
    type Error = ErrorKind;
}

impl SpiDevice for ModelSpi<'_> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let Ok(mut chip) = self.chip.try_borrow_mut() else { return Err(ErrorKind::Other) };
        let mut elapsed = 0_u32;
        chip.select();
        for operation in operations {
            let mut exchange = |out: u8| {
                chip.advance(BYTE_NS);
                elapsed = elapsed.saturating_add(BYTE_NS);
                chip.transfer(out)
            };
            match operation {
                Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = exchange(0)),
                Operation::Write(bytes) => bytes.iter().for_each(|byte| {
                    exchange(*byte);
                }),
                Operation::TransferInPlace(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = exchange(*byte));
                }
                Operation::Transfer(incoming, outgoing) => {
                    let outgoing = outgoing.iter().copied().chain(core::iter::repeat(0));
                    for (byte, out) in incoming.iter_mut().zip(outgoing) {
                        *byte = exchange(out);
                    }
                }
                Operation::DelayNs(nanos) => {
                    chip.advance(*nanos);
                    elapsed = elapsed.saturating_add(*nanos);
                }
            }
        }
        chip.deselect();
        drop(chip);
        self.clock.advance(elapsed.div_ceil(1_000));
        Ok(())
    }
}
