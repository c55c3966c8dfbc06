//! An I²C bus whose transactions all have a time limit.
//!
//! embassy's driver for this chip's I²C waits for interrupts that a disturbed bus never raises
//! (embassy #2372), and leaves a transaction that failed in the middle without its stop condition.
//! So each transaction here has a time limit. When the limit is exceeded, or the peripheral reports
//! a bus error or a lost arbitration, the bus is recovered: up to nine clock pulses, until every
//! device has released the data line, and a reset of the peripheral.

use embassy_embedded_hal::SetConfig;
use embassy_stm32::i2c::{self, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::pac;
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Idr, Moder};
use embassy_stm32::time::Hertz;
use embassy_time::{Delay, Duration};
use embedded_hal::digital::{self, InputPin, OutputPin};
use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};

use crate::board::deadline::{Deadline, Over};

/// The time limit of a transaction: a byte takes 23 µs at 400 kHz, the rest is for tasks of a higher
/// priority.
const LIMIT_US: u64 = 1_000;
const LIMIT_PER_BYTE_US: u64 = 60;

const SPEED: Hertz = Hertz(400_000);

/// Iterations of a loop that waits for the end of a stop condition, which takes 5 µs; an iteration
/// takes 0.1 µs or more.
const STOP_TURNS: u32 = 500;

/// Why a transaction failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum Error {
    /// No device acknowledged the address, or the device refused a byte.
    NotAcknowledged,
    /// The transaction took too long, or the bus does not become free.
    Hung,
    /// The peripheral reported a bus error, a lost arbitration or another error of the lines.
    Disturbed,
    /// There is nothing to send or to read.
    Empty,
}

impl embedded_hal::i2c::Error for Error {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NotAcknowledged => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown),
            Self::Hung | Self::Disturbed => ErrorKind::Bus,
            Self::Empty => ErrorKind::Other,
        }
    }
}

/// An I²C bus as its only master.
pub(crate) struct Bus {
    i2c: I2c<'static, Async, Master>,
    registers: pac::i2c::I2c,
    clock: Line,
    data: Line,
    deadline: &'static Deadline,
}

impl Bus {
    /// The bus of the driver `i2c`, with the registers and pins of its peripheral, and a deadline
    /// that no other bus uses.
    pub(crate) fn new(
        i2c: I2c<'static, Async, Master>,
        registers: pac::i2c::I2c,
        clock: Line,
        data: Line,
        deadline: &'static Deadline,
    ) -> Self {
        Self { i2c, registers, clock, data, deadline }
    }

    /// Waits before a transaction until the stop condition of the last one is over and the lines
    /// are free. A start that is requested while a stop is pending may be lost (RM0090, note on
    /// I2C_CR1).
    async fn ready(&mut self) -> Result<(), Error> {
        if !(self.comes_free() || self.mend().await) {
            return Err(Error::Hung);
        }
        self.empty();
        Ok(())
    }

    /// Throws away what the last read has left. embassy's driver starts the receiving DMA after it has
    /// let the device send, and acknowledges meanwhile (`i2c/v1.rs`): a control step in between lets
    /// one byte too many come in, which the next read would take for its first. There is room for
    /// two, in the data register and in the shift register.
    fn empty(&self) {
        for _ in 0..2 {
            if self.registers.sr1().read().rxne() {
                let _ = self.registers.dr().read();
            }
        }
    }

    fn comes_free(&self) -> bool {
        let is_free = || !self.registers.cr1().read().stop() && !self.registers.sr2().read().busy();
        (0..STOP_TURNS).any(|_| is_free())
    }

    /// Translates the end of a transaction into a result, and readies the bus for the next one.
    async fn close(&mut self, end: Result<Result<(), i2c::Error>, Over>) -> Result<(), Error> {
        let error = match end {
            Ok(Ok(())) => return Ok(()),
            Ok(Err(i2c::Error::Nack)) => {
                // A refused address has been answered with a stop, a refused byte has not.
                let stops = self.registers.cr1().read().stop();
                if !stops && self.registers.sr2().read().msl() {
                    self.registers.cr1().modify(|w| w.set_stop(true));
                }
                return Err(Error::NotAcknowledged);
            }
            Ok(Err(_)) => Error::Disturbed,
            Err(Over) => Error::Hung,
        };
        self.mend().await;
        Err(error)
    }

