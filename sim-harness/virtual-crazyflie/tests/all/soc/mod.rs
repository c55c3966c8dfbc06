//! A chip without a core: a test stores and loads where the core would, and lets time pass.

mod clocks;
mod flash;
mod pins;
mod timers;
mod watchdog;

use virtual_crazyflie::bus::{Bus, Refused, Width};
use virtual_crazyflie::memory::Memory;
use virtual_crazyflie::soc::{
    Board, I2cBus, Level, Nanos, Pin, ResetCause, Soc, SocConfig, SpiBus, UartBus, UartByte,
};

/// Registers, by their addresses.
pub(crate) mod at {
    pub(crate) const RCC_CR: u32 = 0x4002_3800;
    pub(crate) const RCC_PLLCFGR: u32 = 0x4002_3804;
    pub(crate) const RCC_CFGR: u32 = 0x4002_3808;
    pub(crate) const RCC_APB1RSTR: u32 = 0x4002_3820;
    pub(crate) const RCC_AHB1ENR: u32 = 0x4002_3830;
    pub(crate) const RCC_APB1ENR: u32 = 0x4002_3840;
    pub(crate) const RCC_APB2ENR: u32 = 0x4002_3844;
    pub(crate) const RCC_CSR: u32 = 0x4002_3874;
    pub(crate) const PWR_CR: u32 = 0x4000_7000;
    pub(crate) const FLASH_ACR: u32 = 0x4002_3C00;
    pub(crate) const FLASH_KEYR: u32 = 0x4002_3C04;
    pub(crate) const FLASH_SR: u32 = 0x4002_3C0C;
    pub(crate) const FLASH_CR: u32 = 0x4002_3C10;
    pub(crate) const FLASH_OPTCR: u32 = 0x4002_3C14;
    pub(crate) const IWDG_KR: u32 = 0x4000_3000;
    pub(crate) const IWDG_PR: u32 = 0x4000_3004;
    pub(crate) const IWDG_RLR: u32 = 0x4000_3008;
    pub(crate) const IWDG_SR: u32 = 0x4000_300C;
    pub(crate) const SYSCFG_EXTICR: u32 = 0x4001_3808;
    pub(crate) const EXTI_IMR: u32 = 0x4001_3C00;
    pub(crate) const EXTI_EMR: u32 = 0x4001_3C04;
    pub(crate) const EXTI_RTSR: u32 = 0x4001_3C08;
    pub(crate) const EXTI_FTSR: u32 = 0x4001_3C0C;
    pub(crate) const EXTI_SWIER: u32 = 0x4001_3C10;
    pub(crate) const EXTI_PR: u32 = 0x4001_3C14;
    pub(crate) const TIM2: u32 = 0x4000_0000;
    pub(crate) const TIM4: u32 = 0x4000_0800;
    pub(crate) const TIM5: u32 = 0x4000_0C00;
    pub(crate) const TIM10: u32 = 0x4001_4400;
}

/// A board of bare pins.
#[derive(Default)]
pub(crate) struct Bare {
    /// What the board makes of pins that it drives.
    pub(crate) levels: Vec<(Pin, Level)>,
    /// What it will do: moments in order.
    pub(crate) plan: Vec<(Nanos, Pin, Level)>,
    /// What the chip has driven.
    pub(crate) driven: Vec<(Pin, Level)>,
    pub(crate) now: Nanos,
}

impl Bare {
    pub(crate) fn set(&mut self, pin: Pin, level: Level) {
        self.levels.retain(|(other, _)| *other != pin);
        self.levels.push((pin, level));
    }
}

