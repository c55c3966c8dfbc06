//! IT blocks (DDI 0403, A7.3).

use proptest::prelude::*;
use virtual_crazyflie::cpu::{Flags, FlashTiming, Stop};

use super::rig::{CODE, Rig};

/// ADDS Rn, #1, and within an IT block ADD.
const fn add(n: u16) -> u16 {
    0x3001 | n << 8
}

const NOP: u16 = 0xBF00;

/// What the manual's table of conditions says in words.
fn holds(condition: u16, Flags { n, z, c, v, .. }: Flags) -> bool {
    match condition {
        0 => z,
        1 => !z,
        2 => c,
        3 => !c,
        4 => n,
        5 => !n,
        6 => v,
        7 => !v,
        8 => c && !z,
        9 => !c || z,
        10 => n == v,
        11 => n != v,
        12 => !z && n == v,
        13 => z || n != v,
        _ => true,
    }
}

/// The IT for so many instructions, each of which is "then" or "else".
fn it(condition: u16, thens: &[bool]) -> u16 {
    let mut mask = 0;
    for (index, then) in thens.iter().enumerate().skip(1) {
        let bit = if *then { condition & 1 } else { !condition & 1 };
        mask |= bit << (4 - index);
    }
    0xBF00 | condition << 4 | mask | 1 << (4 - thens.len())
}

fn any_flags() -> impl Strategy<Value = Flags> {
    any::<[bool; 4]>().prop_map(|[n, z, c, v]| Flags { n, z, c, v, q: false, ge: 0 })
}

fn any_block() -> impl Strategy<Value = (u16, Vec<bool>)> {
    (0u16..15, prop::collection::vec(any::<bool>(), 0..=3)).prop_map(|(condition, rest)| {
        // After "always" there is no "else".
        let rest = rest.into_iter().map(|then| then || condition == 14);
        (condition, std::iter::once(true).chain(rest).collect())
    })
}

proptest! {
    #[test]
    fn what_is_in_a_block_is_executed_by_its_condition_and_sets_no_flags(
        flags in any_flags(),
        (condition, thens) in any_block(),
    ) {
        let mut code = vec![it(condition, &thens)];
        code.extend((0..4).map(add));
        code.push(NOP);
        let mut rig = Rig::new(&code);
        for n in 0..4 {
            rig.cpu.set_register(n, u32::MAX);
        }
        rig.cpu.set_flags(flags);
        rig.steps(1 + thens.len());
        prop_assert_eq!(rig.cpu.flags(), flags);
        prop_assert_eq!(rig.cpu.itstate(), 0);
        for (n, then) in thens.iter().enumerate() {
            let executed = *then == holds(condition, flags);
            prop_assert_eq!(rig.cpu.register(n) == 0, executed);
        }
        if thens.len() < 4 {
            rig.steps(1);
            prop_assert!(rig.cpu.flags().z && rig.cpu.flags().c, "outside it sets them");
        }
    }

    /// However it is interrupted, the outcome is the same: ITSTATE is kept with the rest.
    #[test]
    fn a_block_can_be_left_and_resumed_anywhere(
        flags in any_flags(),
        (condition, thens) in any_block(),
        pauses in prop::collection::vec(0u64..8, 0..8),
    ) {
        let mut code = vec![it(condition, &thens)];
        code.extend((0..4).map(add));
        code.extend([0xE7FE]);
        let rig = || {
            let mut rig = Rig::new(&code);
            rig.cpu.set_flags(flags);
            rig
        };
        let (mut whole, mut parts) = (rig(), rig());
        prop_assert_eq!(whole.run(50), Stop::Until);
        let mut pauses = pauses;
        pauses.sort_unstable();
        for pause in pauses {
            prop_assert_eq!(parts.run(pause), Stop::Until);
        }
        prop_assert_eq!(parts.run(50), Stop::Until);
        prop_assert_eq!(parts.registers(), whole.registers());
        prop_assert_eq!(parts.cpu.flags(), whole.cpu.flags());
        prop_assert_eq!(parts.cpu.cycles(), whole.cpu.cycles());
        prop_assert_eq!(parts.cpu.instructions(), whole.cpu.instructions());
    }
}

