//! The firmware's own ELF, from its first instruction on.
//!
//! These tests need the file that `cargo fw` builds, or the one that `UCHAIN_ELF` names. They are
//! ignored unless they are asked for:
//!
//! ```text
//! cargo fw && cargo test --package virtual-crazyflie -- --ignored
//! cargo fw && cargo nextest run --package virtual-crazyflie --run-ignored only
//! ```
//!
//! So the report of a plain `cargo test` lists them as ignored, with the reason, and never as
//! passed. Asked for without the file, they fail.

use std::sync::Arc;

use crate::core::rig::Rig;
use units::Dbm;
use virtual_crazyflie::board::nrf51::Power;
use virtual_crazyflie::board::{Config, Crazyflie, InertialNoise};
use virtual_crazyflie::cpu::{Fault, Program, Stop};
use virtual_crazyflie::image::{Image, built_elf};
use virtual_crazyflie::machine::{Machine, MachineConfig};
use virtual_crazyflie::soc::{Pin, PinOutput, ResetCause, SocConfig};

const MILLISECOND: u64 = 1_000_000;
const MOTORS: [Pin; 4] = [Pin::new('A', 1), Pin::new('B', 11), Pin::new('A', 15), Pin::new('B', 9)];

fn image() -> Arc<Image> {
    let path = built_elf(env!("CARGO_TARGET_TMPDIR"));
    Arc::new(Image::open(&path).expect("`cargo fw` builds the ELF"))
}

fn machine(image: &Arc<Image>, config: MachineConfig) -> Machine<Crazyflie> {
    // A sensor without noise is one that has frozen, to the firmware.
    let noise = Some(InertialNoise { seed: 1, gyro: 4, accel: 4 });
    let board = Crazyflie::new(&Config { noise, ..Config::default() });
    Machine::new(Arc::clone(image), board, config)
}

fn run(machine: &mut Machine<Crazyflie>, until: u64) {
    if let Err(halt) = machine.run_until(until) {
        panic!("{halt}; faults: {:#x?}", machine.fault_reports());
    }
}

#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn the_firmware_runs_for_seconds_at_168_mhz_without_a_reset_or_a_fault() {
    let image = image();
    let mut machine = machine(&image, MachineConfig::default());
    run(&mut machine, 3_000 * MILLISECOND);
    assert_eq!(machine.core_hz(), 168e6);
    assert_eq!(machine.soc().bus_dividers(), (4, 2));
    let causes: Vec<_> = machine.resets().iter().map(|reset| reset.cause).collect();
    assert_eq!(causes, [ResetCause::PowerOn]);
    assert!(machine.fault_reports().is_empty());
    assert!(machine.cpu().slept() > machine.cpu().cycles() / 20, "it never sleeps");
}

/// A drone without keys sends no packet, and with no Crazyradio near it hears none: its radio chip
/// stays in Bluetooth mode, in which settings that come again and again switch it off. The firmware
/// takes five seconds of silence for another channel only when that mode is over.
#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn a_drone_without_keys_that_hears_nothing_is_told_its_settings_once_and_stays_on() {
    let image = image();
    let mut machine = machine(&image, MachineConfig::default());
    let frames = |machine: &mut Machine<Crazyflie>, until| {
        run(machine, until);
        let board = machine.board();
        assert_eq!(board.power(), Power::On);
        (
            board.radio().model().unwrap().is_in_bluetooth(),
            board.radio().model().unwrap().counters().good,
        )
    };
    let booted = frames(&mut machine, 1_000 * MILLISECOND);
    assert_eq!(frames(&mut machine, 5_600 * MILLISECOND), booted);
    machine.board_mut().hear_crtp(5_601 * MILLISECOND, &[0xFF], Dbm(-50.0));
    let (in_bluetooth, good) = frames(&mut machine, 6_000 * MILLISECOND);
    assert!(booted.0 && !in_bluetooth && good > booted.1, "it is told its power");
}

#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn motors_stand_still_on_the_ground() {
    let image = image();
    let mut machine = machine(&image, MachineConfig::default());
    for step in 1..=1000 {
        run(&mut machine, step * MILLISECOND);
        for pin in MOTORS {
            let output = machine.output(pin);
            // Until `main` is reached, the pins are inputs.
            let is_still = match output {
                PinOutput::Low => true,
                PinOutput::Input | PinOutput::Alternate(_) => step <= 20,
                PinOutput::High | PinOutput::Pwm { .. } => false,
            };
            assert!(is_still, "{pin:?} after {step} ms: {output:?}");
        }
    }
}

#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn the_same_elf_with_the_same_inputs_ends_in_the_same_state_however_it_is_cut_up() {
    let image = image();
    let mut at_once = machine(&image, MachineConfig::default());
    run(&mut at_once, 700 * MILLISECOND);
    let mut again = machine(&image, MachineConfig::default());
    run(&mut again, 700 * MILLISECOND);
    assert_eq!(at_once.state_hash(), again.state_hash());
    let mut by_steps = machine(&image, MachineConfig::default());
    for step in 1..=700 {
        run(&mut by_steps, step * MILLISECOND);
    }
    assert_eq!(at_once.state_hash(), by_steps.state_hash());
}

#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn a_broken_crystal_ends_in_a_reset_by_software_and_no_motor_turns() {
    let image = image();
    let soc = SocConfig { hse_hz: None, ..SocConfig::default() };
    let mut machine = machine(&image, MachineConfig { soc, ..MachineConfig::default() });
    run(&mut machine, 1_000 * MILLISECOND);
    let again: Vec<_> = machine.resets().iter().skip(1).map(|reset| reset.cause).collect();
    assert!(!again.is_empty());
    assert!(again.iter().all(|cause| *cause == ResetCause::Software), "{again:?}");
}

#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn the_firmware_knows_after_each_reset_what_it_was() {
    let image = image();
    let mut machine = machine(&image, MachineConfig::default());
    run(&mut machine, 200 * MILLISECOND);
    machine.reset(ResetCause::BrownOut);
    run(&mut machine, 400 * MILLISECOND);
    assert_eq!(machine.resets().len(), 2);
    assert_eq!(machine.resets()[1].cause, ResetCause::BrownOut);
    assert_eq!(machine.core_hz(), 168e6);
}

#[test]
fn a_machine_can_be_given_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<Machine<Crazyflie>>();
}

/// On a chip that has nothing but a core and memory, the firmware runs up to its first access to a
/// peripheral's register.
#[test]
#[ignore = "needs the firmware's ELF: cargo fw"]
fn the_firmware_boots_to_its_first_register() {
    let image = image();
    let (start, code) = image.flat();
    let mut rig = Rig::new(&[]);
    assert!(rig.memory.program(start, &code), "it is flash");
    rig.program = Program::new(start, &code);
    rig.cpu.reset_core(&rig.memory, image.vector_table());
    let stop = loop {
        let before = rig.cpu.instructions();
        match rig.step() {
            Stop::Until if rig.cpu.faults().is_empty() => {}
            stop => break (stop, before),
        }
    };
    let (stop, instructions) = stop;
    println!("{instructions} instructions, then {stop:x?} {:x?}", rig.cpu.faults().first());
    assert!(instructions > 1000, "{instructions}");
    let peripheral = 0x4000_0000..0x6000_0000;
    let address = match (stop, rig.cpu.faults().first().map(|report| report.fault)) {
        (Stop::Refused { address, .. }, _) => address,
        (_, Some(Fault::DataBus { address })) => address,
        other => panic!("{other:?}"),
    };
    assert!(peripheral.contains(&address), "{address:#x}");
}
