//! Cycles, deadlines and sleep.

use virtual_crazyflie::cpu::Stop;

use super::rig::{DATA, REGISTER, Rig};

/// The cycles of so many instructions.
#[track_caller]
fn cycles(mut rig: Rig, count: usize) -> u64 {
    let before = rig.cpu.cycles();
    rig.steps(count);
    rig.cpu.cycles() - before
}

#[test]
fn instructions_take_what_the_table_says() {
    let rig = |code: &[u16]| Rig::new(code).with(2, DATA).with(3, DATA);
    // ADDS R0, #1
    assert_eq!(cycles(rig(&[0x3001]), 1), 1);
    // LDR R0, [R2]; LDR R1, [R3]; LDR R4, [R2]; NOP: loads are pipelined.
    assert_eq!(cycles(rig(&[0x6810, 0x6819, 0x6814, 0xBF00]), 3), 4);
    // LDR R2, [R2]; LDR R0, [R2]: not where one needs the other.
    let mut chained = rig(&[0x6812, 0x6810]);
    chained.word(DATA, DATA);
    assert_eq!(cycles(chained, 2), 4);
    // STR R0, [R2]
    assert_eq!(cycles(rig(&[0x6010]), 1), 1);
    // PUSH {R0-R3}; POP {R0-R3}
    assert_eq!(cycles(rig(&[0xB40F, 0xBC0F]), 2), 10);
    // B .+4; BNE, taken and not
    assert_eq!(cycles(rig(&[0xE000, 0xBF00]), 1), 2);
    assert_eq!(cycles(rig(&[0xD100, 0xBF00]), 1), 2);
    assert_eq!(cycles(rig(&[0xD000, 0xBF00]), 1), 1);
    // BX LR
    assert_eq!(cycles(rig(&[0x4770]).with(14, DATA | 1), 1), 3);
    // UMULL R0, R1, R2, R3; MLA R0, R1, R2, R3
    assert_eq!(cycles(rig(&[0xFBA2, 0x0103]), 1), 1);
    assert_eq!(cycles(rig(&[0xFB01, 0x3002]), 1), 1);
}

#[test]
fn a_division_takes_two_to_twelve_cycles() {
    // UDIV R0, R1, R2
    let udiv = |n, m| cycles(Rig::new(&[0xFBB1, 0xF0F2]).with(1, n).with(2, m), 1);
    assert_eq!(udiv(1, 2), 2);
    assert_eq!(udiv(u32::MAX, 1), 12);
    assert!((2..=12).contains(&udiv(100_000, 7)));
    // SDIV R0, R1, R2: the sign makes no difference.
    let sdiv =
        |n: i32, m: i32| cycles(Rig::new(&[0xFB91, 0xF0F2]).with(1, n as u32).with(2, m as u32), 1);
    assert_eq!(sdiv(-1000, 7), sdiv(1000, 7));
}

#[test]
fn floating_point_takes_what_the_table_says() {
    let fp = |code: &[u16]| cycles(Rig::new(code).with(2, DATA).with_fpu(), 1);
    // VADD, VMLA, VDIV, VSQRT of S0; VLDR S0, [R2]; VPUSH {S0-S3}
    assert_eq!(fp(&[0xEE30, 0x0A00]), 1);
    assert_eq!(fp(&[0xEE00, 0x0A00]), 3);
    assert_eq!(fp(&[0xEE80, 0x0A00]), 14);
    assert_eq!(fp(&[0xEEB1, 0x0AC0]), 14);
    assert_eq!(fp(&[0xED92, 0x0A00]), 2);
    assert_eq!(fp(&[0xED2D, 0x0A04]), 5);
}

#[test]
fn what_is_due_happens_at_the_next_instruction() {
    // NOPs and B .
    let mut code = [0xBF00; 33];
    code[32] = 0xE7FE;
    let mut rig = Rig::new(&code);
    rig.bus.due = vec![5, 9, 17];
    assert_eq!(rig.run(30), Stop::Until);
    assert_eq!(rig.bus.happened, [5, 9, 17]);
    assert_eq!(rig.cpu.cycles(), 30);
}

#[test]
fn an_access_knows_the_time() {
    // NOP; NOP; STR R1, [R2]
    let mut rig = Rig::new(&[0xBF00, 0xBF00, 0x6011]).with(2, REGISTER);
    rig.steps(3);
    assert_eq!(rig.bus.stores[0].0, 3);
}

#[test]
fn sleep_is_until_something_happens_and_is_counted() {
    // WFI; B .
    let mut rig = Rig::new(&[0xBF30, 0xE7FE]);
    rig.bus.due = vec![400];
    assert_eq!(rig.run(1000), Stop::Until);
    assert_eq!((rig.cpu.cycles(), rig.cpu.slept()), (1000, 999));
    assert_eq!(rig.bus.happened, [400]);
    assert!(rig.cpu.is_asleep());
}

#[test]
fn an_event_is_waited_for_once() {
    // SEV; WFE; WFE; B .
    let mut rig = Rig::new(&[0xBF40, 0xBF20, 0xBF20, 0xE7FE]);
    assert_eq!(rig.run(100), Stop::Until);
    assert_eq!(rig.cpu.instructions(), 3);
    assert_eq!(rig.cpu.slept(), 97);
}

#[test]
fn the_bus_can_ask_for_a_reset() {
    let mut rig = Rig::new(&[0xE7FE]);
    rig.bus.resets = true;
    assert_eq!(rig.run(100), Stop::Reset);
    assert_eq!(rig.cpu.instructions(), 0);
}
