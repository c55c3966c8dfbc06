//! Special registers, as MRS and MSR see them.

use proptest::prelude::*;

use super::*;

const PRIMASK: u8 = 16;
const BASEPRI: u8 = 17;
const BASEPRI_MAX: u8 = 18;
const FAULTMASK: u8 = 19;
const CONTROL: u8 = 20;

proptest! {
    #[test]
    fn xpsr_comes_back_as_it_was_set(
        apsr in any::<u32>(), it in any::<u8>(), ipsr in 0_u32..98,
    ) {
        let mut cpu = Cpu::new();
        let it = if it & 0xF == 0 { 0 } else { u32::from(it) };
        let value = apsr & 0xF80F_0000 | (it & 3) << 25 | (it >> 2) << 10 | 1 << 24 | ipsr;
        cpu.set_xpsr(value);
        prop_assert_eq!(cpu.xpsr(), value);
        prop_assert_eq!(cpu.apsr(), apsr & 0xF80F_0000);
        prop_assert_eq!(cpu.mrs(3), apsr & 0xF80F_0000 | ipsr, "EPSR reads as zero");
        prop_assert_eq!(cpu.mrs(5), ipsr);
        prop_assert_eq!(cpu.mrs(6), 0);
    }
}

#[test]
fn an_interrupted_load_multiple_begins_anew() {
    let mut cpu = Cpu::new();
    cpu.set_xpsr(0x0100_5000);
    assert_eq!(cpu.it, 0);
}

#[test]
fn the_mask_of_msr_chooses_flags() {
    let mut cpu = Cpu::new();
    cpu.msr(0, 2, u32::MAX);
    assert_eq!(cpu.apsr(), 0xF800_0000);
    cpu.msr(0, 1, 0x000A_0000);
    assert_eq!(cpu.apsr(), 0xF80A_0000);
    cpu.msr(0, 3, 0);
    assert_eq!(cpu.apsr(), 0);
    cpu.msr(5, 3, u32::MAX);
    assert_eq!(cpu.xpsr(), 1 << 24, "IPSR is not written");
}

#[test]
fn spsel_changes_stacks_in_thread_mode_only() {
    let mut cpu = Cpu::new();
    cpu.msr(8, 0, 0x2000_1003);
    cpu.msr(9, 0, 0x2000_2003);
    assert_eq!((cpu.r[13], cpu.mrs(8), cpu.mrs(9)), (0x2000_1000, 0x2000_1000, 0x2000_2000));
    cpu.msr(CONTROL, 0, 2);
    assert_eq!((cpu.r[13], cpu.mrs(8), cpu.mrs(9)), (0x2000_2000, 0x2000_1000, 0x2000_2000));
    cpu.msr(9, 0, 0x2000_3000);
    assert_eq!(cpu.r[13], 0x2000_3000);
    cpu.msr(CONTROL, 0, 0);
    assert_eq!(cpu.r[13], 0x2000_1000);
    cpu.special.ipsr = 20;
    cpu.msr(CONTROL, 0, 2);
    assert_eq!((cpu.r[13], cpu.mrs(CONTROL)), (0x2000_1000, 0));
}

#[test]
fn basepri_max_only_ever_masks_more() {
    let mut cpu = Cpu::new();
    for (value, expected) in [(0x8F, 0x80), (0x90, 0x80), (0x40, 0x40), (0, 0x40), (0x0F, 0x40)] {
        cpu.msr(BASEPRI_MAX, 0, value);
        assert_eq!((cpu.mrs(BASEPRI), cpu.mrs(BASEPRI_MAX)), (expected, expected));
    }
    cpu.msr(BASEPRI, 0, 0);
    assert_eq!(cpu.mrs(BASEPRI), 0);
}

#[test]
fn faultmask_cannot_be_set_in_a_hard_fault() {
    let mut cpu = Cpu::new();
    cpu.exceptions.priorities.set_active(1 << 3, true);
    cpu.cps(false, false, true);
    assert_eq!(cpu.mrs(FAULTMASK), 0);
    cpu.exceptions.priorities.set_active(1 << 3, false);
    cpu.msr(FAULTMASK, 0, 1);
    assert_eq!(cpu.mrs(FAULTMASK), 1);
    cpu.cps(true, false, true);
    assert_eq!(cpu.mrs(FAULTMASK), 0);
}

#[test]
fn what_is_unmasked_comes_in_at_once() {
    let mut cpu = Cpu::new();
    cpu.cps(false, true, false);
    cpu.exceptions.priorities.set_enabled(1 << 20, true);
    cpu.set_lines(1 << 4);
    cpu.deadline = u64::MAX;
    cpu.msr(PRIMASK, 0, 1);
    assert_eq!(cpu.deadline, u64::MAX);
    cpu.msr(PRIMASK, 0, 0);
    assert_eq!(cpu.deadline, 0);
}

#[test]
fn without_privileges_only_flags_and_control_are_readable_and_flags_writable() {
    let mut cpu = Cpu::new();
    cpu.r[13] = 0x2000_1000;
    cpu.msr(BASEPRI, 0, 0x80);
    cpu.msr(CONTROL, 0, 1);
    for register in [8, 9, PRIMASK, BASEPRI, BASEPRI_MAX, FAULTMASK] {
        assert_eq!(cpu.mrs(register), 0);
        cpu.msr(register, 0, 0x71);
    }
    cpu.msr(CONTROL, 0, 0);
    cpu.cps(false, true, true);
    cpu.msr(0, 2, 1 << 31);
    assert_eq!((cpu.mrs(CONTROL), cpu.mrs(0)), (1, 1 << 31));
    cpu.special.ipsr = 20;
    assert_eq!(cpu.r[13], 0x2000_1000);
    assert_eq!((cpu.mrs(PRIMASK), cpu.mrs(BASEPRI), cpu.mrs(FAULTMASK)), (0, 0x80, 0));
}
