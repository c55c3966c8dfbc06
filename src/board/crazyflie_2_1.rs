//! The Crazyflie 2.1 and 2.1+: clocks, pins, buses, and the priorities of the interrupts.
//!
//! | function | pins | peripheral | DMA |
//! |---|---|---|---|
//! | inertial sensor, 400 kHz | PA8, PC9; data ready PC14 | I2C3 | 1, streams 2 and 4 |
//! | decks, 400 kHz: rangers, expander, EEPROM | PB6, PB7 | I2C1 | 1, streams 0 and 6 |
//! | optic flow, mode 0, 1.3 MHz | PA5, PA6, PA7; select PB4 | SPI1 | 2, streams 0 and 5 |
//! | radio chip, 1 Mbaud | PC6, PC7; "wait" PA4 | USART6 | 2, streams 1 and 7 |
//! | motors | PA1, PB11, PA15; PB9 | TIM2; TIM4 | |
//! | LEDs | PC0 to PC3, PD2 | | |
//! | time | | TIM5 | |
//!
//! From crazyflie-firmware: `i2c_drv.c`, `sensors_bmi088_i2c.c`, `deck_spi.c`, `uart_syslink.h`,
//! `motors_def.c`, `led.h`.

use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, LsConfig, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv,
    PllSource, Sysclk,
};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Config, bind_interrupts, dma, i2c, pac, peripherals};
use flight::FlightConfig;
use static_cell::StaticCell;

use crate::board::bus::{Bus, Line};
use crate::board::deadline;
use crate::board::flow_control::FlowControl;
use crate::safety::panic;

/// The configuration of the flight code, with the propellers of this board.
pub(crate) const FLIGHT: FlightConfig = if cfg!(feature = "crazyflie-2-1-plus") {
    FlightConfig::CRAZYFLIE_2_1_PLUS
} else {
    FlightConfig::CRAZYFLIE_2_1
};

/// Motors, their pins and timers (crazyflie-firmware, `motors.h`, `motors_def.c`).
///
/// | motor | where | pin | timer |
/// |---|---|---|---|
/// | M1 | front right | PA1 | TIM2, channel 2 |
/// | M2 | rear right | PB11 | TIM2, channel 4 |
/// | M3 | rear left | PA15 | TIM2, channel 1 |
/// | M4 | front left | PB9 | TIM4, channel 4 |
pub(crate) mod motor {
    use embassy_stm32::pac;
    use embassy_stm32::pac::gpio::Gpio;
    use embassy_stm32::pac::timer::vals::Ocm;

    /// The pin of a motor, which turns while the pin is high.
    pub(crate) struct Pin {
        pub(crate) port: Gpio,
        pub(crate) number: usize,
        /// Which of the pin's functions is the timer.
        pub(crate) alternate: u8,
    }

    /// M1 to M4: front right, rear right, rear left, front left.
    pub(crate) const PINS: [Pin; 4] = [
        Pin { port: pac::GPIOA, number: 1, alternate: 1 },
        Pin { port: pac::GPIOB, number: 11, alternate: 1 },
        Pin { port: pac::GPIOA, number: 15, alternate: 1 },
        Pin { port: pac::GPIOB, number: 9, alternate: 2 },
    ];

    /// The timer's clock is 84 MHz and a period has 256 steps: 328 kHz.
    pub(crate) const STEPS: u16 = 256;

    /// Switches on the ports that the pins belong to. It may be called at any moment.
    pub(crate) fn power_ports() {
        pac::RCC.ahb1enr().modify(|w| {
            w.set_gpioaen(true);
            w.set_gpioben(true);
        });
        // A peripheral answers two cycles after its clock is enabled (STM32F405 errata sheet
        // ES0182, "Delay after an RCC peripheral clock enabling"); reading the register back takes
        // them.
        let _ = pac::RCC.ahb1enr().read();
    }

    /// Takes all configuration from the timers. It may be called at any moment.
    pub(crate) fn reset_timers() {
        for reset in [true, false] {
            pac::RCC.apb1rstr().modify(|w| {
                w.set_tim2rst(reset);
                w.set_tim4rst(reset);
            });
        }
    }

    /// Sets the timers up and starts them, with all four outputs low.
    pub(crate) fn start() {
        pac::RCC.apb1enr().modify(|w| {
            w.set_tim2en(true);
            w.set_tim4en(true);
        });
        let _ = pac::RCC.apb1enr().read();
        for channel in [0, 1, 3] {
            pac::TIM2.ccmr_output(channel / 2).modify(|w| {
                w.set_ocm(channel % 2, Ocm::PWM_MODE1);
                w.set_ocpe(channel % 2, true);
            });
            pac::TIM2.ccer().modify(|w| w.set_cce(channel, true));
        }
        pac::TIM4.ccmr_output(1).modify(|w| {
            w.set_ocm(1, Ocm::PWM_MODE1);
            w.set_ocpe(1, true);
        });
        pac::TIM4.ccer().modify(|w| w.set_cce(3, true));
        pac::TIM2.arr().write_value(u32::from(STEPS) - 1);
        pac::TIM4.arr().write(|w| w.set_arr(STEPS - 1));
        compare([0; 4]);
        // The compare values are taken over at an update, so there must be a first.
        pac::TIM2.egr().write(|w| w.set_ug(true));
        pac::TIM4.egr().write(|w| w.set_ug(true));
        pac::TIM2.cr1().modify(|w| w.set_cen(true));
        pac::TIM4.cr1().modify(|w| w.set_cen(true));
    }

