//! [`CountingBus`], an I²C bus that counts transactions and failures, to detect that the bus hangs.

use embedded_hal::i2c::{Error as _, ErrorKind, ErrorType, Operation};
use embedded_hal_async::i2c::I2c;

/// Passes every transaction to the bus, and counts them and their failures.
#[derive(Debug)]
pub(super) struct CountingBus<I2C> {
    i2c: I2C,
    transactions: u16,
    /// Failures other than a missing acknowledgement.
    failures: u16,
}

impl<I2C> CountingBus<I2C> {
    pub(super) const fn new(i2c: I2C) -> Self {
        Self { i2c, transactions: 0, failures: 0 }
    }

    /// Sets the counts to zero.
    pub(super) const fn reset_counts(&mut self) {
        (self.transactions, self.failures) = (0, 0);
    }

    /// Whether there were transactions, and all of them failed otherwise than by a missing
    /// acknowledgement.
    pub(super) const fn is_suspect(&self) -> bool {
        self.transactions > 0 && self.failures == self.transactions
    }
}

impl<I2C: ErrorType> ErrorType for CountingBus<I2C> {
    type Error = I2C::Error;
}

impl<I2C: I2c> I2c for CountingBus<I2C> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Self::Error> {
        let outcome = self.i2c.transaction(address, operations).await;
        self.transactions = self.transactions.saturating_add(1);
        if let Err(error) = &outcome
            && !matches!(error.kind(), ErrorKind::NoAcknowledge(_))
        {
            self.failures = self.failures.saturating_add(1);
        }
        outcome
    }
}
