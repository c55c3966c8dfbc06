//! The messages of a frame.

use crate::mcap::{BEAMS, Moment, RADIUS, spatial};
use crate::pictures::{launch_limit, node_rgb};
use mission::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};
use ros2_topics::messages::{
    ColorRgba, DiagnosticArray, DiagnosticStatus, Header, KeyValue, Marker, MarkerArray, Odometry,
    Path, Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, Range, TfMessage, Transform,
    TransformStamped, Twist, TwistWithCovariance, Vector3,
};
use units::Role;

/// The frame of reference of the floor plan.
pub(super) const MAP: &str = "map";

/// The angle of a beam's cone: 27° (UM2555, VL53L1x).
const CONE_RAD: f32 = 0.471_238_9;

/// The poses of a path; when it has more, every second is left out.
const MOST_POSES: usize = 600;

pub(super) fn header(frame: &str, now: Moment) -> Header {
    Header::at_micros(now.micros, frame)
}

fn drone_frame(node: &Node) -> String {
    format!("drone_{}", node.id)
}

pub(super) fn beam_frame(id: u8, beam: &str) -> String {
    format!("drone_{id}/range_{beam}")
}

fn place(drone: &DroneFrame) -> Point {
    let [x, y, z] = spatial(drone).map(f64::from);
    Point { x, y, z }
}

fn pose(drone: &DroneFrame) -> Pose {
    Pose { position: place(drone), orientation: Quaternion::about_vertical(drone.pose.yaw.0) }
}

/// Where each drone is in the map.
pub(super) fn transforms(trace: &Trace, frame: &Frame, now: Moment) -> TfMessage {
    let transform = |(node, drone): (&Node, &DroneFrame)| {
        let Point { x, y, z } = place(drone);
        TransformStamped {
            header: header(MAP, now),
            child_frame_id: drone_frame(node),
            transform: Transform {
                translation: Vector3 { x, y, z },
                rotation: Quaternion::about_vertical(drone.pose.yaw.0),
            },
        }
    };
    TfMessage { transforms: trace.nodes.iter().zip(&frame.drones).map(transform).collect() }
}

/// Where the beams are on each drone.
pub(super) fn fixed(trace: &Trace, now: Moment) -> TfMessage {
    let beams = trace.nodes.iter().flat_map(|node| {
        BEAMS.map(|(beam, direction)| TransformStamped {
            header: header(&drone_frame(node), now),
            child_frame_id: beam_frame(node.id.0, beam),
            transform: Transform {
                rotation: Quaternion::about_vertical(direction),
                ..Transform::default()
            },
        })
    });
    TfMessage { transforms: beams.collect() }
}

/// The true place and heading, and the true velocity since the frame before, in body axes.
pub(super) fn odometry(
    node: &Node,
    drone: &DroneFrame,
    before: Option<(u64, &DroneFrame)>,
    now: Moment,
) -> Odometry {
    Odometry {
        header: header(MAP, now),
        child_frame_id: drone_frame(node),
        pose: PoseWithCovariance { pose: pose(drone), ..PoseWithCovariance::default() },
        twist: TwistWithCovariance {
            twist: before.map_or_else(Twist::default, |before| twist(drone, before, now)),
            ..TwistWithCovariance::default()
        },
    }
}

fn twist(drone: &DroneFrame, (then_us, before): (u64, &DroneFrame), now: Moment) -> Twist {
    let seconds = now.micros.saturating_sub(then_us).max(1) as f64 * 1e-6;
    let [now, then] = [drone, before].map(|drone| spatial(drone).map(f64::from));
    let [x, y, z] = [0, 1, 2].map(|axis| (now[axis] - then[axis]) / seconds);
    let (sin, cos) = libm::sincos(f64::from(drone.pose.yaw.0));
    let turned = f64::from(drone.pose.yaw.0 - before.pose.yaw.0);
    // The shorter way round.
    let turned = libm::atan2(libm::sin(turned), libm::cos(turned));
    Twist {
        linear: Vector3 { x: cos * x + sin * y, y: cos * y - sin * x, z },
        angular: Vector3 { x: 0.0, y: 0.0, z: turned / seconds },
    }
}

/// What a beam measures; infinite where it saw nothing, as REP 117 has it.
pub(super) fn range(frame: String, metres: f32, reach: f32, now: Moment) -> Range {
    /// Of `Range`: the light is infrared.
    const INFRARED: u8 = 1;
    Range {
        header: header(&frame, now),
        radiation_type: INFRARED,
        field_of_view: CONE_RAD,
        min_range: 0.0,
        max_range: reach,
        range: metres,
        variance: 0.0,
    }
}

/// The way that a drone has flown, a pose for each second or, where that is long, fewer.
#[derive(Default)]
pub(super) struct Flown {
    poses: Vec<PoseStamped>,
    /// Seconds between two poses, as a power of two.
    doubled: u32,
}

impl Flown {
    pub(super) fn add(&mut self, drone: &DroneFrame, now: Moment) {
        if !now.micros.is_multiple_of(1_000_000 << self.doubled) {
            return;
        }
        if self.poses.len() == MOST_POSES {
            let mut place = 0;
            self.poses.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.doubled = (self.doubled + 1).min(32);
        }
        self.poses.push(PoseStamped { header: header(MAP, now), pose: pose(drone) });
    }

    pub(super) fn path(&self, now: Moment) -> Path {
        Path { header: header(MAP, now), poses: self.poses.clone() }
    }
}

