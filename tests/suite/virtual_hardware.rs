//! The firmware's ELF on a board that is not as it should be: a radio chip that is slow, old or set
//! otherwise, and a board of another name.
//!
//! Like [`virtual_drones`](crate::virtual_drones) they fly the file that `cargo fw` makes:
//! `cargo test --test suite virtual_hardware -- --ignored`.

use std::sync::Arc;

use sim_harness::bodies::emulated::Emulated;
use sim_harness::mission::Mission;
use units::NodeId;
use virtual_crazyflie::board::nrf51::{Counters, Tuning};
use virtual_crazyflie::board::{Config, Fault};
use virtual_crazyflie::log::Messages;
use virtual_crazyflie::machine::MachineConfig;
use virtual_crazyflie::soc::SocConfig;

use crate::virtual_drones::{firmware, scenario};

const MS: u64 = 1_000_000;

/// How a head went that was ordered to explore, with a hosted relay behind it.
struct Went {
    take_offs: u32,
    counters: Counters,
    log: String,
}

impl Went {
    /// Frames and bytes on their way to the radio chip that did not arrive.
    const fn lost(&self) -> u32 {
        let Counters { bad_first_sums, bad_second_sums, too_long, dropped_bytes, .. } =
            self.counters;
        bad_first_sums + bad_second_sums + too_long + dropped_bytes
    }
}

/// Runs the head for 12 s, with a fault from its switching-on plus a time.
fn head(board_name: &'static str, version: &str, fault: Option<(Fault, u64)>) -> Went {
    let scenario = scenario();
    let world = scenario.world();
    let soc = SocConfig { board_name, ..SocConfig::default() };
    let machine = MachineConfig { soc, ..MachineConfig::default() };
    let board = Config { version: version.into(), ..Config::default() };
    let mut drone = Emulated::with_board(&scenario, firmware(), NodeId(0), 1, machine, board);
    drone.read_log(&Arc::new(Messages::of(firmware().image()).unwrap()));
    if let Some((fault, from)) = fault {
        drone.machine_mut().board_mut().inject(fault, from, u64::MAX);
    }
    let mut mission = Mission::emulated(&scenario, &world, 1, vec![drone]);
    mission.advance(12_000_000);
    assert_eq!(mission.halted(), None);
    let take_offs = mission.bodies().next().unwrap().craft().unwrap().record().take_offs();
    let drone = mission.emulated_drone(0).unwrap();
    let radio = drone.machine().board().radio().model().unwrap();
    let lines: Vec<_> = drone.log().iter().map(|line| line.text.as_str()).collect();
    Went { take_offs, counters: radio.counters(), log: lines.join("\n") }
}

const BOARD: &str = "0;CF21";
const VERSION: &str = "2025.02 (CF21)";

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_sound_head_takes_off_and_has_no_fault() {
    let went = head("0;CF21;R=D", VERSION, None);
    assert_eq!((went.take_offs, went.lost()), (1, 0));
    assert!(!went.log.contains("hardware"), "{}", went.log);
}

/// The chip says "wait" in the middle of frames, by its six bytes.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_busy_radio_chip_loses_no_byte_of_a_frame() {
    for (every, busy) in [(1_000, 100), (700, 250), (5_000, 1_500)] {
        let fault = Fault::RadioBusy { every: every * 1_000, busy: busy * 1_000 };
        let went = head(BOARD, VERSION, Some((fault, 0)));
        assert_eq!(went.lost(), 0, "{busy} of {every} us: {:?}", went.counters);
        assert!(went.counters.good > 50, "{busy} of {every} us: {:?}", went.counters);
        assert_eq!(went.take_offs, 1, "{busy} of {every} us");
    }
}

/// A Crazyradio can set the channel from the air, and the chip tells its flight processor nothing of it. The drone is alone here,
/// since the simulated medium asks no radio for its channel.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_radio_that_was_set_from_the_air_is_told_its_channel_again() {
    let mut drone = Emulated::new(&scenario(), firmware(), NodeId(1), 1);
    let machine = drone.machine_mut();
    machine.board_mut().inject(Fault::RadioRetuned(33), 3_000 * MS, u64::MAX);
    let mut channel_at = |moment: u64| {
        while machine.now() < moment {
            machine.advance_to(moment).unwrap();
        }
        machine.board().radio().tuning().channel
    };
    let own = Tuning::DEFAULT.channel;
    assert_eq!(channel_at(2_900 * MS), own);
    assert_eq!(channel_at(3_100 * MS), 33);
    assert_eq!(channel_at(8_500 * MS), own, "it has heard nothing for 5 s");
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_drone_with_an_old_radio_firmware_stays_on_the_ground_and_says_why() {
    let went = head(BOARD, "2021.06 (CF21)", None);
    assert_eq!(went.take_offs, 0);
    assert!(went.log.contains("hardware: RadioFirmware"), "{}", went.log);
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_board_that_is_no_crazyflie_2_1_stays_on_the_ground_and_says_why() {
    for name in ["0;CB10", "0;C21B", ""] {
        let went = head(name, VERSION, None);
        assert_eq!(went.take_offs, 0, "{name}");
        assert!(went.log.contains("hardware: Board"), "{name}: {}", went.log);
    }
}
