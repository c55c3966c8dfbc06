//! RCC: oscillators, the PLL, prescalers, clock gates, resets and why the last one was (RM0090,
//! "Reset and clock control for STM32F405xx").
//!
//! An oscillator takes its time to start, and a switch to one that is not there waits for it. A PLL
//! outside its limits is an error, not a frequency. Clock security, interrupts of this block and
//! gates that close in sleep are refused; the clocks of I2S, USB and of the MCO pins go nowhere.

use crate::bus::Refused;
use crate::soc::clocks::Frequency;
use crate::soc::wiring::Nanos;

/// Bits of RCC_CR.
mod cr {
    pub(super) const HSION: u32 = 1 << 0;
    pub(super) const HSIRDY: u32 = 1 << 1;
    pub(super) const HSITRIM: u32 = 31 << 3;
    pub(super) const HSEON: u32 = 1 << 16;
    pub(super) const HSERDY: u32 = 1 << 17;
    pub(super) const HSEBYP: u32 = 1 << 18;
    pub(super) const CSSON: u32 = 1 << 19;
    pub(super) const PLLON: u32 = 1 << 24;
    pub(super) const PLLRDY: u32 = 1 << 25;
    pub(super) const PLLI2SON: u32 = 1 << 26;
    pub(super) const PLLI2SRDY: u32 = 1 << 27;
}

const CCMDATARAMEN: u32 = 1 << 20;

/// How long oscillators take to start (STM32F405 data sheet: t_SU(HSI) at most 4 µs, t_SU(HSE)
/// typically 2 ms, t_LOCK of the PLL 100 to 300 µs, t_SU(LSI) typically 15 µs).
const HSI_STARTS: Nanos = 4_000;
const HSE_STARTS: Nanos = 2_000_000;
const PLL_LOCKS: Nanos = 200_000;
const LSI_STARTS: Nanos = 15_000;

/// The oscillators that the clocks depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillators {
    /// The frequency of the internal oscillator, in Hz.
    pub(crate) hsi: u32,
    /// The crystal, in Hz; none when it is broken.
    pub(crate) hse: Option<u32>,
}

/// A bus with gates: an index of its registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    Ahb1 = 0,
    Ahb2 = 1,
    Apb1 = 3,
    Apb2 = 4,
}

/// The cause of a reset, as the flags of RCC_CSR show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResetCause {
    /// The chip was switched on.
    PowerOn,
    /// The supply dipped below the brown-out level.
    BrownOut,
    /// The reset pin was pulled low.
    Pin,
    /// The firmware asked for it: AIRCR, SYSRESETREQ.
    Software,
    /// The independent watchdog was not fed.
    Watchdog,
}

impl std::fmt::Display for ResetCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::PowerOn => "switched on",
            Self::BrownOut => "brown-out",
            Self::Pin => "the reset pin",
            Self::Software => "by its software",
            Self::Watchdog => "by the watchdog",
        })
    }
}

impl ResetCause {
    /// Every reset pulls the pin low as well; power-on raises the brown-out flag too.
    const fn flags(self) -> u32 {
        const BORRSTF: u32 = 1 << 25;
        const PINRSTF: u32 = 1 << 26;
        const PORRSTF: u32 = 1 << 27;
        PINRSTF
            | match self {
                Self::PowerOn => PORRSTF | BORRSTF,
                Self::BrownOut => BORRSTF,
                Self::Pin => 0,
                Self::Software => 1 << 28,
                Self::Watchdog => 1 << 29,
            }
    }
}

/// The clock that drives the system (RCC_CFGR, SW).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Hsi = 0,
    Hse = 1,
    Pll = 2,
}

/// The clocks that the registers select.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tree {
    pub(crate) hclk: Frequency,
    /// HCLK over PCLK1 and PCLK2.
    pub(crate) apb1: u64,
    pub(crate) apb2: u64,
}

/// An oscillator: off, or on and ready from a moment on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Oscillator {
    Off,
    /// `Nanos::MAX` if it never will be.
    On {
        ready: Nanos,
    },
}

impl Oscillator {
    fn switch(&mut self, on: bool, ready: Nanos) {
        match (on, *self) {
            (false, _) => *self = Self::Off,
            (true, Self::Off) => *self = Self::On { ready },
            (true, Self::On { .. }) => {}
        }
    }

    const fn is_on(self) -> bool {
        matches!(self, Self::On { .. })
    }

    fn is_ready(self, now: Nanos) -> bool {
        matches!(self, Self::On { ready } if ready <= now)
    }
}

