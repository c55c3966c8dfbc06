//! An instruction that faults has no effect.

use virtual_crazyflie::bus::{Refused, Width};
use virtual_crazyflie::cpu::{Fault, Stop};

use super::rig::{CODE, DATA, NOTHING, Rig, STACK, UNMODELLED};

/// The instruction faults, and no register has changed.
#[track_caller]
fn assert_faults(mut rig: Rig, fault: Fault) {
    let before = rig.registers();
    assert_eq!(rig.step(), Stop::Until);
    assert_eq!(rig.cpu.faults().first().expect("a fault").fault, fault);
    assert_eq!(rig.registers(), before);
    assert_eq!(rig.cpu.instructions(), 0);
}

#[test]
fn a_load_where_nothing_is_changes_no_register() {
    let fault = Fault::DataBus { address: NOTHING };
    // LDR R1, [R2]; LDR R1, [R2], #4; LDR R1, [R2, #4]!
    assert_faults(Rig::new(&[0x6811]).with(2, NOTHING), fault);
    assert_faults(Rig::new(&[0xF852, 0x1B04]).with(2, NOTHING), fault);
    assert_faults(Rig::new(&[0xF852, 0x1F04]).with(2, NOTHING - 4), fault);
    // STR R1, [R2], #4; POP {R0, R1}; PUSH {R0, R1}
    assert_faults(Rig::new(&[0xF842, 0x1B04]).with(2, NOTHING), fault);
    assert_faults(Rig::new(&[0xBC03]).with(13, NOTHING), fault);
    assert_faults(Rig::new(&[0xB403]).with(13, NOTHING + 8), fault);
    // LDRD R0, R1, [R2], #8; STREX and LDREX R0, [R2]
    assert_faults(Rig::new(&[0xE8F2, 0x0102]).with(2, NOTHING), fault);
    assert_faults(Rig::new(&[0xE852, 0x0F00]).with(2, NOTHING), fault);
}

#[test]
fn the_registers_of_a_load_of_several_change_together_or_not_at_all() {
    // LDM R2!, {R0, R1, R3}: the last word is behind the end of RAM.
    let end = 0x2002_0000;
    assert_faults(Rig::new(&[0xCA0B]).with(2, end - 8), Fault::DataBus { address: end });
}

#[test]
fn only_plain_loads_and_stores_need_no_alignment() {
    // LDR R1, [R2]; LDRH; STR; STRH
    for code in [0x6811, 0x8811, 0x6011, 0x8011] {
        let mut rig = Rig::new(&[code]).with(1, 0x1234_5678).with(2, DATA + 1);
        rig.word(DATA, 0x4433_2211);
        rig.word(DATA + 4, 0x8877_6655);
        rig.steps(1);
        match code {
            0x6811 => assert_eq!(rig.cpu.register(1), 0x5544_3322),
            0x8811 => assert_eq!(rig.cpu.register(1), 0x3322),
            0x6011 => assert_eq!((rig.read(DATA), rig.read(DATA + 4)), (0x3456_7811, 0x8877_6612)),
            _ => assert_eq!(rig.read(DATA), 0x4456_7811),
        }
    }
    let fault = Fault::Unaligned { address: DATA + 2 };
    // LDM R2, {R0, R1}; LDRD R0, R1, [R2]; STRD; LDREX; STREX R0, R1, [R2]
    for code in
        [[0xE892, 0x0003], [0xE9D2, 0x0100], [0xE9C2, 0x0100], [0xE852, 0x0F00], [0xE842, 0x1000]]
    {
        assert_faults(Rig::new(&code).with(2, DATA + 2), fault);
    }
    // VLDR S0, [R2]; VSTR; VLDM R2!, {S0, S1}
    for code in [[0xED92, 0x0A00], [0xED82, 0x0A00], [0xECB2, 0x0A02]] {
        let mut rig = Rig::new(&code).with(2, DATA + 2).with_fpu();
        assert_eq!(rig.step(), Stop::Until);
        assert_eq!(rig.cpu.faults().first().expect("a fault").fault, fault);
        assert_eq!(rig.cpu.register(2), DATA + 2);
    }
}

#[test]
fn a_trap_of_unaligned_accesses_is_a_trap_of_all() {
    let mut rig = Rig::new(&[0x6001, 0x6811]).with(0, 0xE000_ED14).with(1, 8).with(2, DATA + 1);
    rig.steps(1);
    rig.step();
    assert_eq!(
        rig.cpu.faults().first().expect("a fault").fault,
        Fault::Unaligned { address: DATA + 1 }
    );
}

