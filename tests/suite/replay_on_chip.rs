//! A replay on a chip: on one that is played here, and on the firmware's ELF.
//!
//! The tests with the ELF run the file that `cargo fw` makes, or the one that `UCHAIN_ELF` names:
//! `cargo test --test suite replay_on_chip -- --ignored`.

use std::fs;
use std::path::{Path, PathBuf};

use airlink::Sealed;
use onboard::Drone;
use onboard::replay::{
    Answer, Begin, NoStopwatch, Receiver, Refusal, Request, Session, Step, VERSION,
};
use sim_harness::bodies::emulated::Emulated;
use sim_harness::mission::Mission;
use sim_harness::replay::chip::emulated::EmulatedTarget;
use sim_harness::replay::chip::{
    ChipOptions, ChipSummary, Error, Link, Lost, Pace, Target, replay,
};
use sim_harness::scenario::Scenario;
use tunnel_nav::{Diagonals, Range};
use units::{Duration, Instant, Metres, MetresPerSecond, NodeId, Order, PolicyCode, Role};
use virtual_crazyflie::machine::Machine;
use virtual_crazyflie::rtt::ControlBlock;
use virtual_crazyflie::soc::{Board, Pin, PinOutput, ResetCause};

use crate::virtual_drones::firmware;

/// A log of two links: one grows weaker, the other stronger, with a gap in the middle.
fn log(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("replay-on-chip");
    fs::create_dir_all(&folder).unwrap();
    let mut text = String::from("time_s,link,rssi_dbm,velocity_mps\n");
    for n in (0..300).filter(|n| !(100..120).contains(n)) {
        let (time, noise) = (f64::from(n) / 5.0, n * 7 % 5);
        text += &format!("{time:.1},head,{},0.1\n", -45 - n / 10 + noise);
        text += &format!("{time:.1},base,{},-0.1\n", -75 + n / 10 - noise);
    }
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    file
}

/// A chip that is played on the host.
struct Played {
    session: Session,
    drone: Box<Drone<Sealed>>,
    receiver: Receiver,
    answers: Vec<u8>,
    clock: Instant,
    requests: u32,
    plays: fn(u32, Answer) -> Option<Answer>,
}

impl Played {
    fn new(plays: fn(u32, Answer) -> Option<Answer>) -> Self {
        Self {
            session: Session::new(),
            drone: Box::new(Drone::switched_off()),
            receiver: Receiver::new(),
            answers: Vec::new(),
            clock: Instant::ZERO,
            requests: 0,
            plays,
        }
    }
}

impl Target for Played {
    const NAME: &'static str = "played";

    fn write(&mut self, bytes: &[u8]) -> Result<usize, Lost> {
        // Little room, as in a ring.
        let bytes = bytes.get(..100).unwrap_or(bytes);
        for byte in bytes {
            let Some(request) = self.receiver.push(*byte, Request::parse) else { continue };
            let (number, request) = request.expect("the host sends whole requests");
            self.requests += 1;
            let answer = self.session.answer(&mut self.drone, &request, &NoStopwatch);
            if let Some(answer) = (self.plays)(self.requests, answer) {
                answer.send(number, |byte| self.answers.push(byte));
            }
        }
        Ok(bytes.len())
    }

    fn read(&mut self) -> Result<Vec<u8>, Lost> {
        if self.requests == 50 && (self.plays)(50, Answer::Begun).is_none() {
            return Err(Lost("the cable was pulled".into()));
        }
        Ok(std::mem::take(&mut self.answers))
    }

    fn run(&mut self, span: Duration) -> Result<(), Lost> {
        self.clock = self.clock + span;
        Ok(())
    }

    fn now(&self) -> Instant {
        self.clock
    }
}

fn played(name: &str, plays: fn(u32, Answer) -> Option<Answer>) -> Result<ChipSummary, Error> {
    let target = || Ok(Played::new(plays));
    replay(&[log(name)], &ChipOptions::default(), target, || {})
}

#[test]
fn a_chip_that_decides_what_the_host_decides_is_equal_in_every_step() {
    let summary = played("equal.csv", |_, answer| Some(answer)).unwrap();
    // 60 s at 5 Hz, but for the gap of 4 s, in which the drone is not stepped.
    assert_eq!((summary.steps, summary.equal), (280, 280));
    assert_eq!(summary.logs[0].first_difference, None);
    let states: Vec<_> =
        summary.logs[0].rows.iter().map(|row| row.chip.outputs.status.state.name()).collect();
    assert!(states.contains(&"relaying"), "{states:?}");
}

