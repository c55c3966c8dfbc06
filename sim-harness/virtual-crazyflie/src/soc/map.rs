//! The memory map: the peripheral at each address, and the gate that its clock comes through (RM0090,
//! "Memory map" and the enable registers of RCC).

use super::rcc::Domain;

/// A peripheral that is modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// An index of [`TIMERS`].
    Timer(usize),
    /// I2C1 is 0.
    I2c(usize),
    Spi1,
    Usart6,
    Gpio(usize),
    /// DMA1 is 0.
    Dma(usize),
    Syscfg,
    Exti,
    Pwr,
    Rcc,
    Flash,
    Iwdg,
    Rtc,
    Dbgmcu,
    Adc,
    Usb,
    Rng,
}

/// The unit at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Unit(Unit),
    /// The chip has it, and it is not modelled.
    Known(&'static str),
    /// There is nothing.
    Nothing,
}

/// The stretches of APB1, APB2 and AHB1 that peripherals are in.
const PERIPHERALS: u32 = 0x4000_0000;
static PLACES: [Place; 0xA0] = {
    let mut places = [Place::Nothing; 0xA0];
    let mut n = 0;
    while n < places.len() {
        places[n] = search(PERIPHERALS + 1024 * n as u32);
        n += 1;
    }
    places
};

/// Finds the unit at an address.
#[inline(always)]
pub(super) fn locate(address: u32) -> Place {
    let stretch = address.wrapping_sub(PERIPHERALS) >> 10;
    PLACES.get(stretch as usize).copied().unwrap_or_else(|| search(address))
}

/// By the stretches of 1 KiB that RM0090's table is made of.
const fn search(address: u32) -> Place {
    use Place::{Known, Nothing};
    let unit = match address >> 10 {
        0x10_0000..=0x10_0008 => Unit::Timer((address >> 10) as usize - 0x10_0000),
        0x10_000A => Unit::Rtc,
        0x10_000B => return Known("WWDG"),
        0x10_000C => Unit::Iwdg,
        0x10_000D => return Known("I2S2ext"),
        0x10_000E => return Known("SPI2"),
        0x10_000F => return Known("SPI3"),
        0x10_0010 => return Known("I2S3ext"),
        0x10_0011 => return Known("USART2"),
        0x10_0012 => return Known("USART3"),
        0x10_0013 => return Known("UART4"),
        0x10_0014 => return Known("UART5"),
        0x10_0015..=0x10_0017 => Unit::I2c((address >> 10) as usize - 0x10_0015),
        0x10_0019 => return Known("CAN1"),
        0x10_001A => return Known("CAN2"),
        0x10_001C => Unit::Pwr,
        0x10_001D => return Known("DAC"),
        0x10_0040 => return Known("TIM1"),
        0x10_0041 => return Known("TIM8"),
        0x10_0044 => return Known("USART1"),
        0x10_0045 => Unit::Usart6,
        0x10_0048 => Unit::Adc,
        0x10_004B => return Known("SDIO"),
        0x10_004C => Unit::Spi1,
        0x10_004E => Unit::Syscfg,
        0x10_004F => Unit::Exti,
        0x10_0050..=0x10_0052 => Unit::Timer((address >> 10) as usize - 0x10_0050 + 9),
        0x10_0080..=0x10_0088 => Unit::Gpio((address >> 10) as usize - 0x10_0080),
        0x10_008C => return Known("CRC"),
        0x10_008E => Unit::Rcc,
        0x10_008F => Unit::Flash,
        0x10_0090..=0x10_0093 => return Known("BKPSRAM"),
        0x10_0098..=0x10_0099 => Unit::Dma((address >> 10) as usize - 0x10_0098),
        0x10_0100..=0x10_01FF => return Known("USB OTG HS"),
        0x14_0000..=0x14_00FF => Unit::Usb,
        0x14_0182 => Unit::Rng,
        0x18_0000..=0x27_FFFF => return Known("FSMC's banks"),
        0x28_0000..=0x28_0003 => return Known("FSMC"),
        0x38_0108 => Unit::Dbgmcu,
        _ => return Nothing,
    };
    Place::Unit(unit)
}

impl Unit {
    /// The gate that its clock and its reset go through; none for what is always clocked.
    pub(super) const fn gate(self) -> Option<(Domain, u32)> {
        Some(match self {
            Self::Timer(index) => TIMERS[index % TIMERS.len()].gate,
            Self::I2c(index) => (Domain::Apb1, 21 + index as u32),
            Self::Spi1 => (Domain::Apb2, 12),
            Self::Usart6 => (Domain::Apb2, 5),
            Self::Gpio(port) => (Domain::Ahb1, port as u32),
            Self::Dma(index) => (Domain::Ahb1, 21 + index as u32),
            Self::Syscfg => (Domain::Apb2, 14),
            Self::Pwr => (Domain::Apb1, 28),
            Self::Usb => (Domain::Ahb2, 7),
            Self::Rng => (Domain::Ahb2, 6),
            // Each converter has a gate of its own.
            Self::Adc
            | Self::Exti
            | Self::Rcc
            | Self::Flash
            | Self::Iwdg
            | Self::Rtc
            | Self::Dbgmcu => return None,
        })
    }

    /// Whether what it does depends on the board.
    pub(super) const fn sees_board(self) -> bool {
        matches!(
            self,
            Self::Gpio(_) | Self::Exti | Self::Syscfg | Self::I2c(_) | Self::Spi1 | Self::Usart6
        )
    }