impl Board for Bare {
    fn advance(&mut self, now: Nanos) {
        assert!(now >= self.now, "time runs backwards");
        self.now = now;
        while let Some(&(at, pin, level)) = self.plan.first() {
            if at > now {
                break;
            }
            self.set(pin, level);
            self.plan.remove(0);
        }
    }
    fn due(&self) -> Nanos {
        self.plan.first().map_or(Nanos::MAX, |(at, ..)| *at)
    }
    fn i2c_start(&mut self, _: I2cBus, _: u8, _: bool) -> bool {
        false
    }
    fn i2c_write(&mut self, _: I2cBus, _: u8) -> bool {
        false
    }
    fn i2c_read(&mut self, _: I2cBus) -> u8 {
        0xFF
    }
    fn i2c_stop(&mut self, _: I2cBus) {}
    fn i2c_lines(&self, _: I2cBus) -> (bool, bool) {
        (true, true)
    }
    fn spi_exchange(&mut self, _: SpiBus, _: u8) -> u8 {
        0xFF
    }
    fn uart_take(&mut self, _: UartBus, _: u8, _: u32) {}
    fn uart_give(&mut self, _: UartBus) -> Option<UartByte> {
        None
    }
    fn drive(&mut self, pin: Pin, level: Level) {
        self.driven.push((pin, level));
    }
    fn level(&self, pin: Pin) -> Level {
        self.levels.iter().find(|(other, _)| *other == pin).map_or(Level::Released, |(_, l)| *l)
    }
}

/// A chip whose core a test stands in for.
pub(crate) struct Chip {
    pub(crate) soc: Soc<Bare>,
    pub(crate) memory: Memory,
    pub(crate) now: u64,
}

impl Chip {
    pub(crate) fn new() -> Self {
        Self::with(SocConfig::default())
    }

    pub(crate) fn with(config: SocConfig) -> Self {
        Self { soc: Soc::new(Bare::default(), config), memory: Memory::new(), now: 0 }
    }

    pub(crate) fn try_load(&mut self, address: u32, width: Width) -> Result<u32, Refused> {
        self.soc.load(&mut self.memory, self.now, address, width)
    }

    pub(crate) fn load(&mut self, address: u32) -> u32 {
        self.try_load(address, Width::Word).expect("loads")
    }

    pub(crate) fn try_store(
        &mut self,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        self.soc.store(&mut self.memory, self.now, address, width, value)
    }

    pub(crate) fn store(&mut self, address: u32, value: u32) {
        self.try_store(address, Width::Word, value).expect("stores");
    }

    /// Sets and clears bits.
    pub(crate) fn modify(&mut self, address: u32, clear: u32, set: u32) {
        let value = self.load(address);
        self.store(address, value & !clear | set);
    }

    /// So many cycles pass, with everything that is due.
    pub(crate) fn pass(&mut self, cycles: u64) {
        self.pass_to(self.now + cycles);
    }

    pub(crate) fn pass_to(&mut self, cycle: u64) {
        while self.soc.due() <= cycle {
            self.now = self.now.max(self.soc.due());
            self.soc.advance(&mut self.memory, self.now);
            if self.soc.resets() {
                self.soc.take_change();
                if self.soc.resets() {
                    return;
                }
            }
        }
        self.now = cycle;
    }

    /// Until a moment.
    pub(crate) fn pass_until(&mut self, moment: Nanos) {
        let cycle = self.soc.cycle(moment);
        self.pass_to(cycle);
    }

    pub(crate) fn nanos(&self) -> Nanos {
        self.soc.nanos(self.now)
    }

    pub(crate) fn line(&self, number: u32) -> bool {
        self.soc.lines() >> number & 1 != 0
    }

    pub(crate) fn reset(&mut self, cause: ResetCause) {
        self.soc.reset(self.now, cause);
    }

    /// 168 MHz from the crystal, as the firmware has it.
    pub(crate) fn start_clocks(&mut self) {
        self.modify(at::RCC_APB1ENR, 0, 1 << 28);
        self.modify(at::RCC_CR, 0, 1 << 16);
        while self.load(at::RCC_CR) & 1 << 17 == 0 {
            self.pass(100);
        }
        self.store(at::RCC_PLLCFGR, 8 | 336 << 6 | 1 << 22 | 7 << 24);
        self.modify(at::RCC_CR, 0, 1 << 24);
        while self.load(at::RCC_CR) & 1 << 25 == 0 {
            self.pass(100);
        }
        self.store(at::FLASH_ACR, 5);
        self.store(at::RCC_CFGR, 2 | 5 << 10 | 4 << 13);
        while self.load(at::RCC_CFGR) >> 2 & 3 != 2 {
            self.pass(1);
        }
        assert!(self.soc.take_change());
    }
}

/// What was not modelled.
pub(crate) fn unmodelled<T: std::fmt::Debug>(result: Result<T, Refused>) -> &'static str {
    match result {
        Err(Refused::Unmodelled { what }) => what,
        other => panic!("{other:?} is not refused"),
    }
}
