//! The mission in Foxglove's own messages: scenes, points, transforms and log lines.

use std::f32::consts::FRAC_PI_4;

use agent::{ChainDuty, Duty, State};
use foxglove::messages::log::Level;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::scene_entity_deletion;
use foxglove::messages::{
    ArrowPrimitive, Color, FrameTransform, FrameTransforms, LinePrimitive, Log, PackedElementField,
    Point3, PointCloud, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate,
    SpherePrimitive, TextPrimitive, Vector3, line_primitive,
};
use plotters::style::RGBColor;
use units::Role;
use world::FloorPlan;

use super::{MAP_FRAME, Moment};
use units::Point2;

use crate::pictures::{launch_limit, node_rgb, palette};
use mission::trace::{DroneFrame, Frame, Node, Trace};

const WALL: Color = Color { r: 0.5, g: 0.56, b: 0.62, a: 1.0 };
const CENTRE_LINE: Color = Color { r: 0.6, g: 0.65, b: 0.7, a: 0.6 };
const BEAM: Color = Color { r: 0.9, g: 0.62, b: 0.0, a: 0.5 };

/// Half the diagonal of a Crazyflie over its propellers, in metres (Crazyflie 2.1 data sheet:
/// 92 × 92 mm motor to motor and 45 mm propellers).
pub(crate) const RADIUS: f64 = 0.09;

/// The beams in the order of [`DroneFrame::ranges`], and their directions from the nose, rad,
/// counter-clockwise.
pub(crate) const BEAMS: [(&str, f32); 4] =
    [("nw", FRAC_PI_4), ("ne", -FRAC_PI_4), ("sw", 3.0 * FRAC_PI_4), ("se", -3.0 * FRAC_PI_4)];

/// Walls and centre-line as lines.
pub(super) fn map(plan: &FloorPlan, now: Moment) -> SceneUpdate {
    let walls = plan
        .outlines
        .iter()
        .map(|outline| polyline(outline, line_primitive::Type::LineLoop, 0.05, WALL));
    let centres = plan
        .centre_lines
        .iter()
        .map(|line| polyline(&line.points, line_primitive::Type::LineStrip, 0.02, CENTRE_LINE));
    let entity = SceneEntity {
        timestamp: Some(now.timestamp()),
        frame_id: MAP_FRAME.to_owned(),
        id: "floor plan".to_owned(),
        lines: walls.chain(centres).collect(),
        ..SceneEntity::default()
    };
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}

fn polyline(
    points: &[Point2],
    kind: line_primitive::Type,
    thickness: f64,
    colour: Color,
) -> LinePrimitive {
    LinePrimitive {
        r#type: kind as i32,
        pose: Some(origin()),
        thickness,
        points: points.iter().map(|p| point3(p.x, p.y, 0.0)).collect(),
        color: Some(colour),
        ..LinePrimitive::default()
    }
}

/// The walls as points a decimetre apart, for viewers that draw no scenes.
pub(super) fn walls(plan: &FloorPlan, now: Moment) -> PointCloud {
    const SPACING: f32 = 0.1;
    let mut points = Vec::new();
    for outline in &plan.outlines {
        for (Point2 { x: ax, y: ay }, Point2 { x: bx, y: by }) in
            outline.iter().zip(outline.iter().cycle().skip(1))
        {
            let steps = (libm::hypotf(bx - ax, by - ay) / SPACING).clamp(1.0, 10_000.0) as u32;
            points.extend(
                (0..steps)
                    .map(|n| n as f32 / steps as f32)
                    .map(|t| ([ax + (bx - ax) * t, ay + (by - ay) * t, 0.0], [128, 143, 158])),
            );
        }
    }
    cloud(points, now)
}

/// The drones as points, each in its colour, for viewers that draw no scenes.
pub(super) fn points(trace: &Trace, frame: &Frame, now: Moment) -> PointCloud {
    let points = trace.nodes.iter().zip(&frame.drones);
    cloud(points.map(|(node, drone)| (spatial(drone), node_rgb(node))), now)
}

