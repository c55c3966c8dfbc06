//! The two lines of an I²C bus: which devices take part, which fault holds a line low, and a
//! controller that moves the lines by hand.

use crate::soc::Level;

/// A fault that keeps a line low that should be high.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hold {
    /// No line is held.
    None,
    /// A device that was interrupted while it sent. It lets go of the data line at the falling edge
    /// of its last clock; without a number, never.
    Data { clocks: Option<u32> },
    /// The clock line is held, which no clock pulse can end.
    Clock,
}

/// The meaning of a line's movement by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gesture {
    None,
    Start,
    Stop,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line {
    Clock,
    Data,
}

/// A bus.
#[derive(Debug)]
pub(super) struct Wires {
    /// Devices that acknowledged their address, one bit each.
    pub(super) taking_part: u8,
    hold: Hold,
    /// The lines as the controller leaves them when it moves them by hand.
    clock: bool,
    data: bool,
}

impl Wires {
    pub(super) const fn new() -> Self {
        Self { taking_part: 0, hold: Hold::None, clock: true, data: true }
    }

    pub(super) const fn hold(&mut self, hold: Hold) {
        self.hold = hold;
    }

    /// Clock and data, as the devices leave them.
    pub(super) const fn released(&self) -> (bool, bool) {
        match self.hold {
            Hold::None => (true, true),
            Hold::Data { .. } => (true, false),
            Hold::Clock => (false, true),
        }
    }

    pub(super) const fn is_held(&self) -> bool {
        !matches!(self.hold, Hold::None)
    }

    /// The level of a line: low if any device holds it.
    pub(super) const fn level(&self, line: Line) -> Level {
        let (clock, data) = self.released();
        let high = match line {
            Line::Clock => clock && self.clock,
            Line::Data => data && self.data,
        };
        if high { Level::High } else { Level::Low }
    }

    /// The controller moves a line by hand.
    pub(super) fn drive(&mut self, line: Line, level: Level) -> Gesture {
        let before = (self.level(Line::Clock), self.level(Line::Data));
        let high = level != Level::Low;
        match line {
            Line::Clock => self.clock = high,
            Line::Data => self.data = high,
        }
        let after = (self.level(Line::Clock), self.level(Line::Data));
        match (before, after) {
            ((Level::High, _), (Level::Low, _)) => {
                self.clocked();
                Gesture::None
            }
            ((Level::High, Level::High), (Level::High, Level::Low)) => Gesture::Start,
            ((Level::High, Level::Low), (Level::High, Level::High)) => Gesture::Stop,
            _ => Gesture::None,
        }
    }

    const fn clocked(&mut self) {
        self.hold = match self.hold {
            Hold::Data { clocks: Some(0 | 1) } => Hold::None,
            Hold::Data { clocks: Some(left) } => Hold::Data { clocks: Some(left - 1) },
            hold => hold,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_lets_go_at_the_falling_edge_of_its_last_clock() {
        let mut wires = Wires::new();
        wires.hold(Hold::Data { clocks: Some(2) });
        for data in [Level::Low, Level::High] {
            assert_eq!(wires.drive(Line::Clock, Level::High), Gesture::None);
            assert_eq!(wires.level(Line::Data), Level::Low);
            wires.drive(Line::Clock, Level::Low);
            assert_eq!(wires.level(Line::Data), data);
        }
    }

    #[test]
    fn a_held_clock_hides_every_gesture() {
        let mut wires = Wires::new();
        wires.hold(Hold::Clock);
        for level in [Level::Low, Level::Released, Level::Low, Level::High] {
            assert_eq!(wires.drive(Line::Data, level), Gesture::None);
            assert_eq!(wires.level(Line::Clock), Level::Low);
        }
    }

    #[test]
    fn data_that_moves_while_the_clock_is_high_is_a_start_or_a_stop() {
        let mut wires = Wires::new();
        assert_eq!(wires.drive(Line::Data, Level::Low), Gesture::Start);
        assert_eq!(wires.drive(Line::Clock, Level::Low), Gesture::None);
        assert_eq!(wires.drive(Line::Data, Level::Released), Gesture::None);
        assert_eq!(wires.drive(Line::Data, Level::Low), Gesture::None);
        assert_eq!(wires.drive(Line::Clock, Level::High), Gesture::None);
        assert_eq!(wires.drive(Line::Data, Level::High), Gesture::Stop);
    }
}
