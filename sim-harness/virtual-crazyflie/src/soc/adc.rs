//! The analog-to-digital converters, set up and idle (RM0090, "Analog-to-digital converter (ADC)").
//!
//! A Crazyflie's firmware switches a converter on for decks that have an analog output. The decks of
//! this board have none, so a conversion is refused; what sets a converter up is kept.

use crate::bus::Refused;

/// The common registers lie behind those of the three converters.
const COMMON: u32 = 0x300;
const BETWEEN: u32 = 0x100;
const CONVERTERS: usize = 3;
/// Registers of a converter: SR to DR.
const REGISTERS: usize = 20;

/// Registers by their words.
const SR: usize = 0;
const CR1: usize = 1;
const CR2: usize = 2;
const HTR: usize = 9;
const DR: usize = 19;

/// ADC_CR2: a conversion asked for by software or by a timer, regular or injected; DMA.
const STARTS: u32 = 1 << 30 | 3 << 28 | 1 << 22 | 3 << 20 | 1 << 8;
/// ADC_CR1: interrupts.
const INTERRUPTS: u32 = 1 << 26 | 7 << 5;
const CCR: u32 = 0x04;

/// The bits of each register that there are.
const BITS: [u32; REGISTERS] = [
    0x0000_003F,
    0x07C0_FFFF,
    0x7F7F_0F03,
    0x07FF_FFFF,
    0x3FFF_FFFF,
    0xFFF,
    0xFFF,
    0xFFF,
    0xFFF,
    0xFFF,
    0xFFF,
    0x00FF_FFFF,
    0x3FFF_FFFF,
    0x3FFF_FFFF,
    0x003F_FFFF,
    0,
    0,
    0,
    0,
    0,
];

/// The three converters.
#[derive(Clone, Debug)]
pub(crate) struct Adc {
    converters: [[u32; REGISTERS]; CONVERTERS],
    ccr: u32,
}

impl Adc {
    pub(crate) fn new() -> Self {
        let mut registers = [0; REGISTERS];
        registers[HTR] = 0xFFF;
        Self { converters: [registers; CONVERTERS], ccr: 0 }
    }

    /// The converter that an address belongs to; none for what is common to all.
    pub(crate) const fn converter(offset: u32) -> Option<u32> {
        if offset < COMMON { Some(offset / BETWEEN) } else { None }
    }

    pub(crate) fn read(&self, offset: u32) -> Result<u32, Refused> {
        if offset >= COMMON {
            return match offset - COMMON {
                // CSR and CDR: nothing was converted.
                0x00 | 0x08 => Ok(0),
                CCR => Ok(self.ccr),
                _ => refuse(),
            };
        }
        self.converters[(offset / BETWEEN) as usize]
            .get((offset % BETWEEN / 4) as usize)
            .map_or_else(refuse, |value| Ok(*value))
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        if offset >= COMMON {
            return match offset - COMMON {
                CCR if value & (0x1F | 3 << 14) != 0 => {
                    Err(Refused::Unmodelled { what: "ADC_CCR: converters together, or DMA" })
                }
                CCR => {
                    self.ccr = value & 0x00C3_2F00;
                    Ok(())
                }
                _ => refuse(),
            };
        }
        let registers = &mut self.converters[(offset / BETWEEN) as usize];
        let register = (offset % BETWEEN / 4) as usize;
        match register {
            // Cleared by writing zero; nothing sets them.
            SR => registers[SR] &= value,
            CR1 if value & INTERRUPTS != 0 => {
                return Err(Refused::Unmodelled { what: "ADC_CR1: interrupts" });
            }
            CR2 if value & STARTS != 0 => {
                return Err(Refused::Unmodelled { what: "ADC_CR2: a conversion" });
            }
            _ if register <= DR => registers[register] = value & BITS[register],
            _ => return refuse(),
        }
        Ok(())
    }
}

fn refuse<T>() -> Result<T, Refused> {
    Err(Refused::Unmodelled { what: "ADC: a reserved register" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_converter_keeps_how_it_is_set_up_and_converts_nothing() {
        let mut adc = Adc::new();
        let adc2 = 0x100;
        assert_eq!(adc.read(adc2 + 0x24), Ok(0xFFF), "ADC_HTR after reset");
        assert_eq!(adc.write(adc2 + 0x08, 1), Ok(()));
        assert_eq!((adc.read(adc2 + 0x08), adc.read(0x08)), (Ok(1), Ok(0)));
        assert_eq!(adc.read(adc2), Ok(0), "ADC_SR: no conversion has ended");
        for start in [1 << 30, 1 << 22, 1 << 28] {
            assert!(adc.write(adc2 + 0x08, 1 | start).is_err());
        }
        assert!(adc.read(0x50).is_err() && adc.read(0x30C).is_err());
    }
}
