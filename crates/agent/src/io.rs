//! What goes into a step of the agent, and what comes out.

use chain::neighbours::{Heard, Neighbour};
use chain::policy::LinkEnd;
use chain::report::Report;
use flight::Cause;
use tunnel_nav::{Diagonals, Walls};
use units::{Dbm, Duration, Metres, MetresPerSecond, NodeId, Order, Phase, Radians, Setpoint};

use crate::State;

/// A velocity over ground in body axes, as the optic flow measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyVelocity {
    /// Along x.
    pub forward: MetresPerSecond,
    /// Along y.
    pub lateral: MetresPerSecond,
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
    /// Reports received, in order of arrival.
    pub heard: &'a [Heard],
    /// The operator's newest order, where one came in: at the base from the operator, elsewhere
    /// from the radio link, which sees to it that it is authentic and newer than the last. A
    /// pilot's stick comes in anew each time that it is read, though it says the same.
    pub order: Option<Order>,
    /// What the flight code says of the machine.
    pub fitness: Fitness,
    /// How long the battery still carries the drone; `None` while that is not known.
    pub endurance: Option<Duration>,
}

/// How far the machine is fit to do what the agent wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Fitness {
    /// It flies, or would.
    #[default]
    Fit,
    /// On the ground, and would not take off.
    Unfit,
    /// Coming down by itself.
    Landing(Cause),
    /// It came down by itself and is on the ground.
    Landed(Cause),
    /// Its motors are off until the next boot.
    Stopped,
}

/// One of the drone's two links, as it sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinkView {
    /// The neighbour at the other end.
    pub peer: NodeId,
    /// Its last packet.
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

/// What the drone thinks: for logs, displays and tests, never for control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Status {
    /// What it is doing.
    pub state: State,
    /// The link towards the head.
    pub front: Option<LinkView>,
    /// The link towards the base.
    pub back: Option<LinkView>,
    /// Its way along the tunnel since take-off.
    pub odometer: Metres,
    /// The walls that it steers by.
    pub walls: Walls,
}

/// What a step decided.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Outputs {
    /// For the flight controller.
    pub setpoint: Setpoint,
    /// For everyone in earshot.
    pub report: Report,
    /// For whoever watches.
    pub status: Status,
}
