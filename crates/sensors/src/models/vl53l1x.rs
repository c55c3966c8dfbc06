//! Model of a VL53L1x: its reset line, its boot, its changeable address, and measurements that take
//! as long as the timeouts in its registers say.

use core::ops::Deref;
use core::sync::atomic::{AtomicU8, Ordering};

use units::Metres;

use super::{Fault, I2cModel, peek, poke};
use crate::expander::Lines;
use crate::vl53l1x::{CountRate, DEFAULT_ADDRESS, METRES_PER_STEP};

/// Number of registers, up to the identification.
const FILE: usize = 0x0112;
/// Time from the reset to the first answer, in µs. The data sheet's t_BOOT is 1200 at most; the
/// vendor's firmware waits for two ticks, of which the first is cut, and finds every sensor there.
const BOOT_US: u32 = 1_000;
/// The oscillator's calibration: ticks of the period register in a millisecond.
const OSCILLATOR: u16 = 800;
/// Time in ns of the 2304 ticks of the laser's clock that make a macro period, as ST's API
/// calculates it for the usual oscillator of 11.8 MHz.
const MACRO_TICK_NS: u64 = 3_051;
/// Time of a measurement beside the two timeouts, in µs.
const OVERHEAD_US: u64 = 4_500;

/// SYSTEM__MODE_START: ranging is aborted, after which the stream count goes on when it is started
/// again. A stop, which is a zero, lets it begin anew. ST's API takes a count of zero for a range
/// without a check for wrapping; the vendor aborts after every range, and has good ones.
const ABORT: u8 = 0x80;

/// A fault of this sensor beside a [`Fault`] of its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vl53l1xFault {
    /// The sensor works.
    #[default]
    None,
    /// The sensor's own firmware never starts.
    NeverBoots,
    /// The sensor never has a result.
    NeverReady,
    /// The sensor signals new results, but they are always the same.
    Frozen,
    /// Every measurement ends with this status code of the device.
    Status(u8),
}

/// The model of a ranger.
pub struct Vl53l1xModel<L> {
    /// The fault on its bus.
    pub fault: Fault,
    /// The fault of its ranging.
    pub ranging_fault: Vl53l1xFault,
    /// The distance to the target.
    pub distance: Metres,
    /// The standard deviation that it reports.
    pub sigma: Metres,
    /// The status code of a measurement; with `None` it depends on the distance.
    pub status: Option<u8>,
    /// The rate of its own light that is reflected back.
    pub signal: CountRate,
    /// The rate of the ambient light.
    pub ambient: CountRate,
    /// The value of its identification register.
    pub model_id: u16,
    reset_line: Option<(L, Lines)>,
    was_off: bool,
    registers: [u8; FILE],
    pointer: Pointer,
    booting: u32,
    until_result: Option<u32>,
    stream: Option<u8>,
    /// A result that was not acknowledged.
    ready: bool,
    results: u32,
}

#[derive(Clone, Copy)]
enum Pointer {
    Unset,
    High(u8),
    At(u16),
}

impl Vl53l1xModel<&'static AtomicU8> {
    /// A sensor without a reset line that has just been switched on.
    #[must_use]
    pub fn alone() -> Self {
        Self::new(None)
    }
}

impl<L: Deref<Target = AtomicU8>> Vl53l1xModel<L> {
    /// A sensor that has just been switched on. With a reset line, it is in reset while that is
    /// low.
    #[must_use]
    pub fn new(reset_line: Option<(L, Lines)>) -> Self {
        let mut model = Self {
            fault: Fault::None,
            ranging_fault: Vl53l1xFault::None,
            distance: Metres(1.0),
            sigma: Metres(0.003),
            status: None,
            signal: CountRate(8.0),
            ambient: CountRate(0.25),
            model_id: 0xEACC,
            reset_line,
            was_off: false,
            registers: [0; FILE],
            pointer: Pointer::Unset,
            booting: 0,
            until_result: None,
            stream: None,
            ready: false,
            results: 0,
        };
        model.reset();
        model
    }

    /// Resets the sensor as a drop of its supply does: it answers at its default address again and
    /// does not measure.
    pub fn reset(&mut self) {
        self.registers = [0; FILE];
        poke(&mut self.registers, 0x0001, &[DEFAULT_ADDRESS]);
        poke(&mut self.registers, 0x0030, &[0x11, 0x01]);
        poke(&mut self.registers, 0x00DE, &OSCILLATOR.to_be_bytes());
        poke(&mut self.registers, 0x010F, &self.model_id.to_be_bytes());
        self.booting = BOOT_US;
        self.until_result = None;
        (self.stream, self.ready) = (None, false);
    }

    /// The I²C address at which it answers.
    #[must_use]
    pub fn address(&self) -> u8 {
        peek(&self.registers, 0x0001) & 0x7F
    }

    /// The value of a register.
    #[must_use]
    pub fn register(&self, register: u16) -> u8 {
        peek(&self.registers, register.into())
    }

    /// Number of measurements since it was switched on.
    #[must_use]
    pub const fn results(&self) -> u32 {
        self.results
    }

    /// The time in µs until the present measurement is over, if there is one.
    #[must_use]
    pub const fn until_result(&self) -> Option<u32> {
        self.until_result
    }

    fn word(&self, at: usize) -> (u8, u8) {
        (peek(&self.registers, at), peek(&self.registers, at + 1))
    }

