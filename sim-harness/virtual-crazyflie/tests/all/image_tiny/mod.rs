//! A small ELF, and a machine that runs it on a board with nothing on it.

use std::sync::Arc;

use virtual_crazyflie::image::Image;
use virtual_crazyflie::machine::{Machine, MachineConfig};
use virtual_crazyflie::soc::{Board, I2cBus, Level, Nanos, Pin, SpiBus, UartBus, UartByte};

/// `tiny.rs`, compiled.
pub(crate) const TINY: &[u8] = include_bytes!("tiny.elf");

/// The same, parsed.
pub(crate) fn tiny() -> Image {
    Image::parse(TINY.to_vec()).expect("it is as it was compiled")
}

/// A machine that has just been switched on with it.
pub(crate) fn machine() -> Machine<Nothing> {
    Machine::new(Arc::new(tiny()), Nothing, MachineConfig::default())
}

/// A board of bare pins.
pub(crate) struct Nothing;

impl Board for Nothing {
    fn advance(&mut self, _: Nanos) {}
    fn due(&self) -> Nanos {
        Nanos::MAX
    }
    fn i2c_start(&mut self, _: I2cBus, _: u8, _: bool) -> bool {
        false
    }
    fn i2c_write(&mut self, _: I2cBus, _: u8) -> bool {
        false
    }
    fn i2c_read(&mut self, _: I2cBus) -> u8 {
        0xFF
    }
    fn i2c_stop(&mut self, _: I2cBus) {}
    fn i2c_lines(&self, _: I2cBus) -> (bool, bool) {
        (true, true)
    }
    fn spi_exchange(&mut self, _: SpiBus, _: u8) -> u8 {
        0
    }
    fn uart_take(&mut self, _: UartBus, _: u8, _: u32) {}
    fn uart_give(&mut self, _: UartBus) -> Option<UartByte> {
        None
    }
    fn drive(&mut self, _: Pin, _: Level) {}
    fn level(&self, _: Pin) -> Level {
        Level::Released
    }
}
