//! Executes one instruction on Unicorn's Cortex-M4.
//!
//! After a fault an engine may stay as it is and never execute again, and a comparison would then
//! compare nothing. So every fault costs an engine, every thousandth instruction is one whose answer
//! is known, and the counts must reach the number expected.

use core_vectors::outcome::changes;
use core_vectors::state::{CODE, LITERALS, LITERALS_SIZE, background, ram};
use core_vectors::{After, Outcome, State};
use unicorn_engine::{Arch, ArmCpuModel, Mode, Prot, RegisterARM, Unicorn, uc_error};
use virtual_crazyflie::memory::map;

/// `B .`: where a block of translated code ends.
const HERE: u16 = 0xE7FE;

const KNOWN_EVERY: u64 = 1000;

/// The other core.
pub(crate) struct Other {
    engine: Unicorn<'static, ()>,
    encoding: Option<u32>,
    ram: [[(u32, Vec<u8>); 2]; 2],
    /// Which of the two is in memory.
    holds: Option<bool>,
    now: Vec<u8>,
    literals: Vec<u8>,
    dirty: bool,
    steps: u64,
    /// The number of engines that were made.
    pub(crate) engines: u64,
    /// The number of instructions with a known answer that were right.
    pub(crate) known: u64,
}

impl Other {
    /// A core, and memory as ours has it.
    pub(crate) fn new() -> Self {
        let literals = background(LITERALS_SIZE, false);
        Self {
            engine: engine(&literals),
            encoding: None,
            ram: [ram(false), ram(true)],
            holds: None,
            now: Vec::new(),
            literals,
            dirty: false,
            steps: 0,
            engines: 1,
            known: 0,
        }
    }

    /// The instruction, from this state.
    pub(crate) fn run(&mut self, encoding: u32, state: &State) -> Outcome {
        self.steps += 1;
        if self.steps.is_multiple_of(KNOWN_EVERY) {
            self.ask_what_is_known();
        }
        self.execute(encoding, state)
    }

    /// ADDS R0, R1, R2: 0x7FFF_FFFF + 1 is negative and has overflowed.
    fn ask_what_is_known(&mut self) {
        let mut state =
            State { r: [0; 15], apsr: 0, it: 0, s: [0; 32], fpscr: 0, window_of_code: false };
        (state.r[1], state.r[2], state.r[13]) = (0x7FFF_FFFF, 1, map::RAM);
        match self.execute(0x1888, &state) {
            Outcome::Done(after) if after.r[0] == 1 << 31 && after.apsr == 0x9000_0000 => {
                self.known += 1;
            }
            other => panic!("Unicorn no longer adds: {other:?}"),
        }
    }

    fn renew(&mut self) {
        self.engine = engine(&self.literals);
        self.encoding = None;
        self.holds = None;
        self.dirty = false;
        self.engines += 1;
    }

    fn execute(&mut self, encoding: u32, state: &State) -> Outcome {
        if self.dirty {
            self.renew();
        }
        if self.encoding != Some(encoding) {
            self.place(encoding);
        }
        if self.holds.replace(state.window_of_code) != Some(state.window_of_code) {
            for (base, bytes) in &self.ram[usize::from(state.window_of_code)] {
                self.engine.mem_write((*base).into(), bytes).expect("RAM is mapped");
            }
        }
        self.set(state);
        let result = self.engine.emu_start(u64::from(CODE) | 1, 0, 0, 1);
        let pc = self.word(RegisterARM::PC);
        match result {
            Ok(()) => Outcome::Done(Box::new(self.after(state))),
            // It jumped to where nothing is or nothing may be executed, or to what is no
            // instruction, or left Thumb state: the instruction itself was executed.
            Err(
                uc_error::FETCH_UNMAPPED
                | uc_error::FETCH_PROT
                | uc_error::EXCEPTION
                | uc_error::INSN_INVALID,
            ) if pc != CODE => {
                self.dirty = true;
                Outcome::Done(Box::new(self.after(state)))
            }
            Err(error) => {
                self.dirty = true;
                Outcome::Fault(format!("{error:?}"))
            }
        }
    }

