//! Model of a PMW3901, the optical flow sensor: banks of registers, a motion burst, and a count of
//! the pauses that were shorter than the chip needs.

use super::{Fault, SpiModel, peek, poke};

/// Number of registers in a bank.
const FILE: usize = 0x80;
/// Number of banks; banks up to 0x15 are used.
const BANKS: usize = 0x16;

/// Shortest pause in ns from the address to the data of a read (data sheet, t_SRAD and
/// t_SRAD_MOTBR).
const READ_GAP: u32 = 35_000;
/// Shortest pause in ns from a write to the next command (data sheet, t_SWW and t_SWR).
const AFTER_WRITE: u32 = 45_000;
/// Shortest pause in ns from a read to the next command (data sheet).
const AFTER_READ: u32 = 20_000;

#[derive(Clone, Copy)]
enum Phase {
    Address,
    Write { register: u8 },
    Read { register: u8 },
    Burst { sent: usize },
    Done,
}

/// The model of the chip.
pub struct Pmw3901Model {
    /// The chip's fault. [`Fault::Absent`] reads as a line that is pulled high.
    pub fault: Fault,
    /// The surface quality, once the chip is configured.
    pub squal: u8,
    /// The exposure in cycles of the chip's clock.
    pub shutter: u16,
    /// The mean brightness of the image.
    pub raw_sum: u8,
    /// Brightness of the brightest pixel.
    pub raw_max: u8,
    /// Brightness of the darkest pixel.
    pub raw_min: u8,
    banks: [[u8; FILE]; BANKS],
    id: [u8; 2],
    counts: [i16; 2],
    burst: [u8; 12],
    phase: Phase,
    /// Time in ns since the last byte.
    idle: u32,
    /// Time in ns that must pass before the next command.
    rest: u32,
    violations: u32,
}

impl Pmw3901Model {
    /// A chip that has just been switched on and stands still over well-textured ground.
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

    /// Resets the chip as a drop of its supply does: it loses its configuration and its counts.
    pub fn reset(&mut self) {
        self.banks = [[0; FILE]; BANKS];
        self.counts = [0; 2];
        self.phase = Phase::Done;
    }

    /// Sets the chip's two identification bytes.
    pub const fn set_id(&mut self, id: [u8; 2]) {
        self.id = id;
    }

    /// Moves the ground under the chip, in counts along the chip's own axes.
    pub const fn push(&mut self, dx: i16, dy: i16) {
        let [x, y] = self.counts;
        self.counts = [x.saturating_add(dx), y.saturating_add(dy)];
    }

    /// Number of times that a pause was shorter than the chip needs.
    #[must_use]
    pub const fn violations(&self) -> u32 {
        self.violations
    }

    /// The value of a register of a bank.
    #[must_use]
    pub fn register(&self, bank: u8, register: u8) -> u8 {
        self.banks.get(usize::from(bank)).map_or(0, |bank| peek(bank, register.into()))
    }

    /// Whether the manufacturer's settings are in place, judged by the last of them.
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

    /// Counts a violation if less than `nanos` ns have passed since the last byte.
    fn require_pause(&mut self, nanos: u32) {
        if self.idle < nanos {
            self.violations += 1;
        }
    }

    fn write_register(&mut self, register: u8, value: u8) {
        match (self.bank(), register, value) {
            // The register that selects the bank is the same in every bank.
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
            // Reading the motion register latches the counts, which the next registers hold (data
            // sheet, Motion).
            (0, 0x02) => {
                self.latch();
                peek(&self.burst, 0)
            }
            (0, 0x03..=0x06) => peek(&self.burst, usize::from(register) - 1),
            (bank, _) => self.register(bank, register),
        }
    }

    /// Latches the bytes of a burst, and sets the counts to zero.
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
                self.require_pause(self.rest);
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
                self.require_pause(READ_GAP);
                self.rest = AFTER_READ;
                (Phase::Done, self.read_register(register))
            }
            Phase::Burst { sent } => {
                if sent == 0 {
                    self.require_pause(READ_GAP);
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
