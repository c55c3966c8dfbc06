//! Draws the floor plan with the places of a planned chain.

use agent::State;
use input::counted;
use units::{Dbm, MissionKind, NodeId, Order, Point2, Pose2, Radians, Role};
use world::{FloorPlan, SkeletonPlace};

use super::sheet::{Picture, headed};
use super::{PictureError, map};
use mission::trace::{DroneFrame, Frame, Node, TeamMap, Trace};

/// A planned chain, for its picture.
pub struct PlanPicture<'a> {
    /// The name of the place.
    pub name: &'a str,
    /// The floor plan.
    pub plan: FloorPlan,
    /// The places of base, relays and head, base first.
    pub places: Vec<Point2>,
}

/// The picture of a plan.
pub(super) fn picture(plan: &PlanPicture<'_>) -> Result<Picture, PictureError> {
    let trace = standing(plan);
    let title = format!("Plan: {}", plan.name);
    Picture::draw((960.0, map::height_of(&trace)), &title, |sheet| {
        let relays = plan.places.len().saturating_sub(2);
        let subtitle = format!("Where base, head and {} would stand", counted(relays, "relay"));
        let body = headed(sheet, &title, &subtitle)?;
        map::panel(&body, &trace, "")
    })
}

/// A record of one moment, at which all drones stand at their places.
fn standing(plan: &PlanPicture<'_>) -> Trace {
    let last = plan.places.len().saturating_sub(1);
    // The numbers count from the head.
    let node = |n: usize| Node {
        id: NodeId(n as u8),
        role: match n {
            0 => Role::Head,
            n if n == last => Role::Base,
            _ => Role::Relay,
        },
        mission: MissionKind::Chain,
    };
    let drone = |&at: &Point2| DroneFrame {
        pose: Pose2 { at, yaw: Radians(0.0) },
        height: 0.0,
        place: SkeletonPlace { edge: 0, along: 0.0 },
        way: f32::NAN,
        commanded: [0.0; 2],
        yaw_rate: 0.0,
        ranges: [f32::NAN; 4],
        state: State::Idle,
        goal: None,
        target: None,
        battery_v: f32::NAN,
        front: None,
        back: None,
    };
    let drones = plan.places.iter().rev().map(drone).collect();
    Trace {
        scenario: plan.name.to_owned(),
        seed: None,
        mission: MissionKind::Chain,
        floor_plan: plan.plan.clone(),
        nodes: (0..plan.places.len()).map(node).collect(),
        launch_limit: Dbm(0.0),
        passage: None,
        team_map: TeamMap::default(),
        frames: vec![Frame { time_us: 0, order: Order::Wait, drones, team_links: Vec::new() }],
    }
}