/// The registers.
#[derive(Clone, Debug)]
pub(crate) struct Rcc {
    around: Oscillators,
    hsi: Oscillator,
    hse: Oscillator,
    pll: Oscillator,
    plli2s: Oscillator,
    lsi: Oscillator,
    /// HSITRIM and HSEBYP.
    cr: u32,
    pllcfgr: u32,
    plli2scfgr: u32,
    /// Without SW and SWS.
    cfgr: u32,
    wanted: Source,
    source: Source,
    rstr: [u32; 5],
    enr: [u32; 5],
    bdcr: u32,
    /// The flags of RCC_CSR.
    causes: u32,
}

/// AHB1, AHB2, AHB3, APB1, APB2: which bits of RSTR and ENR there are.
const GATES: [u32; 5] = [0x6074_11FF, 0x0000_00C0, 1, 0x36FE_C9FF, 0x0007_5F33];
/// LPENR after reset: everything goes on in sleep.
const SLEEP: [u32; 5] = [0x7E67_91FF, 0x0000_00F1, 1, 0x36FE_C9FF, 0x0007_5F33];

impl Rcc {
    pub(crate) fn new(around: Oscillators) -> Self {
        Self {
            around,
            hsi: Oscillator::On { ready: 0 },
            hse: Oscillator::Off,
            pll: Oscillator::Off,
            plli2s: Oscillator::Off,
            lsi: Oscillator::Off,
            cr: 16 << 3,
            pllcfgr: 0x2400_3010,
            plli2scfgr: 0x2000_3000,
            cfgr: 0,
            wanted: Source::Hsi,
            source: Source::Hsi,
            rstr: [0; 5],
            enr: [CCMDATARAMEN, 0, 0, 0, 0],
            bdcr: 0,
            causes: 0,
        }
    }

    /// The chip is reset. The backup domain keeps what it has, and flags of earlier resets stay until
    /// they are cleared or power goes.
    pub(crate) fn reset(&mut self, cause: ResetCause) {
        let kept = if cause == ResetCause::PowerOn { 0 } else { self.causes };
        let bdcr = self.bdcr;
        *self = Self { bdcr, causes: kept | cause.flags(), ..Self::new(self.around) };
    }

    /// Whether the clock of a peripheral is on.
    pub(crate) const fn is_clocked(&self, domain: Domain, bit: u32) -> bool {
        self.enr[domain as usize] >> bit & 1 != 0
    }

    /// Whether a peripheral is held in reset.
    pub(crate) const fn is_held(&self, domain: Domain, bit: u32) -> bool {
        self.rstr[domain as usize] >> bit & 1 != 0
    }

    /// Whether the PLL is on.
    pub(crate) const fn pll_is_on(&self) -> bool {
        self.pll.is_on()
    }

    /// When a pending switch can be made; `Nanos::MAX` for none.
    pub(crate) fn due(&self) -> Nanos {
        if self.wanted == self.source {
            return Nanos::MAX;
        }
        match self.oscillator(self.wanted) {
            Oscillator::On { ready } => ready,
            Oscillator::Off => Nanos::MAX,
        }
    }

    const fn oscillator(&self, source: Source) -> Oscillator {
        match source {
            Source::Hsi => self.hsi,
            Source::Hse => self.hse,
            Source::Pll => self.pll,
        }
    }

    /// Makes a switch that was waited for; whether there was one.
    pub(crate) fn settle(&mut self, now: Nanos) -> bool {
        let switches = self.source != self.wanted && self.oscillator(self.wanted).is_ready(now);
        if switches {
            self.source = self.wanted;
        }
        switches
    }

    /// `watchdog` runs, which keeps its oscillator on.
    pub(crate) fn read(&mut self, offset: u32, now: Nanos, watchdog: bool) -> Result<u32, Refused> {
        self.settle(now);
        Ok(match offset {
            0x00 => self.cr(now),
            0x04 => self.pllcfgr,
            0x08 => self.cfgr | self.wanted as u32 | (self.source as u32) << 2,
            0x0C => 0,
            0x10..=0x24 => self.rstr[bank(offset - 0x10)?],
            0x30..=0x44 => self.enr[bank(offset - 0x30)?],
            0x50..=0x64 => SLEEP[bank(offset - 0x50)?],
            0x70 => self.bdcr,
            0x74 => {
                let on = self.lsi.is_on() || watchdog;
                let ready = self.lsi.is_ready(now) || watchdog;
                self.causes | u32::from(self.lsi.is_on()) | u32::from(on && ready) << 1
            }
            0x80 => 0,
            0x84 => self.plli2scfgr,
            // Registers of larger chips of the family, which drivers for all of them look at.
            0x88..=0x94 => 0,
            _ => return Err(Refused::Unmodelled { what: "RCC: a reserved register" }),
        })
    }

