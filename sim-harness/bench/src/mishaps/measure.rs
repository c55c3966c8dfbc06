//! Measures how a flight of the firmware ends when its chip, its buses or its own code fail: the
//! ELF, in an emulator, in flight.
//!
//! The rows of [`faults`](crate::faults) are wrong readings and weak motors; these are failures of
//! the firmware's surroundings: hung buses, devices that do not answer, a supply that dips, a
//! memory with other bytes in it, noise on the line to the radio chip, code that gets stuck.
//!
//! Each flight must end in one of four ways ([`Ending`]), in none of which the motors turn while no
//! code controls them.

use std::path::Path;
use world::World;

use flight::Mode;
use input::InputError;
use rayon::prelude::*;
use sensors::multi_ranger::Beam;
use units::NodeId;
use virtual_crazyflie::board::{Device, Fault, Shares};
use virtual_crazyflie::bus::Width;
use virtual_crazyflie::machine::Pause;
use virtual_crazyflie::memory::map;
use virtual_crazyflie::soc::{I2cBus, ResetCause};

use bodies::craft::Craft;
use bodies::emulated::{CONTROL_STEP, Emulated, Firmware};
use mission::Mission;
use scenario::Scenario;

/// The scenario that is flown.
pub const SCENARIO: &str = "short-hop";
/// The drone that suffers the mishap: the head.
const VICTIM: NodeId = NodeId(0);
/// The moment of the mishap: the head flies, and its relay waits.
const STRIKES_US: u64 = 9_000_000;
/// The time for which the drone is then watched.
const WATCHED_US: u64 = 9_000_000;
/// The longest that motors may turn while no code drives them.
pub const MOTORS_AIM_MS: u64 = 500;
/// A body that came down faster than this on its feet fell (see [`faults`](crate::faults)).
const SAFE_IMPACT: f32 = 1.0;
/// Cosine of the largest tilt of one that stands or flies as it should.
const UPRIGHT: f32 = 0.9;
/// Lower than this it is no flight, m; and higher than this it was none that was asked for.
const HEIGHTS: std::ops::RangeInclusive<f32> = 0.1..=0.8;
/// Durations, in µs.
const SHORT_US: u64 = 100_000;
const LONG_US: u64 = 2_000_000;

/// The ending of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The drone never took off.
    Grounded,
    /// The drone flies on, as ordered.
    FliesOn,
    /// The drone landed on its feet, and stands with its motors off.
    Landed,
    /// The motors were switched off in the air, within [`MOTORS_AIM_MS`], and stay off.
    CutOff,
    /// Any other ending.
    Uncontrolled,
}

impl Ending {
    /// The name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grounded => "grounded",
            Self::FliesOn => "flies on",
            Self::Landed => "landed",
            Self::CutOff => "motors cut off",
            Self::Uncontrolled => "uncontrolled",
        }
    }
}

/// One row.
#[derive(Clone, Debug)]
pub struct Row {
    /// The name of the mishap.
    pub name: String,
    /// The ending.
    pub ending: Ending,
    /// The time from the mishap until all motors were off, in ms; `None` for a drone whose motors
    /// still turn, or never did.
    pub motors_off_ms: Option<u64>,
    /// The speed at which the drone met the floor, m/s.
    pub impact_mps: f32,
    /// The number of resets, and the cause of the first.
    pub resets: usize,
    /// See [`resets`](Self::resets).
    pub cause: Option<ResetCause>,
    /// The state of the agent at the end.
    pub state: &'static str,
}

/// A mishap.
enum Mishap {
    /// A fault of the board, for a time.
    Board(Vec<Fault>, u64),
    /// A fault of the board from before it is switched on.
    Before(Vec<Fault>),
    /// The supply dips.
    BrownOut,
    /// The core runs in an endless loop from the next step of the control loop on, above all tasks
    /// of the thread.
    ControlStuck,
    /// The core runs in an endless loop from the next moment on at which a task of the thread runs.
    ThreadStuck,
    /// The core executes an undefined instruction.
    Undefined,
    /// The stack has reached its end, which is that of the RAM.
    StackFull,
}

