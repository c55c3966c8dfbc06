//! Interrupts and exceptions, by the ARMv6-M Architecture Reference Manual, B1.5.

use nrf51_chip::core::{Cause, Core};

use crate::flat::{Flat, RAM};

/// The programs' addresses: the main program counts in R4, and a handler stores the number of the
/// exception behind R6 and returns.
const MAIN: u32 = 0x200;
const HANDLER: u32 = 0x300;
const SLOW: u32 = 0x340;

/// A core with interrupts 1 to 3 enabled, whose handlers log; that of interrupt 1 is slow.
fn machine() -> (Core, Flat) {
    let vectors = [
        (0, RAM + 0x800),
        (4, MAIN | 1),
        (4 * 11, HANDLER | 1),
        (4 * 17, SLOW | 1),
        (4 * 18, HANDLER | 1),
        (4 * 19, HANDLER | 1),
    ];
    // ADDS r4, #1; B to it. MRS r0, IPSR; STRB r0, [r6]; ADDS r6, #1; BX lr. The slow handler has
    // eight NOPs before its last two instructions.
    let main: &[u16] = &[0x3401, 0xE7FD];
    let handler: &[u16] = &[0xF3EF, 0x8005, 0x7030, 0x3601, 0x4770];
    let slow: &[u16] = &[
        0xF3EF, 0x8005, 0x7030, 0xBF00, 0xBF00, 0xBF00, 0xBF00, 0xBF00, 0xBF00, 0xBF00, 0xBF00,
        0x3601, 0x4770,
    ];
    let mut memory = Flat::with(&vectors, &[(MAIN, main), (HANDLER, handler), (SLOW, slow)]);
    let mut core = Core::new(&mut memory, 0).unwrap();
    core.set_register(6, RAM);
    (core, memory)
}

/// Writes a register of the core, by a program of two instructions.
fn set(core: &mut Core, memory: &mut Flat, address: u32, value: u32) {
    let saved = [0, 1, 15].map(|it| core.register(it));
    memory.code[0x3F0] = 0x08;
    memory.code[0x3F1] = 0x60;
    for (register, value) in [(0, value), (1, address), (15, 0x3F0)] {
        core.set_register(register, value);
    }
    core.step(memory).unwrap();
    for (register, value) in [0, 1, 15].into_iter().zip(saved) {
        core.set_register(register, value);
    }
}

const ISER: u32 = 0xE000_E100;
const IPR0: u32 = 0xE000_E400;

/// The exceptions in the order in which their handlers ended or wrote, after so many steps.
fn log(core: &mut Core, memory: &mut Flat, steps: usize) -> Vec<u8> {
    for _ in 0..steps {
        core.step(memory).unwrap();
    }
    let count = core.register(6) - RAM;
    memory.ram[..count as usize].to_vec()
}

#[test]
fn an_interrupt_leaves_no_trace_but_its_own() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 1 << 2);
    core.set_register(0, 0x1234);
    core.step(&mut memory).unwrap();
    let before: Vec<_> = (0..16).filter(|it| *it != 6).map(|it| core.register(it)).collect();
    core.set_lines(1 << 2);
    assert_eq!(core.step(&mut memory), Ok(16));
    assert_eq!((core.exception(), core.register(14)), (18, 0xFFFF_FFF9));
    core.set_lines(0);
    assert_eq!(log(&mut core, &mut memory, 4), [18]);
    let after: Vec<_> = (0..16).filter(|it| *it != 6).map(|it| core.register(it)).collect();
    assert_eq!(before, after);
    assert_eq!(core.exception(), 0);
}

#[test]
fn a_line_that_stays_high_interrupts_again() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 1 << 2);
    core.set_lines(1 << 2);
    assert_eq!(log(&mut core, &mut memory, 15), [18, 18, 18]);
}

