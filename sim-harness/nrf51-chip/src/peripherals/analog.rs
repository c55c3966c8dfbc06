//! The ADC and the thermometer.

use units::Volts;

use super::interrupts::Events;
use crate::{Cycles, MICROSECOND, NEVER};

/// The time of a conversion with 10 bits (nRF51822 Product Specification, "ADC specifications").
const CONVERSION: Cycles = 68 * MICROSECOND;
/// The time of a measurement of the temperature (the same, "TEMP specifications").
const TEMPERATURE: Cycles = 35 * MICROSECOND;
/// The internal reference.
const REFERENCE: Volts = Volts(1.2);
/// The analog inputs.
pub(super) const INPUTS: usize = 8;

/// The offsets of the ADC's registers.
mod offset {
    pub(super) const START: u32 = 0x000;
    pub(super) const STOP: u32 = 0x004;
    pub(super) const BUSY: u32 = 0x400;
    pub(super) const ENABLE: u32 = 0x500;
    pub(super) const CONFIG: u32 = 0x504;
    pub(super) const RESULT: u32 = 0x508;
}

/// The ADC.
#[derive(Clone, Debug)]
pub(super) struct Adc {
    events: Events,
    enabled: u32,
    configuration: u32,
    result: u32,
    /// The end of the conversion that runs.
    end: Option<Cycles>,
    /// The voltages at its inputs, by their numbers.
    pub(super) inputs: [Volts; INPUTS],
}

impl Adc {
    pub(super) const fn new() -> Self {
        Self {
            events: Events::new(1),
            enabled: 0,
            configuration: 0x18,
            result: 0,
            end: None,
            inputs: [Volts(0.0); INPUTS],
        }
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    pub(super) fn due(&self) -> Cycles {
        self.end.unwrap_or(NEVER)
    }

    pub(super) fn advance(&mut self, now: Cycles) {
        if self.due() <= now {
            self.end = None;
            self.result = self.convert();
            self.events.raise(0);
        }
    }

    /// The result of the input that is selected: RES, INPSEL and PSEL of CONFIG.
    fn convert(&self) -> u32 {
        let bits = 8 + (self.configuration & 3).min(2);
        let scale = match self.configuration >> 2 & 7 {
            1 => 2.0 / 3.0,
            2 => 1.0 / 3.0,
            _ => 1.0,
        };
        let selected = (self.configuration >> 8 & 0xFF).trailing_zeros() as usize;
        let input = self.inputs.get(selected).copied().unwrap_or(Volts(0.0));
        let full = ((1u32 << bits) - 1) as f32;
        (input.0 * scale / REFERENCE.0 * full).round().clamp(0.0, full) as u32
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::BUSY => self.end.is_some().into(),
            offset::ENABLE => self.enabled,
            offset::CONFIG => self.configuration,
            offset::RESULT => self.result,
            _ => return self.events.read(offset),
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        match offset {
            offset::START if self.enabled & 1 != 0 => self.end = Some(now + CONVERSION),
            offset::START => {}
            offset::STOP => self.end = None,
            offset::ENABLE => self.enabled = value,
            offset::CONFIG => self.configuration = value,
            _ => self.events.write(offset, value)?,
        }
        Some(())
    }
}

/// The thermometer.
#[derive(Clone, Debug)]
pub(super) struct Thermometer {
    events: Events,
    end: Option<Cycles>,
    /// The temperature in quarters of a degree Celsius.
    pub(super) quarters: i32,
}

impl Thermometer {
    /// The register of the result.
    const RESULT: u32 = 0x508;

    /// A thermometer at 25 °C.
    pub(super) const fn new() -> Self {
        Self { events: Events::new(1), end: None, quarters: 100 }
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    pub(super) fn due(&self) -> Cycles {
        self.end.unwrap_or(NEVER)
    }

    pub(super) fn advance(&mut self, now: Cycles) {
        if self.due() <= now {
            self.end = None;
            self.events.raise(0);
        }
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        if offset == Self::RESULT {
            return Some(self.quarters.cast_unsigned());
        }
        self.events.read(offset)
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        match offset {
            offset::START => self.end = Some(now + TEMPERATURE),
            offset::STOP => self.end = None,
            _ => self.events.write(offset, value)?,
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_battery_is_measured_in_steps_of_five_millivolts() {
        let mut adc = Adc::new();
        // AIN2, by two thirds, 10 bits; the board divides by three in front of it.
        adc.write(0, offset::CONFIG, 4 << 8 | 1 << 2 | 2).unwrap();
        adc.write(0, offset::ENABLE, 1).unwrap();
        adc.inputs[2] = Volts(4.0 / 3.0);
        adc.write(0, offset::START, 1).unwrap();
        assert_eq!(adc.read(offset::BUSY), Some(1));
        adc.advance(CONVERSION);
        let result = adc.read(offset::RESULT).unwrap();
        // Volts = result / 1023 × 1.2 × 4.5 (`pm.c`).
        assert!((result as f32 / 1023.0 * 1.2 * 4.5 - 4.0).abs() < 0.003, "{result}");
    }
}