fn cases() -> Vec<(String, Mishap)> {
    let mut cases = Vec::new();
    let mut add = |name: &str, mishap| cases.push((name.to_owned(), mishap));
    let spans = [("for 0.1 s", SHORT_US), ("for 2 s", LONG_US), ("for good", WATCHED_US)];
    let buses = [("inertial sensor's bus", I2cBus::I2c3), ("decks' bus", I2cBus::I2c1)];
    for (whose, bus) in buses {
        let held = |clocks| vec![Fault::SdaHeld { bus, clocks }];
        add(
            &format!("{whose}: data line held, nine clocks free it"),
            Mishap::Board(held(Some(9)), WATCHED_US),
        );
        for (how_long, us) in spans {
            let name = format!("{whose}: data line held {how_long}");
            add(&name, Mishap::Board(held(None), us));
            let name = format!("{whose}: clock line held {how_long}");
            add(&name, Mishap::Board(vec![Fault::SclHeld(bus)], us));
        }
    }
    let devices = [
        ("gyroscope", Device::Gyro),
        ("accelerometer", Device::Accel),
        ("optic flow", Device::Flow),
        ("down ranger", Device::Ranger(Beam::Down)),
        ("front ranger", Device::Ranger(Beam::Front)),
        ("expander", Device::Expander),
        ("EEPROM", Device::Eeprom),
    ];
    for (whose, device) in devices {
        add(
            &format!("{whose}: every 7th byte refused for 2 s"),
            Mishap::Board(vec![Fault::NackEvery(device, 7)], LONG_US),
        );
        for (how_long, us) in spans {
            let name = format!("{whose}: answers nothing {how_long}");
            add(&name, Mishap::Board(vec![Fault::Silent(device)], us));
        }
        add(
            &format!("{whose}: without supply for 0.1 s"),
            Mishap::Board(vec![Fault::Unpowered(device)], SHORT_US),
        );
    }
    add(
        "gyroscope: never says that it is ready",
        Mishap::Board(vec![Fault::DataReadyMissing], WATCHED_US),
    );
    add("inertial sensor: frozen", Mishap::Board(vec![Fault::ImuFrozen], WATCHED_US));
    let noise = |share| {
        let shares = Shares { flipped: share, noisy: share, broken: share, lost: share };
        vec![Fault::Noise { shares, seed: 1 }]
    };
    add("radio line: one byte in 1000 disturbed", Mishap::Board(noise(250), WATCHED_US));
    add("radio line: one byte in 20 disturbed", Mishap::Board(noise(12_500), WATCHED_US));
    add("radio line: every second byte disturbed", Mishap::Board(noise(125_000), WATCHED_US));
    add("radio chip: reset", Mishap::Board(vec![Fault::RadioReset], SHORT_US));
    add("radio chip: takes nothing for 2 s", Mishap::Board(vec![Fault::FlowControlStuck], LONG_US));
    add(
        "radio chip: takes nothing any more",
        Mishap::Board(vec![Fault::FlowControlStuck], WATCHED_US),
    );
    add(
        "radio chip: sends others' old packets for 2 s",
        Mishap::Board(vec![Fault::RadioGhost], LONG_US),
    );
    let bytes = |byte, count| Fault::EepromBytes { at: 0x200, bytes: vec![byte; count] };
    add("EEPROM: overwritten in flight", Mishap::Board(vec![bytes(0x55, 0x200)], SHORT_US));
    add("EEPROM: other bytes in it at boot", Mishap::Before(vec![bytes(0xA5, 0x200)]));
    add("EEPROM: reads as zeros at boot", Mishap::Before(vec![Fault::Reads(Device::Eeprom, 0)]));
    add("EEPROM: answers nothing at boot", Mishap::Before(vec![Fault::Silent(Device::Eeprom)]));
    add("brown-out", Mishap::BrownOut);
    add("control loop stuck", Mishap::ControlStuck);
    add("a task of the thread stuck", Mishap::ThreadStuck);
    add("undefined instruction", Mishap::Undefined);
    add("stack overflow", Mishap::StackFull);
    cases
}

/// Flies every mishap, one in each flight.
///
/// # Errors
/// When there is no ELF to fly, or it does what the emulator does not know.
pub fn run(
    elf: &Path,
    seed: u64,
    wanted: impl Fn(&str) -> bool,
    after_each: impl Fn() + Sync,
) -> Result<Vec<Row>, InputError> {
    let firmware = Firmware::open(elf)?;
    let scenario = Scenario::open(SCENARIO)?;
    let world = scenario.world();
    let chosen: Vec<_> = cases().into_iter().filter(|(name, _)| wanted(name)).collect();
    chosen
        .into_par_iter()
        .map(|(name, mishap)| {
            let row = fly(&firmware, &scenario, &world, seed, name, mishap);
            after_each();
            row
        })
        .collect()
}

/// The number of rows with these names.
pub fn count(wanted: impl Fn(&str) -> bool) -> usize {
    cases().iter().filter(|(name, _)| wanted(name)).count()
}

fn fly(
    firmware: &Firmware,
    scenario: &Scenario,
    world: &World,
    seed: u64,
    name: String,
    mishap: Mishap,
) -> Result<Row, InputError> {
    let mut drone = Emulated::new(scenario, firmware, VICTIM, seed);
    if let Mishap::Before(faults) = &mishap {
        for fault in faults {
            drone.machine_mut().board_mut().inject(fault.clone(), 0, u64::MAX);
        }
    }
    let mut mission = Mission::emulated(scenario, world, seed, vec![drone]);
    mission.advance(STRIKES_US);
    let flew = craft(&mission).record().take_offs() > 0;
    let landed_before = craft(&mission).record().touchdown();
    if let Some(drone) = mission.emulated_drone_mut(0) {
        strike(drone, mishap)
            .map_err(|why| InputError::new(why, "the emulator has to learn it"))?;
    }
    let mut off_at = None;
    for ms in 1..=WATCHED_US / 1_000 {
        mission.advance(1_000);
        let off = craft(&mission).outputs().duties.0.iter().all(|duty| *duty == 0.0);
        off_at = if off { off_at.or(Some(ms)) } else { None };
    }
    if let Some(halted) = mission.halted() {
        let remedy = "the emulator has to learn it";
        return Err(InputError::new(format!("{name}: {halted}"), remedy));
    }
    let touched = craft(&mission).record().touchdown() != landed_before;
    Ok(judge(&mission, name, flew, off_at, touched))
}

