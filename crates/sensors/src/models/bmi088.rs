//! Model of a BMI088: two dies with registers of their own, of which the accelerometer sleeps after
//! its reset and the gyroscope has a "data ready" pin.

use units::{Acceleration, AngularVelocity};

use super::{Fault, I2cModel, peek, poke, quantised};
use crate::bmi088::{ACCEL, GYRO};

/// Number of registers of either die.
const FILE: usize = 0x80;
/// Standard gravity in m/s².
const G: f32 = 9.806_65;

/// Duration of the gyroscope's "data ready" pulse in µs (data sheet, GYRO_INT_STAT_1: 280 to 400).
const PULSE_US: u32 = 300;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Die {
    Gyro,
    Accel,
}

/// The state of one die.
struct DieState {
    die: Die,
    registers: [u8; FILE],
    pointer: Option<u8>,
    /// Time in µs until the die answers again after a reset.
    booting: u32,
    /// Time in µs since the last sample.
    since_sample: u32,
    /// Time in µs for which "data ready" is still signalled.
    pulse: u32,
    /// The upper byte that belongs to the lower byte read last, so that both are of one sample
    /// (data sheet, "Rate data").
    locked: Option<u8>,
    /// The true value that the die measures.
    truth: [f32; 3],
    /// The noise of its samples.
    noise: Noise,
}

/// Noise in whole steps, with a random sequence of its own.
struct Noise {
    state: u32,
    steps: u8,
}

impl Noise {
    /// The next noise value, from −`steps` to `steps`: the difference of two uniform random
    /// numbers.
    fn next(&mut self) -> f32 {
        if self.steps == 0 {
            return 0.0;
        }
        let mut draw = || {
            // Xorshift (Marsaglia 2003).
            self.state ^= self.state << 13;
            self.state ^= self.state >> 17;
            self.state ^= self.state << 5;
            (self.state >> 8) % (u32::from(self.steps) + 1)
        };
        let (up, down) = (draw(), draw());
        up as f32 - down as f32
    }
}

impl DieState {
    const fn new(die: Die) -> Self {
        Self {
            die,
            registers: [0; FILE],
            pointer: None,
            booting: 0,
            since_sample: 0,
            pulse: 0,
            locked: None,
            truth: [0.0; 3],
            noise: Noise { state: 1, steps: 0 },
        }
    }

    /// Sets all registers to their reset values (data sheet BST-BMI088-DS001).
    fn reset(&mut self, id: u8, booting: u32) {
        self.registers = [0; FILE];
        self.booting = booting;
        self.since_sample = 0;
        (self.pulse, self.locked) = (0, None);
        poke(&mut self.registers, 0x00, &[id]);
        match self.die {
            Die::Gyro => {
                poke(&mut self.registers, 0x10, &[0x80]);
                poke(&mut self.registers, 0x16, &[0x0F]);
            }
            Die::Accel => {
                poke(&mut self.registers, 0x40, &[0xA8, 0x01]);
                poke(&mut self.registers, 0x7C, &[0x03, 0x00]);
            }
        }
    }

    const fn address(&self) -> u8 {
        match self.die {
            Die::Gyro => GYRO,
            Die::Accel => ACCEL,
        }
    }

    /// Time in µs between samples; `None` while the die sleeps.
    fn sample_period(&self) -> Option<u32> {
        match self.die {
            Die::Gyro if peek(&self.registers, 0x11) != 0 => None,
            Die::Gyro => Some(match peek(&self.registers, 0x10) & 0x07 {
                0 | 1 => 500,
                2 => 1_000,
                3 => 2_500,
                4 | 6 => 5_000,
                _ => 10_000,
            }),
            Die::Accel if peek(&self.registers, 0x7D) != 0x04 => None,
            Die::Accel if peek(&self.registers, 0x7C) != 0x00 => None,
            Die::Accel => {
                let rate = u32::from(peek(&self.registers, 0x40) & 0x0F).clamp(5, 12);
                // 12.5 Hz at 5, doubled with each step up.
                Some(80_000 >> (rate - 5))
            }
        }
    }