#[test]
fn division_by_zero_is_zero_unless_it_is_trapped() {
    // SDIV R0, R1, R2; UDIV R0, R1, R2
    for code in [[0xFB91, 0xF0F2], [0xFBB1, 0xF0F2]] {
        let mut rig = Rig::new(&code).with(0, 7).with(1, 5).with(2, 0);
        rig.steps(1);
        assert_eq!(rig.cpu.register(0), 0);
        let mut rig = Rig::new(&[0x601C, code[0], code[1]])
            .with(0, 7)
            .with(1, 5)
            .with(2, 0)
            .with(3, 0xE000_ED14)
            .with(4, 0x10);
        rig.steps(1);
        rig.step();
        assert_eq!(rig.cpu.faults().first().expect("a fault").fault, Fault::DivideByZero);
        assert_eq!(rig.cpu.register(0), 7);
    }
}

#[test]
fn what_is_no_instruction_is_a_fault() {
    assert_faults(Rig::new(&[0xDE00]), Fault::Undefined);
    assert_faults(Rig::new(&[0xF7F0, 0xA000]), Fault::Undefined);
    // MCR P15, and VADD before the unit is switched on.
    assert_faults(Rig::new(&[0xEE01, 0x0F72]), Fault::NoCoprocessor);
    assert_faults(Rig::new(&[0xEE30, 0x0A00]), Fault::NoCoprocessor);
}

#[test]
fn what_the_manual_leaves_open_stops_the_core() {
    // LDR R1, [R1], #4
    let mut rig = Rig::new(&[0xF851, 0x1B04]).with(1, DATA);
    assert_eq!(rig.run(100), Stop::Unpredictable { encoding: 0xF851_1B04 });
    assert_eq!((rig.cpu.pc(), rig.cpu.register(1)), (CODE, DATA));
}

#[test]
fn what_is_not_modelled_stops_the_core_at_its_instruction() {
    let why = Refused::Unmodelled { what: "TIM4" };
    // NOP; STRH R1, [R2]
    let mut rig = Rig::new(&[0xBF00, 0x8011]).with(2, UNMODELLED);
    let refused = Stop::Refused { address: UNMODELLED, store: true, width: Width::Half, why };
    assert_eq!(rig.run(100), refused);
    assert_eq!(rig.cpu.pc(), CODE + 2);
    assert_eq!(rig.run(100), refused, "and so it does again");
    // LDRB R1, [R2]
    let mut rig = Rig::new(&[0x7811]).with(2, UNMODELLED);
    let refused = Stop::Refused { address: UNMODELLED, store: false, width: Width::Byte, why };
    assert_eq!(rig.run(100), refused);
}

#[test]
fn a_breakpoint_is_the_debuggers() {
    let mut rig = Rig::new(&[0xBF00, 0xBE07]);
    assert_eq!(rig.run(100), Stop::Breakpoint);
    assert_eq!(rig.cpu.pc(), CODE + 2);
    assert_eq!(rig.cpu.instructions(), 1);
}

#[test]
fn a_branch_without_the_thumb_bit_goes_there_and_faults_there() {
    // BX R0
    let mut rig = Rig::new(&[0x4700]).with(0, CODE + 0x100);
    rig.steps(1);
    assert_eq!(rig.cpu.pc(), CODE + 0x100);
    rig.step();
    assert_eq!(rig.cpu.faults().first().expect("a fault").fault, Fault::InvalidState);
}

#[test]
fn nothing_is_executed_where_nothing_or_only_a_peripheral_is() {
    let at = |address| Rig::new(&[0xBF00]).with(15, address);
    assert_faults(at(NOTHING), Fault::FetchBus { address: NOTHING });
    assert_faults(at(0x4000_0000), Fault::ExecuteNever { address: 0x4000_0000 });
    assert_faults(at(0xE000_E000), Fault::ExecuteNever { address: 0xE000_E000 });
}

#[test]
fn a_push_that_fits_only_in_part_leaves_the_stack_pointer() {
    // PUSH {R0-R3} with two words left.
    let start = 0x2000_0000;
    let mut rig = Rig::new(&[0xB40F]).with(13, start + 8);
    rig.step();
    assert_eq!(rig.cpu.register(13), start + 8);
    assert!(!rig.cpu.faults().is_empty());
    let mut rig = Rig::new(&[0xB40F]).with(13, STACK);
    rig.steps(1);
    assert_eq!(rig.cpu.register(13), STACK - 16);
}
