//! Interrupts and exceptions that wait or are being handled, with their priorities (ARMv6-M
//! Architecture Reference Manual, B1.5 and B3.4), and the core's registers at 0xE000E000.

/// The exception of interrupt 0.
const FIRST_INTERRUPT: u8 = 16;
/// The number of exceptions: 16 of the architecture, 32 interrupts.
const EXCEPTIONS: usize = 48;
/// The exceptions whose priority is fixed and higher than every other: HardFault and above.
const FIXED: u8 = 4;
/// A priority below every other: that of the program that no exception interrupts.
const LOWEST: u8 = u8::MAX;

/// The registers of the NVIC and of the system control block (B3.2, B3.4).
mod address {
    pub(super) const ISER: u32 = 0xE000_E100;
    pub(super) const ICER: u32 = 0xE000_E180;
    pub(super) const ISPR: u32 = 0xE000_E200;
    pub(super) const ICPR: u32 = 0xE000_E280;
    pub(super) const IPR: u32 = 0xE000_E400;
    pub(super) const IPR_END: u32 = 0xE000_E420;
    pub(super) const CPUID: u32 = 0xE000_ED00;
    pub(super) const ICSR: u32 = 0xE000_ED04;
    pub(super) const AIRCR: u32 = 0xE000_ED0C;
    pub(super) const SCR: u32 = 0xE000_ED10;
    pub(super) const CCR: u32 = 0xE000_ED14;
    pub(super) const SHPR2: u32 = 0xE000_ED1C;
    pub(super) const SHPR3: u32 = 0xE000_ED20;
}

/// CPUID of a Cortex-M0 r0p0 (Technical Reference Manual, 4.2).
const CPUID: u32 = 0x410C_C200;
/// CCR: unaligned accesses fault, and stacks are aligned to 8 bytes at an exception.
const CCR: u32 = 1 << 9 | 1 << 3;
/// The key with which AIRCR is written, and the request for a reset.
const AIRCR_KEY: u32 = 0x05FA;
const RESET_REQUEST: u32 = 1 << 2;
/// SVC, PendSV and SysTick.
pub(super) const SUPERVISOR_CALL: u8 = 11;
const PENDABLE: u8 = 14;

/// The effect of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Written {
    /// A register has its value.
    Register,
    /// The program asks for a reset.
    ResetRequest,
}

/// Which exceptions wait, and which are being handled. Sets have one bit for each exception.
#[derive(Clone, Debug)]
pub(super) struct Nvic {
    pending: u64,
    enabled: u32,
    lines: u32,
    priorities: [u8; EXCEPTIONS],
    /// The exceptions that are being handled, the latest last.
    active: Vec<u8>,
    /// The exception that may interrupt what is being handled.
    ready: Option<u8>,
    scr: u32,
}

impl Default for Nvic {
    fn default() -> Self {
        Self {
            pending: 0,
            enabled: 0,
            lines: 0,
            priorities: [0; EXCEPTIONS],
            active: Vec::with_capacity(8),
            ready: None,
            scr: 0,
        }
    }
}

const fn bit(exception: u8) -> u64 {
    1 << exception
}

/// The byte of a word that holds the priority of an exception.
const fn shift(exception: u8) -> u32 {
    (exception as u32 % 4) * 8
}

impl Nvic {
    pub(super) const fn is_ready(&self) -> bool {
        self.ready.is_some()
    }

    pub(super) const fn ready(&self) -> Option<u8> {
        self.ready
    }

    /// The exception that is being handled, or 0.
    pub(super) fn current(&self) -> u8 {
        self.active.last().copied().unwrap_or(0)
    }

    /// The levels of the lines. A line that rises, or is high while its interrupt is not being
    /// handled, makes the interrupt wait (B3.4.1).
    pub(super) fn set_lines(&mut self, lines: u32) {
        let rising = lines & !self.lines;
        self.lines = lines;
        self.pending |= u64::from(rising | lines & !self.active_interrupts()) << FIRST_INTERRUPT;
        self.settle();
    }

    fn active_interrupts(&self) -> u32 {
        let active = self.active.iter().fold(0, |set, exception| set | bit(*exception));
        (active >> FIRST_INTERRUPT) as u32
    }

    /// SVC makes its exception wait. Returns whether it is taken at once, as it has to be.
    pub(super) fn call(&mut self) -> bool {
        self.pending |= bit(SUPERVISOR_CALL);
        self.settle();
        self.ready == Some(SUPERVISOR_CALL)
    }