#[test]
fn a_single_bit_is_a_difference_and_the_first_one_is_told() {
    let summary = played("differs.csv", |request, answer| match answer {
        Answer::Stepped(mut stepped) if request > 40 => {
            let (_, estimate) = stepped.estimates.first_mut().unwrap();
            estimate.variance = f32::from_bits(estimate.variance.to_bits() ^ 1);
            Some(Answer::Stepped(stepped))
        }
        answer => Some(answer),
    });
    let summary = summary.unwrap();
    assert_eq!((summary.steps, summary.equal), (280, 39));
    let first = summary.logs[0].first_difference.as_ref().unwrap();
    assert_eq!((first.step, first.part), (40, "estimates"));
    assert_ne!(first.host, first.chip);
    assert!(!summary.is_equal());
}

#[test]
fn the_cycles_of_a_step_are_no_difference() {
    let summary = played("cycles.csv", |request, answer| match answer {
        Answer::Stepped(stepped) => {
            Some(Answer::Stepped(onboard::replay::Stepped { cycles: 1_000 + request, ..stepped }))
        }
        answer => Some(answer),
    });
    let summary = summary.unwrap();
    assert!(summary.is_equal());
    assert_eq!(summary.cycles_max, 1_281);
    assert_eq!(summary.cycles_mean, Some(1_141.5));
}

#[test]
fn a_chip_that_refuses_is_silent_or_goes_away_ends_the_replay_in_one_line() {
    let error = |name, plays| played(name, plays).unwrap_err();
    let refused = error("refused.csv", |_, _| Some(Answer::Refused(Refusal::NoDebugger)));
    assert!(matches!(refused, Error::Input(_)), "{refused}");
    assert_eq!(
        refused.to_string(),
        "the chip does not replay: it sees no debugger; attach a probe to the debug connector"
    );
    let silent = error("silent.csv", |_, _| None);
    assert!(matches!(silent, Error::Input(_)), "{silent}");
    assert!(silent.to_string().starts_with("the firmware on the chip does not answer"), "{silent}");
    let lost = error("lost.csv", |request, answer| (request < 50).then_some(answer));
    assert_eq!(
        lost,
        Error::Lost("the chip was lost in the middle of the replay: the cable was pulled".into())
    );
    let never = error("never-ready.csv", |_, _| Some(Answer::Refused(Refusal::NotReady)));
    assert!(never.to_string().contains("has not read its settings"), "{never}");
    let reset = error("reset.csv", |request, answer| match request {
        30 => Some(Answer::Refused(Refusal::NotBegun)),
        _ => Some(answer),
    });
    assert_eq!(reset, Error::Lost("the chip refused request 30: NotBegun".into()));
    assert_eq!(VERSION, 4);
}

#[test]
fn a_firmware_that_boots_is_waited_for() {
    let summary = played("boots.csv", |request, answer| match request {
        0..20 => Some(Answer::Refused(Refusal::NotReady)),
        _ => Some(answer),
    });
    assert!(summary.unwrap().is_equal());
}

