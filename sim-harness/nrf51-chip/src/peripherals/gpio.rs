//! GPIO: 32 pins, and what they are seen to do from outside.

use crate::Cycles;

/// The offsets of the registers.
mod offset {
    pub(super) const OUT: u32 = 0x504;
    pub(super) const OUTSET: u32 = 0x508;
    pub(super) const OUTCLR: u32 = 0x50C;
    pub(super) const IN: u32 = 0x510;
    pub(super) const DIR: u32 = 0x514;
    pub(super) const DIRSET: u32 = 0x518;
    pub(super) const DIRCLR: u32 = 0x51C;
    pub(super) const PIN_CNF: u32 = 0x700;
    pub(super) const PIN_CNF_END: u32 = 0x780;
}

const PINS: usize = 32;
/// PIN_CNF: the drive of a level of 1 is disconnected from this value of DRIVE on (S0D1, H0D1).
const OPEN_DRAIN: u32 = 6;

/// What a pin does to the wire on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinLevel {
    /// The chip drives it low.
    Low,
    /// The chip drives it high.
    High,
    /// The chip does not drive it.
    Released,
    /// A resistor in the chip pulls it down.
    PulledDown,
    /// A resistor in the chip pulls it up.
    PulledUp,
}

/// A change of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinChange {
    /// When it changed, in cycles since the chip's start.
    pub at: Cycles,
    /// The pin's number in port 0.
    pub pin: u8,
    /// What it does from then on.
    pub level: PinLevel,
}

/// The port.
#[derive(Clone, Debug)]
pub(super) struct Gpio {
    out: u32,
    configuration: [u32; PINS],
    levels: [PinLevel; PINS],
    /// What is driven from outside, pin by pin.
    outside: [Option<bool>; PINS],
    changes: Vec<PinChange>,
}

impl Gpio {
    pub(super) const fn new() -> Self {
        Self {
            out: 0,
            // Input, with its buffer disconnected.
            configuration: [2; PINS],
            levels: [PinLevel::Released; PINS],
            outside: [None; PINS],
            changes: Vec::new(),
        }
    }

    /// A pin is driven from outside, or is not any more.
    pub(super) const fn drive(&mut self, pin: u8, level: Option<bool>) {
        self.outside[pin as usize % PINS] = level;
    }

    pub(super) const fn level(&self, pin: u8) -> PinLevel {
        self.levels[pin as usize % PINS]
    }

    pub(super) fn take_changes(&mut self) -> Vec<PinChange> {
        std::mem::take(&mut self.changes)
    }

    fn level_of(&self, pin: usize) -> PinLevel {
        let configuration = self.configuration[pin];
        let is_output = configuration & 1 != 0;
        match (is_output, self.out >> pin & 1 != 0, configuration >> 8 & 7, configuration >> 2 & 3)
        {
            (true, true, drive, _) if drive >= OPEN_DRAIN => PinLevel::Released,
            (true, true, ..) => PinLevel::High,
            (true, false, ..) => PinLevel::Low,
            (false, _, _, 1) => PinLevel::PulledDown,
            (false, _, _, 3) => PinLevel::PulledUp,
            (false, ..) => PinLevel::Released,
        }
    }

    fn settle(&mut self, now: Cycles) {
        for pin in 0..PINS {
            let level = self.level_of(pin);
            if level != self.levels[pin] {
                self.levels[pin] = level;
                self.changes.push(PinChange { at: now, pin: pin as u8, level });
            }
        }
    }

    /// The levels that the program reads. A pin that nothing drives is high: the board's pull-ups.
    fn levels_in(&self) -> u32 {
        (0..PINS).fold(0, |all, pin| {
            let driven = match self.levels[pin] {
                PinLevel::Low => Some(false),
                PinLevel::High => Some(true),
                PinLevel::Released | PinLevel::PulledUp => self.outside[pin].or(Some(true)),
                PinLevel::PulledDown => self.outside[pin].or(Some(false)),
            };
            all | u32::from(driven == Some(true)) << pin
        })
    }

    fn directions(&self) -> u32 {
        (0..PINS).fold(0, |all, pin| all | (self.configuration[pin] & 1) << pin)
    }

    fn set_directions(&mut self, directions: u32) {
        for (pin, configuration) in self.configuration.iter_mut().enumerate() {
            *configuration = *configuration & !1 | directions >> pin & 1;
        }
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::OUT | offset::OUTSET | offset::OUTCLR => self.out,
            offset::IN => self.levels_in(),
            offset::DIR | offset::DIRSET | offset::DIRCLR => self.directions(),
            offset::PIN_CNF..offset::PIN_CNF_END => {
                self.configuration[(offset - offset::PIN_CNF) as usize / 4]
            }
            _ => return None,
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        match offset {
            offset::OUT => self.out = value,
            offset::OUTSET => self.out |= value,
            offset::OUTCLR => self.out &= !value,
            offset::DIR => self.set_directions(value),
            offset::DIRSET => self.set_directions(self.directions() | value),
            offset::DIRCLR => self.set_directions(self.directions() & !value),
            offset::PIN_CNF..offset::PIN_CNF_END => {
                self.configuration[(offset - offset::PIN_CNF) as usize / 4] = value;
            }
            _ => return None,
        }
        self.settle(now);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_open_drain_is_driven_low_and_released_high() {
        let mut gpio = Gpio::new();
        gpio.write(0, offset::PIN_CNF + 21 * 4, 1 | 6 << 8).unwrap();
        assert_eq!(gpio.level(21), PinLevel::Low);
        gpio.write(5, offset::OUTSET, 1 << 21).unwrap();
        assert_eq!(gpio.level(21), PinLevel::Released);
        let change = |at, level| PinChange { at, pin: 21, level };
        let changes = [change(0, PinLevel::Low), change(5, PinLevel::Released)];
        assert_eq!(gpio.take_changes(), changes);
    }

    #[test]
    fn what_is_driven_from_outside_is_read_where_the_chip_does_not_drive() {
        let mut gpio = Gpio::new();
        let reads = |gpio: &Gpio| gpio.read(offset::IN).unwrap() >> 4 & 1;
        gpio.write(0, offset::PIN_CNF + 16, 3 << 2).unwrap();
        assert_eq!(reads(&gpio), 1);
        gpio.drive(4, Some(false));
        assert_eq!(reads(&gpio), 0);
        gpio.write(0, offset::OUTSET, 1 << 4).unwrap();
        gpio.write(0, offset::DIRSET, 1 << 4).unwrap();
        assert_eq!(reads(&gpio), 1);
    }
}