    /// One step of a sample, in rad/s or m/s².
    fn step(&self) -> f32 {
        match self.die {
            Die::Gyro => {
                let range = 2000.0 / f32::from(1_u16 << (peek(&self.registers, 0x0F) & 0x07));
                range / 32768.0 * (core::f32::consts::PI / 180.0)
            }
            Die::Accel => {
                let range = 3.0 * f32::from(1_u16 << (peek(&self.registers, 0x41) & 0x03));
                range / 32768.0 * G
            }
        }
    }

    fn advance(&mut self, micros: u32) {
        self.booting = self.booting.saturating_sub(micros);
        self.pulse = self.pulse.saturating_sub(micros);
        let Some(period) = self.sample_period() else { return };
        self.since_sample = self.since_sample.saturating_add(micros);
        if self.since_sample >= period {
            self.since_sample %= period;
            self.sample();
            self.pulse = PULSE_US.saturating_sub(self.since_sample);
        }
        if self.die == Die::Gyro && self.pulse == 0 {
            poke(&mut self.registers, 0x0A, &[0x00]);
        }
    }

    /// Whether "data ready" is enabled on the pin INT3 (GYRO_INT_CTRL, INT3_INT4_IO_MAP).
    fn int3_is_enabled(&self) -> bool {
        peek(&self.registers, 0x15) & 0x80 != 0 && peek(&self.registers, 0x18) & 0x01 != 0
    }

    fn sample(&mut self) {
        let step = self.step();
        let (data, status) = match self.die {
            Die::Gyro => (0x02, 0x0A),
            Die::Accel => (0x12, 0x03),
        };
        for (axis, value) in self.truth.into_iter().enumerate() {
            let noise = self.noise.next() * step;
            let raw = quantised(value + noise, step).to_le_bytes();
            poke(&mut self.registers, data + 2 * axis, &raw);
        }
        // The gyroscope signals its samples only when that is enabled.
        if self.die == Die::Accel || peek(&self.registers, 0x15) & 0x80 != 0 {
            poke(&mut self.registers, status, &[0x80]);
        }
    }

    fn write(&mut self, byte: u8) {
        let Some(at) = self.pointer else {
            self.pointer = Some(byte);
            return;
        };
        let id = peek(&self.registers, 0x00);
        match (self.die, at, byte) {
            (Die::Gyro, 0x14, 0xB6) => self.reset(id, 30_000),
            (Die::Accel, 0x7E, 0xB6) => self.reset(id, 1_000),
            // The built-in self-test is over at once: ready, no failure, rate good (data sheet,
            // GYRO_SELF_TEST).
            (Die::Gyro, 0x3C, _) => {
                let ready = if byte & 0x01 != 0 { 0x02 } else { 0x00 };
                poke(&mut self.registers, 0x3C, &[0x10 | ready]);
            }
            (Die::Gyro, 0x10, _) => poke(&mut self.registers, at.into(), &[byte | 0x80]),
            _ => poke(&mut self.registers, at.into(), &[byte]),
        }
        self.pointer = Some(at.wrapping_add(1));
    }

    fn read(&mut self) -> u8 {
        let at = self.pointer.unwrap_or(0);
        self.pointer = Some(at.wrapping_add(1));
        let byte = peek(&self.registers, at.into());
        let first = match self.die {
            Die::Gyro => 0x02,
            Die::Accel => 0x12,
        };
        if self.die == Die::Accel && at == first {
            poke(&mut self.registers, 0x03, &[0x00]);
        }
        match at.checked_sub(first) {
            Some(0 | 2 | 4) => {
                self.locked = Some(peek(&self.registers, usize::from(at) + 1));
                byte
            }
            Some(1 | 3 | 5) => self.locked.take().unwrap_or(byte),
            _ => byte,
        }
    }
}

/// The model of the inertial sensor.
pub struct Bmi088Model {
    /// The gyroscope's fault.
    pub gyro_fault: Fault,
    /// The accelerometer's fault.
    pub accel_fault: Fault,
    gyro: DieState,
    accel: DieState,
    selected: Option<Die>,
}

impl Bmi088Model {
    /// A sensor that has just been switched on and lies still and level.
    #[must_use]
    pub fn new() -> Self {
        let mut model = Self {
            gyro_fault: Fault::None,
            accel_fault: Fault::None,
            gyro: DieState::new(Die::Gyro),
            accel: DieState::new(Die::Accel),
            selected: None,
        };
        model.accel.truth = [0.0, 0.0, G];
        model.set_ids(0x0F, 0x1E);
        model
    }

