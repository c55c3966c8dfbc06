//! An SPI bus with a model of one chip on it.

use core::cell::RefCell;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_async::spi::SpiDevice;

use super::Wires;

/// A device on an SPI bus, driven byte by byte.
pub trait SpiModel {
    /// Selects the chip.
    fn select(&mut self);
    /// Exchanges a byte: takes the controller's and returns the chip's.
    fn transfer(&mut self, byte: u8) -> u8;
    /// Deselects the chip.
    fn deselect(&mut self);
    /// Lets `nanos` ns pass.
    fn advance(&mut self, nanos: u32);
}

/// The SPI bus for a driver. It advances the time of the chip, and the clock of the given wires.
pub struct ModelSpi<'a> {
    chip: &'a RefCell<dyn SpiModel + 'a>,
    clock: &'a Wires<'a>,
}

/// Time of a byte in ns at 1.3 MHz, the clock of the deck's bus.
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
