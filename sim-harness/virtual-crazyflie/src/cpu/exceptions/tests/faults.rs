//! Faults are escalated, reported and locked up as the manual says.

use super::*;

/// The exception that is taken for a fault.
fn taken(cpu: &mut Cpu, memory: &mut Memory, fault: Fault) -> u16 {
    cpu.r[15] = FLASH + 0x400;
    cpu.fault(memory, fault);
    cpu.take_exception(memory);
    assert_eq!(word(memory, cpu.r[13] + 0x18), FLASH + 0x400, "the instruction itself");
    cpu.special.ipsr
}

const FAULTS: [Fault; 12] = [
    Fault::Undefined,
    Fault::InvalidState,
    Fault::InvalidReturn { exc_return: 0xFFFF_FFF3 },
    Fault::NoCoprocessor,
    Fault::Unaligned { address: 0x2000_0001 },
    Fault::DivideByZero,
    Fault::ExecuteNever { address: 0x4000_0000 },
    Fault::FetchBus { address: 0x6000_0000 },
    Fault::DataBus { address: 0x6000_0000 },
    Fault::VectorTable { exception: 20 },
    Fault::Supervisor { number: 9 },
    Fault::Breakpoint,
];

#[test]
fn each_fault_in_words_with_its_exception_enabled_and_not() {
    let mut text = String::new();
    for fault in FAULTS {
        for enabled in [true, false] {
            if enabled && matches!(fault, Fault::Supervisor { .. }) {
                // That would be no fault.
                continue;
            }
            let (mut cpu, mut memory) = machine();
            if enabled {
                store(&mut cpu, 0xE000_EDFC, 1 << 16);
            } else {
                store(&mut cpu, 0xE000_ED24, 0);
                cpu.cps(false, true, false);
            }
            let exception = taken(&mut cpu, &mut memory, fault);
            text += &format!("exception {exception}: {}\n", cpu.faults()[0]);
        }
    }
    assert_eq!(text, include_str!("faults.txt"));
}

#[test]
fn the_lock_up_is_the_end_of_a_fault_in_hard_fault() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_ED24, 0);
    assert_eq!(taken(&mut cpu, &mut memory, Fault::Undefined), number::HARD_FAULT);
    assert!(!cpu.exceptions.locked_up());
    cpu.fault(&mut memory, Fault::DataBus { address: 0 });
    assert!(cpu.exceptions.locked_up());
    assert_eq!(cpu.faults()[1].exception, None);
    assert_eq!(cpu.fault_count(), 2);
}

#[test]
fn faultmask_leaves_a_fault_nowhere_to_go() {
    let (mut cpu, mut memory) = machine();
    cpu.cps(false, false, true);
    cpu.fault(&mut memory, Fault::Undefined);
    assert!(cpu.exceptions.locked_up());
}

#[test]
fn a_fault_in_a_handler_of_its_own_priority_escalates() {
    let (mut cpu, mut memory) = machine();
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(taken(&mut cpu, &mut memory, Fault::DivideByZero), number::HARD_FAULT);
    assert_eq!(cpu.faults()[0].hfsr, 1 << 30);
}

#[test]
fn an_interrupt_that_came_with_a_fault_goes_first_if_it_is_higher() {
    let (mut cpu, mut memory) = machine();
    cpu.exceptions.priorities.set_priority(number::USAGE_FAULT, 0x80);
    cpu.pend(bit(20));
    assert_eq!(taken(&mut cpu, &mut memory, Fault::Undefined), 20);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.special.ipsr, number::USAGE_FAULT);
    assert_eq!(word(&memory, cpu.r[13] + 0x18), FLASH + 0x400);
}

#[test]
fn a_stack_without_memory_is_a_bus_fault_that_goes_first_if_it_is_higher() {
    for (priority, first) in [(0x10, number::BUS_FAULT), (0x30, 20)] {
        let (mut cpu, mut memory) = machine();
        cpu.exceptions.priorities.set_priority(number::BUS_FAULT, priority);
        cpu.exceptions.priorities.set_priority(20, 0x20);
        cpu.select_stack(true);
        cpu.r[13] = 0x1000_0010;
        cpu.pend(bit(20));
        cpu.take_exception(&mut memory);
        assert_eq!(cpu.special.ipsr, first);
        assert_eq!(load(&mut cpu, 0xE000_ED28), 1 << 12);
        assert_eq!(cpu.exceptions.priorities.pending().count_ones(), 1, "the other waits");
        assert_eq!((cpu.r[13], cpu.other_sp), (MAIN_STACK, 0x1000_0010 - 32));
        assert_eq!(cpu.r[14], 0xFFFF_FFFD);
    }
}

#[test]
fn a_main_stack_without_memory_faults_for_every_entry() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_ED24, 0);
    cpu.r[13] = RAM + 0x10;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.special.ipsr, number::HARD_FAULT);
    assert_eq!(cpu.faults()[0].fault, Fault::Stacking);
    assert_eq!(cpu.faults()[0].exception, Some(number::HARD_FAULT));
}

