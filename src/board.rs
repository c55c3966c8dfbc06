//! Clocks and pins of the Crazyflie 2.1.

use embassy_stm32::Config;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};
use embassy_stm32::time::Hertz;

/// What the rest of the firmware is handed of the board.
pub(crate) struct Board {
    /// The blue LED on the left: PD2, lit when high (crazyflie-firmware, `led.h`).
    pub(crate) lamp: Output<'static>,
    /// The red LED on the left: PC0, lit when low (crazyflie-firmware, `led.h`).
    pub(crate) fault_lamp: Output<'static>,
}

/// Sets the clocks and hands out the pins. To be called once; a second call is a panic in
/// embassy-stm32.
pub(crate) fn init() -> Board {
    let p = embassy_stm32::init(clocks());
    Board {
        lamp: Output::new(p.PD2, Level::Low, Speed::Low),
        fault_lamp: Output::new(p.PC0, Level::High, Speed::Low),
    }
}

/// 168 MHz from the 8 MHz crystal: 8 / 8 · 336 / 2. AHB runs at 168, APB1 at 42, APB2 at 84 and
/// USB at 48 MHz (crazyflie-firmware, `system_stm32f4xx.c`). The wait states of the flash follow.
fn clocks() -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Oscillator });
    rcc.pll_src = PllSource::HSE;
    rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV8,
        mul: PllMul::MUL336,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV7),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV1;
    rcc.apb1_pre = APBPrescaler::DIV4;
    rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
