//! A core, some code, and a bus with one register.

use virtual_crazyflie::bus::{Bus, Refused, Width};
use virtual_crazyflie::cpu::{Cpu, Program, Stop};
use virtual_crazyflie::memory::Memory;

pub(crate) const CODE: u32 = 0x0800_4000;
pub(crate) const DATA: u32 = 0x2000_1000;
pub(crate) const STACK: u32 = 0x2000_8000;
/// The only register there is.
pub(crate) const REGISTER: u32 = 0x4000_0000;
/// The chip would have something here.
pub(crate) const UNMODELLED: u32 = 0x4000_1000;
/// It would have nothing here.
pub(crate) const NOTHING: u32 = 0x6000_0000;

/// One register, and a list of when something happens by itself.
#[derive(Default)]
pub(crate) struct OneRegister {
    pub(crate) value: u32,
    pub(crate) stores: Vec<(u64, u32, Width, u32)>,
    pub(crate) due: Vec<u64>,
    pub(crate) happened: Vec<u64>,
    pub(crate) wait_states: u8,
    pub(crate) resets: bool,
}

impl Bus for OneRegister {
    fn load(&mut self, _: &mut Memory, _: u64, address: u32, _: Width) -> Result<u32, Refused> {
        match address {
            REGISTER => Ok(self.value),
            UNMODELLED => Err(Refused::Unmodelled { what: "TIM4" }),
            _ => Err(Refused::Fault),
        }
    }

    fn store(
        &mut self,
        _: &mut Memory,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        match address {
            REGISTER => {
                self.stores.push((now, address, width, value));
                self.value = value;
                Ok(())
            }
            UNMODELLED => Err(Refused::Unmodelled { what: "TIM4" }),
            _ => Err(Refused::Fault),
        }
    }

    fn due(&self) -> u64 {
        self.due.first().copied().unwrap_or(u64::MAX)
    }

    fn advance(&mut self, _: &mut Memory, now: u64) {
        self.due.retain(|due| *due > now);
        self.happened.push(now);
    }

    fn lines(&self) -> u128 {
        0
    }

    fn resets(&self) -> bool {
        self.resets
    }

    fn flash_wait_states(&self) -> u8 {
        self.wait_states
    }
}

pub(crate) struct Rig {
    pub(crate) cpu: Cpu,
    pub(crate) memory: Memory,
    pub(crate) bus: OneRegister,
    pub(crate) program: Program,
}

impl Rig {
    /// Code in flash, about to be executed.
    pub(crate) fn new(code: &[u16]) -> Self {
        let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        Self::of_bytes(&bytes)
    }

    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        let mut memory = Memory::new();
        assert!(memory.program(CODE, bytes));
        let mut cpu = Cpu::new();
        cpu.set_register(13, STACK);
        cpu.set_register(15, CODE);
        let program = Program::new(CODE, bytes);
        Self { cpu, memory, bus: OneRegister::default(), program }
    }

    pub(crate) fn with(mut self, n: usize, value: u32) -> Self {
        self.cpu.set_register(n, value);
        self
    }

    pub(crate) fn word(&mut self, address: u32, value: u32) {
        assert!(self.memory.store(address, Width::Word, value));
    }

    pub(crate) fn read(&self, address: u32) -> u32 {
        self.memory.load(address, Width::Word).expect("it is memory")
    }

    pub(crate) fn run(&mut self, until: u64) -> Stop {
        self.cpu.run(&self.program, &mut self.memory, &mut self.bus, until)
    }

    pub(crate) fn step(&mut self) -> Stop {
        self.cpu.step(&self.program, &mut self.memory, &mut self.bus, u64::MAX)
    }

    /// So many instructions, none of which may come to nothing.
    pub(crate) fn steps(&mut self, count: usize) {
        for _ in 0..count {
            assert_eq!(self.step(), Stop::Until);
            assert!(self.cpu.faults().is_empty(), "{:?}", self.cpu.faults());
        }
    }

    pub(crate) fn registers(&self) -> [u32; 16] {
        std::array::from_fn(|n| self.cpu.register(n))
    }

    /// The floating-point unit is switched on, by the one way there is.
    pub(crate) fn with_fpu(mut self) -> Self {
        let saved = self.registers();
        // STR R1, [R0] in RAM.
        self.memory.store(STACK, Width::Half, 0x6001);
        self.cpu.set_register(0, 0xE000_ED88);
        self.cpu.set_register(1, 0xF << 20);
        self.cpu.set_register(15, STACK);
        self.steps(1);
        for (n, value) in saved.into_iter().enumerate() {
            self.cpu.set_register(n, value);
        }
        self
    }
}