fn craft<'m>(mission: &'m Mission<'_>) -> &'m Craft {
    let head = mission.bodies().next().and_then(|body| body.craft());
    head.expect("the head of a mission at flight level has a craft")
}

/// Makes the mishap happen.
fn strike(drone: &mut Emulated, mishap: Mishap) -> Result<(), String> {
    let machine = drone.machine_mut();
    let now = machine.now();
    match mishap {
        Mishap::Before(_) => {}
        Mishap::Board(faults, us) => {
            for fault in faults {
                machine.board_mut().inject(fault, now, now + us * 1_000);
            }
        }
        Mishap::BrownOut => machine.reset(ResetCause::BrownOut),
        Mishap::ControlStuck => {
            let step = machine.image().find(CONTROL_STEP).ok_or("no control step")?.address;
            run_to(drone, Some(step))?;
            go_to(drone, 0xE7FE)?;
        }
        Mishap::ThreadStuck => {
            run_to(drone, None)?;
            go_to(drone, 0xE7FE)?;
        }
        Mishap::Undefined => {
            run_to(drone, None)?;
            go_to(drone, 0xDE00)?;
        }
        Mishap::StackFull => {
            run_to(drone, None)?;
            drone.machine_mut().cpu_mut().set_register(13, map::RAM + 8);
        }
    }
    Ok(())
}

/// Runs up to this instruction, or to any instruction of a task of the thread.
fn run_to(drone: &mut Emulated, address: Option<u32>) -> Result<(), String> {
    /// A bound far longer than a round of any task.
    const LONGEST_NS: u64 = 1_000_000_000;
    let machine = drone.machine_mut();
    let until = machine.now() + LONGEST_NS;
    while machine.now() < until {
        let paused = match address {
            Some(address) => {
                machine.program_mut().trap(address);
                let paused = machine.advance_to(until);
                machine.program_mut().untrap(address);
                paused
            }
            None => machine.step(until),
        };
        let arrived = match (paused.map_err(|halt| halt.to_string())?, address) {
            (Pause::Trap, Some(_)) => true,
            (_, None) => machine.cpu().xpsr() & 0x1FF == 0,
            _ => false,
        };
        if arrived {
            return Ok(());
        }
    }
    Err("the core never comes there".into())
}

/// Puts the core at an instruction of these bits, in the last word of the RAM, which is not used.
fn go_to(drone: &mut Emulated, bits: u32) -> Result<(), String> {
    const PLACE: u32 = map::RAM + map::RAM_SIZE - 4;
    let machine = drone.machine_mut();
    if !machine.memory_mut().store(PLACE, Width::Half, bits) {
        return Err("there is no RAM".into());
    }
    machine.cpu_mut().set_register(15, PLACE);
    Ok(())
}

fn judge(
    mission: &Mission<'_>,
    name: String,
    flew: bool,
    off_at: Option<u64>,
    touched: bool,
) -> Row {
    let (craft, state) = (craft(mission), mission.states().next());
    let (body, record) = (craft.body(), craft.record());
    let upright = body.uprightness() >= UPRIGHT;
    let mode = craft.outputs().status.mode;
    let down = body.is_on_floor();
    let gently = record.touchdown().is_some_and(|t| t.speed <= SAFE_IMPACT && t.upright >= UPRIGHT);
    let ending = match off_at {
        Some(_) if !flew => Ending::Grounded,
        Some(_) if down && gently && upright => Ending::Landed,
        Some(ms) if down && ms <= MOTORS_AIM_MS => Ending::CutOff,
        // A drone that fell and took off again, because the order to explore still stood, counts as
        // uncontrolled.
        None if !touched
            && matches!(mode, Mode::Flying { .. })
            && upright
            && HEIGHTS.contains(&body.height())
            && state.is_some_and(|state| state.is_airborne()) =>
        {
            Ending::FliesOn
        }
        _ => Ending::Uncontrolled,
    };
    let resets = mission.emulated_drone(0).map_or(&[][..], |drone| drone.machine().resets());
    Row {
        name,
        ending,
        motors_off_ms: off_at.filter(|_| flew),
        impact_mps: record.touchdown().map_or(0.0, |touchdown| touchdown.speed),
        resets: resets.len().saturating_sub(1),
        cause: resets.get(1).map(|reset| reset.cause),
        state: state.map_or("gone", |state| state.name()),
    }
}
