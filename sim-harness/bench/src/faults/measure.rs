//! Measures how flights end after a fault: every sensor lost, frozen and lying, for 0.2 s, 2 s and
//! for good, and other faults ([`bodies::craft::faults`] defines each).
//!
//! Two places: *hover*, one drone over the middle of a room of 3 m by 3 m, with a set-point of rest
//! at 0.3 m; and *tunnel*, head and relay at work (scenario `relay-pair`), one of which, as the
//! seed decides, has the fault. The fault begins between 2 and 6 s after the beginning; the run
//! ends 14 s later, or when a landing that has begun by then is over. Machines that are not as the
//! flight code believes (they shake, they are too weak or too strong, their batteries are old) and
//! poor floors are so from the switching-on, in the tunnel for all drones.
//!
//! A run ends in one of three ways:
//!
//! * **survived**: it still flies under control, following its set-points: the flight code says
//!   that it is flying, it is within 30° of upright and between 0.1 m and 0.7 m high where it is to
//!   be at 0.3 m (a ranger that reads half makes 0.6 m of that, and nothing on board can tell); in
//!   the tunnel its agent is in the air as well.
//! * **landed safely**: it met the floor at less than [`SAFE_IMPACT`] and within 30° of upright, is
//!   upright on the floor with its motors off, and a cause is known: the flight code's, or the
//!   agent's where the agent ordered the landing.
//! * **uncontrolled**: everything else. There must be none.

use agent::State;
use flight::Mode;
use input::InputError;
use random::{Purpose, Stream};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use units::{Metres, MetresPerSecond, Point2, RadiansPerSecond, Setpoint};
use world::layout::Layout;
use world::{Tunnel, World};

use bodies::craft::faults::{Failing, Fault, Manner, Sensor};
use bodies::craft::{Craft, Surroundings};
use bodies::others::Others;
use mission::Mission;
use scenario::Ground;
use scenario::Scenario;
use scenario::VehicleSpec;

/// Faster than this on the floor is a crash, m/s: a fall from 11 cm, 37 mJ of 33 g. A number of
/// ours: less than the third of a metre from which drones of this size are dropped by hand without
/// harm, and three times the fastest descent that is ever asked for.
pub const SAFE_IMPACT: f32 = 1.5;
/// Cosine of the largest tilt of a drone under control, and of one that sets down: 30°.
const UPRIGHT: f32 = 0.866_025;
/// Height in the room, m: the agent's.
const HEIGHT: f32 = 0.3;
/// Between these a drone under control flies, m.
const HEIGHTS: std::ops::RangeInclusive<f32> = 0.1..=0.7;
/// A run lasts so long after the fault has begun, ms.
const AFTER_MS: u64 = 14_000;
/// A drone that is landing then is watched for so much longer, ms: a landing from 0.7 m at 0.3 m/s
/// takes 2.4 s.
const LANDING_MS: u64 = 4_000;
/// When a fault begins, ms.
const ONSET_MS: (u64, u64) = (2_000, 6_000);
/// The scenario of the tunnel.
pub const SCENARIO: &str = "relay-pair";
/// At most so many seeds of uncontrolled runs are listed.
const LISTED: usize = 5;

/// A radio chip that is reset is silent for so long, ms: the firmware notices it after a second
/// (`onboard::hardware`), and the chip takes half of one to boot.
const CHIP_RESET_MS: u64 = 1_500;
/// A radio chip that has lost its channel is told it again after so long, ms: when it has heard
/// nothing for 5 s (`onboard::hardware`), and within a report's 200 ms.
const SETTINGS_LOST_MS: u64 = 5_200;

/// The duration of a fault, ms.
const SPANS: [(u64, &str); 3] = [(200, "0.2 s"), (2_000, "2 s"), (u64::MAX, "for good")];

/// The place of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// One drone alone in a room.
    Hover,
    /// Head and relay of a chain in a tunnel.
    Tunnel,
}

impl Place {
    /// The name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hover => "hover",
            Self::Tunnel => "tunnel",
        }
    }
}

/// One row of the benchmark.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The name of the fault in the table.
    pub name: String,
    /// The place.
    pub place: Place,
    trouble: Trouble,
}

