//! GPIO: what each pin is, and its level (RM0090, "General-purpose I/Os").
//!
//! The level that a peripheral drives through an alternate function does not show in GPIO_IDR here:
//! such a pin reads as the board has it. A pin that nothing drives or pulls reads low.

use crate::bus::Refused;
use crate::soc::wiring::{Board, Level, Pin};

const PORTS: usize = 9;

/// The mode of a pin (GPIO_MODER).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Input,
    Output,
    Alternate(u8),
    Analog,
}

/// The state of the sequence that locks a port (GPIO_LCKR).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Lock {
    #[default]
    Open,
    /// Written with LCKK set.
    Armed(u32),
    /// Then without.
    Cocked(u32),
    /// And again with: these pins are locked, once LCKR is read.
    Fired(u32),
    Locked(u32),
}

impl Lock {
    const KEY: u32 = 1 << 16;

    fn written(self, value: u32) -> Self {
        let pins = value & 0xFFFF;
        match (self, value & Self::KEY != 0) {
            (Self::Locked(_), _) => self,
            (Self::Armed(armed), false) if armed == pins => Self::Cocked(pins),
            (Self::Cocked(armed), true) if armed == pins => Self::Fired(pins),
            (_, true) => Self::Armed(pins),
            (_, false) => Self::Open,
        }
    }

    fn read(self) -> Self {
        if let Self::Fired(pins) = self { Self::Locked(pins) } else { self }
    }

    fn value(self) -> u32 {
        match self {
            Self::Open => 0,
            Self::Armed(pins) | Self::Cocked(pins) | Self::Fired(pins) => pins,
            Self::Locked(pins) => pins | Self::KEY,
        }
    }

    fn pins(self) -> u32 {
        if let Self::Locked(pins) = self { pins } else { 0 }
    }
}

/// One port's registers.
#[derive(Clone, Copy, Debug)]
struct Port {
    moder: u32,
    otyper: u32,
    ospeedr: u32,
    pupdr: u32,
    odr: u32,
    lock: Lock,
    afr: [u32; 2],
    /// The driven pins and their levels, as the board was last notified.
    driven: u32,
    high: u32,
}

impl Port {
    /// After reset the debugger's pins are in use: PA13 to PA15, PB3 and PB4.
    fn new(number: usize) -> Self {
        let (moder, ospeedr, pupdr) = match number {
            0 => (0xA800_0000, 0x0C00_0000, 0x6400_0000),
            1 => (0x0000_0280, 0x0000_00C0, 0x0000_0100),
            _ => (0, 0, 0),
        };
        Self {
            moder,
            otyper: 0,
            ospeedr,
            pupdr,
            odr: 0,
            lock: Lock::Open,
            afr: [0; 2],
            driven: 0,
            high: 0,
        }
    }

    fn mode(&self, pin: usize) -> Mode {
        match self.moder >> (2 * pin) & 3 {
            0 => Mode::Input,
            1 => Mode::Output,
            2 => Mode::Alternate((self.afr[pin / 8] >> (4 * (pin % 8)) & 15) as u8),
            _ => Mode::Analog,
        }
    }

    /// The level that a pin drives as a plain output.
    fn drives(&self, pin: usize) -> Level {
        let is_open_drain = self.otyper >> pin & 1 != 0;
        match (self.mode(pin), self.odr >> pin & 1 != 0) {
            (Mode::Output, false) => Level::Low,
            (Mode::Output, true) if !is_open_drain => Level::High,
            _ => Level::Released,
        }
    }

    /// PUPDR's reserved value 3 is kept and taken for no pull: the vendor's LED set-up writes bytes
    /// that it has not initialised there, which reach the pulls of neighbouring pins.
    fn pulls_up(&self, pin: usize) -> bool {
        self.pupdr >> (2 * pin) & 3 == 1
    }
}

/// All ports' pins.
#[derive(Clone, Debug)]
pub(crate) struct Pins {
    ports: [Port; PORTS],
}

impl Pins {
    pub(crate) fn new() -> Self {
        Self { ports: std::array::from_fn(Port::new) }
    }

    pub(crate) fn mode(&self, pin: Pin) -> Mode {
        self.ports[pin.port()].mode(pin.number())
    }

    /// The alternate function that a pin is in, if it is in one.
    pub(crate) fn alternate(&self, pin: Pin) -> Option<u8> {
        match self.mode(pin) {
            Mode::Alternate(function) => Some(function),
            _ => None,
        }
    }

    /// The level that a pin drives as a plain output.
    pub(crate) fn drives(&self, pin: Pin) -> Level {
        self.ports[pin.port()].drives(pin.number())
    }

