//! An exception's frame on the stack, and that a return takes all of it back.

use proptest::prelude::*;

use super::*;
use crate::cpu::fp::Fpscr;

#[test]
fn a_basic_frame_word_by_word() {
    let (mut cpu, mut memory) = machine();
    cpu.r = std::array::from_fn(|n| 0x1111_1111 * n as u32);
    cpu.r[13] = MAIN_STACK;
    cpu.r[15] = FLASH + 0x500;
    cpu.it = 0xA5;
    cpu.set_apsr(0xF80A_0000);
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    let frame: Vec<u32> = (0..8).map(|n| word(&memory, MAIN_STACK - 32 + 4 * n)).collect();
    let expected = [
        0,
        0x1111_1111,
        0x2222_2222,
        0x3333_3333,
        0xCCCC_CCCC,
        0xEEEE_EEEE,
        FLASH + 0x500,
        // NZCVQ, IT[1:0] and T, GE, IT[7:2], no padding, thread mode.
        0xFB0A_A400,
    ];
    assert_eq!(frame, expected);
    assert_eq!((cpu.r[13], cpu.r[14]), (MAIN_STACK - 32, 0xFFFF_FFF9));
}

#[test]
fn a_stack_that_is_four_off_is_padded_and_the_frame_says_so() {
    let (mut cpu, mut memory) = machine();
    cpu.r[13] = MAIN_STACK - 4;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.r[13], MAIN_STACK - 40);
    assert_eq!(word(&memory, cpu.r[13] + 0x1C) & 0x200, 0x200);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.r[13], MAIN_STACK - 4);
}

#[test]
fn without_stkalign_nothing_is_padded() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_ED14, 0);
    cpu.r[13] = MAIN_STACK - 4;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.r[13], MAIN_STACK - 36);
    cpu.exception_return(&mut memory, 0xFFFF_FFF9);
    assert_eq!(cpu.r[13], MAIN_STACK - 4);
}

#[test]
fn room_is_left_for_floating_point_state_and_filled_when_a_handler_needs_the_registers() {
    let (mut cpu, mut memory) = machine();
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.fpu.s = std::array::from_fn(|n| 0x4000_0000 + n as u32);
    cpu.fpu.fpscr = Fpscr::from_bits(0x9000_0010);
    store(&mut cpu, 0xE000_EF3C, 0x0300_0000);
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    let frame = MAIN_STACK - 0x68;
    assert_eq!((cpu.r[13], cpu.r[14]), (frame, 0xFFFF_FFE9));
    assert_eq!(load(&mut cpu, 0xE000_EF38), frame + 0x20);
    assert_eq!(
        load(&mut cpu, 0xE000_EF34),
        // ASPEN, LSPEN, BFRDY, MMRDY, HFRDY, THREAD, LSPACT.
        0xC000_0079,
        "nothing was active, so any enabled fault could have come in"
    );
    assert!(!cpu.fpu.ready && !cpu.special.fpca);
    assert_eq!(word(&memory, frame + 0x20), 0xA5A5_A5A5, "nothing is stored yet");
    assert_eq!(cpu.cycles, 12);
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    for n in 0..16 {
        assert_eq!(word(&memory, frame + 0x20 + 4 * n), 0x4000_0000 + n);
    }
    assert_eq!(word(&memory, frame + 0x60), 0x9000_0010);
    assert_eq!(cpu.fpu.fpscr.bits() & Fpscr::CONTROL, 0x0300_0000, "FPDSCR's");
    assert!(cpu.fpu.ready && cpu.special.fpca);
    assert_eq!(cpu.cycles, 12 + 17);
    cpu.fpu.s[3] = 1;
    cpu.exception_return(&mut memory, 0xFFFF_FFE9);
    assert_eq!((cpu.fpu.s[3], cpu.fpu.fpscr.bits()), (0x4000_0003, 0x9000_0010));
    assert_eq!((cpu.r[13], cpu.special.fpca), (MAIN_STACK, true));
    assert_eq!(cpu.cycles, 12 + 17 + 10 + 17);
}

#[test]
fn what_no_handler_needed_is_never_saved_and_never_loaded() {
    let (mut cpu, mut memory) = machine();
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.fpu.s[3] = 7;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    cpu.exception_return(&mut memory, 0xFFFF_FFE9);
    assert_eq!((cpu.fpu.s[3], cpu.fpu.ready, cpu.cycles), (7, true, 22));
    assert_eq!(load(&mut cpu, 0xE000_EF34) & 1, 0);
}