/// What is wrong in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trouble {
    /// Something fails in flight, for so many milliseconds.
    Fault(Fault, u64),
    /// The machine or the floor is not as the flight code believes, from the switching-on to the
    /// end.
    Machine(Machine),
}

/// A machine or a floor that is not as the flight code believes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Machine {
    vibration: f32,
    thrust: f32,
    motor_error: f32,
    yaw_torque: [f32; 2],
    battery_ohm: f32,
    charge: f32,
    flow_scale_error: f32,
    ground: Ground,
}

impl Machine {
    const USUAL: Self = Self {
        vibration: VehicleSpec::DEFAULT.vibration,
        thrust: VehicleSpec::DEFAULT.thrust,
        motor_error: VehicleSpec::DEFAULT.motor_error,
        yaw_torque: VehicleSpec::DEFAULT.yaw_torque,
        battery_ohm: VehicleSpec::DEFAULT.battery_ohm,
        charge: VehicleSpec::DEFAULT.charge,
        flow_scale_error: VehicleSpec::DEFAULT.flow_scale_error,
        ground: Ground::GOOD,
    };

    /// This machine with another vehicle's other constants.
    const fn vehicle(&self, rest: VehicleSpec) -> VehicleSpec {
        VehicleSpec {
            vibration: self.vibration,
            thrust: self.thrust,
            motor_error: self.motor_error,
            yaw_torque: self.yaw_torque,
            battery_ohm: self.battery_ohm,
            charge: self.charge,
            flow_scale_error: self.flow_scale_error,
            ..rest
        }
    }
}

/// The rows of machines and floors.
fn machines() -> Vec<(String, Trouble)> {
    let usual = Machine::USUAL;
    let mut all: Vec<(String, Machine)> = Vec::new();
    for vibration in [0.0, 0.1, 0.2, 0.3, 0.5] {
        all.push((format!("vibration of {vibration} g"), Machine { vibration, ..usual }));
    }
    for percent in [-30, -25, -10, 10, 25, 30_i16] {
        let thrust = 1.0 + 0.01 * f32::from(percent);
        all.push((format!("thrust {percent:+} %"), Machine { thrust, ..usual }));
    }
    all.push(("each motor ±15 %".into(), Machine { motor_error: 0.15, ..usual }));
    let torques = [
        ("measured yaw torque", VehicleSpec::MEASURED_YAW_TORQUE),
        ("largest yaw torque", [VehicleSpec::LARGEST_YAW_TORQUE; 2]),
    ];
    for (name, yaw_torque) in torques {
        all.push((name.into(), Machine { yaw_torque, ..usual }));
    }
    let poor = Machine { vibration: 0.3, motor_error: 0.1, ..usual };
    for (percent, thrust) in [(-25, 0.75), (25, 1.25)] {
        let name = format!("thrust {percent:+} %, each motor ±10 %, 0.3 g");
        all.push((name, Machine { thrust, ..poor }));
    }
    for battery_ohm in [0.1, 0.25, 0.35] {
        for (charge, is) in [(1.0, "full"), (0.5, "half full")] {
            let name = format!("battery of {battery_ohm} Ω, {is}");
            all.push((name, Machine { battery_ohm, charge, ..usual }));
        }
    }
    let ground = |light, texture| Machine { ground: Ground { light, texture }, ..usual };
    all.push(("dim light".into(), ground(0.1, 1.0)));
    all.push(("little texture".into(), ground(1.0, 0.35)));
    all.push(("flow gain off by 10 %".into(), Machine { flow_scale_error: 0.1, ..usual }));
    all.into_iter().map(|(name, machine)| (name, Trouble::Machine(machine))).collect()
}

impl Case {
    const fn machine(&self) -> Machine {
        match self.trouble {
            Trouble::Machine(machine) => machine,
            Trouble::Fault(..) => Machine::USUAL,
        }
    }
}

