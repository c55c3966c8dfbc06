//! An I²C bus with models on it, and a clock that the bus and the delay advance.

use core::cell::{Cell, RefCell};

use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use units::Instant;

use super::I2cModel;

/// Time of a byte and its acknowledgement at 400 kHz, in µs.
const BYTE_US: u32 = 23;
/// Time of a transaction that hangs until the limit of the bus's owner ends it, in µs.
const HANG_US: u32 = 5_000;

/// The two lines and the devices on them.
pub struct Wires<'a> {
    devices: &'a [&'a RefCell<dyn I2cModel + 'a>],
    clock: Cell<u64>,
    transactions: Cell<u32>,
    /// Number of transactions that still succeed before one fails.
    until_failure: Cell<Option<u32>>,
    hung: Cell<bool>,
}

impl<'a> Wires<'a> {
    /// Connects devices to a bus whose clock is at zero. Without devices this is just a clock.
    #[must_use]
    pub const fn new(devices: &'a [&'a RefCell<dyn I2cModel + 'a>]) -> Self {
        Self {
            devices,
            clock: Cell::new(0),
            transactions: Cell::new(0),
            until_failure: Cell::new(None),
            hung: Cell::new(false),
        }
    }

    /// The time on the clock of the bus.
    #[must_use]
    pub const fn now(&self) -> Instant {
        Instant::from_micros(self.clock.get())
    }

    /// Number of transactions so far.
    #[must_use]
    pub const fn transactions(&self) -> u32 {
        self.transactions.get()
    }

    /// Makes the transaction after the next `count` ones fail with a missing acknowledgement;
    /// `None` lets all succeed.
    pub fn refuse_after(&self, count: Option<u32>) {
        self.until_failure.set(count);
    }

    /// Makes the bus hang, or frees it. While it hangs every transaction fails.
    pub fn hang(&self, hung: bool) {
        self.hung.set(hung);
    }

    /// Lets `micros` µs pass for the bus and all devices.
    pub fn advance(&self, micros: u32) {
        self.clock.set(self.clock.get().saturating_add(micros.into()));
        self.each(|device| device.advance(micros));
    }

    /// Calls `visit` for every device, except one that is borrowed at the moment by a test.
    fn each(&self, mut visit: impl FnMut(&mut dyn I2cModel)) {
        for device in self.devices {
            if let Ok(mut device) = device.try_borrow_mut() {
                visit(&mut *device);
            }
        }
    }

    fn transact(&self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.transactions.set(self.transactions.get().saturating_add(1));
        if self.hung.get() {
            self.advance(HANG_US);
            return Err(ErrorKind::Bus);
        }
        match self.until_failure.get() {
            Some(0) => {
                self.until_failure.set(None);
                self.advance(BYTE_US);
                return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
            }
            Some(left) => self.until_failure.set(Some(left - 1)),
            None => {}
        }
        let outcome = operations.iter_mut().try_for_each(|op| self.operate(address, op));
        self.each(|device| device.stop());
        outcome
    }

    fn operate(&self, address: u8, operation: &mut Operation<'_>) -> Result<(), ErrorKind> {
        // One bit for each of the first 32 devices tells whether the device takes part.
        let reads = matches!(operation, Operation::Read(_));
        let mut taking_part = 0_u32;
        let mut bit = 1_u32;
        self.each(|device| {
            if device.start(address, reads) {
                taking_part |= bit;
            }
            bit = bit.wrapping_shl(1);
        });
        self.advance(BYTE_US);
        if taking_part == 0 {
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        match operation {
            Operation::Write(bytes) => {
                bytes.iter().try_for_each(|byte| self.send(taking_part, *byte))
            }
            Operation::Read(bytes) => {
                bytes.iter_mut().for_each(|byte| *byte = self.receive(taking_part));
                Ok(())
            }
        }
    }

    fn send(&self, taking_part: u32, byte: u8) -> Result<(), ErrorKind> {
        let mut acknowledged = false;
        self.each_of(taking_part, |device| acknowledged |= device.write(byte));
        self.advance(BYTE_US);
        if acknowledged { Ok(()) } else { Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data)) }
    }

    fn receive(&self, taking_part: u32) -> u8 {
        let mut byte = 0xFF;
        self.each_of(taking_part, |device| byte &= device.read());
        self.advance(BYTE_US);
        byte
    }

    fn each_of(&self, taking_part: u32, mut visit: impl FnMut(&mut dyn I2cModel)) {
        let mut bit = 1_u32;
        self.each(|device| {
            if taking_part & bit != 0 {
                visit(device);
            }
            bit = bit.wrapping_shl(1);
        });
    }
}

/// The I²C bus for a driver. Copies share the wires.
#[derive(Clone, Copy)]
pub struct ModelBus<'a> {
    wires: &'a Wires<'a>,
}

impl<'a> ModelBus<'a> {
    /// A bus on these wires.
    #[must_use]
    pub const fn new(wires: &'a Wires<'a>) -> Self {
        Self { wires }
    }
}

impl ErrorType for ModelBus<'_> {
    type Error = ErrorKind;
}

impl I2c for ModelBus<'_> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        self.wires.transact(address, operations)
    }
}

/// A delay that advances the clock of the models and returns at once.
#[derive(Clone, Copy)]
pub struct ModelDelay<'a> {
    wires: &'a Wires<'a>,
}

impl<'a> ModelDelay<'a> {
    /// A delay for the devices on these wires.
    #[must_use]
    pub const fn new(wires: &'a Wires<'a>) -> Self {
        Self { wires }
    }
}

impl DelayNs for ModelDelay<'_> {
    async fn delay_ns(&mut self, ns: u32) {
        self.wires.advance(ns.div_ceil(1_000));
    }
}
