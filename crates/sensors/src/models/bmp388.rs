//! Model of a BMP388, the barometer (data sheet BST-BMP388-DS001). The firmware of this project does
//! not use it; the vendor's does not start without it.

use super::{Fault, I2cModel, peek, poke};

/// The sensor's I²C address on the Crazyflie: SDO is high.
const ADDRESS: u8 = 0x77;
/// Number of registers.
const FILE: usize = 0x80;
/// Time in µs from switching on to the first answer (data sheet, start-up time).
const BOOT_US: u32 = 2_000;
/// The same from a reset by command, for which Bosch's driver waits 2 ms, of which the vendor's
/// clock makes one tick and a part of another.
const RESET_US: u32 = 1_000;

const STATUS: usize = 0x03;
const DATA: usize = 0x04;
const EVENT: usize = 0x10;
const POWER: usize = 0x1B;
const RATE: usize = 0x1D;
const CALIBRATION: usize = 0x31;
const COMMAND: usize = 0x7E;

/// STATUS: a command may come; pressure and temperature are new.
const COMMAND_READY: u8 = 1 << 4;
const DATA_READY: u8 = 3 << 5;
/// PWR_CTRL: either sensor is on; the mode in which it measures again and again.
const SENSORS: u8 = 3;
const NORMAL: u8 = 3 << 4;

/// The calibration of an ideal sensor, whose pressure is linear in its raw value: NVM_PAR_T1 to
/// NVM_PAR_T3, NVM_PAR_P1, P2, P5 and zeros (data sheet, 9.1).
const T1: u16 = 27_000;
const T2: u16 = 19_000;
const P1: i16 = -200;
const P2: i16 = 16_384;
const P5: u16 = 22_000;

/// The model of the barometer. It measures a constant pressure of one standard atmosphere at 25 °C.
pub struct Bmp388Model {
    /// The sensor's fault.
    pub fault: Fault,
    registers: [u8; FILE],
    phase: Phase,
    booting: u32,
    until_sample: u32,
}

/// The next byte that is written.
#[derive(Clone, Copy)]
enum Phase {
    Register,
    Value { at: u8 },
}

impl Bmp388Model {
    /// A sensor that has just been switched on.
    #[must_use]
    pub fn new() -> Self {
        let mut model = Self {
            fault: Fault::None,
            registers: [0; FILE],
            phase: Phase::Register,
            booting: 0,
            until_sample: 0,
        };
        model.reset();
        model.booting = BOOT_US;
        model
    }

    /// Sets all registers to their reset values.
    pub fn reset(&mut self) {
        self.registers = [0; FILE];
        poke(&mut self.registers, 0x00, &[0x50, 0x01, 0x00, COMMAND_READY]);
        poke(&mut self.registers, DATA, &[0x00, 0x00, 0x80, 0x00, 0x00, 0x80]);
        poke(&mut self.registers, EVENT, &[0x01]);
        poke(&mut self.registers, 0x1C, &[0x02]);
        let [t1, t2] = [T1, T2].map(u16::to_le_bytes);
        let [p1, p2] = [P1, P2].map(i16::to_le_bytes);
        poke(&mut self.registers, CALIBRATION, &[t1[0], t1[1], t2[0], t2[1], 0]);
        poke(&mut self.registers, CALIBRATION + 5, &[p1[0], p1[1], p2[0], p2[1], 0, 0]);
        poke(&mut self.registers, CALIBRATION + 11, &P5.to_le_bytes());
        self.booting = RESET_US;
    }

    /// The value of a register.
    #[must_use]
    pub fn register(&self, register: u8) -> u8 {
        peek(&self.registers, register.into())
    }

    /// Time in µs between two samples; `None` while it sleeps.
    fn period(&self) -> Option<u32> {
        let power = peek(&self.registers, POWER);
        let measures = power & NORMAL == NORMAL && power & SENSORS != 0;
        measures.then(|| 5_000 << (peek(&self.registers, RATE) & 0x1F).min(17))
    }

    /// The raw values whose compensation is 25 °C and 101,325 Pa (data sheet, 9.2 and 9.3).
    fn sample(&mut self) {
        let temperature = 25.0 / (f32::from(T2) / 1_073_741_824.0) + f32::from(T1) * 256.0;
        let slope = (f32::from(P1) - 16_384.0) / 1_048_576.0;
        let pressure = (101_325.0 - f32::from(P5) * 8.0) / slope;
        for (at, raw) in [(DATA, pressure), (DATA + 3, temperature)] {
            let [low, middle, high, _] = (raw as u32).to_le_bytes();
            poke(&mut self.registers, at, &[low, middle, high]);
        }
        poke(&mut self.registers, STATUS, &[COMMAND_READY | DATA_READY]);
    }

