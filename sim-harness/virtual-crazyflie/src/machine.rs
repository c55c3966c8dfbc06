//! Runs core, chip, memories and board together, up to a moment.

use std::fmt;
use std::sync::Arc;

use nrf51_chip::core::Fault;

use crate::board::{Crazyflie, FirmwareChip};
use crate::bus::{Bus, Refused, Width};
use crate::cpu::{Cpu, FaultReport, FlashTiming, Program, Stop};
use crate::image::Image;
use crate::memory::{Memory, map};
use crate::soc::{Board, Nanos, Pin, PinOutput, ResetCause, Soc, SocConfig};

/// An observer of the core at marked addresses.
pub trait Observer {
    /// The core is about to execute the instruction at a marked address.
    fn trap(&mut self, cpu: &Cpu, memory: &Memory);

    /// The chip is about to be reset: what is in memory is as the firmware has left it.
    fn reset(&mut self, cpu: &Cpu, memory: &mut Memory, reset: Reset) {
        let _ = (cpu, memory, reset);
    }
}

/// The cost of fetching from flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlashModel {
    /// The cost with the accelerator as the firmware has set it up (FLASH_ACR).
    #[default]
    AsConfigured,
    /// A fixed cost, whatever the firmware sets up.
    Fixed(FlashTiming),
}

/// The configuration of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MachineConfig {
    /// The chip.
    pub soc: SocConfig,
    /// The cost of fetching from flash.
    pub flash: FlashModel,
    /// How long the bootloader takes, after each reset, until it jumps to the image. The vendor's
    /// has nothing to wait for when it is not asked to stay.
    pub bootloader: Nanos,
}

/// A reset that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// When.
    pub at: Nanos,
    /// Why.
    pub cause: ResetCause,
}

/// Why a machine cannot go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Halt {
    /// When.
    pub at: Nanos,
    /// The instruction that the core was at.
    pub pc: u32,
    /// The symbol of that address.
    pub symbol: String,
    /// The reason.
    pub why: HaltReason,
}

/// Why a machine halted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HaltReason {
    /// An access to what is not modelled.
    Unmodelled {
        /// The address.
        address: u32,
        /// The access was a store.
        store: bool,
        /// The size of the access.
        width: Width,
        /// The register or feature that is not modelled.
        what: &'static str,
    },
    /// Something that is not modelled came up without an access.
    Trouble(&'static str),
    /// An instruction of which the manual does not say what it does.
    Unpredictable {
        /// The instruction's bits.
        encoding: u32,
    },
    /// A fault while a fault was dealt with. The watchdog would end it, if it runs.
    Lockup(Option<FaultReport>),
    /// A BKPT, with no debugger there.
    Breakpoint,
    /// The firmware of the radio chip faulted, at the instruction of this address and that chip's.
    Radio(Fault),
}

impl fmt::Display for Halt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, micros) = (self.at / 1_000_000_000, self.at / 1000 % 1_000_000);
        write!(f, "at {seconds}.{micros:06} s, {:#010x} ({}): {}", self.pc, self.symbol, self.why)
    }
}

impl fmt::Display for HaltReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unmodelled { address, store, width, what } => {
                let access = if *store { "store" } else { "load" };
                let bits = 8 * width.bytes();
                write!(f, "{access} of {bits} bits at {address:#010x}: not modelled: {what}")
            }
            Self::Trouble(what) => write!(f, "not modelled: {what}"),
            Self::Unpredictable { encoding } => {
                write!(f, "instruction {encoding:#010x} is unpredictable")
            }
            Self::Lockup(None) => write!(f, "lockup"),
            Self::Lockup(Some(report)) => write!(
                f,
                "lockup: {:?} at {:#010x}, CFSR {:#010x}",
                report.fault, report.pc, report.cfsr
            ),
            Self::Breakpoint => write!(f, "breakpoint instruction"),
            Self::Radio(fault) => write!(f, "the radio chip faulted: {fault}"),
        }
    }
}

impl std::error::Error for Halt {}

