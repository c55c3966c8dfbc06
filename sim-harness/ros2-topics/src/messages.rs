//! Messages of ROS 2, as structures whose fields are in the order of their definitions, and those
//! definitions.
//!
//! The definitions are those of `common_interfaces` and `geometry2` (ROS 2 Jazzy), without comments and
//! constants, neither of which is in the bytes of a message.

use serde::{Deserialize, Serialize};

/// A message with a definition.
pub trait Message: Serialize {
    /// Its package and name.
    const NAME: &'static str;
}

macro_rules! messages {
    ($($(#[$about:meta])* $name:ident $full:literal { $($field:ident: $kind:ty,)* })*) => {
        $(
            #[doc = concat!("`", $full, "`.")]
            $(#[$about])*
            #[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
            #[expect(missing_docs, reason = "fields have the names of the message's definition")]
            pub struct $name { $(pub $field: $kind,)* }
            impl Message for $name {
                const NAME: &'static str = $full;
            }
        )*
    };
}

/// A sequence of fixed length is its elements, one after the other, however they are grouped.
pub type Covariance = [[f64; 6]; 6];

messages! {
    Time "builtin_interfaces/msg/Time" { sec: i32, nanosec: u32, }
    Duration "builtin_interfaces/msg/Duration" { sec: i32, nanosec: u32, }
    Clock "rosgraph_msgs/msg/Clock" { clock: Time, }
    Header "std_msgs/msg/Header" { stamp: Time, frame_id: String, }
    ColorRgba "std_msgs/msg/ColorRGBA" { r: f32, g: f32, b: f32, a: f32, }
    Float32 "std_msgs/msg/Float32" { data: f32, }
    Text "std_msgs/msg/String" { data: String, }
    Point "geometry_msgs/msg/Point" { x: f64, y: f64, z: f64, }
    Vector3 "geometry_msgs/msg/Vector3" { x: f64, y: f64, z: f64, }
    Quaternion "geometry_msgs/msg/Quaternion" { x: f64, y: f64, z: f64, w: f64, }
    Pose "geometry_msgs/msg/Pose" { position: Point, orientation: Quaternion, }
    PoseStamped "geometry_msgs/msg/PoseStamped" { header: Header, pose: Pose, }
    PoseWithCovariance "geometry_msgs/msg/PoseWithCovariance" {
        pose: Pose, covariance: Covariance,
    }
    Twist "geometry_msgs/msg/Twist" { linear: Vector3, angular: Vector3, }
    TwistWithCovariance "geometry_msgs/msg/TwistWithCovariance" {
        twist: Twist, covariance: Covariance,
    }
    Transform "geometry_msgs/msg/Transform" { translation: Vector3, rotation: Quaternion, }
    TransformStamped "geometry_msgs/msg/TransformStamped" {
        header: Header, child_frame_id: String, transform: Transform,
    }
    TfMessage "tf2_msgs/msg/TFMessage" { transforms: Vec<TransformStamped>, }
    MapMetaData "nav_msgs/msg/MapMetaData" {
        map_load_time: Time, resolution: f32, width: u32, height: u32, origin: Pose,
    }
    OccupancyGrid "nav_msgs/msg/OccupancyGrid" { header: Header, info: MapMetaData, data: Vec<i8>, }
    Odometry "nav_msgs/msg/Odometry" {
        header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance,
    }
    Path "nav_msgs/msg/Path" { header: Header, poses: Vec<PoseStamped>, }
    Range "sensor_msgs/msg/Range" {
        header: Header, radiation_type: u8, field_of_view: f32, min_range: f32, max_range: f32,
        range: f32, variance: f32,
    }
    KeyValue "diagnostic_msgs/msg/KeyValue" { key: String, value: String, }
    DiagnosticStatus "diagnostic_msgs/msg/DiagnosticStatus" {
        level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue>,
    }
    DiagnosticArray "diagnostic_msgs/msg/DiagnosticArray" {
        header: Header, status: Vec<DiagnosticStatus>,
    }
    CompressedImage "sensor_msgs/msg/CompressedImage" {
        header: Header, format: String, data: Vec<u8>,
    }
    UvCoordinate "visualization_msgs/msg/UVCoordinate" { u: f32, v: f32, }
    MeshFile "visualization_msgs/msg/MeshFile" { filename: String, data: Vec<u8>, }
    Marker "visualization_msgs/msg/Marker" {
        header: Header, ns: String, id: i32, r#type: i32, action: i32, pose: Pose, scale: Vector3,
        color: ColorRgba, lifetime: Duration, frame_locked: bool, points: Vec<Point>,
        colors: Vec<ColorRgba>, texture_resource: String, texture: CompressedImage,
        uv_coordinates: Vec<UvCoordinate>, text: String, mesh_resource: String, mesh_file: MeshFile,
        mesh_use_embedded_materials: bool,
    }
    MarkerArray "visualization_msgs/msg/MarkerArray" { markers: Vec<Marker>, }
}

impl Time {
    /// So many microseconds after the beginning of time: of a mission, or of 1970.
    #[must_use]
    pub fn at_micros(micros: u64) -> Self {
        // A time after 68 years is cut off here.
        let sec = i32::try_from(micros / 1_000_000).unwrap_or(i32::MAX);
        Self { sec, nanosec: (micros % 1_000_000) as u32 * 1000 }
    }
}

impl Header {
    /// Of a frame of reference, so many microseconds after the beginning of time.
    #[must_use]
    pub fn at_micros(micros: u64, frame: &str) -> Self {
        Self { stamp: Time::at_micros(micros), frame_id: frame.to_owned() }
    }
}

impl Quaternion {
    /// A turn about the vertical, rad.
    #[must_use]
    pub fn about_vertical(yaw: f32) -> Self {
        let (sin, cos) = libm::sincos(f64::from(yaw) / 2.0);
        Self { x: 0.0, y: 0.0, z: sin, w: cos }
    }
}

/// The definition of each message: a line for each field.
const DEFINITIONS: &[(&str, &str)] = &[
    ("builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/msg/Duration", "int32 sec\nuint32 nanosec\n"),
    ("rosgraph_msgs/msg/Clock", "builtin_interfaces/Time clock\n"),
    ("std_msgs/msg/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/msg/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("std_msgs/msg/Float32", "float32 data\n"),
    ("std_msgs/msg/String", "string data\n"),
    ("geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/msg/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/msg/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    (
        "geometry_msgs/msg/Pose",
        "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    ),
    ("geometry_msgs/msg/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"),
    ("geometry_msgs/msg/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    ("geometry_msgs/msg/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    (
        "geometry_msgs/msg/TwistWithCovariance",
        "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    ),
    (
        "geometry_msgs/msg/Transform",
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    ),
    (
        "geometry_msgs/msg/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "nav_msgs/msg/MapMetaData",
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n\
         geometry_msgs/Pose origin\n",
    ),
    (
        "nav_msgs/msg/OccupancyGrid",
        "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n",
    ),
    (
        "nav_msgs/msg/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    ("nav_msgs/msg/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"),
    (
        "sensor_msgs/msg/Range",
        "std_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\nfloat32 min_range\n\
         float32 max_range\nfloat32 range\nfloat32 variance\n",
    ),
    ("diagnostic_msgs/msg/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/msg/DiagnosticStatus",
        "byte level\nstring name\nstring message\nstring hardware_id\n\
         diagnostic_msgs/KeyValue[] values\n",
    ),
    (
        "diagnostic_msgs/msg/DiagnosticArray",
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
    ),
    ("sensor_msgs/msg/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("visualization_msgs/msg/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/msg/MeshFile", "string filename\nuint8[] data\n"),
    (
        "visualization_msgs/msg/Marker",
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
         geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
         builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n\
         std_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n\
         string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n\
         bool mesh_use_embedded_materials\n",
    ),
    ("visualization_msgs/msg/MarkerArray", "visualization_msgs/Marker[] markers\n"),
];

/// The definition of a message with those of all messages that it holds, as `ros2msg` schemas have them.
#[must_use]
pub fn schema(name: &str) -> String {
    let (mut names, mut text) = (vec![name.to_owned()], String::new());
    let mut done = 0;
    while let Some(name) = names.get(done).cloned() {
        let found = DEFINITIONS.iter().find(|(known, _)| *known == name);
        let definition = found.map_or("", |(_, definition)| definition);
        if done > 0 {
            let short = name.replace("/msg/", "/");
            text += &format!("{}\nMSG: {short}\n", "=".repeat(80));
        }
        text += definition;
        for line in definition.lines() {
            let kind = line.split([' ', '[']).next().unwrap_or_default();
            let kind = kind.replace('/', "/msg/");
            if kind.contains('/') && !names.contains(&kind) {
                names.push(kind);
            }
        }
        done += 1;
    }
    text
}

#[cfg(test)]
mod tests {
    use byteorder::LittleEndian;

    use super::*;

    /// A string begins with its length, and a number stands at a multiple of its size, counted from
    /// behind the encapsulation.
    #[test]
    fn messages_are_aligned() {
        let header = Header { frame_id: "map".into(), ..Default::default() };
        let path = Path { header, poses: vec![Default::default()] };
        let bytes = cdr_encoding::to_vec::<_, LittleEndian>(&path).unwrap();
        // Stamp 8, length and "map" with its zero 8, length of poses 4; of the pose: stamp 8, an empty
        // string 5, padding to the next eight, and seven numbers.
        assert_eq!(bytes.len(), 8 + 8 + 4 + 8 + 5 + 7 + 7 * 8);
    }

    #[test]
    fn a_schema_has_the_definitions_of_all_that_it_holds() {
        let text = schema("nav_msgs/msg/Path");
        for part in ["std_msgs/Header", "geometry_msgs/Quaternion", "builtin_interfaces/Time"] {
            assert_eq!(text.matches(&format!("\nMSG: {part}\n")).count(), 1, "{text}");
        }
        assert!(text.starts_with("std_msgs/Header header\n"));
    }
}
