//! Defines the table of parameters: their names, their types, and how each is read and set.
//!
//! cfclient reads and sets parameters of its own accord, and prints a traceback for each that is
//! missing (cfclient 2026.8.1, `ui/tabs`). cflib raises a `KeyError`, which ends a script
//! (cflib 0.1.34, `positioning/motion_commander.py`, `utils/reset_estimator.py`, and its examples).
//! So the table has a row for each of them, also where nothing can be set: such a row refuses every
//! value but the one that it has.

use agent::AgentConfig;
use flight::ControlConfig as Control;
use storage::settings::Limits;
use units::{Branch, Dbm, Metres, MetresPerSecond, PolicyCode, Role};
use wire::crtp::{LogType, ParamType, Value};

use crate::parameters::{OperatorTask, Parameters};
use crate::table::{Documented, Get, crc_of_row};

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterId(u16);

impl ParameterId {
    /// The parameter `uchain.task`.
    pub const TASK: Self = Self::of("uchain", "task");
    /// The parameter `uchain.speed`.
    pub const SPEED: Self = Self::of("uchain", "speed");
    /// The parameter `uchain.branch`.
    pub const BRANCH: Self = Self::of("uchain", "branch");
    /// The parameter `uchain.height`.
    pub const HEIGHT: Self = Self::of("uchain", "height");
    /// The parameter `uchain.launchLimit`.
    pub const LAUNCH_LIMIT: Self = Self::of("uchain", "launchLimit");
    /// The parameter `uchain.retreatLimit`.
    pub const RETREAT_LIMIT: Self = Self::of("uchain", "retreatLimit");
    /// The parameter `uchain.policy`.
    pub const POLICY: Self = Self::of("uchain", "policy");
    /// The parameter `kalman.resetEstimation`.
    pub(crate) const RESET_ESTIMATION: Self = Self::of("kalman", "resetEstimation");

    pub(crate) const fn new(row: u16) -> Self {
        Self(row)
    }

    /// The parameter's row in the table.
    #[must_use]
    pub const fn row(self) -> u16 {
        self.0
    }

    /// The row of a name. A wrong name does not compile.
    const fn of(group: &str, name: &str) -> Self {
        let mut id = 0;
        while !(same(TABLE[id].group, group) && same(TABLE[id].name, name)) {
            id += 1;
        }
        Self(id as u16)
    }
}

const fn same(a: &str, b: &str) -> bool {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    while let ([x, rest_a @ ..], [y, rest_b @ ..]) = (a, b) {
        if *x != *y {
            return false;
        }
        (a, b) = (rest_a, rest_b);
    }
    a.is_empty() && b.is_empty()
}

/// A parameter.
pub(crate) struct Parameter {
    pub(crate) group: &'static str,
    pub(crate) name: &'static str,
    get: Get<Parameters>,
    /// Sets the value; `None` where the parameter is read-only.
    set: Option<Set>,
}

/// Changes a parameter to a value of its own type, unless that is out of its range.
type Set = fn(&mut Parameters, Value) -> bool;

impl Parameter {
    pub(crate) const fn kind(&self) -> ParamType {
        match self.get.kind() {
            LogType::U8 => ParamType::U8,
            LogType::U16 => ParamType::U16,
            LogType::U32 => ParamType::U32,
            LogType::I8 => ParamType::I8,
            LogType::I16 => ParamType::I16,
            LogType::I32 => ParamType::I32,
            LogType::F32 | LogType::F16 => ParamType::F32,
        }
    }

    pub(crate) const fn is_read_only(&self) -> bool {
        self.set.is_none()
    }

    pub(crate) fn value(&self, of: &Parameters) -> Value {
        self.get.value(of)
    }

    /// Whether the parameter now has the value. Not inlined, for the same reason as [`Get::value`].
    #[inline(never)]
    pub(crate) fn set(&self, of: &mut Parameters, value: Value) -> bool {
        self.set.is_some_and(|set| self.value(of) == value || set(of, value))
    }
}

/// The parameter in a row.
pub(crate) fn row(id: u16) -> Option<&'static Parameter> {
    TABLE.get(usize::from(id))
}

/// The parameter of a name, and its row.
pub(crate) fn named(group: &[u8], name: &[u8]) -> Option<(ParameterId, &'static Parameter)> {
    (0..)
        .map(ParameterId)
        .zip(&TABLE)
        .find(|(_, row)| row.group.as_bytes() == group && row.name.as_bytes() == name)
}

/// Rows.
pub(crate) const COUNT: u16 = TABLE.len() as u16;

