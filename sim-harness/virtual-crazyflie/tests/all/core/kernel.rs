//! A whole program, of which the same source has been executed by the host's processor too.

use proptest::prelude::*;
use virtual_crazyflie::cpu::{FlashTiming, Stop};

use super::rig::{CODE, Rig};

/// See examples/mips/kernel.rs.
const KERNEL: &[u8] = include_bytes!("../../../examples/mips/kernel.bin");
/// Where it counts its rounds, and where the checksum of a round is.
const ROUND: u32 = 0x2000_0000;
const CHECKSUM: u32 = 0x2000_0004;
/// Of `write_volatile(0x2000_0000, round)`: what comes at the end of a round.
const ROUND_CYCLES: u64 = 12_000;

fn kernel() -> Rig {
    let mut rig = Rig::of_bytes(KERNEL);
    rig.word(ROUND, 0);
    rig
}

/// The kernel's sums of floats, packed and with a checksum, as the same source computes them when
/// it is compiled for x86-64: nothing of it may depend on the processor.
#[test]
fn it_computes_what_the_host_computes() {
    let mut rig = kernel();
    for (round, checksum) in [(1, 0x0BC4_4794), (100, 0x4553_4709), (1500, 0x5ABA_C468)] {
        while rig.read(ROUND) < round {
            let until = rig.cpu.cycles() + 1000;
            assert_eq!(rig.run(until), Stop::Until);
        }
        assert_eq!(rig.read(ROUND), round, "a round takes more than a thousand cycles");
        assert_eq!(rig.read(CHECKSUM), checksum, "round {round}");
    }
}

fn state(rig: &Rig) -> impl PartialEq + std::fmt::Debug + use<> {
    (
        rig.registers(),
        rig.cpu.flags(),
        rig.cpu.itstate(),
        (0..32).map(|n| rig.cpu.s(n)).collect::<Vec<_>>(),
        rig.cpu.fpscr(),
        rig.cpu.cycles(),
        rig.cpu.instructions(),
        rig.read(CHECKSUM),
    )
}

#[test]
fn step_by_step_is_the_same_as_at_once() {
    let (mut steps, mut run) = (kernel(), kernel());
    while steps.cpu.cycles() < 3 * ROUND_CYCLES {
        steps.steps(1);
        assert_eq!(run.run(steps.cpu.cycles()), Stop::Until);
        assert_eq!(state(&run), state(&steps));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn it_does_not_matter_how_often_it_is_stopped(parts in prop::collection::vec(1u64..3000, 1..40)) {
        let (mut whole, mut stopped) = (kernel(), kernel());
        let end: u64 = parts.iter().sum();
        let mut until = 0;
        for part in parts {
            until += part;
            prop_assert_eq!(stopped.run(until), Stop::Until);
        }
        prop_assert_eq!(whole.run(end), Stop::Until);
        prop_assert_eq!(state(&whole), state(&stopped));
    }
}

#[test]
fn the_accelerator_is_between_the_bounds() {
    let cycles = |timing, wait_states| {
        let mut rig = kernel();
        rig.bus.wait_states = wait_states;
        rig.cpu.set_flash_timing(timing, wait_states);
        while rig.read(ROUND) < 40 {
            let until = rig.cpu.cycles() + 1000;
            assert_eq!(rig.run(until), Stop::Until);
        }
        rig.cpu.cycles()
    };
    let ideal = cycles(FlashTiming::Ideal, 5);
    let accelerated = cycles(FlashTiming::Accelerated, 5);
    let off = cycles(FlashTiming::Off, 5);
    assert!(ideal < accelerated && accelerated < off, "{ideal} {accelerated} {off}");
    assert!(accelerated < ideal * 5 / 4, "{ideal} {accelerated}");
    // Without wait states there is nothing to wait for.
    let near = |cycles: u64| cycles.abs_diff(ideal) <= 1000;
    assert!(near(cycles(FlashTiming::Accelerated, 0)) && near(cycles(FlashTiming::Off, 0)));
}

#[test]
fn a_trap_stops_each_time_it_is_come_to_and_costs_nothing() {
    // The first instruction after the floating-point unit has been switched on.
    let trap = CODE + 0x5C;
    let (mut free, mut trapped) = (kernel(), kernel());
    assert!(trapped.program.trap(trap) && trapped.program.is_trapped(trap));
    assert!(!trapped.program.trap(0x2000_0000), "that is not in the program");
    let copy = trapped.program.clone();
    assert_eq!(trapped.run(1000), Stop::Trap);
    assert_eq!(trapped.cpu.pc(), trap);
    assert_eq!(trapped.run(1000), Stop::Trap, "it has not gone past it");
    assert_eq!(trapped.step(), Stop::Until);
    assert_eq!(trapped.run(5000), Stop::Until);
    assert_eq!(free.run(5000), Stop::Until);
    assert_eq!(state(&free), state(&trapped));
    trapped.program.untrap(trap);
    assert!(!trapped.program.is_trapped(trap) && copy.is_trapped(trap));
}
