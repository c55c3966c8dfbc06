//! A PMW3901: banks of registers, a motion burst, and a watch on the pauses that it needs.

use super::{Fault, SpiModel, peek, poke};

/// Registers in a bank; banks up to 0x15 are used.
const FILE: usize = 0x80;
const BANKS: usize = 0x16;

/// From the address to the data of a read in ns (data sheet, t_SRAD and t_SRAD_MOTBR).
const READ_GAP: u32 = 35_000;
/// From one command to the next in ns (data sheet, t_SWW and t_SWR; after a read 20 µs suffice).
const AFTER_WRITE: u32 = 45_000;
const AFTER_READ: u32 = 20_000;

#[derive(Clone, Copy)]
enum Phase {
    Address,
    Write { register: u8 },
    Read { register: u8 },
    Burst { sent: usize },
    Done,
}

/// The model.
pub struct Pmw3901Model {
    /// What is wrong with it. [`Fault::Absent`] reads as a line that is pulled high.
    pub fault: Fault,
    /// Surface quality, once the chip is configured.
    pub squal: u8,
    /// Exposure.
    pub shutter: u16,
    /// Mean brightness of the image,
    pub raw_sum: u8,
    /// its brightest pixel,
    pub raw_max: u8,
    /// and its darkest.
    pub raw_min: u8,
    banks: [[u8; FILE]; BANKS],
    id: [u8; 2],
    counts: [i16; 2],
    burst: [u8; 12],
    phase: Phase,
    idle: u32,
    rest: u32,
    violations: u32,
}

impl Pmw3901Model {
    /// As after switching on, over a good ground, standing still.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            fault: Fault::None,
            squal: 80,
            shutter: 1_200,
            raw_sum: 120,
            raw_max: 200,
            raw_min: 40,
            banks: [[0; FILE]; BANKS],
            id: [0x49, 0xB6],
            counts: [0; 2],
            burst: [0; 12],
            phase: Phase::Address,
            idle: u32::MAX,
            rest: 0,
            violations: 0,
        }
    }

    /// The supply dips: it forgets its configuration, and what it has counted.
    pub fn reset(&mut self) {
        self.banks = [[0; FILE]; BANKS];
        self.counts = [0; 2];
        self.phase = Phase::Done;
    }

    /// Lets it call itself so.
    pub const fn set_id(&mut self, id: [u8; 2]) {
        self.id = id;
    }

    /// The chip sees the ground move, in counts along its own axes.
    pub const fn push(&mut self, dx: i16, dy: i16) {
        let [x, y] = self.counts;
        self.counts = [x.saturating_add(dx), y.saturating_add(dy)];
    }

    /// How often it was given less time than it needs.
    #[must_use]
    pub const fn violations(&self) -> u32 {
        self.violations
    }

    /// A register of a bank.
    #[must_use]
    pub fn register(&self, bank: u8, register: u8) -> u8 {
        self.banks.get(usize::from(bank)).map_or(0, |bank| peek(bank, register.into()))
    }

    /// Whether the maker's settings are in place, going by the last of them.
    #[must_use]
    pub fn is_configured(&self) -> bool {
        self.register(0x00, 0x61) == 0xAD
            && self.register(0x00, 0x5A) == 0x10
            && self.register(0x07, 0x40) == 0x40
            && self.register(0x0D, 0x6F) == 0xD5
    }

    fn bank(&self) -> u8 {
        self.register(0x00, 0x7F)
    }

    fn needs(&mut self, nanos: u32) {
        if self.idle < nanos {
            self.violations += 1;
        }
    }

    fn write_register(&mut self, register: u8, value: u8) {
        match (self.bank(), register, value) {
            // Wherever it is written, the bank's number is one.
            (_, 0x7F, _) => {
                if let Some(first) = self.banks.first_mut() {
                    poke(first, 0x7F, &[value]);
                }
            }
            (0, 0x3A, 0x5A) => {
                self.banks = [[0; FILE]; BANKS];
                self.counts = [0; 2];
            }
            (bank, _, _) => {
                if let Some(bank) = self.banks.get_mut(usize::from(bank)) {
                    poke(bank, register.into(), &[value]);
                }
            }
        }
    }

    fn read_register(&mut self, register: u8) -> u8 {
        let [id, inverse] = self.id;
        match (self.bank(), register) {
            (0, 0x00) => id,
            (0, 0x5F) => inverse,
            // Reading the motion register freezes the counts, which lie behind it in another order
            // than a burst's (data sheet, Motion).
            (0, 0x02) => {
                self.latch();
                peek(&self.burst, 0)
            }
            (0, 0x03..=0x06) => peek(&self.burst, usize::from(register) - 1),
            (bank, _) => self.register(bank, register),
        }
    }

    /// Freezes what a burst will send, and begins to count anew.
    fn latch(&mut self) {
        let [x, y] = core::mem::take(&mut self.counts);
        let moved = (x, y) != (0, 0);
        let squal = if self.is_configured() { self.squal } else { 0 };
        let ([x0, x1], [y0, y1]) = (x.to_le_bytes(), y.to_le_bytes());
        let [s1, s0] = self.shutter.to_be_bytes();
        let motion = if moved { 0xB0 } else { 0x30 };
        let (sum, max, min) = (self.raw_sum, self.raw_max, self.raw_min);
        self.burst = [motion, 0xBF, x0, x1, y0, y1, squal, sum, max, min, s1, s0];
    }
}

impl Default for Pmw3901Model {
    fn default() -> Self {
        Self::new()
    }
}

impl SpiModel for Pmw3901Model {
    fn select(&mut self) {
        self.phase = Phase::Address;
    }

    fn transfer(&mut self, byte: u8) -> u8 {
        let (phase, answer) = match self.phase {
            Phase::Address => {
                self.needs(self.rest);
                match byte {
                    0x16 => {
                        self.latch();
                        (Phase::Burst { sent: 0 }, 0)
                    }
                    _ if byte & 0x80 != 0 => (Phase::Write { register: byte & 0x7F }, 0),
                    register => (Phase::Read { register }, 0),
                }
            }
            Phase::Write { register } => {
                self.write_register(register, byte);
                self.rest = AFTER_WRITE;
                (Phase::Done, 0)
            }
            Phase::Read { register } => {
                self.needs(READ_GAP);
                self.rest = AFTER_READ;
                (Phase::Done, self.read_register(register))
            }
            Phase::Burst { sent } => {
                if sent == 0 {
                    self.needs(READ_GAP);
                }
                self.rest = AFTER_READ;
                (Phase::Burst { sent: sent + 1 }, peek(&self.burst, sent))
            }
            Phase::Done => (Phase::Done, 0),
        };
        self.phase = phase;
        self.idle = 0;
        match self.fault {
            Fault::Absent => 0xFF,
            fault => fault.read(answer),
        }
    }

    fn deselect(&mut self) {
        self.phase = Phase::Done;
    }

    fn advance(&mut self, nanos: u32) {
        self.idle = self.idle.saturating_add(nanos);
    }
}
