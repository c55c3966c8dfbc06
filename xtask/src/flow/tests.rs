//! Flows of made-up functions.

use super::*;
use crate::synthetic::{
    Line, PC, SP, always, branch, call, call_register, jump, listing, offset, perhaps, pop, pop_pc,
    push, ret, set, take,
};
use virtual_crazyflie::cpu::effect;

/// The flow of a function at 0x100. `0xC000` and up are other functions; the one at `0xDEAD` never
/// returns.
fn flow(lines: Vec<Line>) -> Result<Flow, String> {
    let instructions = listing(0x100, lines);
    analyse(&Code {
        start: 0x100,
        end: 0x100 + 2 * instructions.len() as u32,
        instructions: &instructions,
        diverging: &BTreeSet::from([0xDEAD]),
    })
}

fn calls(flow: &Flow) -> Vec<(u32, Target)> {
    flow.calls.iter().map(|call| (call.depth, call.to)).collect()
}

const fn constant(register: u8, value: u32) -> Line {
    set(register, effect::Value::Constant(value))
}

#[test]
fn pushes_and_subtractions_add_up() {
    let flow = flow(vec![
        push(16),
        offset(7, SP, 8),
        push(32),
        take(0x78),
        call(0xC000),
        take(-0x78),
        pop(32),
        pop_pc(16),
    ])
    .unwrap();
    assert_eq!(flow.frame, 16 + 32 + 0x78);
    assert_eq!(calls(&flow), [(168, Target::At(0xC000))]);
    assert!(flow.returns);
}

#[test]
fn every_way_of_taking_stack_counts() {
    use effect::Value::{Difference, Masked, UpperHalf};
    for (take, bytes) in [
        (vec![take(4096)], 4096),
        (vec![push(8)], 8),
        (vec![constant(12, 0x1234), set(SP, Difference(SP, 12))], 0x1234),
        (
            vec![constant(4, 0x10), set(4, UpperHalf(4, 0x1_0000)), set(SP, Difference(SP, 4))],
            0x1_0010,
        ),
        // Aligned down to 16 and to 32 bytes, by a frame that may have been a multiple of four.
        (vec![offset(4, SP, -0x40), set(4, Masked(4, !0xF)), offset(SP, 4, 0)], 0x40 + 12),
        (vec![offset(4, SP, -0x40), set(4, Masked(4, !0x1F)), offset(SP, 4, 0)], 0x40 + 28),
    ] {
        let lines = take.into_iter().chain([call(0xDEAD)]).collect();
        assert_eq!(flow(lines).map(|flow| flow.frame), Ok(bytes));
    }
}

#[test]
fn a_stack_whose_size_is_only_known_when_running_is_an_error() {
    for (what, unknown) in [
        ("sub sp, r0", set(SP, effect::Value::Difference(SP, 0))),
        ("mov sp, r4", offset(SP, 4, 0)),
        ("msr msp, r0", always(Effect::SetMainStack(0))),
        ("ldr sp, [r0]", always(Effect::Opaque("SP"))),
    ] {
        assert!(flow(vec![unknown, ret()]).is_err(), "{what}");
    }
    let endless = flow(vec![push(4), jump(0x100)]).unwrap_err();
    assert!(endless.contains("a loop takes stack"), "{endless}");
}

#[test]
fn another_stack_is_counted_apart() {
    let flow = flow(vec![
        push(8),
        constant(1, 0x1000_0480),
        always(Effect::SetMainStack(1)),
        push(16),
        call(0xC000),
        jump(0xC100),
    ])
    .unwrap();
    assert_eq!((flow.frame, flow.elsewhere), (8, BTreeMap::from([(0x1000_0480, 16)])));
    assert_eq!(flow.calls[0].stack, Some(0x1000_0480));
    assert_eq!(flow.calls[0].depth, 16);
}

#[test]
fn a_frame_pointer_leads_back() {
    let flow = flow(vec![
        push(12),
        offset(7, SP, 4),
        take(0x20),
        call(0xC000),
        offset(4, 7, -4),
        offset(SP, 4, 0),
        call(0xC000),
        pop_pc(12),
    ])
    .unwrap();
    assert_eq!(calls(&flow), [(44, Target::At(0xC000)), (12, Target::At(0xC000))]);
}

#[test]
fn a_jump_to_another_function_leaves_the_frame_behind() {
    let flow = flow(vec![branch(0x108), push(8), pop(8), jump(0xC000), ret()]).unwrap();
    assert_eq!(flow.frame, 8);
    assert_eq!(calls(&flow), [(0, Target::At(0xC000))]);
    assert!(flow.returns);
}

#[test]
fn execution_does_not_continue_behind_a_call_that_never_returns() {
    let flow = flow(vec![branch(0x108), push(8), take(0x40), call(0xDEAD), ret()]).unwrap();
    assert_eq!(calls(&flow), [(72, Target::At(0xDEAD))]);
    assert!(flow.returns);
    let flow = self::flow(vec![push(8), call(0xDEAD)]).unwrap();
    assert!(!flow.returns);
}

#[test]
fn where_ways_meet_the_deeper_counts() {
    let flow = flow(vec![branch(0x106), take(0x10), jump(0x108), take(0x30), call(0xC000), ret()])
        .unwrap();
    assert_eq!(calls(&flow), [(0x30, Target::At(0xC000))]);
}

#[test]
fn a_return_on_condition_may_not_be_taken() {
    let flow = flow(vec![
        push(8),
        perhaps(Effect::Stack { by: 8, loaded: 1 << PC | 1 << 4 }),
        call(0xC000),
        perhaps(Effect::JumpRegister(14)),
        pop_pc(8),
    ])
    .unwrap();
    assert_eq!(calls(&flow), [(8, Target::At(0xC000))]);
}

#[test]
fn a_call_through_a_known_constant_is_a_direct_one() {
    let known = vec![constant(1, 0x0800_6B09), call_register(1), call_register(1)];
    let flow = flow(known).unwrap();
    assert_eq!(calls(&flow), [(0, Target::At(0x0800_6B08)), (0, Target::Unknown)]);
}

#[test]
fn a_branch_table_leads_to_each_of_its_entries_but_to_no_padding() {
    let lines =
        |targets| vec![take(8), always(Effect::JumpTable(targets)), call(0xC000), call(0xDEAD)];
    let flow = flow(lines(vec![0x104, 0x106, 0x4000])).unwrap();
    assert_eq!(calls(&flow), [(8, Target::At(0xC000)), (8, Target::At(0xDEAD))]);
    assert!(self::flow(lines(vec![0x4000])).is_err());
}