    fn place(&mut self, encoding: u32) {
        let mut bytes = self.literals[(CODE - LITERALS) as usize..][..8].to_vec();
        if encoding > 0xFFFF {
            bytes[..2].copy_from_slice(&((encoding >> 16) as u16).to_le_bytes());
            bytes[2..4].copy_from_slice(&(encoding as u16).to_le_bytes());
            bytes[4..6].copy_from_slice(&HERE.to_le_bytes());
        } else {
            bytes[..2].copy_from_slice(&(encoding as u16).to_le_bytes());
            bytes[2..4].copy_from_slice(&HERE.to_le_bytes());
        }
        for address in [CODE, CODE - map::FLASH] {
            self.engine.mem_write(address.into(), &bytes).expect("flash is mapped");
        }
        self.engine
            .ctl_remove_cache((CODE - 8).into(), (CODE + 16).into())
            .expect("the code can be forgotten");
        self.encoding = Some(encoding);
    }

    fn set(&mut self, state: &State) {
        let mut registers = Vec::with_capacity(64);
        let mut values = Vec::with_capacity(64);
        let mut put = |register: i32, value: u32| {
            registers.push(register);
            values.push(u64::from(value));
        };
        // Thread mode, privileged, the main stack, and a context that uses the FPU.
        put(RegisterARM::CONTROL as i32, 4);
        put(RegisterARM::PSP as i32, 0);
        for (register, value) in CORE.iter().zip(&state.r) {
            put(*register as i32, *value);
        }
        for (register, value) in single().zip(&state.s) {
            put(register, *value);
        }
        let it = u32::from(state.it);
        put(
            RegisterARM::XPSR_NZCVQG as i32,
            state.apsr | 1 << 24 | (it & 3) << 25 | (it & 0xFC) << 8,
        );
        put(RegisterARM::FPSCR as i32, state.fpscr);
        let count = i32::try_from(registers.len()).expect("a few");
        self.engine.reg_write_batch(&registers, &values, count).expect("these registers exist");
    }

    fn after(&mut self, state: &State) -> After {
        let mut registers: Vec<i32> = CORE.iter().map(|register| *register as i32).collect();
        registers.push(RegisterARM::PC as i32);
        registers.extend(single());
        let others = [
            RegisterARM::XPSR,
            RegisterARM::FPSCR,
            RegisterARM::MSP,
            RegisterARM::PSP,
            RegisterARM::PRIMASK,
            RegisterARM::BASEPRI,
            RegisterARM::FAULTMASK,
            RegisterARM::CONTROL,
        ];
        registers.extend(others.map(|register| register as i32));
        let count = i32::try_from(registers.len()).expect("a few");
        let values: Vec<u32> = self
            .engine
            .reg_read_batch(&mut registers, count)
            .expect("these registers exist")
            .into_iter()
            .map(|value| value as u32)
            .collect();
        let xpsr = values[48];
        let special: [u32; 6] = values[50..56].try_into().expect("six");
        self.dirty |= special[2..] != [0, 0, 0, 4] || special[1] != 0;
        let mut memory = Vec::new();
        for (base, before) in &self.ram[usize::from(state.window_of_code)] {
            self.now.resize(before.len(), 0);
            self.engine.mem_read((*base).into(), &mut self.now).expect("RAM is mapped");
            let first = memory.len();
            changes(*base, before, &self.now, &mut memory);
            for (address, _) in &memory[first..] {
                let byte = before[(address - base) as usize];
                self.engine.mem_write((*address).into(), &[byte]).expect("RAM is mapped");
            }
        }
        After {
            r: values[..16].try_into().expect("sixteen"),
            apsr: xpsr & 0xF80F_0000,
            thumb: xpsr >> 24 & 1 == 1,
            it: (xpsr >> 25 & 3 | xpsr >> 8 & 0xFC) as u8,
            s: values[16..48].try_into().expect("thirty-two"),
            fpscr: values[49],
            special,
            memory,
        }
    }

    /// Marks the engine as used up: the next instruction must not see its exclusive monitor.
    pub(crate) fn forget(&mut self) {
        self.dirty = true;
    }

    fn word(&self, register: RegisterARM) -> u32 {
        self.engine.reg_read(register).expect("it exists") as u32
    }
}