fn cloud(points: impl IntoIterator<Item = ([f32; 3], [u8; 3])>, now: Moment) -> PointCloud {
    let field = |name: &str, offset, kind: NumericType| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: kind as i32,
    };
    let mut data = Vec::new();
    for (place, colour) in points {
        data.extend(place.iter().flat_map(|metres| metres.to_le_bytes()));
        data.extend(colour);
        data.push(u8::MAX);
    }
    PointCloud {
        timestamp: Some(now.timestamp()),
        frame_id: MAP_FRAME.to_owned(),
        pose: Some(origin()),
        point_stride: 16,
        fields: vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field("red", 12, NumericType::Uint8),
            field("green", 13, NumericType::Uint8),
            field("blue", 14, NumericType::Uint8),
            field("alpha", 15, NumericType::Uint8),
        ],
        data: data.into(),
    }
}

/// Every drone's body axes in the map.
pub(super) fn transforms(trace: &Trace, frame: &Frame, now: Moment) -> FrameTransforms {
    let transform = |(node, drone): (&Node, &DroneFrame)| FrameTransform {
        timestamp: Some(now.timestamp()),
        parent_frame_id: MAP_FRAME.to_owned(),
        child_frame_id: format!("drone_{}", node.id),
        translation: Some(place(drone)),
        rotation: Some(heading(drone.pose.yaw.0)),
    };
    FrameTransforms { transforms: trace.nodes.iter().zip(&frame.drones).map(transform).collect() }
}

/// Every drone as a body with nose, name, beams and links.
pub(super) fn drones(trace: &Trace, frame: &Frame, now: Moment) -> SceneUpdate {
    let all = trace.nodes.iter().zip(&frame.drones);
    let mut entities: Vec<_> = all.map(|(node, drone)| body(node, drone, now)).collect();
    let mut deletions = Vec::new();
    let lines: Vec<_> = links(trace, frame).iter().map(DrawnLink::line).collect();
    if lines.is_empty() {
        deletions.push(SceneEntityDeletion {
            timestamp: Some(now.timestamp()),
            r#type: scene_entity_deletion::Type::MatchingId as i32,
            id: LINKS.to_owned(),
        });
    } else {
        entities.push(SceneEntity {
            timestamp: Some(now.timestamp()),
            frame_id: MAP_FRAME.to_owned(),
            id: LINKS.to_owned(),
            lines,
            ..SceneEntity::default()
        });
    }
    SceneUpdate { deletions, entities }
}

const LINKS: &str = "links";

fn body(node: &Node, drone: &DroneFrame, now: Moment) -> SceneEntity {
    let [r, g, b] = node_rgb(node).map(|c| f64::from(c) / 255.0);
    let colour = Color { r, g, b, a: 1.0 };
    let pose = Pose { position: Some(place(drone)), orientation: Some(heading(drone.pose.yaw.0)) };
    let above = Vector3 { z: f64::from(drone.height) + 0.35, ..place(drone) };
    let nose = ArrowPrimitive {
        pose: Some(pose),
        shaft_length: 0.25,
        shaft_diameter: 0.03,
        head_length: 0.1,
        head_diameter: 0.08,
        color: Some(colour),
    };
    SceneEntity {
        timestamp: Some(now.timestamp()),
        frame_id: MAP_FRAME.to_owned(),
        id: format!("drone {}", node.id),
        spheres: vec![SpherePrimitive {
            pose: Some(pose),
            size: Some(Vector3 { x: 2.0 * RADIUS, y: 2.0 * RADIUS, z: RADIUS }),
            color: Some(colour),
        }],
        arrows: if node.role == Role::Base { Vec::new() } else { vec![nose] },
        texts: vec![TextPrimitive {
            pose: Some(Pose { position: Some(above), orientation: Some(heading(0.0)) }),
            billboard: true,
            font_size: 14.0,
            scale_invariant: true,
            color: Some(colour),
            text: format!("{node}\n{}", drone.state.name()),
        }],
        lines: beams(drone).into_iter().collect(),
        ..SceneEntity::default()
    }
}

/// The beams that saw something, as far as they saw.
fn beams(drone: &DroneFrame) -> Option<LinePrimitive> {
    let [x, y, z] = spatial(drone);
    let directions = BEAMS.map(|(_, direction)| direction);
    let seen = drone.ranges.into_iter().zip(directions).filter(|(range, _)| range.is_finite());
    let points: Vec<Point3> = seen
        .flat_map(|(range, direction)| {
            let (sin, cos) = libm::sincosf(drone.pose.yaw.0 + direction);
            [point3(x, y, z), point3(x + range * cos, y + range * sin, z)]
        })
        .collect();
    (!points.is_empty()).then(|| LinePrimitive {
        r#type: line_primitive::Type::LineList as i32,
        pose: Some(origin()),
        thickness: 0.01,
        points,
        color: Some(BEAM),
        ..LinePrimitive::default()
    })
}