    /// Resets both dies as a drop of the supply does.
    pub fn reset(&mut self) {
        self.reset_gyro();
        self.reset_accel();
    }

    /// Resets the gyroscope alone.
    pub fn reset_gyro(&mut self) {
        let id = peek(&self.gyro.registers, 0);
        self.gyro.reset(id, 0);
    }

    /// Resets the accelerometer alone.
    pub fn reset_accel(&mut self) {
        let id = peek(&self.accel.registers, 0);
        self.accel.reset(id, 0);
    }

    /// Sets the identifications of the dies, and resets both.
    pub fn set_ids(&mut self, gyro: u8, accel: u8) {
        self.gyro.reset(gyro, 0);
        self.accel.reset(accel, 0);
    }

    /// Sets the true values that the dies measure from now on.
    pub fn set(&mut self, gyro: AngularVelocity, accel: Acceleration) {
        self.gyro.truth = gyro.0;
        self.accel.truth = accel.0;
    }

    /// Adds noise to every sample from now on, at most this many steps either way. Without noise
    /// the samples of a constant value are equal to the last bit, as those of a real die never are.
    pub fn set_noise(&mut self, seed: u32, gyro_steps: u8, accel_steps: u8) {
        self.gyro.noise = Noise { state: seed.max(1), steps: gyro_steps };
        self.accel.noise = Noise { state: (!seed).max(1), steps: accel_steps };
    }

    /// The level of the pin INT3: true is high, and `None` is an open drain that is released
    /// (INT3_INT4_IO_CONF).
    #[must_use]
    pub fn int3(&self) -> Option<bool> {
        let configuration = self.gyro_register(0x16);
        let active_high = configuration & 0x01 != 0;
        let high = active_high == (self.gyro.int3_is_enabled() && self.gyro.pulse > 0);
        let open_drain = configuration & 0x02 != 0;
        if open_drain && high { None } else { Some(high) }
    }

    /// The time in µs until INT3 changes by itself; `None` if it does not.
    #[must_use]
    pub fn int3_changes_in(&self) -> Option<u32> {
        if !self.gyro.int3_is_enabled() {
            return None;
        }
        let period = self.gyro.sample_period()?;
        let next_sample = period.saturating_sub(self.gyro.since_sample);
        Some(if self.gyro.pulse > 0 { self.gyro.pulse.min(next_sample) } else { next_sample })
    }

    /// The value of a register of the gyroscope.
    #[must_use]
    pub fn gyro_register(&self, register: u8) -> u8 {
        peek(&self.gyro.registers, register.into())
    }

    /// The value of a register of the accelerometer.
    #[must_use]
    pub fn accel_register(&self, register: u8) -> u8 {
        peek(&self.accel.registers, register.into())
    }

    /// The die that takes part in the transaction, with its fault.
    const fn selected(&mut self) -> Option<(&mut DieState, &mut Fault)> {
        match self.selected {
            Some(Die::Gyro) => Some((&mut self.gyro, &mut self.gyro_fault)),
            Some(Die::Accel) => Some((&mut self.accel, &mut self.accel_fault)),
            None => None,
        }
    }
}

impl Default for Bmi088Model {
    fn default() -> Self {
        Self::new()
    }
}

impl I2cModel for Bmi088Model {
    fn start(&mut self, address: u8, read: bool) -> bool {
        self.selected = [Die::Gyro, Die::Accel].into_iter().find(|die| match die {
            Die::Gyro => self.gyro.address() == address,
            Die::Accel => self.accel.address() == address,
        });
        let Some((state, fault)) = self.selected() else { return false };
        if !read {
            state.pointer = None;
        }
        state.booting == 0 && fault.acknowledges()
    }

    fn write(&mut self, byte: u8) -> bool {
        let Some((state, fault)) = self.selected() else { return false };
        if !fault.acknowledges() {
            return false;
        }
        state.write(byte);
        true
    }

    fn read(&mut self) -> u8 {
        match self.selected() {
            Some((state, fault)) => fault.read(state.read()),
            None => 0xFF,
        }
    }

    fn stop(&mut self) {
        self.selected = None;
    }

    fn advance(&mut self, micros: u32) {
        self.gyro.advance(micros);
        self.accel.advance(micros);
    }
}
