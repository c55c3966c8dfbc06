//! Entry, return, and what becomes of faults, on a core without instructions.

mod faults;
mod frames;

use super::priorities::{bit, number};
use super::*;
use crate::bus::Width;
use crate::memory::map::{FLASH, RAM};

/// The address of the handlers: that of exception n is `HANDLERS + 16 * n`.
const HANDLERS: u32 = FLASH + 0x1000;
const MAIN_STACK: u32 = RAM + 0x8000;
const PROCESS_STACK: u32 = RAM + 0x4000;

fn handler(exception: u16) -> u32 {
    HANDLERS + 16 * u32::from(exception)
}

/// A core in thread mode, all of its faults and interrupts enabled, with a table of vectors.
fn machine() -> (Cpu, Memory) {
    let mut memory = Memory::new();
    let vectors = (0..98_u16).flat_map(|exception| {
        let word = if exception == 0 { MAIN_STACK } else { handler(exception) | 1 };
        word.to_le_bytes()
    });
    assert!(memory.program(FLASH, &vectors.collect::<Vec<u8>>()));
    let mut cpu = Cpu::new();
    cpu.reset_core(&memory, FLASH);
    cpu.other_sp = PROCESS_STACK;
    store(&mut cpu, 0xE000_ED88, 0x00F0_0000);
    store(&mut cpu, 0xE000_ED24, 7 << 16);
    for register in 0..3 {
        store(&mut cpu, 0xE000_E100 + 4 * register, !0);
    }
    cpu.cycles = 0;
    (cpu, memory)
}

fn store(cpu: &mut Cpu, address: u32, value: u32) {
    assert_eq!(cpu.system_store(address, Width::Word, value), Ok(()));
}

fn load(cpu: &mut Cpu, address: u32) -> u32 {
    cpu.system_load(address, Width::Word).expect("it is modelled")
}

fn word(memory: &Memory, address: u32) -> u32 {
    memory.load(address, Width::Word).expect("there is memory")
}

/// Everything that an exception must leave as it was.
fn context(cpu: &Cpu) -> ([u32; 16], u32, u32, u8, crate::cpu::Special) {
    let special = cpu.special;
    (cpu.r, cpu.other_sp, cpu.xpsr(), cpu.it, special)
}

#[test]
fn a_handler_runs_at_its_vector_with_nothing_of_what_was_before() {
    let (mut cpu, mut memory) = machine();
    cpu.it = 0x45;
    cpu.exclusive = Some(RAM);
    cpu.pend(bit(20));
    assert!(cpu.exceptions.wants_in());
    assert_eq!(cpu.deadline, 0);
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.r[15], handler(20));
    assert_eq!(cpu.special.ipsr, 20);
    assert_eq!(cpu.it, 0);
    assert_eq!(cpu.exclusive, None);
    assert!(cpu.event);
    assert_eq!(cpu.cycles, 12);
    assert!(!cpu.exceptions.wants_in());
}

#[test]
fn what_waits_is_chained_without_the_stack_being_touched() {
    let (mut cpu, mut memory) = machine();
    cpu.pend(bit(20) | bit(21));
    cpu.take_exception(&mut memory);
    let (sp, lr) = (cpu.r[13], cpu.r[14]);
    cpu.cycles = 0;
    cpu.exception_return(&mut memory, lr);
    assert_eq!((cpu.special.ipsr, cpu.r[15]), (21, handler(21)));
    assert_eq!((cpu.r[13], cpu.r[14], cpu.cycles), (sp, lr, 6));
    cpu.exception_return(&mut memory, lr);
    assert_eq!((cpu.special.ipsr, cpu.r[13]), (0, MAIN_STACK));
}

#[test]
fn the_higher_of_two_interrupts_the_lower() {
    let (mut cpu, mut memory) = machine();
    cpu.exceptions.priorities.set_priority(21, 0x40);
    cpu.exceptions.priorities.set_priority(20, 0x80);
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    cpu.pend(bit(21));
    assert!(cpu.exceptions.wants_in());
    cpu.take_exception(&mut memory);
    assert_eq!((cpu.special.ipsr, cpu.r[14]), (21, 0xFFFF_FFF1));
    cpu.exception_return(&mut memory, 0xFFFF_FFF1);
    assert_eq!((cpu.special.ipsr, cpu.r[15]), (20, handler(20)));
}

#[test]
fn an_svc_that_may_not_come_in_is_a_hard_fault_at_itself() {
    let (mut cpu, mut memory) = machine();
    cpu.r[15] = FLASH + 0x402;
    cpu.svc(&mut memory, 7);
    assert_eq!(cpu.exceptions.priorities.best(), Some(number::SV_CALL));
    cpu.exceptions.priorities.unpend(bit(number::SV_CALL));
    cpu.cps(false, true, false);
    cpu.svc(&mut memory, 7);
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.special.ipsr, number::HARD_FAULT);
    assert_eq!(word(&memory, cpu.r[13] + 0x18), FLASH + 0x400);
}

#[test]
fn a_line_wakes_wfi_though_primask_is_set() {
    let (mut cpu, _memory) = machine();
    cpu.cps(false, true, false);
    assert!(!cpu.wakes_wfi());
    cpu.set_lines(1 << 5);
    assert!(cpu.wakes_wfi());
    assert!(!cpu.exceptions.wants_in());
    cpu.msr(17, 0, 0x10);
    assert!(cpu.wakes_wfi(), "its priority is zero, above what BASEPRI masks");
    cpu.exceptions.priorities.set_priority(21, 0x10);
    assert!(!cpu.wakes_wfi());
}

#[test]
fn a_disabled_interrupt_is_an_event_where_sevonpend_says_so() {
    let (mut cpu, _memory) = machine();
    store(&mut cpu, 0xE000_E180, !0);
    cpu.set_lines(1);
    assert!(!cpu.event);
    cpu.set_lines(0);
    store(&mut cpu, 0xE000_E280, 1);
    store(&mut cpu, 0xE000_ED10, 1 << 4);
    cpu.set_lines(1);
    assert!(cpu.event);
    cpu.event = false;
    cpu.set_lines(3);
    assert!(cpu.event);
}

#[test]
fn it_sleeps_on_exit_from_the_last_handler_only() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_ED10, 1 << 1);
    cpu.pend(bit(20) | bit(21));
    cpu.take_exception(&mut memory);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.asleep, None);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.asleep, Some(Sleep::Interrupt));
}

#[test]
fn a_core_without_a_vector_table_locks_up() {
    let (mut cpu, memory) = machine();
    cpu.reset_core(&memory, 0x6000_0000);
    assert!(cpu.exceptions.locked_up());
}

#[test]
fn a_reset_forgets_everything_but_time_and_faults() {
    let (mut cpu, mut memory) = machine();
    cpu.fault(&mut memory, Fault::Undefined);
    cpu.take_exception(&mut memory);
    cpu.cycles = 77;
    cpu.reset_core(&memory, FLASH);
    assert_eq!((cpu.r[13], cpu.r[15], cpu.thumb), (MAIN_STACK, handler(1), true));
    assert_eq!((cpu.special, cpu.cycles), (crate::cpu::Special::default(), 77));
    assert_eq!(load(&mut cpu, 0xE000_ED28), 0);
    assert_eq!(load(&mut cpu, 0xE000_ED08), 0);
    assert_eq!(cpu.faults().len(), 1);
}
