//! The inputs and outputs of one step of the agent.

use chain::neighbours::{Heard, Neighbour};
use chain::policy::LinkEnd;
use chain::report::Report;
use flight::Cause;
use tunnel_nav::{Diagonals, Walls};
use units::{
    Dbm, Duration, Instant, Metres, MetresPerSecond, NodeId, Order, Payload, Phase, Pose2, Radians,
    Setpoint,
};

use crate::{Reckoning, State};

/// A velocity over ground in body axes, as the optic flow measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyVelocity {
    /// The velocity along x.
    pub forward: MetresPerSecond,
    /// The velocity along y.
    pub lateral: MetresPerSecond,
}

/// Where a drone is in the world, by a positioning system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The place and the direction of the nose.
    pub pose: Pose2,
    /// The standard deviation of the place along each axis.
    pub deviation: Metres,
}

/// A message of the mission from another of its drones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The drone that sent it.
    pub from: NodeId,
    /// When it arrived, by this drone's clock.
    pub at: Instant,
    /// The strength of the sender's last packet.
    pub rssi: Dbm,
    /// What it says.
    pub payload: Payload,
}

/// Everything that happened since the last step.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The four side beams.
    pub ranges: Diagonals,
    /// Velocity over ground; `None` while the flow sensor sees nothing it trusts.
    pub velocity: Option<BodyVelocity>,
    /// Heading by gyro, from any origin, within half a turn, drifting slowly; `None` while there
    /// is none.
    pub heading: Option<Radians>,
    /// Height over ground; `None` while it is not measured.
    pub height: Option<Metres>,
    /// Where the drone is in the world; `None` while no positioning system says it.
    pub located: Option<Located>,
    /// Reports received, in order of arrival.
    pub heard: &'a [Heard],
    /// Messages of the mission that were received, in order of arrival.
    pub told: &'a [Told],
    /// The operator's newest order, where one came in: at the base from the operator, elsewhere
    /// from the radio link, which sees to it that it is authentic and newer than the last. A
    /// pilot's stick comes in anew each time that it is read, though it says the same.
    pub order: Option<Order>,
    /// The flight code's verdict on the machine.
    pub fitness: Fitness,
    /// How long the battery still carries the drone; `None` while that is not known.
    pub endurance: Option<Duration>,
}

/// Whether the machine is fit to do what the agent wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Fitness {
    /// The drone flies, or would.
    #[default]
    Fit,
    /// The drone is on the ground and would not take off.
    Unfit,
    /// The flight code brings the drone down.
    Landing(Cause),
    /// The flight code has brought the drone down.
    Landed(Cause),
    /// The motors are off until the next boot.
    Stopped,
}

/// One of the drone's two links, as it sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinkView {
    /// The neighbour at the other end.
    pub peer: NodeId,
    /// The strength of its last packet; where an end of the link is on the ground for good, what it
    /// would be in the air, here and below.
    pub raw: Dbm,
    /// The filtered strength.
    pub rssi: Dbm,
    /// How fast it said it flies along the tunnel.
    pub velocity: MetresPerSecond,
    /// Whether it is the base.
    pub is_base: bool,
}

impl LinkView {
    pub(crate) fn of(neighbour: &Neighbour) -> Self {
        Self {
            peer: neighbour.report.from,
            raw: neighbour.raw,
            rssi: neighbour.rssi(),
            velocity: neighbour.report.velocity,
            is_base: neighbour.report.phase == Phase::Base,
        }
    }

    pub(crate) const fn end(&self) -> LinkEnd {
        LinkEnd { rssi: self.rssi, velocity: self.velocity }
    }
}

/// The agent's view of its drone, for logs, displays and tests; nothing is controlled by it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Status {
    /// The state of the drone.
    pub state: State,
    /// The link towards the head.
    pub front: Option<LinkView>,
    /// The link towards the base.
    pub back: Option<LinkView>,
    /// Where the drone is by its own reckoning.
    pub here: Reckoning,
    /// The walls that the drone steers by.
    pub walls: Walls,
}

/// The decisions of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Outputs {
    /// The set-point of the flight controller.
    pub setpoint: Setpoint,
    /// The report to all drones that hear this one.
    pub report: Report,
    /// The agent's view of its drone.
    pub status: Status,
}