    fn cr(&self, now: Nanos) -> u32 {
        let state = |oscillator: Oscillator, on, ready| {
            let on = if oscillator.is_on() { on } else { 0 };
            on | if oscillator.is_ready(now) { ready } else { 0 }
        };
        // A factory calibration of 128.
        self.cr
            | 128 << 8
            | state(self.hsi, cr::HSION, cr::HSIRDY)
            | state(self.hse, cr::HSEON, cr::HSERDY)
            | state(self.pll, cr::PLLON, cr::PLLRDY)
            | state(self.plli2s, cr::PLLI2SON, cr::PLLI2SRDY)
    }

    /// `open` is PWR_CR, DBP. True where the backup domain is to be reset.
    pub(crate) fn write(
        &mut self,
        offset: u32,
        value: u32,
        now: Nanos,
        open: bool,
    ) -> Result<(), Refused> {
        self.settle(now);
        match offset {
            0x00 => self.set_cr(value, now)?,
            0x04 => {
                let value = value & 0x0F43_7FFF;
                refuse(
                    self.pll.is_on() && value != self.pllcfgr & 0x0F43_7FFF,
                    "RCC_PLLCFGR: written while the PLL is on",
                )?;
                self.pllcfgr = value | 0x2000_0000;
            }
            0x08 => self.set_cfgr(value, now)?,
            0x0C => refuse(value & 0x3F00 != 0, "RCC_CIR: interrupts")?,
            0x10..=0x24 => {
                let bank = bank(offset - 0x10)?;
                self.rstr[bank] = value & GATES[bank];
            }
            0x30..=0x44 => {
                let bank = bank(offset - 0x30)?;
                refuse(bank == 0 && value & CCMDATARAMEN == 0, "RCC_AHB1ENR: CCM switched off")?;
                self.enr[bank] = value & GATES[bank];
            }
            0x50..=0x64 => {
                let bank = bank(offset - 0x50)?;
                refuse(
                    value & GATES[bank] != SLEEP[bank] & GATES[bank],
                    "RCC_LPENR: gates in sleep",
                )?;
            }
            0x70 if open => self.set_bdcr(value)?,
            // Protected: nothing happens.
            0x70 => {}
            0x74 => {
                self.lsi.switch(value & 1 != 0, now + LSI_STARTS);
                if value & 1 << 24 != 0 {
                    self.causes = 0;
                }
            }
            0x80 => refuse(value & 1 << 31 != 0, "RCC_SSCGR: spread spectrum")?,
            0x84 => self.plli2scfgr = value & 0x7000_7FC0,
            0x88..=0x94 => refuse(value != 0, "RCC: a register that this chip does not have")?,
            _ => return Err(Refused::Unmodelled { what: "RCC: a reserved register" }),
        }
        Ok(())
    }

    fn set_cr(&mut self, value: u32, now: Nanos) -> Result<(), Refused> {
        refuse(value & cr::CSSON != 0, "RCC_CR: clock security")?;
        let asked = |bit| value & bit != 0;
        refuse(
            self.hse.is_on() && (value ^ self.cr) & cr::HSEBYP != 0,
            "RCC_CR: HSEBYP changed while the HSE is on",
        )?;
        self.cr = value & (cr::HSITRIM | cr::HSEBYP);
        // What drives the system cannot be switched off, nor what drives that.
        let drives = |source| self.source == source || self.wanted == source;
        let by_pll = drives(Source::Pll) || asked(cr::PLLON);
        let hsi = asked(cr::HSION) || drives(Source::Hsi) || by_pll && !self.pll_takes_hse();
        let hse = asked(cr::HSEON) || drives(Source::Hse) || by_pll && self.pll_takes_hse();
        let pll = asked(cr::PLLON) || drives(Source::Pll);
        let hse_is_wanted_only = hse && !asked(cr::HSEON) && !self.hse.is_on();
        self.hsi.switch(hsi, now + HSI_STARTS);
        if !hse_is_wanted_only {
            let starts = if self.around.hse.is_some() { now + HSE_STARTS } else { Nanos::MAX };
            self.hse.switch(hse, starts);
        }
        if pll && !self.pll.is_on() {
            self.pll_output()?;
            let input = if self.pll_takes_hse() { self.hse } else { self.hsi };
            refuse(!input.is_ready(now), "RCC_CR: PLL switched on without a clock")?;
        }
        self.pll.switch(pll, now + PLL_LOCKS);
        self.plli2s.switch(asked(cr::PLLI2SON), now + PLL_LOCKS);
        Ok(())
    }

    fn set_cfgr(&mut self, value: u32, now: Nanos) -> Result<(), Refused> {
        self.wanted = match value & 3 {
            0 => Source::Hsi,
            1 => Source::Hse,
            2 => Source::Pll,
            _ => return Err(Refused::Unmodelled { what: "RCC_CFGR: SW is 3" }),
        };
        self.cfgr = value & 0xFFFF_FCF0;
        self.settle(now);
        self.tree().map_err(|what| Refused::Unmodelled { what })?;
        Ok(())
    }

