//! A bus that counts what goes wrong on it.

use embedded_hal::i2c::{Error as _, ErrorKind, ErrorType, Operation};
use embedded_hal_async::i2c::I2c;

/// Passes everything on, and remembers how it went.
#[derive(Debug)]
pub(super) struct Counted<I2C> {
    i2c: I2C,
    tried: u16,
    broken: u16,
}

impl<I2C> Counted<I2C> {
    pub(super) const fn new(i2c: I2C) -> Self {
        Self { i2c, tried: 0, broken: 0 }
    }

    /// Forgets what was counted.
    pub(super) const fn begin(&mut self) {
        (self.tried, self.broken) = (0, 0);
    }

    /// Whether no transaction succeeded, and none failed merely for want of an answer.
    pub(super) const fn is_suspect(&self) -> bool {
        self.tried > 0 && self.broken == self.tried
    }
}

impl<I2C: ErrorType> ErrorType for Counted<I2C> {
    type Error = I2C::Error;
}

impl<I2C: I2c> I2c for Counted<I2C> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Self::Error> {
        let outcome = self.i2c.transaction(address, operations).await;
        self.tried = self.tried.saturating_add(1);
        if let Err(error) = &outcome
            && !matches!(error.kind(), ErrorKind::NoAcknowledge(_))
        {
            self.broken = self.broken.saturating_add(1);
        }
        outcome
    }
}
