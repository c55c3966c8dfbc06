//! A PCA9534 whose eight lines other models can watch.

use core::cell::Cell;

use super::{Fault, I2cModel};
use crate::expander::ADDRESS;

/// The model. Its lines are a [`Cell`] outside it, so that other models see them.
pub struct ExpanderModel<'a> {
    /// What is wrong with it.
    pub fault: Fault,
    lines: &'a Cell<u8>,
    floating: u8,
    output: u8,
    direction: u8,
    command: Option<u8>,
}

impl<'a> ExpanderModel<'a> {
    /// As after its reset: every line an input, at the level that `floating` gives it.
    #[must_use]
    pub fn new(lines: &'a Cell<u8>, floating: u8) -> Self {
        lines.set(floating);
        let (output, direction) = (0xFF, 0xFF);
        Self { fault: Fault::None, lines, floating, output, direction, command: None }
    }

    /// Its supply dips: all lines float again.
    pub fn reset(&mut self) {
        *self = Self { fault: self.fault, ..Self::new(self.lines, self.floating) };
    }

    fn register(&self) -> u8 {
        match self.command {
            Some(0) => self.lines.get(),
            Some(1) => self.output,
            Some(3) => self.direction,
            _ => 0,
        }
    }
}

impl I2cModel for ExpanderModel<'_> {
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
        self.lines.set((self.output & !self.direction) | (self.floating & self.direction));
        true
    }

    fn read(&mut self) -> u8 {
        self.fault.read(self.register())
    }

    fn stop(&mut self) {}

    fn advance(&mut self, _micros: u32) {}
}