#[test]
fn a_vector_that_cannot_be_read_is_a_hard_fault_and_a_lockup_if_that_has_none() {
    let (mut cpu, mut memory) = machine();
    cpu.pend(bit(20));
    // At the end of RAM there is room for the vectors of the core's own exceptions and no more.
    let table = RAM + 0x2_0000 - 64;
    cpu.control.set_vtor(table);
    memory.store(table + 12, Width::Word, handler(3) | 1);
    cpu.take_exception(&mut memory);
    assert_eq!((cpu.special.ipsr, cpu.r[15]), (number::HARD_FAULT, handler(3)));
    assert_eq!(load(&mut cpu, 0xE000_ED2C), 1 << 1);
    assert_eq!(cpu.exceptions.priorities.pending(), bit(20));

    let (mut cpu, mut memory) = machine();
    cpu.control.set_vtor(0x6000_0000);
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert!(cpu.exceptions.locked_up());
}

#[test]
fn an_exc_return_that_does_not_fit_is_a_usage_fault_that_keeps_the_frame() {
    // With one exception active, and with two.
    let fits = |exc_return, depth| match exc_return & 0x1F {
        0x11 => depth == 2,
        0x19 => depth == 1,
        _ => false,
    };
    for low in 0..32 {
        for depth in 1..=2 {
            let exc_return = 0xFFFF_FFE0 | low;
            let (mut cpu, mut memory) = machine();
            cpu.exceptions.priorities.set_priority(20, 0x80);
            cpu.exceptions.priorities.set_priority(21, 0x70);
            for exception in [20, 21].into_iter().take(depth) {
                cpu.pend(bit(exception));
                cpu.take_exception(&mut memory);
            }
            if matches!(low, 0x01 | 0x09 | 0x0D | 0x1D) {
                // Other frames and another stack: these may fit too, or not, for what is in them.
                continue;
            }
            let sp = cpu.r[13];
            cpu.exception_return(&mut memory, exc_return);
            if fits(exc_return, depth) {
                assert!(cpu.faults().is_empty(), "{exc_return:#x} {depth}");
                continue;
            }
            assert_eq!(cpu.special.ipsr, number::USAGE_FAULT, "{exc_return:#x} {depth}");
            assert_eq!(load(&mut cpu, 0xE000_ED28), 1 << 18);
            assert_eq!((cpu.r[13], cpu.r[14]), (sp, exc_return));
        }
    }
}

#[test]
fn a_return_of_what_is_not_active_is_a_usage_fault() {
    let (mut cpu, mut memory) = machine();
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    cpu.exceptions.priorities.set_active(bit(20), false);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.special.ipsr, number::USAGE_FAULT);
}

#[test]
fn nonbasethrdena_and_nothing_else_lets_a_nested_handler_return_to_thread_mode() {
    for (ccr, ipsr, faults) in [(0x201, 0, 0), (0x200, number::USAGE_FAULT, 1)] {
        let (mut cpu, mut memory) = machine();
        store(&mut cpu, 0xE000_ED14, ccr);
        cpu.exceptions.priorities.set_priority(20, 0x80);
        for exception in [20, 21] {
            cpu.pend(bit(exception));
            cpu.take_exception(&mut memory);
        }
        // As such a handler would, it makes the frame one of thread mode.
        let at = cpu.r[13] + 0x1C;
        let psr = word(&memory, at);
        memory.store(at, Width::Word, psr & !0x1FF);
        cpu.exception_return(&mut memory, 0xFFFF_FFF9);
        assert_eq!((cpu.special.ipsr, cpu.faults().len()), (ipsr, faults));
        assert_eq!(cpu.exceptions.priorities.active() & bit(20), bit(20));
    }
}

#[test]
fn a_frame_that_cannot_be_read_is_a_bus_fault_on_the_same_stack() {
    let (mut cpu, mut memory) = machine();
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    cpu.other_sp = 0x6000_0000;
    cpu.exception_return(&mut memory, 0xFFFF_FFFD);
    assert_eq!((cpu.special.ipsr, cpu.r[14]), (number::BUS_FAULT, 0xFFFF_FFFD));
    assert_eq!(load(&mut cpu, 0xE000_ED28), 1 << 11);
    assert_eq!(cpu.other_sp, 0x6000_0000);
}

#[test]
fn a_late_save_that_fails_is_a_fault_of_the_context_whose_state_it_was() {
    let (mut cpu, mut memory) = machine();
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    store(&mut cpu, 0xE000_EF38, 0x6000_0000);
    assert_eq!(cpu.prepare_fp(&mut memory), Err(Fault::LazySave));
    cpu.fault(&mut memory, Fault::LazySave);
    assert_eq!(cpu.exceptions.priorities.best(), Some(number::BUS_FAULT));
    assert!(!cpu.exceptions.wants_in(), "the handler has the same priority");
    assert_eq!(cpu.prepare_fp(&mut memory), Ok(()), "the state is lost");
    assert_eq!(load(&mut cpu, 0xE000_ED28), 1 << 13);
}

#[test]
fn the_fpu_is_refused_to_whom_cpacr_refuses_it() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_ED88, 0x0050_0000);
    assert_eq!(cpu.prepare_fp(&mut memory), Ok(()));
    assert!(cpu.fpu.ready);
    cpu.msr(20, 0, 5);
    assert!(!cpu.fpu.ready);
    assert_eq!(cpu.prepare_fp(&mut memory), Err(Fault::NoCoprocessor));
}

#[test]
fn a_faulting_program_fills_no_memory_with_reports() {
    let (mut cpu, mut memory) = machine();
    for _ in 0..1000 {
        cpu.fault(&mut memory, Fault::DivideByZero);
        cpu.take_exception(&mut memory);
        cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    }
    assert_eq!((cpu.faults().len(), cpu.fault_count()), (16, 1000));
}