#[test]
fn what_sets_flags_by_its_name_does_so_in_a_block_too() {
    // IT AL; ADDS.W R0, R0, #1.
    let mut rig = Rig::new(&[0xBFE8, 0xF110, 0x0001]).with(0, u32::MAX);
    rig.steps(2);
    assert!(rig.cpu.flags().z && rig.cpu.flags().c);
    // ITT EQ; CMP R0, #1; ADDEQ R1, #1: the comparison decides about what follows it.
    let mut rig = Rig::new(&[0xBF04, 0x2801, 0x3101]);
    rig.cpu.set_flags(Flags { z: true, ..Flags::default() });
    rig.steps(3);
    assert_eq!(rig.cpu.register(1), 0);
}

#[test]
fn a_branch_at_the_end_of_a_block_leaves_it() {
    // ITE NE; ADDNE R0, #1; BEQ .+8 (B.N in the block); ADDS R0; ADDS R0; ADDS R0; B .
    let code = [0xBF14, add(0), 0xE001, add(0), add(0), add(1), 0xE7FE];
    let mut rig = Rig::new(&code).with(0, 0).with(1, 0);
    rig.cpu.set_flags(Flags { z: true, ..Flags::default() });
    rig.run(20);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(1)), (0, 1));
    assert_eq!(rig.cpu.itstate(), 0);
}

#[test]
fn a_trap_in_a_block_stops_before_its_instruction() {
    // ITT AL; ADD R0, #1; ADD R1, #1; B .
    let mut rig = Rig::new(&[0xBFE4, add(0), add(1), 0xE7FE]).with(0, 0).with(1, 0);
    assert!(rig.program.trap(CODE + 4));
    assert_eq!(rig.run(100), Stop::Trap);
    assert_eq!(rig.cpu.pc(), CODE + 4);
    assert_ne!(rig.cpu.itstate(), 0);
    assert_eq!(rig.cpu.register(1), 0);
    assert_eq!(rig.step(), Stop::Until);
    assert_eq!((rig.cpu.register(1), rig.cpu.itstate()), (1, 0));
}

#[test]
fn what_faults_in_a_block_is_still_in_it() {
    // ITT AL; ADD R0, #1; LDR R1, [R2]; with nothing at R2.
    let mut rig = Rig::new(&[0xBFE4, add(0), 0x6811]).with(2, super::rig::NOTHING);
    rig.steps(2);
    let it = rig.cpu.itstate();
    assert_eq!(rig.step(), Stop::Until);
    assert_eq!(rig.cpu.faults().len(), 1);
    assert_eq!((rig.cpu.pc(), rig.cpu.itstate()), (CODE + 4, it));
}

/// ADD.W Rn, Rn, #1
const fn add_wide(n: u16) -> [u16; 2] {
    [0xF100 | n, n << 8 | 1]
}

/// Cycles, instructions and program counter after a run to `until` that paused at `cut` too.
fn run_with_a_pause(code: &[u16], flags: Flags, cut: u64, until: u64) -> (u64, u64, u32) {
    let mut rig = Rig::new(code);
    rig.bus.wait_states = 5;
    rig.cpu.set_flash_timing(FlashTiming::Accelerated, 5);
    rig.cpu.set_flags(flags);
    for moment in [cut, until] {
        assert_eq!(rig.run(moment), Stop::Until);
    }
    (rig.cpu.cycles(), rig.cpu.instructions(), rig.cpu.register(15))
}

proptest! {
    /// The lines of flash that a block lies in cost the same cycles wherever a run pauses: in the
    /// block, at its IT, or not at all.
    #[test]
    fn a_pause_within_a_block_costs_no_cycle(
        (condition, thens) in any_block(),
        flags in any_flags(),
        before in 0_usize..8,
        cut in 0_u64..60,
        until in 60_u64..90,
    ) {
        let mut code = vec![NOP; before];
        code.push(it(condition, &thens));
        code.extend((0..4).take(thens.len()).flat_map(add_wide));
        code.extend([NOP; 120]);
        prop_assert_eq!(
            run_with_a_pause(&code, flags, cut, until),
            run_with_a_pause(&code, flags, 0, until)
        );
    }
}

#[test]
fn a_block_in_ram_is_executed_like_one_in_flash() {
    let code = [0xBF14u16, add(0), add(1), add(2), 0xE7FE];
    let mut rig = Rig::new(&[NOP]).with(0, 0).with(1, 0).with(2, 0);
    for (at, half) in (0x2000_0100..).step_by(2).zip(code) {
        rig.memory.store(at, virtual_crazyflie::bus::Width::Half, half.into());
    }
    rig.cpu.set_register(15, 0x2000_0100);
    rig.run(20);
    assert_eq!([0, 1, 2].map(|n| rig.cpu.register(n)), [1, 0, 1]);
}
