//! The LEDs, and when each went on and off.

use std::collections::VecDeque;

use crate::soc::{Level, Nanos, Pin};

/// An LED, by where it sits (crazyflie-firmware, `led.h`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Led {
    /// PD2, lit when high.
    BlueLeft,
    /// PC1, lit when low, as the others.
    GreenLeft,
    /// PC0.
    RedLeft,
    /// PC2.
    GreenRight,
    /// PC3.
    RedRight,
    /// The radio chip's own, which it lights at its start.
    Radio,
}

impl Led {
    const ON_PINS: [(Pin, Self); 5] = [
        (Pin::new('D', 2), Self::BlueLeft),
        (Pin::new('C', 1), Self::GreenLeft),
        (Pin::new('C', 0), Self::RedLeft),
        (Pin::new('C', 2), Self::GreenRight),
        (Pin::new('C', 3), Self::RedRight),
    ];

    /// Whether the LED is lit at this level of its pin.
    fn is_lit(self, level: Level) -> bool {
        match self {
            Self::BlueLeft => level == Level::High,
            _ => level == Level::Low,
        }
    }
}

/// An LED went on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blink {
    /// When.
    pub at: Nanos,
    /// Which.
    pub led: Led,
    /// Whether the LED is lit now.
    pub on: bool,
}

/// The most changes that are kept.
const KEPT: usize = 4_096;

/// All of them, and what they did last.
#[derive(Debug)]
pub(super) struct Leds {
    lit: Vec<Led>,
    log: VecDeque<Blink>,
}

impl Leds {
    pub(super) fn new() -> Self {
        Self { lit: vec![Led::Radio], log: VecDeque::new() }
    }

    /// A pin is driven; nothing happens where no LED is.
    pub(super) fn drive(&mut self, at: Nanos, pin: Pin, level: Level) {
        if let Some((_, led)) = Led::ON_PINS.into_iter().find(|(of, _)| *of == pin) {
            self.set(at, led, led.is_lit(level));
        }
    }

    pub(super) fn set(&mut self, at: Nanos, led: Led, on: bool) {
        if on == self.is_lit(led) {
            return;
        }
        match on {
            true => self.lit.push(led),
            false => self.lit.retain(|other| *other != led),
        }
        if self.log.len() == KEPT {
            self.log.pop_front();
        }
        self.log.push_back(Blink { at, led, on });
    }

    pub(super) fn is_lit(&self, led: Led) -> bool {
        self.lit.contains(&led)
    }

    pub(super) fn take_log(&mut self) -> Vec<Blink> {
        self.log.drain(..).collect()
    }
}
