//! Effects of encodings, and of IT blocks.

use super::*;
use crate::cpu::is_wide;

/// The instructions of `halves` from `address` on.
fn decoded(address: u32, halves: &[u16]) -> Vec<Instruction> {
    let half = |at: u32| halves.get((at.checked_sub(address)? / 2) as usize).copied();
    let (mut decoder, mut found, mut at) = (Decoder::default(), Vec::new(), address);
    while let Some(first) = half(at) {
        let size = if is_wide(first) { 4 } else { 2 };
        let around = Surroundings { half: &half, next: at + size };
        found.push(decoder.next(at, (first, half(at + 2).unwrap_or(0)), &around));
        at += size;
    }
    found
}

fn effect_of(address: u32, first: u16, second: u16) -> Effect {
    let around = Surroundings { half: &|_| None, next: address + 4 };
    Decoder::default().next(address, (first, second), &around).effect
}

#[test]
fn branches_are_read_as_a_disassembler_reads_them() {
    use Effect::{Call, Jump};
    // From llvm-objdump, of a firmware.
    for (at, first, second, is) in [
        (0x0800_41BE, 0xE7FA, 0, Jump(0x0800_41B6)),
        (0x0800_5FF2, 0xE008, 0, Jump(0x0800_6006)),
        (0x0800_433A, 0xD1F1, 0, Jump(0x0800_4320)),
        (0x0800_6138, 0xD106, 0, Jump(0x0800_6148)),
        (0x0800_53A6, 0xF000, 0x815B, Jump(0x0800_5660)),
        (0x0800_5888, 0xF040, 0x80A1, Jump(0x0800_59CE)),
        (0x0800_E1A2, 0xF200, 0x8113, Jump(0x0800_E3CC)),
        (0x0800_4272, 0xF020, 0xBD42, Jump(0x0802_4CFA)),
        (0x0800_B25C, 0xF7FF, 0xBA48, Jump(0x0800_A6F0)),
        (0x0800_42DE, 0xF018, 0xFFF2, Call(0x0801_D2C6)),
        (0x0800_40AA, 0xF7FF, 0xFFEF, Call(0x0800_408C)),
        (0x0800_4000, 0xDE00, 0, Effect::Fault),
        (0x0800_4000, 0xDF00, 0, Effect::Clobbers(0)),
        (0x0800_4000, 0xF3EF, 0x8005, Effect::Clobbers(1)),
        (0x0800_4000, 0xF3BF, 0x8F4F, Effect::Clobbers(0)),
    ] {
        assert_eq!(effect_of(at, first, second), is, "{first:04x} {second:04x}");
    }
}

#[test]
fn every_way_of_moving_the_stack_pointer_is_described() {
    let stack = |by, loaded| Effect::Stack { by, loaded };
    let sp = |value| Effect::Set { register: SP, value };
    for (first, second, text, is) in [
        (0xB511, 0, "push {r0, r4, lr}", stack(-12, 0)),
        (0xBD11, 0, "pop {r0, r4, pc}", stack(12, 0x8011)),
        (0xE92D, 0x4110, "push.w {r4, r8, lr}", stack(-12, 0)),
        (0xE8BD, 0x8110, "pop.w {r4, r8, pc}", stack(12, 0x8110)),
        (0xF84D, 0x9D04, "str r9, [sp, #-4]!", stack(-4, 0)),
        (0xF85D, 0x9B04, "ldr r9, [sp], #4", stack(4, 1 << 9)),
        (0xF85D, 0xFB04, "ldr pc, [sp], #4", stack(4, 1 << 15)),
        (0xE96D, 0x4E04, "strd r4, lr, [sp, #-16]!", stack(-16, 0)),
        (0xE8FD, 0x4E04, "ldrd r4, lr, [sp], #16", stack(16, 0x4010)),
        (0xED2D, 0x8A04, "vpush {s16, s17, s18, s19}", stack(-16, 0)),
        (0xECBD, 0x8B10, "vpop {d8-d15}", stack(64, 0)),
        (0xB0FF, 0, "sub sp, #508", sp(Value::Offset(SP, 508_u32.wrapping_neg()))),
        (0xF6AD, 0x7DFF, "subw sp, sp, #4095", sp(Value::Offset(SP, 4095_u32.wrapping_neg()))),
        (0xF50D, 0x7D3F, "add.w sp, sp, #764", sp(Value::Offset(SP, 764))),
        (0xEBAD, 0x0D03, "sub.w sp, sp, r3", sp(Value::Difference(SP, 3))),
        (0x449D, 0, "add sp, r3", sp(Value::Sum(SP, 3))),
        (0x468D, 0, "mov sp, r1", sp(Value::Offset(1, 0))),
        (0xF381, 0x8808, "msr msp, r1", Effect::SetMainStack(1)),
    ] {
        assert_eq!(effect_of(0x0800_1000, first, second), is, "{text}");
    }
}