    fn write_register(&mut self, at: u8, value: u8) {
        match usize::from(at) {
            COMMAND if value == 0xB6 => self.reset(),
            // Read-only: identification, status, data and calibration.
            0x00..=0x14 | CALIBRATION..=0x57 => {}
            at => {
                poke(&mut self.registers, at, &[value]);
                if at == POWER {
                    self.until_sample = self.period().unwrap_or(0);
                }
            }
        }
    }
}

impl Default for Bmp388Model {
    fn default() -> Self {
        Self::new()
    }
}

impl I2cModel for Bmp388Model {
    fn start(&mut self, address: u8, read: bool) -> bool {
        if address != ADDRESS || self.booting > 0 {
            return false;
        }
        if !read {
            self.phase = Phase::Register;
        }
        self.fault.acknowledges()
    }

    /// Registers are written in pairs of address and value; only reads count on (data sheet, 5.2).
    fn write(&mut self, byte: u8) -> bool {
        if !self.fault.acknowledges() {
            return false;
        }
        self.phase = match self.phase {
            Phase::Register => Phase::Value { at: byte },
            Phase::Value { at } => {
                self.write_register(at, byte);
                Phase::Register
            }
        };
        true
    }

    fn read(&mut self) -> u8 {
        let Phase::Value { at } = self.phase else { return 0xFF };
        self.phase = Phase::Value { at: at.wrapping_add(1) };
        let byte = peek(&self.registers, at.into());
        // The flags fall when the data is read, the power-on flag when it is.
        match usize::from(at) {
            DATA..=0x09 => poke(&mut self.registers, STATUS, &[COMMAND_READY]),
            EVENT => poke(&mut self.registers, EVENT, &[0]),
            _ => {}
        }
        self.fault.read(byte)
    }

    fn stop(&mut self) {}

    fn advance(&mut self, micros: u32) {
        self.booting = self.booting.saturating_sub(micros);
        let Some(period) = self.period() else { return };
        if micros >= self.until_sample {
            self.sample();
            self.until_sample = period;
        } else {
            self.until_sample -= micros;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<const N: usize>(model: &mut Bmp388Model, at: u8) -> [u8; N] {
        assert!(model.start(ADDRESS, false) && model.write(at) && model.start(ADDRESS, true));
        core::array::from_fn(|_| model.read())
    }

    fn write(model: &mut Bmp388Model, pairs: &[u8]) {
        assert!(model.start(ADDRESS, false) && pairs.iter().all(|byte| model.write(*byte)));
    }

    #[test]
    fn it_answers_after_its_boot_and_after_a_reset() {
        let mut model = Bmp388Model::new();
        assert!(!model.start(ADDRESS, false));
        model.advance(BOOT_US);
        assert_eq!(read(&mut model, 0), [0x50]);
        write(&mut model, &[0x7E, 0xB6]);
        assert!(!model.start(ADDRESS, false));
        assert!(!model.start(0x76, false));
    }

    #[test]
    fn its_compensated_values_are_those_of_a_standard_atmosphere() {
        let mut model = Bmp388Model::new();
        model.advance(BOOT_US);
        // 50 Hz, both sensors, normal mode.
        write(&mut model, &[0x1D, 0x02, 0x1B, 0x33]);
        model.advance(19_999);
        assert_eq!(read(&mut model, 0x03), [COMMAND_READY]);
        model.advance(1);
        assert_eq!(read(&mut model, 0x03), [COMMAND_READY | DATA_READY]);
        let raw: [u8; 6] = read(&mut model, 0x04);
        let value = |at: usize| {
            f32::from(raw[at]) + 256.0 * f32::from(raw[at + 1]) + 65_536.0 * f32::from(raw[at + 2])
        };
        let celsius = (value(3) - f32::from(T1) * 256.0) * f32::from(T2) / 1_073_741_824.0;
        let pascal = f32::from(P5) * 8.0 + value(0) * (f32::from(P1) - 16_384.0) / 1_048_576.0;
        assert!((celsius - 25.0).abs() < 0.01 && (pascal - 101_325.0).abs() < 1.0);
        assert_eq!(read(&mut model, 0x03), [COMMAND_READY]);
    }
}