/// Changes whenever the table does.
pub(crate) const CRC: u32 = {
    let mut rows: &[Parameter] = &TABLE;
    let mut crc = 0;
    while let [row, rest @ ..] = rows {
        let kind = row.kind() as u8 | if row.is_read_only() { 0x40 } else { 0 };
        crc = crc_of_row(crc, kind, row.group, row.name);
        rows = rest;
    }
    crc
};

/// Returns all parameters as rows of the book's table.
pub fn parameters() -> impl Iterator<Item = Documented> {
    TABLE.iter().zip(NOTES).map(|(row, (unit, meaning))| Documented {
        group: row.group,
        name: row.name,
        kind: row.kind().name(),
        access: if row.is_read_only() { "ro" } else { "rw" },
        unit,
        meaning,
    })
}

/// Within `least` and `most`, and a number.
const fn within(x: f32, least: f32, most: f32) -> bool {
    x >= least && x <= most
}

/// Refuses every value but the one that the parameter has.
const fn inert(_: &mut Parameters, _: Value) -> bool {
    false
}

/// Rows of `name: type "unit" "meaning" => getter [, setter];` by groups, split into the table and
/// the texts for the book, which are not linked into a firmware.
macro_rules! table {
    ($($group:literal {
        $($name:literal: $kind:ident $unit:literal $meaning:literal => $get:expr $(, $set:expr)?;)*
    })*) => {
        static TABLE: [Parameter; [$($($name),*),*].len()] = [
            $($(Parameter {
                group: $group,
                name: $name,
                get: Get::$kind($get),
                set: table!(@set $($set)?),
            }),*),*
        ];
        static NOTES: [(&str, &str); TABLE.len()] = [$($(($unit, $meaning)),*),*];
    };
    (@set) => { None };
    (@set $set:expr) => { Some($set) };
}