    /// Sets how many of 256 steps each motor's pin is high, all at the next period.
    pub(crate) fn compare([m1, m2, m3, m4]: [u16; 4]) {
        pac::TIM2.ccr(1).write_value(m1.into());
        pac::TIM2.ccr(3).write_value(m2.into());
        pac::TIM2.ccr(0).write_value(m3.into());
        pac::TIM4.ccr(3).write(|w| w.set_ccr(m4));
    }
}

bind_interrupts!(struct Irqs {
    EXTI15_10 => exti::InterruptHandler<embassy_stm32::interrupt::typelevel::EXTI15_10>;
    I2C3_EV => i2c::EventInterruptHandler<peripherals::I2C3>;
    I2C3_ER => i2c::ErrorInterruptHandler<peripherals::I2C3>;
    DMA1_STREAM2 => dma::InterruptHandler<peripherals::DMA1_CH2>;
    DMA1_STREAM4 => dma::InterruptHandler<peripherals::DMA1_CH4>;
    I2C1_EV => i2c::EventInterruptHandler<peripherals::I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<peripherals::I2C1>;
    DMA1_STREAM0 => dma::InterruptHandler<peripherals::DMA1_CH0>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
    DMA2_STREAM0 => dma::InterruptHandler<peripherals::DMA2_CH0>;
    DMA2_STREAM5 => dma::InterruptHandler<peripherals::DMA2_CH5>;
    USART6 => usart::InterruptHandler<peripherals::USART6>;
    DMA2_STREAM1 => dma::InterruptHandler<peripherals::DMA2_CH1>;
    DMA2_STREAM7 => dma::InterruptHandler<peripherals::DMA2_CH7>;
});

/// The interrupt of the control executor: that of a CAN bus, which no Crazyflie has.
pub(crate) const CONTROL: interrupt::Interrupt = interrupt::CAN2_SCE;

/// The priority of the interrupt that holds the line to the radio chip back: a byte takes 10 µs.
const HOLD: Priority = Priority::P0;
/// The priority of the interrupts that wake the control executor: time, data ready, and the sensor
/// bus.
const WAKE: Priority = Priority::P1;
/// The priority of the control executor.
const STEP: Priority = Priority::P2;
/// The priority of radio and decks, whose interrupts only wake tasks of the thread.
const REST: Priority = Priority::P4;

/// A pin whose edges can be waited for.
pub(crate) type Edge = ExtiInput<'static, Async>;

/// The parts of the board, by the tasks that use them.
pub(crate) struct Parts {
    pub(crate) lamps: Lamps,
    pub(crate) imu: ImuParts,
    pub(crate) flow: FlowParts,
    pub(crate) decks: DeckParts,
    pub(crate) radio: RadioParts,
}

/// The LEDs, by where they sit. Blue is lit when high, the others when low.
pub(crate) struct Lamps {
    pub(crate) blue_left: Output<'static>,
    pub(crate) green_left: Output<'static>,
    pub(crate) red_left: Output<'static>,
    pub(crate) green_right: Output<'static>,
    pub(crate) red_right: Output<'static>,
}

/// The inertial sensor's bus and its "data ready".
pub(crate) struct ImuParts {
    pub(crate) bus: Bus,
    pub(crate) ready: Edge,
}

/// The optic flow sensor's bus and select line.
pub(crate) struct FlowParts {
    pub(crate) bus: Spi<'static, Async, spi::mode::Master>,
    pub(crate) select: Output<'static>,
}

/// The bus of the rangers, the expander and the EEPROM.
pub(crate) struct DeckParts {
    pub(crate) bus: Bus,
}

/// The line to the radio chip.
pub(crate) struct RadioParts {
    pub(crate) receive: RingBufferedUartRx<'static>,
    pub(crate) transmit: UartTx<'static, Async>,
    /// Holds back what is sent while the chip cannot take any more.
    pub(crate) wait: FlowControl,
}

/// The bytes that the radio line can buffer: 5 ms at full speed, while control steps keep the thread
/// waiting for less than one.
static RING: StaticCell<[u8; 512]> = StaticCell::new();