/// All rows.
#[must_use]
pub fn cases() -> Vec<Case> {
    let mut faults: Vec<(String, Trouble)> = Vec::new();
    for sensor in Sensor::ALL {
        for manner in Manner::ALL {
            for (lasts, span) in SPANS {
                let name = format!("{} {} {span}", sensor.name(), manner.name());
                faults.push((name, Trouble::Fault(Fault::Sensor(sensor, manner), lasts)));
            }
        }
    }
    let mut push = |name: String, fault, lasts| faults.push((name, Trouble::Fault(fault, lasts)));
    for (lasts, span) in SPANS {
        push(format!("dark floor {span}"), Fault::DarkGround, lasts);
        push(format!("radio silence {span}"), Fault::RadioSilence, lasts);
        push(format!("tick jitter {span}"), Fault::TickJitter, lasts);
    }
    push("radio chip reset".into(), Fault::RadioSilence, CHIP_RESET_MS);
    push("radio settings lost".into(), Fault::RadioSilence, SETTINGS_LOST_MS);
    let for_good = u64::MAX;
    push("motor at 70 %".into(), Fault::WeakMotor(0.7), for_good);
    push("battery at its end".into(), Fault::LowBattery(0.04), for_good);
    push("gust of 1 m/s for 2 s".into(), Fault::Gust(1.0), 2_000);
    faults.extend(machines());
    let at = |place| {
        let case = move |(name, trouble): &(String, Trouble)| Case {
            name: name.clone(),
            place,
            trouble: *trouble,
        };
        faults.iter().map(case)
    };
    at(Place::Hover).chain(at(Place::Tunnel)).collect()
}

/// How one run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Survived,
    LandedSafely,
    Uncontrolled,
}

/// The result of one run.
#[derive(Clone, Copy, Debug)]
struct Run {
    ending: Ending,
    /// The cause by the flight code, or by the agent.
    cause: &'static str,
    wall_contacts: u32,
    /// The speed at which the drone met the floor, m/s.
    impact: f32,
    tilt_deg: f32,
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The fault.
    pub fault: String,
    /// The place.
    pub place: Place,
    /// The number of runs.
    pub runs: usize,
    /// Runs in which the drone still flew under control at the end.
    pub survived: usize,
    /// Runs in which it landed safely, with a cause.
    pub landed_safely: usize,
    /// Runs of neither kind.
    pub uncontrolled: usize,
    /// Touches of a wall, in all runs.
    pub wall_contacts: u32,
    /// The hardest landing, m/s; `None` where there was none.
    pub max_impact_mps: f32,
    /// The largest tilt in the air since the run began, degrees.
    pub max_tilt_deg: f32,
    /// How the other runs ended, by cause.
    pub causes: Vec<(&'static str, usize)>,
    /// Seeds of uncontrolled runs, to fly them again.
    pub uncontrolled_seeds: Vec<u64>,
}

impl Row {
    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let causes: Map<_, _> =
            self.causes.iter().map(|(name, count)| ((*name).to_owned(), json!(count))).collect();
        json!({
            "fault": self.fault,
            "place": self.place.name(),
            "runs": self.runs,
            "survived": self.survived,
            "landed_safely": self.landed_safely,
            "uncontrolled": self.uncontrolled,
            "wall_contacts": self.wall_contacts,
            "max_impact_mps": (f64::from(self.max_impact_mps) * 1e3).round() / 1e3,
            "max_tilt_deg": (f64::from(self.max_tilt_deg) * 10.0).round() / 10.0,
            "causes": causes,
            "uncontrolled_seeds": self.uncontrolled_seeds,
        })
    }
}

/// The room and the tunnel, built once.
pub struct Places {
    room: Tunnel,
    vehicle: VehicleSpec,
    scenario: Scenario,
    world: World,
}

impl Places {
    /// Builds room and tunnel.
    ///
    /// # Errors
    /// None, as long as the built-in scenario is sound.
    pub fn new() -> Result<Self, InputError> {
        let scenario = Scenario::open(SCENARIO)?;
        let world = scenario.world();
        Ok(Self { room: room(), vehicle: VehicleSpec::DEFAULT, scenario, world })
    }