/// A replay on the firmware's ELF.
fn on_elf(log: PathBuf, pace: Pace) -> ChipSummary {
    let options = ChipOptions { pace, ..ChipOptions::default() };
    replay(&[log], &options, || EmulatedTarget::new(firmware()), || {})
        .unwrap_or_else(|why| panic!("{why}"))
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn the_elf_decides_what_the_host_decides() {
    let summary = on_elf(log("elf.csv"), Pace::Fast);
    assert_eq!((summary.steps, summary.equal), (280, 280), "{summary}");
    // A tenth of the round of 200 ms, at 168 MHz.
    assert!((1_000..3_360_000).contains(&summary.cycles_max), "{}", summary.cycles_max);
}

fn recorded(log: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/rssi").join(log)
}

#[test]
#[ignore = "needs the firmware's ELF, and the recordings in ../shared/data"]
fn the_elf_decides_in_a_recorded_walk_and_a_recorded_flight_what_the_host_decides() {
    let walk = recorded("tetam_ble/trk/straight_01_all_sensors.mbd");
    let flight = recorded("uchain_flights/4drones_S_good_novideo.csv");
    for log in [walk, flight] {
        let summary = on_elf(log, Pace::Fast);
        assert!(summary.steps > 100 && summary.is_equal(), "{summary}");
    }
}

/// The motors' pins (crazyflie-firmware, `motors_def.c`).
const MOTORS: [Pin; 4] = [Pin::new('A', 1), Pin::new('B', 11), Pin::new('A', 15), Pin::new('B', 9)];

fn motors_stand<B: Board>(machine: &Machine<B>) -> bool {
    MOTORS.iter().all(|pin| machine.output(*pin) == PinOutput::Low)
}

const BEGIN: Begin = Begin {
    node: NodeId(1),
    role: Role::Relay,
    in_air: Some(Instant::ZERO),
    policy: PolicyCode::new(6).unwrap(),
    is_filtered: false,
    links: 2,
};

/// A round in which the drone flies.
fn flying(n: u64) -> Step {
    let wall = Range::At(Metres(1.0));
    Step {
        now: Instant::from_millis(200 * n),
        velocity: None,
        ranges: Diagonals { nw: wall, ne: wall, sw: wall, se: wall },
        height: Some(Metres(0.3)),
        order: Some(Order::explore(MetresPerSecond(0.3))),
        heard: [].into_iter().collect(),
        strengths: [].into_iter().collect(),
    }
}

/// A drone with keys, at its first boot, without a world around it.
fn provisioned() -> Machine<virtual_crazyflie::board::Crazyflie> {
    let scenario = Scenario::open("short-hop").unwrap();
    Emulated::new(&scenario, firmware(), NodeId(0), 1).into_machine()
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn without_a_debugger_the_firmware_refuses() {
    let mut link = Link::new(EmulatedTarget::of(provisioned()).unwrap()).unwrap();
    link.wait_until(Instant::from_millis(3_000)).unwrap();
    let why = link.begin(BEGIN).unwrap_err();
    assert!(why.to_string().contains("sees no debugger"), "{why}");
    // It goes on as if nothing had been asked.
    let _ = link.target_mut().machine_mut().board_mut().take_packets();
    link.wait_until(link.now() + Duration::from_secs(1)).unwrap();
    assert!(!link.target_mut().machine_mut().board_mut().take_packets().is_empty());
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_drone_that_replays_is_silent_and_its_motors_stand_until_the_next_reset() {
    let mut machine = provisioned();
    machine.cpu_mut().set_debugger(true);
    let mut link = Link::new(EmulatedTarget::of(machine).unwrap()).unwrap();
    link.wait_until(Instant::from_millis(3_000)).unwrap();
    assert!(!link.target_mut().machine_mut().board_mut().take_packets().is_empty(), "it speaks");
    assert_eq!(link.begin(BEGIN).unwrap(), Answer::Begun);
    link.wait_until(link.now() + Duration::from_millis(100)).unwrap();
    let _ = link.target_mut().machine_mut().board_mut().take_packets();
    let mut flown = 0;
    for n in 1..50 {
        let Answer::Stepped(stepped) = link.step(flying(n)).unwrap() else { panic!() };
        flown += usize::from(matches!(stepped.outputs.setpoint, units::Setpoint::Fly { .. }));
        link.wait_until(link.now() + Duration::from_millis(20)).unwrap();
        assert!(motors_stand(link.target_mut().machine()), "step {n}");
    }
    assert!(flown > 30, "{flown} set-points to fly");
    let machine = link.target_mut().machine_mut();
    assert!(machine.board_mut().take_packets().is_empty(), "a drone that replays is silent");
    assert_eq!(machine.reset_count(), 1, "no task fell silent");
    // After a reset it is the drone that it was.
    let now = machine.now();
    machine.reset(ResetCause::Pin);
    machine.run_until(now + 3_000_000_000).unwrap();
    assert!(!machine.board_mut().take_packets().is_empty(), "it speaks again");
}

/// Whether a motor of the head turns in the first ten seconds of a mission, in which the head is
/// ordered to explore at 4 s; `replays`: a replay has begun on it at 3 s.
fn a_motor_of_the_head_turns(replays: bool) -> bool {
    const STEP_US: u64 = 5_000;
    let scenario = Scenario::open("short-hop").unwrap();
    let world = scenario.world();
    let drones = [0, 1].map(|node| Emulated::new(&scenario, firmware(), NodeId(node), 1));
    let mut mission = Mission::emulated(&scenario, &world, 1, drones.into());
    mission.advance(3_000_000);
    if replays {
        let machine = mission.emulated_drone_mut(0).unwrap().machine_mut();
        machine.cpu_mut().set_debugger(true);
        let mut request = Vec::new();
        Request::Begin(BEGIN).send(1, |byte| request.push(byte));
        let block = ControlBlock::find(machine.memory()).expect("the RAM has one");
        let channel = block.down(machine.memory(), 0).unwrap();
        assert_eq!(channel.write(machine.memory_mut(), &request), request.len());
    }
    (0..7_000_000 / STEP_US).any(|_| {
        mission.advance(STEP_US);
        !motors_stand(mission.emulated_drone(0).unwrap().machine())
    })
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_drone_that_replays_does_not_take_off_by_the_order_of_the_base() {
    assert!(a_motor_of_the_head_turns(false), "without a replay it takes off");
    assert!(!a_motor_of_the_head_turns(true));
}
