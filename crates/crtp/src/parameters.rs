//! Defines the table of parameters: those that a client can set, and the read-only ones about the
//! drone.

use agent::AgentConfig;
use storage::settings::{Limits, Settings};
use units::{Dbm, Metres, MetresPerSecond, NodeId, Order, PolicyCode, Role};
use wire::crtp::{LogType, ParamType, Value};

use crate::table::{Documented, Get, crc_of_row};

/// The parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The operator's order.
    pub task: OperatorTask,
    /// The speed at which the head explores.
    pub speed: MetresPerSecond,
    /// The height at which this drone flies.
    pub height: Metres,
    /// The launch limit: when the last link is weaker, the next relay takes off.
    pub launch_limit: Dbm,
    /// The retreat limit: when this drone's back link is weaker, it flies back.
    pub retreat_limit: Dbm,
    /// The movement policy; `None` for one that has no code.
    pub policy: Option<PolicyCode>,
    /// The values of the read-only parameters.
    pub about: About,
}

/// The read-only parameters: number, role and hardware of the drone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// The drone's place in the chain.
    pub node: NodeId,
    /// The drone's part in the chain.
    pub role: Role,
    /// Whether both decks were found at boot.
    pub selftest_passed: bool,
    /// Whether the drone has a Flow deck v2.
    pub has_flow: bool,
    /// Whether the drone has a Multi-ranger deck.
    pub has_rangers: bool,
    /// The first 48 bits of the firmware's revision, 0 where there is none.
    pub revision: u64,
    /// Whether the source code differed from that revision when the firmware was built.
    pub is_modified: bool,
    /// The unique number of the drone's processor.
    pub unique: [u32; 3],
    /// The size of the processor's flash, KB.
    pub flash: u16,
}

impl Parameters {
    /// The parameters before a client has set one, without an order. The speed is that of the
    /// demonstration's pilot, height and limits are those of `agent::AgentConfig`.
    pub const DEFAULT: Self = Self {
        task: OperatorTask::Wait,
        speed: MetresPerSecond(0.2),
        height: agent::FlightConfig::DEFAULT.height,
        launch_limit: AgentConfig::DEFAULT.launch.limit,
        retreat_limit: AgentConfig::DEFAULT.retreat.limit,
        policy: None,
        about: About {
            node: Settings::DEFAULT.node,
            role: Settings::DEFAULT.role,
            selftest_passed: true,
            has_flow: true,
            has_rangers: true,
            revision: 0,
            is_modified: false,
            unique: [0; 3],
            flash: 1024,
        },
    };

    /// The largest speed that can be set, m/s: the head flies no faster.
    const MAX_SPEED: f32 = agent::AgentConfig::DEFAULT.policy.max_speed.0;
    /// The least height that can be set, m: below it the side beams see the floor, by their cone
    /// of 27° (`agent::FlightConfig`).
    const MIN_HEIGHT: f32 = 0.2;
    /// The largest, m: on a dark floor the ranger that looks down sees 1.7 m (VL53L1X data sheet,
    /// 17 % grey, in the dark), and less where there is light.
    const MAX_HEIGHT: f32 = 1.0;

    /// Returns the limits, for the caller to store.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        Limits { launch: Some(self.launch_limit), retreat: Some(self.retreat_limit) }
    }

    /// Sets the limits to the stored ones.
    pub fn set_limits(&mut self, limits: Limits) {
        self.launch_limit = limits.launch.unwrap_or(Self::DEFAULT.launch_limit);
        self.retreat_limit = limits.retreat.unwrap_or(Self::DEFAULT.retreat_limit);
    }

    /// Sets the parameters to an order that was not given by a parameter, so that clients see it.
    pub const fn show(&mut self, order: Order) {
        self.task = match order {
            Order::Wait => OperatorTask::Wait,
            Order::Explore(_) => OperatorTask::Explore,
            Order::Return => OperatorTask::Return,
            Order::Land => OperatorTask::Land,
            Order::Stop => OperatorTask::Stop,
        };
    }

    /// The operator's order.
    #[must_use]
    pub const fn order(&self) -> Order {
        match self.task {
            OperatorTask::Wait => Order::Wait,
            OperatorTask::Explore => Order::Explore(self.speed),
            OperatorTask::Return => Order::Return,
            OperatorTask::Land => Order::Land,
            OperatorTask::Stop => Order::Stop,
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// An operator's order, without its speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum OperatorTask {
    /// The drones stay on the ground.
    #[default]
    Wait = 0,
    /// The drones fly, the head at [`Parameters::speed`].
    Explore = 1,
    /// The drones come home.
    Return = 2,
    /// Each drone lands where it is.
    Land = 3,
    /// All drones stop their motors now.
    Stop = 4,
}

impl OperatorTask {
    const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Wait),
            1 => Some(Self::Explore),
            2 => Some(Self::Return),
            3 => Some(Self::Land),
            4 => Some(Self::Stop),
            _ => None,
        }
    }
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterId(u16);

impl ParameterId {
    /// The parameter `uchain.task`.
    pub const TASK: Self = Self::of("uchain", "task");
    /// The parameter `uchain.speed`.
    pub const SPEED: Self = Self::of("uchain", "speed");
    /// The parameter `uchain.height`.
    pub const HEIGHT: Self = Self::of("uchain", "height");
    /// The parameter `uchain.launchLimit`.
    pub const LAUNCH_LIMIT: Self = Self::of("uchain", "launchLimit");
    /// The parameter `uchain.retreatLimit`.
    pub const RETREAT_LIMIT: Self = Self::of("uchain", "retreatLimit");
    /// The parameter `uchain.policy`.
    pub const POLICY: Self = Self::of("uchain", "policy");

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

    /// Whether the parameter now has the value.
    pub(crate) fn set(&self, of: &mut Parameters, value: Value) -> bool {
        self.set.is_some_and(|set| set(of, value))
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
        "task": U8 "" "what the operator orders: 0 wait, 1 explore, 2 return, 3 land, 4 stop"
            => |p| p.task as u8, set_task;
        "speed": F32 "m/s" "at which the head explores, −0.4 to 0.4; negative is back"
            => |p| p.speed.0, set_speed;
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
        "bcFlow2": U8 "" "1 when there is a Flow deck v2" => |p| p.about.has_flow.into();
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
    }
    "imu_sensors" {
        "BMP3XX": U8 "" "0: the barometer is not used" => |_| 0;
    }
    "commander" {
        "enHighLevel": U8 "" "1, and nothing else; cfclient sets it before a take-off"
            => |_| 1, |_, value| value == Value::U8(1);
    }
    "flightmode" {
        "althold": U8 "" "0, and nothing else; cfclient has a button for it"
            => |_| 0, |_, value| value == Value::U8(0);
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