    /// Flies one case with `runs` seeds from `seed` on.
    #[must_use]
    pub fn run(&self, case: &Case, runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Row {
        let seeds = (0..runs as u64).into_par_iter().map(|n| seed.wrapping_add(n));
        let all: Vec<(u64, Run)> = seeds
            .map(|seed| {
                let run = match case.place {
                    Place::Hover => self.hover(case, seed),
                    Place::Tunnel => self.tunnel(case, seed),
                };
                after_each();
                (seed, run)
            })
            .collect();
        row(case, &all)
    }

    fn hover(&self, case: &Case, seed: u64) -> Run {
        let mut random = Stream::new(seed, Purpose::Fault(0));
        let machine = case.machine();
        let vehicle = machine.vehicle(self.vehicle);
        let around = Surroundings {
            tunnel: &self.room,
            ground: machine.ground,
            vehicle: &vehicle,
            others: Others::NONE,
        };
        let mut craft = Craft::standing(
            flight::FlightConfig::CRAZYFLIE_2_1,
            Point2::default(),
            [1.0, 0.0],
            &vehicle,
            Stream::new(seed, Purpose::Craft(0)),
        )
        .hovering(Metres(HEIGHT), around);
        let (from_ms, failing) = failing(case, &mut random);
        if let Some(failing) = failing {
            craft.sabotage(failing, &mut random);
        }
        let end_ms = from_ms + AFTER_MS;
        for now_ms in 0..end_ms + LANDING_MS {
            if now_ms >= end_ms && !is_landing(&craft) {
                break;
            }
            if now_ms.is_multiple_of(200) && !craft.is_silenced() {
                craft.command(stand_still());
            }
            craft.advance(around);
        }
        judge(&craft, None)
    }

    fn tunnel(&self, case: &Case, seed: u64) -> Run {
        let mut random = Stream::new(seed, Purpose::Fault(1));
        let victim = (random.uniform() * (self.scenario.drones.relays + 1) as f32) as usize;
        let machine = case.machine();
        let mut scenario = self.scenario.clone();
        (scenario.vehicle, scenario.ground) = (machine.vehicle(scenario.vehicle), machine.ground);
        let mut mission = Mission::new(&scenario, &self.world, seed);
        let (from_ms, failing) = failing(case, &mut random);
        if let Some(failing) = failing {
            mission.sabotage(victim, failing, &mut random);
        }
        let end_us = (from_ms + AFTER_MS) * 1_000;
        let craft = |mission: &Mission<'_>| mission.bodies().nth(victim)?.craft().cloned();
        while mission.time_us() < end_us
            || mission.time_us() < end_us + LANDING_MS * 1_000
                && craft(&mission).as_ref().is_some_and(is_landing)
        {
            mission.round();
        }
        let agent = mission.states().nth(victim);
        match craft(&mission).as_ref() {
            Some(craft) => judge(craft, agent),
            None => unreachable!("head and relays have crafts at flight level"),
        }
    }
}

/// Flies all cases that `wanted` picks.
///
/// # Errors
/// None, as long as the built-in scenario is sound.
pub fn run(
    runs: usize,
    seed: u64,
    wanted: impl Fn(&Case) -> bool,
    after_each: impl Fn() + Sync,
) -> Result<Vec<Row>, InputError> {
    let places = Places::new()?;
    let chosen = cases().into_iter().filter(wanted);
    Ok(chosen.map(|case| places.run(&case, runs, seed, &after_each)).collect())
}

/// A room of 3 m by 3 m around the origin.
fn room() -> Tunnel {
    let layout = Layout::corridor(&[[-0.05, 0.0], [0.05, 0.0]], 3.0);
    Tunnel::dig(&layout).expect("a room is a layout that can be built")
}

fn stand_still() -> Setpoint {
    Setpoint::Fly {
        forward: MetresPerSecond::ZERO,
        lateral: MetresPerSecond::ZERO,
        yaw_rate: RadiansPerSecond::ZERO,
        height: Metres(HEIGHT),
    }
}

/// Whether it is on its way to the floor: the flight code switches the motors off some centimetres
/// above it.
fn is_landing(craft: &Craft) -> bool {
    match craft.outputs().status.mode {
        Mode::Flying { .. } => false,
        Mode::Landing { .. } => true,
        Mode::Grounded { .. } | Mode::Landed { .. } | Mode::Stopped { .. } => {
            !craft.body().is_on_floor()
        }
    }
}

/// When the fault begins, and the fault, if there is one.
fn failing(case: &Case, random: &mut Stream) -> (u64, Option<Failing>) {
    let (first, last) = ONSET_MS;
    let from_ms = first + (random.uniform() * (last - first) as f32) as u64;
    let failing = match case.trouble {
        Trouble::Fault(fault, lasts_ms) => {
            Some(Failing { fault, from_ms, until_ms: from_ms.saturating_add(lasts_ms) })
        }
        Trouble::Machine(_) => None,
    };
    (from_ms, failing)
}

/// How a run ended. `agent` is the state of the drone's agent, if it had one.
fn judge(craft: &Craft, agent: Option<State>) -> Run {
    let (body, record, outputs) = (craft.body(), craft.record(), craft.outputs());
    let upright = body.uprightness() >= UPRIGHT;
    let flies = matches!(outputs.status.mode, Mode::Flying { .. })
        && record.is_airborne()
        && upright
        && HEIGHTS.contains(&body.height())
        && agent.is_none_or(|state| state.is_airborne());
    let gently =
        record.touchdown().is_some_and(|down| down.speed <= SAFE_IMPACT && down.upright >= UPRIGHT);
    let off = outputs.duties.0.iter().all(|duty| *duty == 0.0);
    let told = match agent {
        Some(State::Landing { .. } | State::Landed { .. }) => true,
        Some(_) | None => false,
    };
    let cause = match outputs.status.mode {
        Mode::Flying { .. } => "flying",
        Mode::Landing { .. } => "landing",
        Mode::Grounded { .. } => "told",
        Mode::Landed { why } => bodies::craft::record::End::Landed(why).name(),
        Mode::Stopped { why } => bodies::craft::record::End::Stopped(why).name(),
    };
    let named = match outputs.status.mode {
        Mode::Landed { .. } | Mode::Stopped { .. } => true,
        // When the flight code has landed, the agent orders the motors off, and the flight code
        // keeps the cause.
        Mode::Grounded { .. } => told,
        Mode::Flying { .. } | Mode::Landing { .. } => false,
    };
    let landed = gently && off && named && upright && body.is_on_floor();
    Run {
        ending: if flies {
            Ending::Survived
        } else if landed {
            Ending::LandedSafely
        } else {
            Ending::Uncontrolled
        },
        cause: last_end(craft).unwrap_or(cause),
        wall_contacts: craft.contacts(),
        impact: record.touchdown().map_or(0.0, |down| down.speed),
        tilt_deg: record.most_tilt_deg(),
    }
}

/// The cause of the flight code's last landing or stop of its own accord, if there was one.
fn last_end(craft: &Craft) -> Option<&'static str> {
    craft.record().ends().last().map(|end| end.name())
}