table! {
    "uchain" {
        "task": U8 "" "what the operator orders: 0 wait, 1 explore, 2 return, 3 land, 4 stop, 5 perch"
            => |p| p.task as u8, set_task;
        "speed": F32 "m/s" "at which the head explores, −0.4 to 0.4; negative is back"
            => |p| p.speed.0, set_speed;
        "branch": U8 "" "which way the head takes at the junctions that it comes to: 0 not chosen, 1 left, 2 right, 3 straight"
            => |p| Branch::code(p.branch), set_branch;
        "height": F32 "m" "at which this drone flies from its next boot on, 0.2 to 1; in the simulator the scenario's is flown"
            => |p| p.height.0, set_height;
        "launchLimit": F32 "dBm" "a last link weaker than this calls for the next relay, −96 to −20, at least 1 dB above retreatLimit; from the next boot on; in the simulator the scenario's holds"
            => |p| p.launch_limit.0, set_launch_limit;
        "retreatLimit": F32 "dBm" "a back link weaker than this sends this drone back; likewise"
            => |p| p.retreat_limit.0, set_retreat_limit;
        "policy": U8 "" "movement policy that this drone flies: 1 t0, 2 t5, 3 k, 4 authors, 5 k-tuned, 6 chain; 0 for one without a code; it can be set on the ground only"
            => |p| p.policy.map_or(0, PolicyCode::get), set_policy;
        "node": U8 "" "its place in the chain: 0 head, 1 to 15" => |p| p.about.node.0;
        "role": U8 "" "its part in the chain: 0 head, 1 relay, 2 base" => |p| role_code(p.about.role);
    }
    "deck" {
        "bcFlow2": U8 "" "1 when there is a Flow deck v2, and at a base that takes orders: cfclient asks for it before it offers to fly"
            => |p| (p.about.has_flow || p.about.takes_orders).into();
        "bcMultiranger": U8 "" "1 when there is a Multi-ranger deck"
            => |p| p.about.has_rangers.into();
        "bcFlow": U8 "" "0: there is no Flow deck v1" => |_| 0;
        "bcZRanger": U8 "" "0: there is no Z-ranger deck" => |_| 0;
        "bcZRanger2": U8 "" "0: there is no Z-ranger deck v2" => |_| 0;
        "bcLighthouse4": U8 "" "0: there is no Lighthouse deck" => |_| 0;
        "bcLoco": U8 "" "0: there is no Loco deck" => |_| 0;
        "bcDWM1000": U8 "" "0: there is no Loco deck" => |_| 0;
    }
    "firmware" {
        "revision0": U32 "" "the first 32 bits of the firmware's revision"
            => |p| (p.about.revision >> 16) as u32;
        "revision1": U16 "" "the next 16 bits" => |p| p.about.revision as u16;
        "modified": U8 "" "1 when it was built of something else than that"
            => |p| p.about.is_modified.into();
        "radio": U32 "" "the release of the radio chip's firmware by year and month, 202502 for 2025.02; 0 where it is unknown, or no release of the vendor's"
            => |p| p.about.radio.map_or(0, |of| 100 * u32::from(of.year) + u32::from(of.month));
    }
    "cpu" {
        "flash": U16 "KB" "the processor's flash" => |p| p.about.flash;
        "id0": U32 "" "the processor's number" => |p| p.about.unique[0];
        "id1": U32 "" "the processor's number" => |p| p.about.unique[1];
        "id2": U32 "" "the processor's number" => |p| p.about.unique[2];
    }
    "system" {
        "selftestPassed": I8 "" "1 when everything was there at boot"
            => |p| p.about.selftest_passed.into();
        "taskDump": U8 "" "0, and nothing else: no list of tasks" => |_| 0, inert;
        "storageStats": U8 "" "0, and nothing else: no account of the memory" => |_| 0, inert;
    }
    "kalman" {
        "resetEstimation": U8 "" "1 has a drone on the ground forget the position that it knows from outside; in the air it is refused. It reads 0"
            => |_| 0, inert;
        "initialX": F32 "m" "0, and nothing else: the first position from outside counts"
            => |_| 0.0, inert;
        "initialY": F32 "m" "likewise" => |_| 0.0, inert;
        "initialZ": F32 "m" "likewise" => |_| 0.0, inert;
        "initialYaw": F32 "rad" "0, and nothing else: a drone is put down with the board's x along the room's"
            => |_| 0.0, inert;
    }
    "stabilizer" {
        "estimator": U8 "" "2, a Kalman filter, and nothing else" => |_| 2, inert;
        "controller": U8 "" "1, PID, and nothing else" => |_| 1, inert;
    }
    "locSrv" {
        "extPosStdDev": F32 "m" "how well positions from outside are known" => |_| 0.01, inert;
        "extQuatStdDev": F32 "" "how well headings from outside are known, as a quaternion"
            => |_| 0.0045, inert;
    }
    "led" {
        "bitmask": U8 "" "0, and nothing else: the drone sets its lights itself" => |_| 0, inert;
    }
    "imu_sensors" {
        "BMP3XX": U8 "" "0: the barometer is not used" => |_| 0;
    }
    "commander" {
        "enHighLevel": U8 "" "1, and nothing else; cfclient sets it before a take-off"
            => |_| 1, inert;
    }
    "flightmode" {
        "althold": U8 "" "0, and nothing else; cfclient has a button for it" => |_| 0, inert;
    }
    "health" {
        "startPropTest": U8 "" "0, and nothing else: no test of the propellers" => |_| 0, inert;
        "startBatTest": U8 "" "0, and nothing else: no test of the battery" => |_| 0, inert;
    }
    "pid_rate" {
        "roll_kp": F32 "" "roll rate: proportional gain" => |_| Control::TILT_RATE[0], inert;
        "roll_ki": F32 "" "roll rate: integral gain" => |_| Control::TILT_RATE[1], inert;
        "roll_kd": F32 "" "roll rate: derivative gain" => |_| Control::TILT_RATE[2], inert;
        "pitch_kp": F32 "" "pitch rate: proportional gain" => |_| Control::TILT_RATE[0], inert;
        "pitch_ki": F32 "" "pitch rate: integral gain" => |_| Control::TILT_RATE[1], inert;
        "pitch_kd": F32 "" "pitch rate: derivative gain" => |_| Control::TILT_RATE[2], inert;
        "yaw_kp": F32 "" "yaw rate: proportional gain" => |_| Control::YAW_RATE[0], inert;
        "yaw_ki": F32 "" "yaw rate: integral gain" => |_| Control::YAW_RATE[1], inert;
        "yaw_kd": F32 "" "yaw rate: derivative gain" => |_| Control::YAW_RATE[2], inert;
    }
    "pid_attitude" {
        "roll_kp": F32 "" "roll: proportional gain" => |_| Control::TILT[0], inert;
        "roll_ki": F32 "" "roll: integral gain" => |_| Control::TILT[1], inert;
        "roll_kd": F32 "" "roll: derivative gain" => |_| Control::TILT[2], inert;
        "pitch_kp": F32 "" "pitch: proportional gain" => |_| Control::TILT[0], inert;
        "pitch_ki": F32 "" "pitch: integral gain" => |_| Control::TILT[1], inert;
        "pitch_kd": F32 "" "pitch: derivative gain" => |_| Control::TILT[2], inert;
        "yaw_kp": F32 "" "yaw: proportional gain" => |_| Control::YAW[0], inert;
        "yaw_ki": F32 "" "yaw: integral gain" => |_| Control::YAW[1], inert;
        "yaw_kd": F32 "" "yaw: derivative gain" => |_| Control::YAW[2], inert;
    }
    "posCtlPid" {
        "xKp": F32 "" "place along x: proportional gain" => |_| Control::DEFAULT.way, inert;
        "xKi": F32 "" "place along x: integral gain" => |_| 0.0, inert;
        "xKd": F32 "" "place along x: derivative gain" => |_| 0.0, inert;
        "yKp": F32 "" "place along y: proportional gain" => |_| Control::DEFAULT.way, inert;
        "yKi": F32 "" "place along y: integral gain" => |_| 0.0, inert;
        "yKd": F32 "" "place along y: derivative gain" => |_| 0.0, inert;
        "zKp": F32 "" "height: proportional gain" => |_| Control::HEIGHT[0], inert;
        "zKi": F32 "" "height: integral gain" => |_| Control::HEIGHT[1], inert;
        "zKd": F32 "" "height: derivative gain" => |_| Control::HEIGHT[2], inert;
        "thrustBase": U16 "" "0: the airframe's weight takes its place" => |_| 0, inert;
    }
    "velCtlPid" {
        "vxKp": F32 "" "velocity along x: proportional gain" => |_| Control::VELOCITY[0], inert;
        "vxKi": F32 "" "velocity along x: integral gain" => |_| Control::VELOCITY[1], inert;
        "vxKd": F32 "" "velocity along x: derivative gain" => |_| Control::VELOCITY[2], inert;
        "vxKFF": F32 "" "0: no feed-forward" => |_| 0.0, inert;
        "vyKp": F32 "" "velocity along y: proportional gain" => |_| Control::VELOCITY[0], inert;
        "vyKi": F32 "" "velocity along y: integral gain" => |_| Control::VELOCITY[1], inert;
        "vyKd": F32 "" "velocity along y: derivative gain" => |_| Control::VELOCITY[2], inert;
        "vyKFF": F32 "" "0: no feed-forward" => |_| 0.0, inert;
        "vzKp": F32 "" "rate of climb: proportional gain" => |_| Control::CLIMB[0], inert;
        "vzKi": F32 "" "rate of climb: integral gain" => |_| Control::CLIMB[1], inert;
        "vzKd": F32 "" "rate of climb: derivative gain" => |_| Control::CLIMB[2], inert;
    }
}