    /// Frees the lines and resets the peripheral; whether they are free now. Takes 0.5 ms.
    async fn mend(&mut self) -> bool {
        self.clock.take();
        self.data.take();
        let freed = sensors::bus::recover(&mut self.clock, &mut self.data, &mut Delay).await;
        self.registers.cr1().modify(|w| w.set_pe(false));
        self.registers.cr1().modify(|w| w.set_swrst(true));
        self.registers.cr1().modify(|w| w.set_swrst(false));
        self.clock.give_back();
        self.data.give_back();
        // It only writes the timing, and never fails.
        let _ = self.i2c.set_config(&SPEED);
        self.registers.cr1().modify(|w| w.set_pe(true));
        freed && self.comes_free()
    }
}

fn limit(bytes: usize) -> Duration {
    Duration::from_micros(LIMIT_US.saturating_add(LIMIT_PER_BYTE_US * bytes as u64))
}

impl ErrorType for Bus {
    type Error = Error;
}

// An empty buffer is a panic in embassy's driver.
impl embedded_hal_async::i2c::I2c for Bus {
    async fn read(&mut self, address: u8, read: &mut [u8]) -> Result<(), Error> {
        if read.is_empty() {
            return Err(Error::Empty);
        }
        self.ready().await?;
        let end = self.deadline.bound(limit(read.len()), self.i2c.read(address, read)).await;
        self.close(end).await
    }

    async fn write(&mut self, address: u8, write: &[u8]) -> Result<(), Error> {
        if write.is_empty() {
            return Err(Error::Empty);
        }
        self.ready().await?;
        let end = self.deadline.bound(limit(write.len()), self.i2c.write(address, write)).await;
        self.close(end).await
    }

    async fn write_read(
        &mut self,
        address: u8,
        write: &[u8],
        read: &mut [u8],
    ) -> Result<(), Error> {
        if write.is_empty() || read.is_empty() {
            return Err(Error::Empty);
        }
        self.ready().await?;
        let limit = limit(write.len() + read.len());
        let end = self.deadline.bound(limit, self.i2c.write_read(address, write, read)).await;
        self.close(end).await
    }

    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Error> {
        let length = |operation: &Operation<'_>| match operation {
            Operation::Read(read) => read.len(),
            Operation::Write(write) => write.len(),
        };
        if operations.is_empty() || operations.iter().any(|operation| length(operation) == 0) {
            return Err(Error::Empty);
        }
        let limit = limit(operations.iter().map(length).sum());
        self.ready().await?;
        let end = self.deadline.bound(limit, self.i2c.transaction(address, operations)).await;
        self.close(end).await
    }
}

/// One of the bus's two pins, to be driven by hand while the peripheral cannot.
pub(crate) struct Line {
    port: Gpio,
    number: usize,
}

impl Line {
    /// Pin `number` of `port`, which embassy has made an open-drain pin of the peripheral's.
    pub(crate) const fn new(port: Gpio, number: usize) -> Self {
        Self { port, number }
    }

    /// The pin's number, below 16 so that the compiler can leave out the bounds check.
    const fn number(&self) -> usize {
        self.number % 16
    }

    /// Takes the pin from the peripheral.
    fn take(&mut self) {
        self.port.bsrr().write(|w| w.set_bs(self.number(), true));
        self.set_mode(Moder::OUTPUT);
    }

    /// Gives the pin back to the peripheral.
    fn give_back(&mut self) {
        self.set_mode(Moder::ALTERNATE);
    }

    fn set_mode(&mut self, mode: Moder) {
        // Other tasks use the port's other pins.
        cortex_m::interrupt::free(|_| {
            self.port.moder().modify(|w| w.set_moder(self.number(), mode));
        });
    }
}

impl digital::ErrorType for Line {
    type Error = core::convert::Infallible;
}

impl OutputPin for Line {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.port.bsrr().write(|w| w.set_br(self.number(), true));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.port.bsrr().write(|w| w.set_bs(self.number(), true));
        Ok(())
    }
}

impl InputPin for Line {
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        Ok(self.port.idr().read().idr(self.number()) == Idr::HIGH)
    }

    fn is_low(&mut self) -> Result<bool, Self::Error> {
        self.is_high().map(|high| !high)
    }
}