    fn set_bdcr(&mut self, value: u32) -> Result<(), Refused> {
        if value & 1 << 16 != 0 {
            self.bdcr = 1 << 16;
            return Ok(());
        }
        refuse(value & 1 != 0, "RCC_BDCR: LSE, for which there is no crystal")?;
        refuse(value & 1 << 15 != 0, "RCC_BDCR: the calendar's clock")?;
        self.bdcr = value & 0x8305;
        Ok(())
    }

    /// Whether the backup domain is held in reset (BDRST).
    pub(crate) const fn backup_is_held(&self) -> bool {
        self.bdcr & 1 << 16 != 0
    }

    const fn pll_takes_hse(&self) -> bool {
        self.pllcfgr & 1 << 22 != 0
    }

    /// The PLL's main output, or what is wrong with it (RCC_PLLCFGR; STM32F405 data sheet, PLL
    /// characteristics).
    fn pll_output(&self) -> Result<Frequency, Refused> {
        let m = self.pllcfgr & 0x3F;
        let n = self.pllcfgr >> 6 & 0x1FF;
        let p = 2 * (self.pllcfgr >> 16 & 3) + 2;
        let q = self.pllcfgr >> 24 & 15;
        let hse = Frequency::hertz(self.around.hse.unwrap_or(1_000_000));
        let hsi = Frequency::hertz(self.around.hsi);
        let input = if self.pll_takes_hse() { hse } else { hsi };
        refuse(m < 2, "RCC_PLLCFGR: PLLM below 2")?;
        refuse(!(50..=432).contains(&n), "RCC_PLLCFGR: PLLN outside 50 to 432")?;
        refuse(q < 2, "RCC_PLLCFGR: PLLQ below 2")?;
        let vco_input = input.over(m);
        refuse(
            vco_input.below(950_000) || vco_input.above(2_100_000),
            "RCC_PLLCFGR: the VCO's input is not at 0.95 to 2.1 MHz",
        )?;
        let vco = vco_input.times(n);
        // Oscillators are not exact: a thousandth, as for what follows.
        refuse(
            vco.below(99_900_000) || vco.above(432_432_000),
            "RCC_PLLCFGR: the VCO is not at 100 to 432 MHz",
        )?;
        Ok(vco.over(p))
    }

    /// The frequencies of all clocks now, or the reason why there are none.
    pub(crate) fn tree(&self) -> Result<Tree, &'static str> {
        let sysclk = match self.source {
            Source::Hsi => Frequency::hertz(self.around.hsi),
            Source::Hse => Frequency::hertz(self.around.hse.unwrap_or(1)),
            Source::Pll => self.pll_output().map_err(|refused| match refused {
                Refused::Unmodelled { what } => what,
                Refused::Fault => "RCC_PLLCFGR",
            })?,
        };
        let hpre = match self.cfgr >> 4 & 15 {
            0..=7 => 1,
            // There is no division by 32.
            by @ 8..=11 => 2 << (by - 8),
            by => 64 << (by - 12),
        };
        let ppre = |shift: u32| match self.cfgr >> shift & 7 {
            0..=3 => 1,
            by => 2 << (by - 4),
        };
        let (apb1, apb2) = (ppre(10), ppre(13));
        let hclk = sysclk.over(hpre);
        let exceeds = |by: u32, mhz: u64| hclk.over(by).above(mhz * 1_001_000);
        if exceeds(1, 168) {
            return Err("RCC_CFGR: HCLK above 168 MHz");
        }
        if exceeds(apb1, 42) {
            return Err("RCC_CFGR: PCLK1 above 42 MHz");
        }
        if exceeds(apb2, 84) {
            return Err("RCC_CFGR: PCLK2 above 84 MHz");
        }
        Ok(Tree { hclk, apb1: apb1.into(), apb2: apb2.into() })
    }

    pub(crate) fn words(&self, now: Nanos) -> [u32; 10] {
        let [ahb1, ahb2, _, apb1, apb2] = self.enr;
        let selected = self.wanted as u32 | (self.source as u32) << 2;
        [
            self.cr(now),
            self.pllcfgr,
            self.cfgr | selected,
            ahb1,
            ahb2,
            apb1,
            apb2,
            self.bdcr,
            self.causes,
            u32::from(self.lsi.is_on()),
        ]
    }
}

/// AHB1, 2, 3, a gap, APB1, APB2.
fn bank(offset: u32) -> Result<usize, Refused> {
    match offset {
        0x00 => Ok(0),
        0x04 => Ok(1),
        0x08 => Ok(2),
        0x10 => Ok(3),
        0x14 => Ok(4),
        _ => Err(Refused::Unmodelled { what: "RCC: a reserved register" }),
    }
}

fn refuse(is_unknown: bool, what: &'static str) -> Result<(), Refused> {
    if is_unknown { Err(Refused::Unmodelled { what }) } else { Ok(()) }
}
