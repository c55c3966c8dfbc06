//! Holds the values of the parameters: those that a client can set, and the read-only ones about
//! the drone.

use agent::AgentConfig;
use storage::settings::{Limits, Settings};
use units::{Branch, Course, Dbm, Metres, MetresPerSecond, NodeId, Order, PolicyCode, Role};
use wire::syslink::Release;

/// The parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The operator's order.
    pub task: OperatorTask,
    /// The speed at which the head explores.
    pub speed: MetresPerSecond,
    /// The branch that the head takes at the junctions that it comes to.
    pub branch: Option<Branch>,
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
    /// Whether the drone is a base that takes orders from clients.
    pub takes_orders: bool,
    /// Whether the drone has a Multi-ranger deck.
    pub has_rangers: bool,
    /// The first 48 bits of the firmware's revision, 0 where there is none.
    pub revision: u64,
    /// Whether the source code differed from that revision when the firmware was built.
    pub is_modified: bool,
    /// The release of the radio chip's firmware; `None` where it is unknown, or no release of the
    /// vendor's.
    pub radio: Option<Release>,
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
        branch: None,
        height: agent::FlightConfig::DEFAULT.height,
        launch_limit: AgentConfig::DEFAULT.launch.limit,
        retreat_limit: AgentConfig::DEFAULT.retreat.limit,
        policy: None,
        about: About {
            node: Settings::DEFAULT.node,
            role: Settings::DEFAULT.role,
            selftest_passed: true,
            has_flow: true,
            takes_orders: false,
            has_rangers: true,
            revision: 0,
            is_modified: false,
            radio: None,
            unique: [0; 3],
            flash: 1024,
        },
    };

    /// The largest speed that can be set, m/s: the head flies no faster.
    pub(crate) const MAX_SPEED: f32 = agent::AgentConfig::DEFAULT.policy.max_speed.0;
    /// The least height that can be set, m: below it the side beams see the floor, by their cone
    /// of 27° (`agent::FlightConfig`).
    pub(crate) const MIN_HEIGHT: f32 = 0.2;
    /// The largest, m: on a dark floor the ranger that looks down sees 1.7 m (VL53L1X data sheet,
    /// 17 % grey, in the dark), and less where there is light.
    pub(crate) const MAX_HEIGHT: f32 = 1.0;

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
            Order::Explore(..) => OperatorTask::Explore,
            Order::Return => OperatorTask::Return,
            Order::Land => OperatorTask::Land,
            Order::Perch => OperatorTask::Perch,
            Order::Stop => OperatorTask::Stop,
        };
    }

    /// The operator's order.
    #[must_use]
    pub const fn order(&self) -> Order {
        match self.task {
            OperatorTask::Wait => Order::Wait,
            OperatorTask::Explore => {
                Order::Explore(Course { speed: self.speed, branch: self.branch })
            }
            OperatorTask::Return => Order::Return,
            OperatorTask::Land => Order::Land,
            OperatorTask::Perch => Order::Perch,
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
    /// The drones of the chain relay from the ground.
    Perch = 5,
}

impl OperatorTask {
    pub(crate) const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Wait),
            1 => Some(Self::Explore),
            2 => Some(Self::Return),
            3 => Some(Self::Land),
            4 => Some(Self::Stop),
            5 => Some(Self::Perch),
            _ => None,
        }
    }
}