    /// Whether a pin is high, as GPIO_IDR and EXTI see it.
    pub(crate) fn is_high<B: Board>(&self, pin: Pin, board: &B) -> bool {
        let port = &self.ports[pin.port()];
        let number = pin.number();
        // The Schmitt trigger is off.
        if port.mode(number) == Mode::Analog {
            return false;
        }
        match port.drives(number) {
            Level::High => true,
            Level::Low => false,
            Level::Released => match board.level(pin) {
                Level::High => true,
                Level::Low => false,
                Level::Released => port.pulls_up(number),
            },
        }
    }

    pub(crate) fn read<B: Board>(
        &mut self,
        number: usize,
        offset: u32,
        board: &B,
    ) -> Result<u32, Refused> {
        let port = &mut self.ports[number];
        Ok(match offset {
            0x00 => port.moder,
            0x04 => port.otyper,
            0x08 => port.ospeedr,
            0x0C => port.pupdr,
            0x10 => (0..16).fold(0, |levels, pin| {
                levels | u32::from(self.is_high(Pin::of(number, pin), board)) << pin
            }),
            0x14 => port.odr,
            0x18 => 0,
            0x1C => {
                port.lock = port.lock.read();
                port.lock.value()
            }
            0x20 => port.afr[0],
            0x24 => port.afr[1],
            _ => return Err(Refused::Unmodelled { what: "GPIO: a reserved register" }),
        })
    }

    pub(crate) fn write<B: Board>(
        &mut self,
        number: usize,
        offset: u32,
        value: u32,
        board: &mut B,
    ) -> Result<(), Refused> {
        let port = &mut self.ports[number];
        let locked = port.lock.pins();
        match offset {
            0x00 => keep(&mut port.moder, value, spread(locked, 2)),
            0x04 => keep(&mut port.otyper, value & 0xFFFF, locked),
            0x08 => keep(&mut port.ospeedr, value, spread(locked, 2)),
            0x0C => keep(&mut port.pupdr, value, spread(locked, 2)),
            // Read-only.
            0x10 => {}
            0x14 => port.odr = value & 0xFFFF,
            // Where both are written, setting wins.
            0x18 => port.odr = port.odr & !(value >> 16) | value & 0xFFFF,
            0x1C => port.lock = port.lock.written(value),
            0x20 => keep(&mut port.afr[0], value, spread(locked & 0xFF, 4)),
            0x24 => keep(&mut port.afr[1], value, spread(locked >> 8, 4)),
            _ => return Err(Refused::Unmodelled { what: "GPIO: a reserved register" }),
        }
        if matches!(offset, 0x00 | 0x04 | 0x14 | 0x18) {
            self.tell(number, board);
        }
        Ok(())
    }

    /// A port is reset; what it drove is let go.
    pub(crate) fn reset<B: Board>(&mut self, number: usize, board: &mut B) {
        let Port { driven, high, .. } = self.ports[number];
        self.ports[number] = Port { driven, high, ..Port::new(number) };
        self.tell(number, board);
    }

    pub(crate) fn reset_all<B: Board>(&mut self, board: &mut B) {
        for number in 0..PORTS {
            self.reset(number, board);
        }
    }

    /// The board hears of every pin that is driven otherwise than before.
    fn tell<B: Board>(&mut self, number: usize, board: &mut B) {
        let port = &mut self.ports[number];
        let (mut driven, mut high) = (0, 0);
        for pin in 0..16 {
            match port.drives(pin) {
                Level::Released => {}
                Level::Low => driven |= 1 << pin,
                Level::High => {
                    driven |= 1 << pin;
                    high |= 1 << pin;
                }
            }
        }
        let mut changed = (driven ^ port.driven) | (high ^ port.high);
        (port.driven, port.high) = (driven, high);
        while changed != 0 {
            let pin = changed.trailing_zeros() as usize;
            changed &= changed - 1;
            board.drive(Pin::of(number, pin), port.drives(pin));
        }
    }

    /// Everything that tells one state from another.
    pub(crate) fn words(&self) -> impl Iterator<Item = u32> + '_ {
        self.ports.iter().flat_map(|port| {
            let Port { moder, otyper, ospeedr, pupdr, odr, lock, afr, .. } = *port;
            [moder, otyper, ospeedr, pupdr, odr, lock.value(), afr[0], afr[1]]
        })
    }
}

/// Stores `value` except where `frozen`.
fn keep(register: &mut u32, value: u32, frozen: u32) {
    *register = *register & frozen | value & !frozen;
}

/// Spreads one bit per pin to `width` bits per pin.
fn spread(pins: u32, width: u32) -> u32 {
    (0..32 / width)
        .filter(|pin| pins >> pin & 1 != 0)
        .fold(0, |mask, pin| mask | ((1 << width) - 1) << (width * pin))
}
