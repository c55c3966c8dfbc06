//! The whole chip, run up to a moment.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

use units::Volts;

use crate::Cycles;
use crate::air::{Incoming, Rate, Transmission, Upcoming};
use crate::core::{Core, Fault};
use crate::image::{APPLICATION, Program};
use crate::peripherals::{Bus, PinChange, PinLevel, SentByte, Unknown};

/// What differs between two chips with the same firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// The address of the vector table.
    pub vectors: u32,
    /// The device's address (FICR.DEVICEADDR), lowest byte first.
    pub device_address: [u8; 6],
    /// GPREGRET at the first start: what the loader in front of the firmware leaves there.
    pub retained: u8,
}

impl Default for Config {
    /// A chip that has just got its battery: its loader has seen no button, and GPREGRET is zero.
    fn default() -> Self {
        Self { vectors: APPLICATION, device_address: [0xC0, 0xFF, 0xEE, 0, 0, 0xC0], retained: 0 }
    }
}

/// The state of the radio, to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Radio {
    /// The channel: 2400 MHz plus so many MHz.
    pub channel: u8,
    /// The data rate.
    pub rate: Rate,
    /// The address at which it is reached alone.
    pub address: [u8; 5],
    /// The power at which it sends, in dBm.
    pub power: i8,
    /// Whether it receives at this moment.
    pub listens: bool,
    /// Packets that ended while it did not receive them, since its last power-up.
    pub missed: u64,
}

/// An nRF51822 with a firmware. Moments are in cycles since its first start.
#[derive(Clone)]
pub struct Chip {
    core: Core,
    bus: Bus,
    vectors: u32,
    instructions: u64,
}

impl fmt::Debug for Chip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Chip").field("now", &self.bus.now).finish_non_exhaustive()
    }
}

impl Chip {
    /// A chip that starts now.
    ///
    /// # Errors
    ///
    /// A [`Fault`] where the vector table does not begin with a stack and Thumb code.
    pub fn new(program: Arc<Program>, config: Config) -> Result<Self, Fault> {
        let mut bus = Bus::new(program, config);
        let core = Core::new(&mut bus, config.vectors)?;
        Ok(Self { core, bus, vectors: config.vectors, instructions: 0 })
    }

    /// Runs until a moment; it may pass it by an instruction.
    ///
    /// # Errors
    ///
    /// A [`Fault`] at which a real core would enter its HardFault handler. The chip stays there.
    pub fn run_until(&mut self, until: Cycles) -> Result<(), Fault> {
        while self.bus.now < until {
            if self.bus.is_off() {
                self.bus.now = until;
                return Ok(());
            }
            if self.bus.due <= self.bus.now {
                self.bus.advance();
            }
            if self.bus.changed {
                self.bus.changed = false;
                let lines = self.bus.lines();
                self.core.set_lines(lines);
            }
            let cycles = self.core.step(&mut self.bus)?;
            self.bus.now += Cycles::from(cycles);
            self.instructions += 1;
            if self.core.take_reset() {
                self.reset()?;
            }
        }
        Ok(())
    }

    /// Resets the chip: all but GPREGRET and what is outside of it begins anew.
    ///
    /// # Errors
    ///
    /// A [`Fault`] as at the first start.
    pub fn reset(&mut self) -> Result<(), Fault> {
        self.bus.reset();
        self.core = Core::new(&mut self.bus, self.vectors)?;
        Ok(())
    }

    /// The time.
    #[must_use]
    pub const fn now(&self) -> Cycles {
        self.bus.now
    }

    /// How many instructions it has executed, with entries to exceptions.
    #[must_use]
    pub const fn instructions(&self) -> u64 {
        self.instructions
    }

    /// The address of the next instruction.
    #[must_use]
    pub fn pc(&self) -> u32 {
        self.core.register(15)
    }

    /// The number of the exception that is being handled, or 0.
    #[must_use]
    pub fn exception(&self) -> u8 {
        self.core.exception()
    }

    /// Whether the firmware has switched the chip off.
    #[must_use]
    pub const fn is_off(&self) -> bool {
        self.bus.is_off()
    }

    /// The registers that were used and are not modelled, each once.
    #[must_use]
    pub fn unknown(&self) -> &[Unknown] {
        self.bus.unknown()
    }

    /// A byte comes in on the serial line, whose stop bit passes at a moment; `None` is one without
    /// a stop bit, or at another rate.
    pub fn receive(&mut self, at: Cycles, byte: Option<u8>) {
        self.bus.receive(at, byte);
    }

    /// The bytes that the chip has begun to send and that were not taken yet.
    pub const fn sent_bytes(&mut self) -> &mut VecDeque<SentByte> {
        self.bus.sent_bytes()
    }

    /// Whether RTS asks the other end of the line for a pause; `None` while the pin is not driven.
    #[must_use]
    pub fn rts(&self) -> Option<bool> {
        self.bus.rts()
    }

    /// A packet reaches the antenna.
    pub fn hear(&mut self, packet: Incoming) {
        self.bus.hear(packet);
    }

    /// The packets whose sending has ended since the last call.
    pub fn take_transmissions(&mut self) -> Vec<Transmission> {
        self.bus.take_transmissions()
    }

    /// The packets for which the transmitter began to ramp up since the last call: each is taken before
    /// its first bit is on the air where this is called at least once in a ramp-up, every 140 µs.
    pub fn take_upcoming(&mut self) -> Vec<Upcoming> {
        self.bus.take_upcoming()
    }

    /// The changes of pins since the last call.
    pub fn take_pin_changes(&mut self) -> Vec<PinChange> {
        self.bus.take_pin_changes()
    }

    /// What a pin does.
    #[must_use]
    pub const fn pin(&self, pin: u8) -> PinLevel {
        self.bus.pin(pin)
    }

    /// Drives a pin from outside, or leaves it.
    pub const fn drive_pin(&mut self, pin: u8, level: Option<bool>) {
        self.bus.drive_pin(pin, level);
    }

    /// Sets the voltage at an analog input.
    pub fn set_analog(&mut self, input: u8, volts: Volts) {
        self.bus.set_analog(input, volts);
    }

    /// Sets the chip's temperature in quarters of a degree Celsius.
    pub const fn set_temperature(&mut self, quarters: i32) {
        self.bus.set_temperature(quarters);
    }

    /// The state of the radio.
    #[must_use]
    pub const fn radio(&self) -> Radio {
        self.bus.radio()
    }
}