#[test]
fn of_equal_priority_the_lower_number_is_first_and_neither_interrupts_the_other() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 0b1110);
    core.set_lines(0b1000);
    core.step(&mut memory).unwrap();
    core.set_lines(0b0110);
    core.set_lines(0);
    assert_eq!(log(&mut core, &mut memory, 4), [19]);
    assert_eq!(log(&mut core, &mut memory, 14), [19, 17]);
    assert_eq!(log(&mut core, &mut memory, 5), [19, 17, 18]);
}

#[test]
fn a_higher_priority_interrupts_a_lower_one() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 0b1110);
    // Interrupt 1 has priority 3, interrupt 2 priority 1, interrupt 3 priority 3.
    set(&mut core, &mut memory, IPR0, 0xC040_C000);
    core.set_lines(1 << 1);
    core.step(&mut memory).unwrap();
    core.set_lines(1 << 2 | 1 << 3);
    core.set_lines(0);
    core.step(&mut memory).unwrap();
    assert_eq!((core.exception(), core.register(14)), (18, 0xFFFF_FFF1));
    assert_eq!(log(&mut core, &mut memory, 22), [18, 17, 19]);
}

#[test]
fn a_masked_interrupt_waits() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 1 << 2);
    // CPSID i, ADDS r4, CPSIE i.
    memory.code[0x380..0x386].copy_from_slice(&[0x72, 0xB6, 0x01, 0x34, 0x62, 0xB6]);
    core.set_register(15, 0x380);
    core.step(&mut memory).unwrap();
    core.set_lines(1 << 2);
    core.step(&mut memory).unwrap();
    core.step(&mut memory).unwrap();
    assert_eq!(core.exception(), 0);
    core.step(&mut memory).unwrap();
    assert_eq!(core.exception(), 18);
}

#[test]
fn a_supervisor_call_is_taken_before_the_next_instruction_and_faults_where_it_is_masked() {
    let (mut core, mut memory) = machine();
    memory.code[0x380..0x384].copy_from_slice(&[0x05, 0xDF, 0x01, 0x34]);
    core.set_register(15, 0x380);
    assert_eq!(log(&mut core, &mut memory, 6), [11]);
    assert_eq!(core.register(15), 0x382);
    memory.code[0x380..0x384].copy_from_slice(&[0x72, 0xB6, 0x05, 0xDF]);
    core.set_register(15, 0x380);
    core.step(&mut memory).unwrap();
    assert_eq!(core.step(&mut memory).unwrap_err().cause, Cause::MaskedCall);
}

#[test]
fn a_program_on_the_process_stack_comes_back_to_it() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, ISER, 1 << 2);
    // MSR PSP, r0; MSR CONTROL, r1; then the main program.
    let code = [0x80, 0xF3, 0x09, 0x88, 0x81, 0xF3, 0x14, 0x88];
    memory.code[0x380..0x388].copy_from_slice(&code);
    for (register, value) in [(0, RAM + 0x400), (1, 2), (15, 0x380)] {
        core.set_register(register, value);
    }
    core.step(&mut memory).unwrap();
    core.step(&mut memory).unwrap();
    assert_eq!(core.register(13), RAM + 0x400);
    core.set_register(15, MAIN);
    core.set_lines(1 << 2);
    core.step(&mut memory).unwrap();
    assert_eq!((core.register(13), core.register(14)), (RAM + 0x800, 0xFFFF_FFFD));
    core.set_lines(0);
    assert_eq!(log(&mut core, &mut memory, 4), [18]);
    assert_eq!(core.register(13), RAM + 0x400);
}

#[test]
fn a_request_for_a_reset_needs_its_key() {
    let (mut core, mut memory) = machine();
    set(&mut core, &mut memory, 0xE000_ED0C, 4);
    assert!(!core.take_reset());
    set(&mut core, &mut memory, 0xE000_ED0C, 0x05FA_0004);
    assert!(core.take_reset());
    assert!(!core.take_reset());
}