#[test]
fn a_nested_handler_saves_the_state_of_the_thread_below() {
    let (mut cpu, mut memory) = machine();
    cpu.exceptions.priorities.set_priority(20, 0x80);
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.fpu.s[0] = 7;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    cpu.pend(bit(21));
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.r[14], 0xFFFF_FFF1, "the lower handler has no such state");
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.fpu.s[0] = 8;
    cpu.exception_return(&mut memory, 0xFFFF_FFF1);
    assert!(!cpu.special.fpca && !cpu.fpu.ready);
    cpu.exception_return(&mut memory, 0xFFFF_FFE9);
    assert_eq!((cpu.fpu.s[0], cpu.fpu.ready), (7, true));
}

#[test]
fn without_lazy_saving_the_state_is_saved_at_once() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_EF34, 1 << 31);
    cpu.prepare_fp(&mut memory).expect("it is enabled");
    cpu.fpu.s[15] = 7;
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(word(&memory, cpu.r[13] + 0x20 + 60), 7);
    assert_eq!(cpu.cycles, 29);
    assert_eq!(load(&mut cpu, 0xE000_EF34), 1 << 31);
}

#[test]
fn without_aspen_the_unit_marks_no_context() {
    let (mut cpu, mut memory) = machine();
    store(&mut cpu, 0xE000_EF34, 0);
    assert!(cpu.fpu.ready);
    cpu.pend(bit(20));
    cpu.take_exception(&mut memory);
    assert_eq!(cpu.r[14], 0xFFFF_FFF9);
    assert!(cpu.fpu.ready);
}

/// The state of a program.
#[derive(Clone, Debug)]
struct Doing {
    registers: [u32; 16],
    apsr: u32,
    it: u8,
    float: bool,
    s: [u32; 32],
    process: bool,
    unprivileged: bool,
    lazy: bool,
    handler_uses_float: bool,
    depth: usize,
}

prop_compose! {
    fn doing()(
        registers in any::<[u32; 16]>(),
        apsr in any::<u32>(),
        it in any::<u8>(),
        s in any::<[u32; 32]>(),
        flags in any::<[bool; 5]>(),
        depth in 1_usize..4,
    ) -> Doing {
        let [float, process, unprivileged, lazy, handler_uses_float] = flags;
        let it = if it & 0xF == 0 { 0 } else { it };
        Doing {
            registers, apsr, it, float, s, process, unprivileged, lazy, handler_uses_float, depth,
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_return_restores_everything(doing in doing()) {
        let (mut cpu, mut memory) = machine();
        if !doing.lazy {
            store(&mut cpu, 0xE000_EF34, 1 << 31);
        }
        cpu.r = doing.registers;
        cpu.r[15] &= !1;
        cpu.r[13] = MAIN_STACK - (doing.registers[13] & 0xFC);
        cpu.set_apsr(doing.apsr);
        cpu.it = doing.it;
        cpu.fpu.s = doing.s;
        if doing.float {
            cpu.prepare_fp(&mut memory).expect("it is enabled");
        }
        let control = u32::from(doing.unprivileged)
            | u32::from(doing.process) << 1
            | u32::from(doing.float) << 2;
        cpu.msr(20, 0, control);
        let (before, s) = (context(&cpu), cpu.fpu.s);
        let mut returns = Vec::new();
        for level in 0..doing.depth {
            let exception = 30 - level as u16;
            cpu.exceptions.priorities.set_priority(exception, 0xF0 - 0x10 * level as u8);
            cpu.pend(bit(exception));
            prop_assert!(cpu.exceptions.wants_in());
            cpu.take_exception(&mut memory);
            prop_assert_eq!(cpu.special.ipsr, exception);
            returns.push(cpu.r[14]);
            cpu.r[..4].fill(0xDEAD_BEEF);
            cpu.r[12] = 0xDEAD_BEEF;
            cpu.set_apsr(0);
            if doing.handler_uses_float {
                cpu.prepare_fp(&mut memory).expect("handlers are privileged");
                cpu.fpu.s[..16].fill(0xDEAD_BEEF);
            }
        }
        for exc_return in returns.into_iter().rev() {
            cpu.exception_return(&mut memory, exc_return);
        }
        prop_assert_eq!(context(&cpu), before);
        prop_assert_eq!(cpu.exceptions.priorities.active(), 0);
        if doing.float {
            prop_assert_eq!(cpu.fpu.s, s);
        }
        prop_assert!(cpu.faults().is_empty());
    }
}