fn set_task(of: &mut Parameters, value: Value) -> bool {
    let Value::U8(code) = value else { return false };
    let Some(task) = OperatorTask::from_code(code) else { return false };
    of.task = task;
    true
}

fn set_speed(of: &mut Parameters, value: Value) -> bool {
    let Value::F32(speed) = value else { return false };
    let good = within(speed, -Parameters::MAX_SPEED, Parameters::MAX_SPEED);
    if good {
        of.speed = MetresPerSecond(speed);
    }
    good
}

fn set_branch(of: &mut Parameters, value: Value) -> bool {
    let Value::U8(code) = value else { return false };
    let Some(branch) = Branch::from_code(code) else { return false };
    of.branch = branch;
    true
}

fn set_height(of: &mut Parameters, value: Value) -> bool {
    let Value::F32(height) = value else { return false };
    let good = within(height, Parameters::MIN_HEIGHT, Parameters::MAX_HEIGHT);
    if good {
        of.height = Metres(height);
    }
    good
}

fn set_launch_limit(of: &mut Parameters, value: Value) -> bool {
    let Value::F32(limit) = value else { return false };
    set_limits(of, Dbm(limit), of.retreat_limit)
}

fn set_retreat_limit(of: &mut Parameters, value: Value) -> bool {
    let Value::F32(limit) = value else { return false };
    set_limits(of, of.launch_limit, Dbm(limit))
}

/// The drone refuses a code that has no policy.
fn set_policy(of: &mut Parameters, value: Value) -> bool {
    let Value::U8(code) = value else { return false };
    let Some(code) = PolicyCode::new(code) else { return false };
    of.policy = Some(code);
    true
}

/// Each must be a limit, and the two must fit each other.
fn set_limits(of: &mut Parameters, launch: Dbm, retreat: Dbm) -> bool {
    let [weakest, strongest] = Limits::RANGE;
    let good = [launch, retreat].iter().all(|limit| within(limit.0, weakest.0, strongest.0))
        && AgentConfig::DEFAULT.with_limits(Some(launch), Some(retreat)).check().is_ok();
    if good {
        (of.launch_limit, of.retreat_limit) = (launch, retreat);
    }
    good
}

pub(crate) const fn role_code(role: Role) -> u8 {
    match role {
        Role::Head => 0,
        Role::Relay => 1,
        Role::Base => 2,
    }
}