/// The place at which a machine has stopped without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// The machine stopped at the requested moment, or an instruction later.
    Until,
    /// The machine stopped at a marked address. [`Machine::step`] goes past it.
    Trap,
    /// The machine stopped at a BKPT.
    Breakpoint,
}

/// A drone's processor with everything around it.
pub struct Machine<B> {
    cpu: Cpu,
    memory: Memory,
    soc: Soc<B>,
    program: Program,
    image: Arc<Image>,
    config: MachineConfig,
    resets: Vec<Reset>,
    reset_count: u64,
    observer: Option<Box<dyn Observer + Send>>,
}

/// The number of resets that are kept: the first ones.
const KEPT: usize = 64;

/// The image's code, decoded: the same for all machines that run it, which share it.
#[must_use]
pub fn decode(image: &Image) -> Program {
    let (base, bytes) = image.flat();
    Program::new(base, &bytes)
}

impl<B: Board> Machine<B> {
    /// A machine that has just been switched on, with this image in its flash.
    #[must_use]
    pub fn new(image: Arc<Image>, board: B, config: MachineConfig) -> Self {
        let program = decode(&image);
        Self::with_program(image, program, board, config)
    }

    /// A machine as [`new`](Self::new) makes it, with the image's code as [`decode`] has it.
    #[must_use]
    pub fn with_program(
        image: Arc<Image>,
        program: Program,
        board: B,
        config: MachineConfig,
    ) -> Self {
        let mut memory = Memory::new();
        for (address, bytes) in image.segments() {
            memory.program(address, bytes);
        }
        let mut soc = Soc::new(board, config.soc);
        let (start, bytes) = image.flat();
        #[expect(clippy::cast_possible_truncation, reason = "flash has 1 MiB")]
        soc.protect(start..start + bytes.len() as u32);
        let mut machine = Self {
            cpu: Cpu::new(),
            memory,
            soc,
            program,
            image,
            config,
            resets: vec![],
            reset_count: 0,
            observer: None,
        };
        machine.enter(ResetCause::PowerOn);
        machine
    }

    /// Runs up to a moment, and at most an instruction beyond. An observer is shown each trap.
    ///
    /// # Errors
    /// If it cannot go on.
    pub fn run_until(&mut self, moment: Nanos) -> Result<(), Halt> {
        self.outside(|machine| {
            loop {
                match machine.go_on(moment)? {
                    Pause::Until => return Ok(()),
                    Pause::Breakpoint => return Err(machine.halt(HaltReason::Breakpoint)),
                    Pause::Trap => {
                        if let Some(observer) = &mut machine.observer {
                            observer.trap(&machine.cpu, &machine.memory);
                        }
                        machine.step_on(moment)?;
                    }
                }
            }
        })
    }