/// Starts the 8 MHz crystal; false when it does not come within 50 ms or a little more, by the
/// internal oscillator that the chip boots with. It takes 2 ms (STM32F405 data sheet, t_SU(HSE)).
/// embassy's own wait for it, in [`init`], has no bound but the watchdog.
pub(crate) fn crystal_starts() -> bool {
    /// A turn of the loop takes 8 to 15 cycles of 16 MHz: together, less than the watchdog's time.
    const TURNS: u32 = 100_000;
    pac::RCC.cr().modify(|w| w.set_hseon(true));
    (0..TURNS).any(|_| pac::RCC.cr().read().hserdy())
}

/// Sets the clocks and hands out the parts. To be called once; a second call is a panic in
/// embassy-stm32.
pub(crate) fn init() -> Parts {
    let p = embassy_stm32::init(clocks());
    cache_flash();
    set_priorities();

    let mut fast = i2c::Config::default();
    fast.frequency = Hertz(400_000);
    let sensors = i2c::I2c::new(p.I2C3, p.PA8, p.PC9, p.DMA1_CH4, p.DMA1_CH2, Irqs, fast);
    let decks = i2c::I2c::new(p.I2C1, p.PB6, p.PB7, p.DMA1_CH6, p.DMA1_CH0, Irqs, fast);

    let mut deck = spi::Config::default();
    deck.frequency = Hertz(1_312_500);
    let flow = Spi::new(p.SPI1, p.PA5, p.PA7, p.PA6, p.DMA2_CH5, p.DMA2_CH0, Irqs, deck);

    let mut line = usart::Config::default();
    line.baudrate = 1_000_000;
    let uart = Uart::new(p.USART6, p.PC7, p.PC6, p.DMA2_CH7, p.DMA2_CH1, Irqs, line);
    let (Ok(uart), Some(ring)) = (uart, RING.try_init([0; 512])) else {
        panic::give_up("the radio's line cannot be set up");
    };
    let (transmit, receive) = uart.split();

    Parts {
        lamps: Lamps {
            blue_left: Output::new(p.PD2, Level::Low, Speed::Low),
            green_left: Output::new(p.PC1, Level::High, Speed::Low),
            red_left: Output::new(p.PC0, Level::High, Speed::Low),
            green_right: Output::new(p.PC2, Level::High, Speed::Low),
            red_right: Output::new(p.PC3, Level::High, Speed::Low),
        },
        imu: ImuParts {
            bus: Bus::new(
                sensors,
                pac::I2C3,
                Line::new(pac::GPIOA, 8),
                Line::new(pac::GPIOC, 9),
                &deadline::INERTIAL,
            ),
            ready: ExtiInput::new(p.PC14, p.EXTI14, Pull::None, Irqs),
        },
        flow: FlowParts { bus: flow, select: Output::new(p.PB4, Level::High, Speed::VeryHigh) },
        decks: DeckParts {
            bus: Bus::new(
                decks,
                pac::I2C1,
                Line::new(pac::GPIOB, 6),
                Line::new(pac::GPIOB, 7),
                &deadline::DECKS,
            ),
        },
        radio: RadioParts {
            receive: receive.into_ring_buffered(ring),
            transmit,
            wait: FlowControl::new(p.PA4, p.EXTI4),
        },
    }
}

/// Switches the flash accelerator on, as ST's start-up code for this chip does. Without it each line
/// of 16 bytes costs five wait states. embassy sets the wait states and leaves the accelerator off. (Of the first revision of the chip, A, the prefetch is not to be used: ES0182.)
fn cache_flash() {
    pac::FLASH.acr().modify(|w| {
        w.set_icen(true);
        w.set_dcen(true);
        w.set_prften(true);
    });
}

/// Sets the priorities of the interrupts; to be called before a driver enables one.
fn set_priorities() {
    let wake = [
        interrupt::TIM5,
        interrupt::EXTI15_10,
        interrupt::I2C3_EV,
        interrupt::I2C3_ER,
        interrupt::DMA1_STREAM2,
        interrupt::DMA1_STREAM4,
    ];
    let rest = [
        interrupt::I2C1_EV,
        interrupt::I2C1_ER,
        interrupt::DMA1_STREAM0,
        interrupt::DMA1_STREAM6,
        interrupt::DMA2_STREAM0,
        interrupt::DMA2_STREAM5,
        interrupt::DMA2_STREAM1,
        interrupt::DMA2_STREAM7,
    ];
    // Both change one register of the serial port, so neither may interrupt the other.
    for interrupt in [interrupt::EXTI4, interrupt::USART6] {
        interrupt.set_priority(HOLD);
    }
    for interrupt in wake {
        interrupt.set_priority(WAKE);
    }
    CONTROL.set_priority(STEP);
    for interrupt in rest {
        interrupt.set_priority(REST);
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
    // No real-time clock, and so no wait for the oscillator that would drive it.
    rcc.ls = LsConfig::off();
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV1;
    rcc.apb1_pre = APBPrescaler::DIV4;
    rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