const CORE: [RegisterARM; 15] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R4,
    RegisterARM::R5,
    RegisterARM::R6,
    RegisterARM::R7,
    RegisterARM::R8,
    RegisterARM::R9,
    RegisterARM::R10,
    RegisterARM::R11,
    RegisterARM::R12,
    RegisterARM::SP,
    RegisterARM::LR,
];

/// S0 to S31 follow one another.
fn single() -> impl Iterator<Item = i32> {
    (0..32).map(|n| RegisterARM::S0 as i32 + n)
}

fn engine(literals: &[u8]) -> Unicorn<'static, ()> {
    // Not Mode::MCLASS: with it Unicorn takes a Cortex-M33, whatever model is asked for, which is
    // ARMv8-M and starts in the secure state.
    let mut engine = Unicorn::new(Arch::ARM, Mode::THUMB).expect("Unicorn has been built for ARM");
    engine.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32).expect("it knows the Cortex-M4");
    let mut map = |base: u32, size: u32, prot: Prot| {
        engine.mem_map(base.into(), size.into(), prot).expect("nothing else is there");
    };
    map(0, map::FLASH_SIZE, Prot::READ | Prot::EXEC);
    map(map::FLASH, map::FLASH_SIZE, Prot::READ | Prot::EXEC);
    map(map::RAM, map::RAM_SIZE, Prot::ALL);
    map(map::CCM, map::CCM_SIZE, Prot::READ | Prot::WRITE);
    for base in [0, map::FLASH] {
        let empty = vec![0xFF; map::FLASH_SIZE as usize];
        engine.mem_write(base.into(), &empty).expect("flash is mapped");
        engine.mem_write((base + LITERALS - map::FLASH).into(), literals).expect("flash is mapped");
    }
    engine
}

#[cfg(test)]
mod tests {
    use super::*;
    use core_vectors::States;

    fn state(encoding: u32) -> State {
        let mut state = States::of(encoding, 1).next().expect("there is always one more");
        (state.apsr, state.it, state.fpscr) = (0, 0, 0);
        state
    }

    fn done(encoding: u32, state: &State) -> After {
        match Other::new().run(encoding, state) {
            Outcome::Done(after) => *after,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_addition_sets_flags() {
        let mut from = state(0x1888);
        (from.r[1], from.r[2]) = (u32::MAX, 1);
        let after = done(0x1888, &from);
        assert_eq!((after.r[0], after.apsr, after.r[15]), (0, 0x6000_0000, CODE + 2));
        assert!(after.thumb && after.memory.is_empty());
    }

    #[test]
    fn the_floating_point_unit_works_at_once_and_keeps_its_modes() {
        // VADD.F32 S0, S1, S2, rounding towards plus infinity.
        let mut from = state(0xEE30_0A81);
        (from.s[1], from.s[2], from.fpscr) = (0x3F80_0000, 0x3300_0000, 1 << 22);
        let after = done(0xEE30_0A81, &from);
        assert_eq!((after.s[0], after.fpscr), (0x3F80_0001, 1 << 22 | 0x10));
    }

    #[test]
    fn a_block_decides_whether_an_instruction_is_executed() {
        // ADDS R0, R1, R2, as ADDEQ.
        let mut from = state(0x1888);
        from.it = 0x08;
        from.r[0] = 7;
        let after = done(0x1888, &from);
        assert_eq!((after.r[0], after.it, after.apsr), (7, 0, 0));
        from.apsr = 1 << 30;
        let after = done(0x1888, &from);
        assert_eq!((after.r[0], after.it), (from.r[1].wrapping_add(from.r[2]), 0));
        assert_eq!(after.apsr, 1 << 30);
    }

    #[test]
    fn after_a_fault_there_is_a_fresh_engine() {
        let mut other = Other::new();
        assert!(matches!(other.run(0xDE00, &state(0xDE00)), Outcome::Fault(_)));
        assert!(matches!(other.run(0x1888, &state(0x1888)), Outcome::Done(_)));
        assert_eq!(other.engines, 2);
    }

    #[test]
    fn the_known_answer_is_asked_for() {
        let mut other = Other::new();
        let from = state(0xBF00);
        (0..2 * KNOWN_EVERY).for_each(|_| drop(other.run(0xBF00, &from)));
        assert_eq!(other.known, 2);
    }
}