    /// Whether a narrow store comes in all lanes (APB) or in its own (AHB).
    pub(super) const fn is_behind_bridge(self) -> bool {
        !matches!(
            self,
            Self::Gpio(_) | Self::Dma(_) | Self::Rcc | Self::Flash | Self::Usb | Self::Rng
        )
    }

    /// The offset of an address in it: its registers take 1 KiB, those of USB more.
    pub(super) const fn offset(self, address: u32) -> u32 {
        match self {
            Self::Usb => address & 0x3_FFFC,
            _ => address & 0x3FC,
        }
    }

    /// The message when its clock is off.
    pub(super) const fn stopped(self) -> &'static str {
        match self {
            Self::Timer(_) => "a timer whose clock is off (RCC_APBxENR)",
            Self::I2c(_) => "an I2C whose clock is off (RCC_APB1ENR)",
            Self::Spi1 => "SPI1, whose clock is off (RCC_APB2ENR)",
            Self::Usart6 => "USART6, whose clock is off (RCC_APB2ENR)",
            Self::Gpio(_) => "a GPIO port whose clock is off (RCC_AHB1ENR)",
            Self::Dma(_) => "a DMA controller whose clock is off (RCC_AHB1ENR)",
            Self::Syscfg => "SYSCFG, whose clock is off (RCC_APB2ENR)",
            Self::Pwr => "PWR, whose clock is off (RCC_APB1ENR)",
            Self::Usb => "USB OTG FS, whose clock is off (RCC_AHB2ENR)",
            _ => "a peripheral whose clock is off",
        }
    }

    /// The message when it is held in reset.
    pub(super) const fn held(self) -> &'static str {
        match self {
            Self::Timer(_) => "a timer that is held in reset (RCC_APBxRSTR)",
            Self::I2c(_) => "an I2C that is held in reset (RCC_APB1RSTR)",
            Self::Gpio(_) => "a GPIO port that is held in reset (RCC_AHB1RSTR)",
            Self::Dma(_) => "a DMA controller that is held in reset (RCC_AHB1RSTR)",
            _ => "a peripheral that is held in reset",
        }
    }
}

/// A timer, and which pins its channels can be.
pub(super) struct TimerPlace {
    pub(super) gate: (Domain, u32),
    pub(super) channels: usize,
    pub(super) bits: u32,
    pub(super) interrupt: u8,
}

const fn timer(gate: (Domain, u32), channels: usize, bits: u32, interrupt: u8) -> TimerPlace {
    TimerPlace { gate, channels, bits, interrupt }
}

/// TIM2 to TIM7, TIM12 to TIM14, TIM9 to TIM11.
pub(super) const TIMERS: [TimerPlace; 12] = [
    timer((Domain::Apb1, 0), 4, 32, 28),
    timer((Domain::Apb1, 1), 4, 16, 29),
    timer((Domain::Apb1, 2), 4, 16, 30),
    timer((Domain::Apb1, 3), 4, 32, 50),
    timer((Domain::Apb1, 4), 0, 16, 54),
    timer((Domain::Apb1, 5), 0, 16, 55),
    timer((Domain::Apb1, 6), 2, 16, 43),
    timer((Domain::Apb1, 7), 1, 16, 44),
    timer((Domain::Apb1, 8), 1, 16, 45),
    timer((Domain::Apb2, 16), 2, 16, 24),
    timer((Domain::Apb2, 17), 1, 16, 25),
    timer((Domain::Apb2, 18), 1, 16, 26),
];

/// A pin's timer (an index of [`TIMERS`]) and channel, for an alternate function (STM32F405 data
/// sheet, "Alternate function mapping").
pub(super) const fn timer_of(port: usize, number: usize, function: u8) -> Option<(usize, usize)> {
    const A: usize = 0;
    const B: usize = 1;
    const C: usize = 2;
    const D: usize = 3;
    const E: usize = 4;
    const F: usize = 5;
    const H: usize = 7;
    const I: usize = 8;
    Some(match (function, port, number) {
        (1, A, 0 | 5 | 15) => (0, 0),
        (1, A, 1) | (1, B, 3) => (0, 1),
        (1, A, 2) | (1, B, 10) => (0, 2),
        (1, A, 3) | (1, B, 11) => (0, 3),
        (2, A, 6) | (2, B, 4) | (2, C, 6) => (1, 0),
        (2, A, 7) | (2, B, 5) | (2, C, 7) => (1, 1),
        (2, B, 0) | (2, C, 8) => (1, 2),
        (2, B, 1) | (2, C, 9) => (1, 3),
        (2, B, 6) | (2, D, 12) => (2, 0),
        (2, B, 7) | (2, D, 13) => (2, 1),
        (2, B, 8) | (2, D, 14) => (2, 2),
        (2, B, 9) | (2, D, 15) => (2, 3),
        (2, A, 0) | (2, H, 10) => (3, 0),
        (2, A, 1) | (2, H, 11) => (3, 1),
        (2, A, 2) | (2, H, 12) => (3, 2),
        (2, A, 3) | (2, I, 0) => (3, 3),
        (9, B, 14) | (9, H, 6) => (6, 0),
        (9, B, 15) | (9, H, 9) => (6, 1),
        (9, A, 6) | (9, F, 8) => (7, 0),
        (9, A, 7) | (9, F, 9) => (8, 0),
        (3, A, 2) | (3, E, 5) => (9, 0),
        (3, A, 3) | (3, E, 6) => (9, 1),
        (3, B, 8) | (3, F, 6) => (10, 0),
        (3, B, 9) | (3, F, 7) => (11, 0),
        _ => return None,
    })
}