    /// Wraps a call from outside: the caller may have changed the board before it, and reads it
    /// afterwards.
    fn outside<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        self.soc.touch(self.cpu.cycles());
        let result = run(self);
        self.soc.follow();
        result
    }

    /// Runs up to a moment, to a trap or to a breakpoint.
    ///
    /// # Errors
    /// If it cannot go on.
    pub fn advance_to(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        self.outside(|machine| machine.go_on(moment))
    }

    fn go_on(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        loop {
            let until = self.soc.cycle(moment);
            let stop = self.cpu.run(&self.program, &mut self.memory, &mut self.soc, until);
            if let Some(pause) = self.deal_with(stop, moment)? {
                return Ok(pause);
            }
        }
    }

    /// Executes one instruction, whether or not it is marked. While the core sleeps, it sleeps on to
    /// what is due next or to the moment.
    ///
    /// # Errors
    /// If it cannot go on.
    pub fn step(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        let result = self.step_on(moment);
        self.soc.follow();
        result
    }

    fn step_on(&mut self, moment: Nanos) -> Result<Pause, Halt> {
        loop {
            let until = self.soc.cycle(moment).max(self.cpu.cycles() + 1);
            let stop = self.cpu.step(&self.program, &mut self.memory, &mut self.soc, until);
            if let Some(pause) = self.deal_with(stop, moment)? {
                return Ok(pause);
            }
        }
    }

    /// Handles a stop of the core; none if the core can go on.
    fn deal_with(&mut self, stop: Stop, moment: Nanos) -> Result<Option<Pause>, Halt> {
        match stop {
            Stop::Until => Ok(Some(Pause::Until)),
            Stop::Trap => Ok(Some(Pause::Trap)),
            Stop::Breakpoint => Ok(Some(Pause::Breakpoint)),
            Stop::Reset => self.reset_asked().map(|()| None),
            Stop::Lockup => self.locked_up(moment),
            Stop::Refused { address, store, width, why } => {
                let what = match why {
                    Refused::Unmodelled { what } => what,
                    Refused::Fault => "a bus error that is no exception",
                };
                Err(self.halt(HaltReason::Unmodelled { address, store, width, what }))
            }
            Stop::Unpredictable { encoding } => {
                Err(self.halt(HaltReason::Unpredictable { encoding }))
            }
        }
    }

    fn reset_asked(&mut self) -> Result<(), Halt> {
        if let Some(what) = self.soc.trouble() {
            return Err(self.halt(HaltReason::Trouble(what)));
        }
        if self.soc.watchdog_bites() {
            self.reset(ResetCause::Watchdog);
        } else if self.cpu.wants_reset() {
            self.reset(ResetCause::Software);
        }
        if self.soc.take_change() {
            self.adopt();
        }
        Ok(())
    }

    /// A core that is locked up waits for the watchdog, if that runs; nothing else will help it.
    fn locked_up(&mut self, moment: Nanos) -> Result<Option<Pause>, Halt> {
        let Some(bite) = self.soc.watchdog_due() else {
            let report = self.cpu.faults().last().copied();
            return Err(self.halt(HaltReason::Lockup(report)));
        };
        self.wait(self.soc.cycle(bite.min(moment)));
        self.soc.advance(&mut self.memory, self.cpu.cycles());
        Ok((bite > moment).then_some(Pause::Until))
    }

    /// Time passes, and the core does nothing.
    fn wait(&mut self, until: u64) {
        let cycles = until.saturating_sub(self.cpu.cycles);
        self.cpu.cycles += cycles;
        self.cpu.slept += cycles;
    }

    /// The chip is reset, now.
    pub fn reset(&mut self, cause: ResetCause) {
        let reset = Reset { at: self.now(), cause };
        if let Some(observer) = &mut self.observer {
            observer.reset(&self.cpu, &mut self.memory, reset);
        }
        if cause == ResetCause::PowerOn {
            self.memory.lose_power();
        }
        self.soc.reset(self.cpu.cycles(), cause);
        self.enter(cause);
    }

    /// Enters the firmware as the vendor's bootloader does.
    fn enter(&mut self, cause: ResetCause) {
        self.reset_count += 1;
        if self.resets.len() < KEPT {
            self.resets.push(Reset { at: self.now(), cause });
        }
        let done = self.soc.cycle(self.now().saturating_add(self.config.bootloader));
        self.wait(done);
        self.cpu.boot(&self.memory, self.image.vector_table());
        self.soc.take_change();
        self.adopt();
    }

    /// Passes on to the core what the chip has changed.
    fn adopt(&mut self) {
        let timing = match self.config.flash {
            FlashModel::Fixed(timing) => timing,
            FlashModel::AsConfigured => match self.soc.flash_accelerator() {
                (_, true, _) => FlashTiming::Accelerated,
                _ => FlashTiming::Off,
            },
        };
        self.cpu.set_flash_timing(timing, self.soc.flash_wait_states());
        self.cpu.set_counts_in_sleep(self.soc.counts_in_sleep());
    }

    fn halt(&self, why: HaltReason) -> Halt {
        let pc = self.cpu.pc();
        Halt { at: self.now(), pc, symbol: self.image.name_of(pc), why }
    }

    /// The moment that it has come to.
    #[must_use]
    pub fn now(&self) -> Nanos {
        self.soc.nanos(self.cpu.cycles())
    }

    /// The cycle of the core at a moment, as it is clocked now.
    #[must_use]
    pub fn cycle(&self, moment: Nanos) -> u64 {
        self.soc.cycle(moment)
    }

    /// The core's frequency, in Hz.
    #[must_use]
    pub fn core_hz(&self) -> f64 {
        self.soc.core_hz()
    }

    /// The first resets, switching on included.
    #[must_use]
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// The number of resets, those included that are not kept.
    #[must_use]
    pub const fn reset_count(&self) -> u64 {
        self.reset_count
    }

    /// The first faults.
    #[must_use]
    pub fn fault_reports(&self) -> &[FaultReport] {
        self.cpu.faults()
    }

    /// The output of a pin now.
    #[must_use]
    pub fn output(&self, pin: Pin) -> PinOutput {
        self.soc.output(pin, self.cpu.cycles())
    }

    /// The board at the chip's pins.
    #[must_use]
    pub const fn board(&self) -> &B {
        self.soc.board()
    }

    /// The board at the chip's pins, to be changed between two runs.
    pub const fn board_mut(&mut self) -> &mut B {
        self.soc.board_mut()
    }

    /// The core.
    #[must_use]
    pub const fn cpu(&self) -> &Cpu {
        &self.cpu
    }

    /// The core, for a debugger.
    pub const fn cpu_mut(&mut self) -> &mut Cpu {
        &mut self.cpu
    }

    /// The memories.
    #[must_use]
    pub const fn memory(&self) -> &Memory {
        &self.memory
    }

    /// The memories, for a debugger or a probe.
    pub const fn memory_mut(&mut self) -> &mut Memory {
        &mut self.memory
    }

    /// The chip.
    #[must_use]
    pub const fn soc(&self) -> &Soc<B> {
        &self.soc
    }

    /// The image that the machine runs.
    #[must_use]
    pub const fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// The decoded code, to be marked with traps: [`Program::trap`].
    pub const fn program_mut(&mut self) -> &mut Program {
        &mut self.program
    }

    /// From now on, `observer` is called at each trap of [`Self::run_until`]. The previous observer
    /// is returned.
    pub fn observe(
        &mut self,
        observer: Option<Box<dyn Observer + Send>>,
    ) -> Option<Box<dyn Observer + Send>> {
        std::mem::replace(&mut self.observer, observer)
    }

    /// A number that is the same for two machines that are in the same state: registers, memories,
    /// counters and pins. What the board is in does not count.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = Hash::new();
        for n in 0..16 {
            hash.word(self.cpu.register(n));
        }
        for n in 0..32 {
            hash.word(self.cpu.s(n));
        }
        hash.word(self.cpu.xpsr());
        hash.long(self.cpu.cycles());
        hash.long(self.cpu.slept());
        hash.long(self.cpu.instructions());
        for word in self.soc.words(self.cpu.cycles()) {
            hash.word(word);
        }
        for (base, size) in
            [(map::RAM, map::RAM_SIZE), (map::CCM, map::CCM_SIZE), (map::FLASH, map::FLASH_SIZE)]
        {
            hash.bytes(self.memory.bytes(base, size).unwrap_or_default());
        }
        hash.0
    }
}

impl Machine<Crazyflie> {
    /// Whether the radio chip still runs.
    ///
    /// # Errors
    /// If its own firmware has faulted.
    pub fn radio_runs(&self) -> Result<(), Halt> {
        let fault = self.board().radio().firmware().and_then(FirmwareChip::fault);
        fault.map_or(Ok(()), |fault| Err(self.halt(HaltReason::Radio(fault))))
    }
}

/// FNV-1a, eight bytes at a time.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    const fn long(&mut self, value: u64) {
        self.0 = (self.0 ^ value).wrapping_mul(0x0000_0100_0000_01B3);
        // The product's upper bits never come down by themselves.
        self.0 ^= self.0 >> 29;
    }

    fn word(&mut self, value: u32) {
        self.long(value.into());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for chunk in bytes.as_chunks::<8>().0 {
            self.long(u64::from_le_bytes(*chunk));
        }
    }
}