/// A link between two drones, as it is drawn.
struct DrawnLink {
    ends: [[f32; 3]; 2],
    colour: RGBColor,
}

impl DrawnLink {
    fn line(&self) -> LinePrimitive {
        let RGBColor(r, g, b) = self.colour;
        let [r, g, b] = [r, g, b].map(|part| f64::from(part) / 255.0);
        LinePrimitive {
            r#type: line_primitive::Type::LineList as i32,
            pose: Some(origin()),
            thickness: 0.04,
            points: self.ends.map(|[x, y, z]| point3(x, y, z)).to_vec(),
            color: Some(Color { r, g, b, a: 0.9 }),
            ..LinePrimitive::default()
        }
    }

    /// Points from one end to the other, both included.
    fn points(&self) -> impl Iterator<Item = ([f32; 3], [u8; 3])> {
        const SPACING: f32 = 0.25;
        let [from, to] = self.ends;
        let [dx, dy, dz] = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let length = libm::hypotf(libm::hypotf(dx, dy), dz);
        let steps = (length / SPACING).clamp(1.0, 1000.0) as u32;
        let RGBColor(r, g, b) = self.colour;
        (0..=steps).map(move |n| {
            let t = n as f32 / steps as f32;
            ([0, 1, 2].map(|axis| from[axis] * (1.0 - t) + to[axis] * t), [r, g, b])
        })
    }
}

/// The links as rows of points, for viewers that draw no scenes.
pub(super) fn link_points(trace: &Trace, frame: &Frame, now: Moment) -> PointCloud {
    cloud(links(trace, frame).iter().flat_map(DrawnLink::points), now)
}

/// Each link towards the head, in the [colour](palette::link_colour) of its strength.
fn links(trace: &Trace, frame: &Frame) -> Vec<DrawnLink> {
    let limit = launch_limit(trace);
    let link = |drone: &DroneFrame| {
        let link = drone.front.as_ref()?;
        let peer = trace.nodes.iter().position(|node| node.id == link.peer)?;
        let other = frame.drones.get(peer)?;
        let colour = palette::link_colour(f64::from(link.filtered.0), limit);
        Some(DrawnLink { ends: [spatial(drone), spatial(other)], colour })
    };
    frame.drones.iter().filter_map(link).collect()
}

/// A line for every drone that does something else than in the frame before; at the start, for
/// every drone.
pub(super) fn state_changes(
    trace: &Trace,
    frame: &Frame,
    before: Option<&Frame>,
    now: Moment,
) -> Vec<Log> {
    let mut changes = Vec::new();
    for (index, (node, drone)) in trace.nodes.iter().zip(&frame.drones).enumerate() {
        let state = drone.state.name();
        let last = before.and_then(|frame| frame.drones.get(index)).map(|d| d.state.name());
        if last == Some(state) {
            continue;
        }
        let level = match drone.state {
            State::OnMission(Duty::Chain(
                ChainDuty::Reconnecting { .. } | ChainDuty::BackingUp { .. },
            )) => Level::Warning,
            _ => Level::Info,
        };
        changes.push(Log {
            timestamp: Some(now.timestamp()),
            level: level as i32,
            message: format!("{node}: {state}"),
            name: format!("drone_{}", node.id),
            ..Log::default()
        });
    }
    changes
}

fn origin() -> Pose {
    Pose { position: Some(Vector3 { x: 0.0, y: 0.0, z: 0.0 }), orientation: Some(heading(0.0)) }
}

fn place(drone: &DroneFrame) -> Vector3 {
    let [x, y, z] = spatial(drone).map(f64::from);
    Vector3 { x, y, z }
}

fn point3(x: f32, y: f32, z: f32) -> Point3 {
    Point3 { x: f64::from(x), y: f64::from(y), z: f64::from(z) }
}

/// Point and height.
pub(crate) fn spatial(drone: &DroneFrame) -> [f32; 3] {
    [drone.pose.at.x, drone.pose.at.y, drone.height]
}

/// A turn about the vertical.
fn heading(yaw: f32) -> Quaternion {
    let (sin, cos) = libm::sincos(f64::from(yaw) / 2.0);
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}
