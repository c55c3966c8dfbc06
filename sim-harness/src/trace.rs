//! What happened on a mission, five times a second: the one record that every picture, table and
//! file is made from.

use agent::State;
use units::{Dbm, NodeId, Order, Role};

/// A whole mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The scenario's name.
    pub scenario: String,
    /// The seed that it ran with.
    pub seed: u64,
    /// Where it happened.
    pub floor_plan: FloorPlan,
    /// Who flew, head first, base last; every frame lists them in this order.
    pub nodes: Vec<Node>,
    /// Launch limit: links weaker than this call for a relay.
    pub launch_limit: Dbm,
    /// What was, in order of time, one frame per 0.2 s.
    pub frames: Vec<Frame>,
}

/// A point of the floor plan: x east, y north, in metres.
pub type Point = [f32; 2];

/// The tunnel seen from above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorPlan {
    /// The outlines of the free space, each closed (the last point is not the first again): outer
    /// boundaries and the pillars within them.
    pub outlines: Vec<Vec<Point>>,
    /// The centre-line, from the base's end to the far end.
    pub centre_line: Vec<Point>,
}

/// One member of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Its number.
    pub id: NodeId,
    /// Its part.
    pub role: Role,
}

/// One moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Microseconds since the start of the mission.
    pub time_us: u64,
    /// The operator's order at the base.
    pub order: Order,
    /// One for each of [`Trace::nodes`].
    pub drones: Vec<DroneFrame>,
}

/// One drone at one moment. Metres, m/s and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DroneFrame {
    /// Where it truly is: x, y on the floor plan, z above the ground.
    pub position: [f32; 3],
    /// Where its nose points, counter-clockwise from east.
    pub yaw: f32,
    /// Its way along the centre-line from the base's end (the paper's x).
    pub abscissa: f32,
    /// The velocity that it was told to fly, in body axes: forward, left.
    pub commanded: [f32; 2],
    /// The yaw rate that it was told to fly, counter-clockwise.
    pub yaw_rate: f32,
    /// The four beams, NW, NE, SW, SE; infinite where nothing was seen, NaN where not measured.
    pub ranges: [f32; 4],
    /// What it was doing.
    pub state: State,
    /// The voltage of its battery; NaN for the base, and for points, which have none.
    pub battery_v: f32,
    /// Its link towards the head, while it has one.
    pub front: Option<LinkFrame>,
    /// Its link towards the base, while it has one.
    pub back: Option<LinkFrame>,
}

/// One link at one moment, as the drone at one end of it knew it, beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkFrame {
    /// The drone at the other end.
    pub peer: NodeId,
    /// The last packet's RSSI.
    pub raw: Dbm,
    /// What the on-board filter made of it.
    pub filtered: Dbm,
    /// What it truly was, without noise, fading or rounding.
    pub truth: Dbm,
}

/// An order in words: `explore at 0.20 m/s`.
#[must_use]
pub fn order_words(order: Order) -> String {
    match order {
        Order::Wait => "wait".to_owned(),
        Order::Explore(speed) => format!("explore at {:.2} m/s", speed.0),
        Order::Return => "return".to_owned(),
        Order::Land => "land".to_owned(),
        Order::Stop => "stop".to_owned(),
    }
}