    /// An exception's handler begins.
    pub(super) fn enter(&mut self, exception: u8) {
        self.pending &= !bit(exception);
        self.active.push(exception);
        self.settle();
    }

    /// The handler that runs has returned.
    pub(super) fn leave(&mut self) {
        self.active.pop();
        self.set_lines(self.lines);
    }

    /// Whether a handler is interrupted by the one that runs.
    pub(super) fn is_nested(&self) -> bool {
        self.active.len() > 1
    }

    fn priority(&self, exception: u8) -> u8 {
        if exception < FIXED { 0 } else { self.priorities[usize::from(exception)] }
    }

    /// Finds the exception of the highest priority that may interrupt what is being handled; of
    /// equal ones, that with the lowest number.
    fn settle(&mut self) {
        let own = (1 << FIRST_INTERRUPT) - 1;
        let takeable = self.pending & (own | u64::from(self.enabled) << FIRST_INTERRUPT);
        self.ready = None;
        if takeable == 0 {
            return;
        }
        let current = self.active.iter().map(|it| self.priority(*it)).min().unwrap_or(LOWEST);
        let numbers = (0..EXCEPTIONS as u8).filter(|it| takeable & bit(*it) != 0);
        let best = numbers.min_by_key(|it| self.priority(*it));
        self.ready = best.filter(|it| self.priority(*it) < current);
    }

    /// The register at an address, if there is one.
    pub(super) fn read(&self, address: u32) -> Option<u32> {
        let pending = (self.pending >> FIRST_INTERRUPT) as u32;
        Some(match address {
            address::ISER | address::ICER => self.enabled,
            address::ISPR | address::ICPR => pending,
            address::IPR..address::IPR_END => self.four_priorities(Self::first_of(address)),
            address::CPUID => CPUID,
            address::ICSR => self.interrupt_state(),
            address::AIRCR => 0,
            address::SCR => self.scr,
            address::CCR => CCR,
            address::SHPR2 => self.four_priorities(8),
            address::SHPR3 => self.four_priorities(12),
            _ => return None,
        })
    }

    /// ICSR: what is handled, what waits, and whether an interrupt waits.
    fn interrupt_state(&self) -> u32 {
        let waiting = self.ready.map_or(0, u32::from) << 12;
        let any = u32::from(self.pending >> FIRST_INTERRUPT != 0) << 22;
        let pendable = u32::from(self.pending & bit(PENDABLE) != 0) << 28;
        u32::from(self.current()) | waiting | any | pendable
    }

    /// The first of the four interrupts in a priority register.
    const fn first_of(address: u32) -> u8 {
        FIRST_INTERRUPT + (address - address::IPR) as u8
    }

    fn four_priorities(&self, first: u8) -> u32 {
        let four = first..first + 4;
        four.map(|it| u32::from(self.priorities[usize::from(it)]) << shift(it)).sum()
    }

    /// Two bits of each priority exist.
    fn set_four_priorities(&mut self, first: u8, value: u32) {
        for exception in first..first + 4 {
            self.priorities[usize::from(exception)] = (value >> shift(exception)) as u8 & 0xC0;
        }
    }

    /// Writes the register at an address, if there is one.
    pub(super) fn write(&mut self, address: u32, value: u32) -> Option<Written> {
        let interrupts = u64::from(value) << FIRST_INTERRUPT;
        match address {
            address::ISER => self.enabled |= value,
            address::ICER => self.enabled &= !value,
            address::ISPR => self.pending |= interrupts,
            address::ICPR => self.pending &= !interrupts,
            address::IPR..address::IPR_END => {
                self.set_four_priorities(Self::first_of(address), value);
            }
            address::ICSR if value & 1 << 28 != 0 => self.pending |= bit(PENDABLE),
            address::ICSR if value & 1 << 27 != 0 => self.pending &= !bit(PENDABLE),
            address::ICSR | address::CCR => {}
            address::AIRCR if value >> 16 == AIRCR_KEY && value & RESET_REQUEST != 0 => {
                return Some(Written::ResetRequest);
            }
            address::AIRCR => {}
            address::SCR => self.scr = value,
            address::SHPR2 => self.set_four_priorities(8, value),
            address::SHPR3 => self.set_four_priorities(12, value),
            _ => return None,
        }
        self.settle();
        Some(Written::Register)
    }
}
