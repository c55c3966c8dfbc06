//! The interface between the chip and the board that is soldered to its pins.
//!
//! Serial buses are seen byte by byte, other pins level by level. Time is in nanoseconds since the
//! machine was switched on, and never runs backwards.

/// Nanoseconds since power-up.
pub type Nanos = u64;

/// A pin: PA0 is `Pin::new('A', 0)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pin(u8);

impl Pin {
    /// Pin `number` (0 to 15) of port 'A' to 'I'. What is out of range wraps.
    #[must_use]
    pub const fn new(port: char, number: u8) -> Self {
        Self(((port as u32 as u8).wrapping_sub(b'A') % 9) * 16 + number % 16)
    }

    /// The number of the port, A being 0.
    #[must_use]
    pub const fn of(port: usize, number: usize) -> Self {
        Self((port % 9) as u8 * 16 + (number % 16) as u8)
    }

    /// The number of its port, A being 0.
    #[must_use]
    pub const fn port(self) -> usize {
        (self.0 / 16) as usize
    }

    /// Its number within the port.
    #[must_use]
    pub const fn number(self) -> usize {
        (self.0 % 16) as usize
    }
}

/// The drive of a pin, as seen from one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Driven low.
    Low,
    /// Driven high.
    High,
    /// The pin is not driven: an input, or a released open drain.
    Released,
}

/// An I²C peripheral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum I2cBus {
    /// I2C1.
    I2c1,
    /// I2C2.
    I2c2,
    /// I2C3.
    I2c3,
}

/// An SPI peripheral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpiBus {
    /// SPI1.
    Spi1,
}

/// A USART.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UartBus {
    /// USART6.
    Usart6,
}

/// A byte that comes in over a serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UartByte {
    /// When its start bit begins.
    pub at: Nanos,
    /// The duration of one bit, in ns, by the sender's baud rate.
    pub bit: u32,
    /// The byte.
    pub data: u8,
    /// Noise was seen on it.
    pub noise: bool,
    /// Its stop bit is not there.
    pub broken: bool,
}

/// The wiring of the chip.
///
/// [`advance`](Self::advance) is called before anything else, with the moment of what follows.
pub trait Board {
    /// Everything happens that happens before `now` or at it.
    fn advance(&mut self, now: Nanos);

    /// When a pin will next change, or a byte begin to come in, by itself; `u64::MAX` for never.
    fn due(&self) -> Nanos;

    /// A start or repeated start with an address: whether a device acknowledges.
    fn i2c_start(&mut self, bus: I2cBus, address: u8, read: bool) -> bool;
    /// A byte from the chip: whether a device acknowledges.
    fn i2c_write(&mut self, bus: I2cBus, byte: u8) -> bool;
    /// A byte for the chip.
    fn i2c_read(&mut self, bus: I2cBus) -> u8;
    /// A stop.
    fn i2c_stop(&mut self, bus: I2cBus);
    /// Whether the devices let the clock and the data line go high.
    fn i2c_lines(&self, bus: I2cBus) -> (bool, bool);

    /// Exchanges a byte each way. Which device is selected is a matter of pins.
    fn spi_exchange(&mut self, bus: SpiBus, byte: u8) -> u8;

    /// A byte from the chip whose stop bit has just passed, sent with bits of so many ns.
    fn uart_take(&mut self, bus: UartBus, byte: u8, bit: u32);
    /// The byte that comes in next, if it has begun by now. Each is returned once.
    fn uart_give(&mut self, bus: UartBus) -> Option<UartByte>;

    /// The chip drives this pin, as a plain output, from now on.
    fn drive(&mut self, pin: Pin, level: Level);
    /// Shows a pin to the board.
    fn level(&self, pin: Pin) -> Level;
}
