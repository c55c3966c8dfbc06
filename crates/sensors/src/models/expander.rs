//! Model of a PCA9534, the I/O expander, whose eight lines other models can read.

use core::ops::Deref;
use core::sync::atomic::{AtomicU8, Ordering};

use super::{Fault, I2cModel};
use crate::expander::ADDRESS;

/// The model of the expander. Its lines are an atomic outside of it, borrowed or shared, which
/// other models read.
pub struct ExpanderModel<L> {
    /// The expander's fault.
    pub fault: Fault,
    lines: L,
    floating: u8,
    output: u8,
    direction: u8,
    command: Option<u8>,
}

impl<L: Deref<Target = AtomicU8>> ExpanderModel<L> {
    /// An expander after its reset: every line is an input, at the level that `floating` gives it.
    #[must_use]
    pub fn new(lines: L, floating: u8) -> Self {
        lines.store(floating, Ordering::Relaxed);
        let (output, direction) = (0xFF, 0xFF);
        Self { fault: Fault::None, lines, floating, output, direction, command: None }
    }

    /// Resets the expander as a drop of its supply does: all lines float again.
    pub fn reset(&mut self) {
        (self.output, self.direction, self.command) = (0xFF, 0xFF, None);
        self.drive();
    }

    /// Sets the lines to the levels that the registers give.
    fn drive(&self) {
        let lines = (self.output & !self.direction) | (self.floating & self.direction);
        self.lines.store(lines, Ordering::Relaxed);
    }

    fn register(&self) -> u8 {
        match self.command {
            Some(0) => self.lines.load(Ordering::Relaxed),
            Some(1) => self.output,
            Some(3) => self.direction,
            _ => 0,
        }
    }
}

impl<L: Deref<Target = AtomicU8>> I2cModel for ExpanderModel<L> {
    fn start(&mut self, address: u8, read: bool) -> bool {
        if !read {
            self.command = None;
        }
        address == ADDRESS && self.fault.acknowledges()
    }

    fn write(&mut self, byte: u8) -> bool {
        if !self.fault.acknowledges() {
            return false;
        }
        match self.command {
            None => self.command = Some(byte),
            Some(1) => self.output = byte,
            Some(3) => self.direction = byte,
            Some(_) => {}
        }
        self.drive();
        true
    }

    fn read(&mut self) -> u8 {
        self.fault.read(self.register())
    }

    fn stop(&mut self) {}

    fn advance(&mut self, _micros: u32) {}
}