fn row(case: &Case, runs: &[(u64, Run)]) -> Row {
    let count = |ending| runs.iter().filter(|(_, run)| run.ending == ending).count();
    let mut causes: Vec<(&'static str, usize)> = Vec::new();
    for (_, run) in runs.iter().filter(|(_, run)| run.ending != Ending::Survived) {
        match causes.iter_mut().find(|(name, _)| *name == run.cause) {
            Some((_, count)) => *count += 1,
            None => causes.push((run.cause, 1)),
        }
    }
    causes.sort_by_key(|(name, count)| (std::cmp::Reverse(*count), *name));
    let most = |of: fn(&Run) -> f32| runs.iter().map(|(_, run)| of(run)).fold(0.0, f32::max);
    Row {
        fault: case.name.clone(),
        place: case.place,
        runs: runs.len(),
        survived: count(Ending::Survived),
        landed_safely: count(Ending::LandedSafely),
        uncontrolled: count(Ending::Uncontrolled),
        wall_contacts: runs.iter().map(|(_, run)| run.wall_contacts).sum(),
        max_impact_mps: most(|run| run.impact),
        max_tilt_deg: most(|run| run.tilt_deg),
        causes,
        uncontrolled_seeds: runs
            .iter()
            .filter(|(_, run)| run.ending == Ending::Uncontrolled)
            .map(|(seed, _)| *seed)
            .take(LISTED)
            .collect(),
    }
}
