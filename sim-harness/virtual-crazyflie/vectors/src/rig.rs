//! Executes one instruction on the emulated core, with memory and no peripherals.

use crate::outcome::{After, Outcome, changes};
use crate::state::{CODE, LITERALS, LITERALS_SIZE, State, WINDOW, WINDOW_SIZE, background, ram};
use virtual_crazyflie::bus::{MemoryOnly, Width};
use virtual_crazyflie::cpu::fp::Fpscr;
use virtual_crazyflie::cpu::{Cpu, Flags, Program, Stop};
use virtual_crazyflie::memory::Memory;

/// The instruction after the tested one: `B .`.
const HERE: u16 = 0xE7FE;

/// A core that can be put into any state.
pub struct Rig {
    memory: Memory,
    program: Program,
    encoding: Option<u32>,
    ram: [[(u32, Vec<u8>); 2]; 2],
    literals: Vec<u8>,
    /// Which of the two is in memory.
    holds: Option<bool>,
}

impl Rig {
    /// With memory as a comparison wants it.
    #[must_use]
    pub fn new() -> Self {
        let mut memory = Memory::new();
        let literals = background(LITERALS_SIZE, false);
        assert!(memory.program(LITERALS, &literals), "it is flash");
        Self {
            memory,
            program: Program::new(CODE, &[]),
            encoding: None,
            ram: [ram(false), ram(true)],
            literals,
            holds: None,
        }
    }

    /// The instruction, from this state.
    pub fn run(&mut self, encoding: u32, state: &State) -> Outcome {
        if self.encoding != Some(encoding) {
            self.place(encoding);
        }
        if self.holds != Some(state.window_of_code) {
            self.fill(state.window_of_code);
        }
        let mut cpu = Self::core(state);
        let stop = cpu.step(&self.program, &mut self.memory, &mut MemoryOnly::default(), u64::MAX);
        let mut changed = Vec::new();
        for (base, before) in &self.ram[usize::from(state.window_of_code)] {
            let size = u32::try_from(before.len()).expect("it fits the map");
            let now = self.memory.bytes(*base, size).expect("it is RAM");
            let first = changed.len();
            changes(*base, before, now, &mut changed);
            for (address, _) in &changed[first..] {
                let byte = before[(address - base) as usize];
                self.memory.store(*address, Width::Byte, byte.into());
            }
        }
        if let Some(report) = cpu.faults().first() {
            // It is pending. Memory may hold a part of what was to be stored; registers are as
            // they were, so that the instruction can be tried again.
            return if is_untouched(&cpu, state) {
                Outcome::Fault(format!("{:?}", report.fault))
            } else {
                Outcome::Other(format!("{:?} with effects", report.fault))
            };
        }
        match stop {
            Stop::Until => Outcome::Done(Box::new(after(&cpu, changed))),
            other => Outcome::Other(format!("{other:?}")),
        }
    }

    fn place(&mut self, encoding: u32) {
        let mut halves = vec![encoding as u16, HERE];
        if crate::forms::is_wide(encoding) {
            halves.insert(0, (encoding >> 16) as u16);
        }
        let bytes: Vec<u8> = halves.into_iter().flat_map(u16::to_le_bytes).collect();
        let around = &self.literals[(CODE - LITERALS) as usize..][..8];
        assert!(self.memory.program(CODE, around), "it is flash");
        assert!(self.memory.program(CODE, &bytes), "it is flash");
        self.program = Program::new(CODE, &bytes);
        self.encoding = Some(encoding);
    }

    fn fill(&mut self, of_code: bool) {
        for (address, word) in
            (WINDOW..).step_by(4).zip(background(WINDOW_SIZE, of_code).as_chunks::<4>().0)
        {
            self.memory.store(address, Width::Word, u32::from_le_bytes(*word));
        }
        self.holds = Some(of_code);
    }

    /// Thread mode, privileged, the main stack, and a context that uses the FPU.
    fn core(state: &State) -> Cpu {
        let mut cpu = Cpu::new();
        cpu.enable_fpu();
        for (n, value) in state.r.iter().enumerate() {
            cpu.set_register(n, *value);
        }
        cpu.set_register(15, CODE);
        let bit = |n: u32| state.apsr >> n & 1 == 1;
        cpu.set_flags(Flags {
            n: bit(31),
            z: bit(30),
            c: bit(29),
            v: bit(28),
            q: bit(27),
            ge: (state.apsr >> 16 & 15) as u8,
        });
        cpu.set_itstate(state.it);
        for (n, bits) in state.s.iter().enumerate() {
            cpu.set_s(n, *bits);
        }
        cpu.set_fpscr(Fpscr::from_bits(state.fpscr));
        cpu
    }
}

impl Default for Rig {
    fn default() -> Self {
        Self::new()
    }
}

/// One instruction, once. For many, a [`Rig`] is cheaper.
#[must_use]
pub fn run_one(encoding: u32, state: &State) -> Outcome {
    Rig::new().run(encoding, state)
}

fn after(cpu: &Cpu, memory: Vec<(u32, u8)>) -> After {
    let flags = cpu.flags();
    let apsr = u32::from(flags.n) << 31
        | u32::from(flags.z) << 30
        | u32::from(flags.c) << 29
        | u32::from(flags.v) << 28
        | u32::from(flags.q) << 27
        | u32::from(flags.ge) << 16;
    After {
        r: std::array::from_fn(|n| cpu.register(n)),
        apsr,
        thumb: cpu.is_thumb(),
        it: cpu.itstate(),
        s: std::array::from_fn(|n| cpu.s(n)),
        fpscr: cpu.fpscr().bits(),
        special: [8, 9, 16, 17, 19, 20].map(|sysm| cpu.mrs(sysm)),
        memory,
    }
}

fn is_untouched(cpu: &Cpu, state: &State) -> bool {
    let after = after(cpu, Vec::new());
    after.r[..15] == state.r
        && after.r[15] == CODE
        && (after.apsr, after.it) == (state.apsr, state.it)
        && after.s == state.s
        && after.fpscr == Fpscr::from_bits(state.fpscr).bits()
}