#[test]
fn what_cannot_be_followed_is_opaque() {
    for (first, second, text) in [
        (0xEB0D, 0x0D83, "add.w sp, sp, r3, lsl #2"),
        (0xF8D1, 0xD008, "ldr.w sp, [r1, #8]"),
        (0xF8D1, 0xF008, "ldr.w pc, [r1, #8]"),
        (0xE891, 0x8004, "ldm.w r1, {r2, pc}"),
        (0xF383, 0x8814, "msr control, r3"),
        (0xF381, 0x8809, "msr psp, r1"),
        (0xE8D2, 0xF001, "tbb [r2, r1]"),
        (0x448F, 0, "add pc, r1"),
    ] {
        let effect = effect_of(0x0800_1000, first, second);
        assert!(matches!(effect, Effect::Opaque(_)), "{text}: {effect:?}");
    }
}

#[test]
fn values_that_can_be_known_are_described() {
    let set = |register, value| Effect::Set { register, value };
    for (first, second, text, is) in [
        (0x4669, 0, "mov r1, sp", set(1, Value::Offset(SP, 0))),
        (0xA9FF, 0, "add r1, sp, #1020", set(1, Value::Offset(SP, 1020))),
        (0x24FF, 0, "movs r4, #255", set(4, Value::Constant(255))),
        (0xF6CA, 0x31CD, "movt r1, #0xabcd", set(1, Value::UpperHalf(1, 0xABCD_0000))),
        (0xF36F, 0x0103, "bfc r1, #0, #4", set(1, Value::Masked(1, !0xF))),
        (0xF024, 0x041F, "bic r4, r4, #31", set(4, Value::Masked(4, !0x1F))),
        (
            0xE8C3,
            0x2F41,
            "strexb r1, r2, [r3]",
            Effect::StoreExclusive { base: 3, status: 1, byte: true },
        ),
        (0x4770, 0, "bx lr", Effect::JumpRegister(14)),
        (0x47E0, 0, "blx r12", Effect::CallRegister(12)),
        (0xC90C, 0, "ldm r1!, {r2, r3}", Effect::Clobbers(0b1110)),
        (0xC10C, 0, "stm r1!, {r2, r3}", Effect::Clobbers(0b0010)),
        (0x6011, 0, "str r1, [r2]", Effect::Clobbers(0)),
        (0xFB81, 0x2304, "smull r2, r3, r1, r4", Effect::Clobbers(0b1100)),
        (0xEE7F, 0xFA8F, "vadd.f32 s31, s31, s30", Effect::Clobbers(0)),
        (0xEEE1, 0x1A10, "vmsr fpscr, r1", Effect::Clobbers(0)),
        (0xEE10, 0x1A10, "vmov r1, s0", Effect::Clobbers(0b10)),
    ] {
        assert_eq!(effect_of(0x0800_1000, first, second), is, "{text}");
    }
}

proptest::proptest! {
    #[test]
    fn every_encoding_has_an_effect(first: u16, second: u16) {
        let effect = effect_of(0x0800_1000, first, second);
        let pc_is_written =
            matches!(effect, Effect::Clobbers(written) if written & (1 << PC | 1 << SP) != 0);
        proptest::prop_assert!(!pc_is_written, "{effect:?}");
    }
}

#[test]
fn a_constant_behind_the_code_is_known() {
    // ldr r3, [pc, #0], then a nop, and the constant.
    let found = decoded(0x0800_1000, &[0x4B00, 0xBF00, 0x1235, 0x0800]);
    let value = Value::Constant(0x0800_1235);
    assert_eq!(found[0].effect, Effect::Set { register: 3, value });
}

#[test]
fn a_branch_table_has_the_targets_that_stand_behind_it() {
    // tbb [pc, r0] and four entries; then the same with tbh and two.
    for (halves, width) in [([0xE8DF, 0xF000, 0x0402, 0x0204], 1), ([0xE8DF, 0xF010, 2, 4], 2)] {
        let half = |at: u32| halves.get((at.checked_sub(0x100)? / 2) as usize).copied();
        let around = Surroundings { half: &half, next: 0x108 };
        let is = Decoder::default().next(0x100, (halves[0], halves[1]), &around).effect;
        assert_eq!(is, Effect::JumpTable(vec![0x108, 0x10C]), "{width}");
    }
}

#[test]
fn a_block_makes_its_instructions_conditional() {
    // it ne; popne {r4, pc}; bx lr; ite eq; moveq; movne; cbz; beq; b
    let code = [0xBF18, 0xBD10, 0x4770, 0xBF0C, 0x2001, 0x2002, 0xB100, 0xD000, 0xE000];
    let conditional: Vec<bool> =
        decoded(0x0800_1000, &code).iter().map(|instruction| instruction.conditional).collect();
    assert_eq!(conditional, [false, true, false, false, true, true, true, true, false]);
}
