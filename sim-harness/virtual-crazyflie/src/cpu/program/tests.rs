//! Instructions that a program has merged can still be stopped between.

use super::*;
use crate::bus::MemoryOnly;
use crate::cpu::{Cpu, Stop};
use crate::memory::Memory;
use crate::memory::map::FLASH;

/// r0 goes down from 3; r1 counts the rounds.
const LOOP: [u16; 7] = [
    0x2003, // movs r0, #3
    0x3101, // adds r1, #1
    0x3801, // subs r0, #1
    0x2800, // cmp r0, #0
    0xD1FB, // bne to the adds
    0xBF00, // nop
    0xE7FE, // b to itself
];
const COMPARE: u32 = FLASH + 6;
const BRANCH: u32 = FLASH + 8;
const END: u32 = FLASH + 12;

fn set_up() -> (Cpu, Program, Memory) {
    let bytes: Vec<u8> = LOOP.iter().flat_map(|half| half.to_le_bytes()).collect();
    let mut cpu = Cpu::new();
    cpu.set_register(15, FLASH);
    (cpu, Program::new(FLASH, &bytes), Memory::new())
}

#[test]
fn a_compare_and_its_branch_are_two_instructions_when_stopped_between() {
    let (mut stepped, program, mut memory) = set_up();
    let mut between = 0;
    while stepped.pc() != END {
        assert_eq!(
            stepped.step(&program, &mut memory, &mut MemoryOnly::default(), u64::MAX),
            Stop::Until
        );
        between += u32::from(stepped.pc() == BRANCH);
        let (mut run, ..) = set_up();
        assert_eq!(
            run.run(&program, &mut memory, &mut MemoryOnly::default(), stepped.cycles()),
            Stop::Until
        );
        assert_eq!(run.r, stepped.r);
        assert_eq!(run.flags, stepped.flags);
        assert_eq!((run.cycles, run.instructions), (stepped.cycles, stepped.instructions));
    }
    assert_eq!((between, stepped.register(1)), (3, 3));
}

#[test]
fn a_trap_on_either_of_them_is_come_to_in_each_round() {
    for address in [COMPARE, BRANCH] {
        let (mut cpu, mut program, mut memory) = set_up();
        assert!(program.trap(address));
        for round in 1..=3 {
            assert_eq!(
                cpu.run(&program, &mut memory, &mut MemoryOnly::default(), 1000),
                Stop::Trap
            );
            assert_eq!((cpu.pc(), cpu.register(1)), (address, round));
            assert_eq!(
                cpu.step(&program, &mut memory, &mut MemoryOnly::default(), 1000),
                Stop::Until
            );
        }
        program.untrap(address);
        assert_eq!(cpu.run(&program, &mut memory, &mut MemoryOnly::default(), 1000), Stop::Until);
        assert_eq!(cpu.pc(), END);
    }
}