/// The drones as bodies with their names and states, and the links as lines.
pub(super) fn markers(trace: &Trace, frame: &Frame, now: Moment) -> MarkerArray {
    /// Of `Marker`.
    const SPHERE: i32 = 2;
    const LINE_LIST: i32 = 5;
    const TEXT: i32 = 9;
    let mut markers = Vec::new();
    for (node, drone) in trace.nodes.iter().zip(&frame.drones) {
        let [r, g, b] = node_rgb(node).map(|part| f32::from(part) / 255.0);
        let color = ColorRgba { r, g, b, a: 1.0 };
        let id = i32::from(node.id.0);
        let marker = |ns: &str, kind| Marker {
            ns: ns.to_owned(),
            id,
            r#type: kind,
            color: color.clone(),
            pose: pose(drone),
            ..marker(now)
        };
        let scale = Vector3 { x: 2.0 * RADIUS, y: 2.0 * RADIUS, z: 0.05 };
        markers.push(Marker { scale, ..marker("drones", SPHERE) });
        let mut name = marker("names", TEXT);
        name.pose.position.z += 0.35;
        name.scale.z = 0.2;
        name.text = format!("{node}\n{}", drone.state.name());
        markers.push(name);
    }
    let (points, colors) = links(trace, frame);
    let scale = Vector3 { x: 0.04, ..Vector3::default() };
    let ns = "links".to_owned();
    markers.push(Marker { ns, r#type: LINE_LIST, scale, points, colors, ..marker(now) });
    MarkerArray { markers }
}

fn marker(now: Moment) -> Marker {
    let pose = Pose { orientation: Quaternion::about_vertical(0.0), ..Pose::default() };
    let color = ColorRgba { r: 1.0, g: 1.0, b: 1.0, a: 1.0 };
    Marker { header: header(MAP, now), pose, color, ..Marker::default() }
}

/// The ends of all links, and their colours: blue, and vermilion below the launch limit.
fn links(trace: &Trace, frame: &Frame) -> (Vec<Point>, Vec<ColorRgba>) {
    let (mut points, mut colors) = (Vec::new(), Vec::new());
    for drone in &frame.drones {
        let Some(link) = drone.front else { continue };
        let peer = trace.nodes.iter().position(|node| node.id == link.peer);
        let Some(other) = peer.and_then(|peer| frame.drones.get(peer)) else { continue };
        let color = match is_weak(trace, &link) {
            true => ColorRgba { r: 0.84, g: 0.37, b: 0.0, a: 1.0 },
            false => ColorRgba { r: 0.0, g: 0.45, b: 0.7, a: 1.0 },
        };
        points.extend([place(drone), place(other)]);
        colors.extend([color.clone(), color]);
    }
    (points, colors)
}

fn is_weak(trace: &Trace, link: &LinkFrame) -> bool {
    launch_limit(trace).is_some_and(|limit| f64::from(link.filtered.0) < limit)
}

/// The state of each drone and its links in words.
pub(super) fn diagnostics(trace: &Trace, frame: &Frame, now: Moment) -> DiagnosticArray {
    /// Of `DiagnosticStatus`.
    const OK: u8 = 0;
    const WARN: u8 = 1;
    let mut status = Vec::new();
    for (node, drone) in trace.nodes.iter().zip(&frame.drones) {
        let pair = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
        let links = [("front", drone.front), ("back", drone.back)];
        let is_weak = links.iter().any(|(_, it)| it.is_some_and(|link| is_weak(trace, &link)));
        let mut values = vec![pair("way_m", drone.way.to_string())];
        if !drone.battery_v.is_nan() {
            values.push(pair("battery_v", drone.battery_v.to_string()));
        }
        for (side, link) in links {
            let Some(link) = link else { continue };
            values.push(pair(&format!("{side}_peer"), link.peer.to_string()));
            let strengths = [("raw", link.raw), ("filtered", link.filtered), ("true", link.truth)];
            values.extend(
                strengths.map(|(of, it)| pair(&format!("{side}_{of}_dbm"), it.0.to_string())),
            );
        }
        let weak = if is_weak { ", a link is below the launch limit" } else { "" };
        status.push(DiagnosticStatus {
            level: if is_weak && node.role != Role::Base { WARN } else { OK },
            name: node.to_string(),
            message: format!("{}{weak}", drone.state.name()),
            hardware_id: drone_frame(node),
            values,
        });
    }
    DiagnosticArray { header: header("", now), status }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn drones_have_the_names_of_their_mission() {
        for (mission, name) in synthetic::SECOND_NAMES {
            let trace = synthetic::named_as(mission);
            let (frame, now) = (&trace.frames[0], Moment { micros: 0 });
            let markers = markers(&trace, frame, now).markers;
            assert!(markers.iter().any(|marker| marker.text == format!("{name}\narmed")));
            let status = diagnostics(&trace, frame, now).status;
            assert_eq!(status[1].name, name);
        }
    }

    #[test]
    fn a_long_path_keeps_equal_steps_and_its_beginning() {
        let trace = synthetic::mission();
        let drone = &trace.frames[0].drones[0];
        let mut flown = Flown::default();
        for round in 0..=3_000 * 5 {
            flown.add(drone, Moment { micros: round * 200_000 });
            let seconds: Vec<i32> = flown.poses.iter().map(|pose| pose.header.stamp.sec).collect();
            assert_eq!(seconds.first(), Some(&0));
            assert!(seconds.len() <= MOST_POSES, "{} poses", seconds.len());
            let step = 1 << flown.doubled;
            assert!(seconds.windows(2).all(|pair| pair[1] - pair[0] == step), "{seconds:?}");
        }
        // 600 s, 1,200 s and 2,400 s doubled the step.
        assert_eq!((flown.doubled, flown.poses.len()), (3, 376));
    }
}