    /// Time in µs of a measurement, by the two timeouts.
    fn measurement(&self) -> u64 {
        let phase = |timeout: usize, vcsel: usize| {
            let (exponent, mantissa) = self.word(timeout);
            let macro_periods = (u64::from(mantissa) << (exponent & 0x0F)) + 1;
            let ticks = (u64::from(peek(&self.registers, vcsel)) + 1) * 2;
            macro_periods * ticks * MACRO_TICK_NS / 1_000
        };
        phase(0x005E, 0x0060) + phase(0x0061, 0x0063) + OVERHEAD_US
    }

    /// The time in µs from one result to the next: the period, or the measurement if that takes
    /// longer.
    #[must_use]
    pub fn result_period(&self) -> u32 {
        let ((p3, p2), (p1, p0)) = (self.word(0x006C), self.word(0x006E));
        let period = u64::from(u32::from_be_bytes([p3, p2, p1, p0])) * 1_000_000
            / (u64::from(OSCILLATOR) * 1_075);
        u32::try_from(self.measurement().max(period)).unwrap_or(u32::MAX)
    }

    /// Whether the sensor is without supply or held in reset. A change of either resets the sensor.
    fn is_off(&mut self) -> bool {
        let held = self
            .reset_line
            .as_ref()
            .is_some_and(|(lines, own)| lines.load(Ordering::Relaxed) & own.bits() == 0);
        let off = held || self.fault == Fault::Absent;
        if off != self.was_off {
            self.reset();
            self.was_off = off;
        }
        off
    }

    fn finish_measurement(&mut self) {
        if self.ranging_fault == Vl53l1xFault::NeverReady {
            return;
        }
        self.ready = true;
        if self.ranging_fault == Vl53l1xFault::Frozen {
            return;
        }
        self.results = self.results.saturating_add(1);
        // The stream count starts at zero, and after 255 goes on from 128.
        let stream = self.stream.map_or(0, |last| last.checked_add(1).unwrap_or(128));
        self.stream = Some(stream);
        let status = match self.ranging_fault {
            Vl53l1xFault::Status(code) => code,
            _ => self.status.unwrap_or(if self.distance.0 > 4.0 { 4 } else { 9 }),
        };
        let word = |value: f32| ((value + 0.5) as u16).to_be_bytes();
        poke(&mut self.registers, 0x0089, &[status, 0, stream]);
        poke(&mut self.registers, 0x0090, &word(self.ambient.0 * 128.0));
        poke(&mut self.registers, 0x0092, &word(self.sigma.0 * 4e3));
        poke(&mut self.registers, 0x0096, &word(self.distance.0 / METRES_PER_STEP));
        poke(&mut self.registers, 0x0098, &word(self.signal.0 * 128.0));
    }

    /// GPIO__TIO_HV_STATUS: the level of the interrupt line, which is low for a result where
    /// GPIO_HV_MUX__CTRL has chosen active low, as after a reset.
    fn line_status(&self) -> u8 {
        let active_low = peek(&self.registers, 0x0030) & 0x10 != 0;
        0x02 | u8::from(self.ready != active_low)
    }

    fn write_register(&mut self, at: u16, byte: u8) {
        match at {
            0x0086 => {
                if byte & 0x01 != 0 {
                    self.ready = false;
                }
            }
            0x0087 => {
                poke(&mut self.registers, at.into(), &[byte]);
                if byte & 0x40 != 0 {
                    // The first measurement begins at once; the period is from one to the next.
                    self.until_result = Some(u32::try_from(self.measurement()).unwrap_or(u32::MAX));
                } else {
                    self.until_result = None;
                    if byte & ABORT == 0 {
                        self.stream = None;
                    }
                }
            }
            _ => poke(&mut self.registers, at.into(), &[byte]),
        }
    }
}

impl<L: Deref<Target = AtomicU8>> I2cModel for Vl53l1xModel<L> {
    fn start(&mut self, address: u8, read: bool) -> bool {
        if self.is_off() || self.booting > 0 || address != self.address() {
            return false;
        }
        if !read {
            self.pointer = Pointer::Unset;
        }
        self.fault.acknowledges()
    }

    fn write(&mut self, byte: u8) -> bool {
        if !self.fault.acknowledges() {
            return false;
        }
        self.pointer = match self.pointer {
            Pointer::Unset => Pointer::High(byte),
            Pointer::High(high) => Pointer::At(u16::from_be_bytes([high, byte])),
            Pointer::At(at) => {
                self.write_register(at, byte);
                Pointer::At(at.wrapping_add(1))
            }
        };
        true
    }

    fn read(&mut self) -> u8 {
        let Pointer::At(at) = self.pointer else { return 0xFF };
        self.pointer = Pointer::At(at.wrapping_add(1));
        let byte = match at {
            0x00E5 if self.ranging_fault == Vl53l1xFault::NeverBoots => 0x00,
            0x00E5 => 0x03,
            0x0031 => self.line_status(),
            _ => peek(&self.registers, at.into()),
        };
        self.fault.read(byte)
    }

    fn stop(&mut self) {}

    fn advance(&mut self, micros: u32) {
        if self.is_off() {
            return;
        }
        self.booting = self.booting.saturating_sub(micros);
        let Some(mut left) = self.until_result else { return };
        let mut micros = micros;
        while left <= micros {
            micros -= left;
            self.finish_measurement();
            left = self.result_period();
        }
        self.until_result = Some(left - micros);
    }
}
