//! Models on a bus, with a clock that the bus and the delay advance.

use core::cell::{Cell, RefCell};

use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use units::Instant;

use super::I2cModel;

/// A byte and its acknowledgement at 400 kHz, in µs.
const BYTE_US: u32 = 23;
/// What a transaction takes that hangs until its owner's limit ends it, in µs.
const HANG_US: u32 = 5_000;

/// The two lines and the devices on them.
pub struct Wires<'a> {
    devices: &'a [&'a RefCell<dyn I2cModel + 'a>],
    clock: Cell<u64>,
    transactions: Cell<u32>,
    refuse: Cell<Option<u32>>,
    hung: Cell<bool>,
}

impl<'a> Wires<'a> {
    /// Joins devices to a bus, at the beginning of time. Without devices it is just a clock.
    #[must_use]
    pub const fn new(devices: &'a [&'a RefCell<dyn I2cModel + 'a>]) -> Self {
        Self {
            devices,
            clock: Cell::new(0),
            transactions: Cell::new(0),
            refuse: Cell::new(None),
            hung: Cell::new(false),
        }
    }

    /// The time.
    #[must_use]
    pub const fn now(&self) -> Instant {
        Instant::from_micros(self.clock.get())
    }

    /// How many transactions there were.
    #[must_use]
    pub const fn transactions(&self) -> u32 {
        self.transactions.get()
    }

    /// Lets the transaction fail that comes after `count` more, as if nobody had acknowledged it;
    /// `None` lets all pass.
    pub fn refuse_after(&self, count: Option<u32>) {
        self.refuse.set(count);
    }

    /// Lets the bus hang, or frees it. While it hangs every transaction ends without result.
    pub fn hang(&self, hung: bool) {
        self.hung.set(hung);
    }

    /// Lets time pass.
    pub fn advance(&self, micros: u32) {
        self.clock.set(self.clock.get().saturating_add(micros.into()));
        self.each(|device| device.advance(micros));
    }

    /// Gives every device its turn. One that is in use just now (a test that holds it while the
    /// bus runs) is as good as absent.
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
        match self.refuse.get() {
            Some(0) => {
                self.refuse.set(None);
                self.advance(BYTE_US);
                return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
            }
            Some(left) => self.refuse.set(Some(left - 1)),
            None => {}
        }
        let outcome = operations.iter_mut().try_for_each(|op| self.operate(address, op));
        self.each(|device| device.stop());
        outcome
    }

    fn operate(&self, address: u8, operation: &mut Operation<'_>) -> Result<(), ErrorKind> {
        // Who takes part is one bit per device, for the first 32 of them.
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

/// The bus that a driver takes. Copies share the wires.
#[derive(Clone, Copy)]
pub struct ModelBus<'a> {
    wires: &'a Wires<'a>,
}

impl<'a> ModelBus<'a> {
    /// A bus over these wires.
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

/// A delay that lets the models' time pass and none of ours.
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
