//! Defines the two messages of a `trace.mcap` that are this project's own: what a drone did, and how a
//! link was.
//!
//! In protobuf's terms they are proto2 with required fields, because proto3 leaves zeros out: a
//! viewer would show nothing where a drone stands at 0. Field numbers never change; a new field
//! takes the next one.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

/// One link as the drone at one end of it knew it, beside the truth.
#[derive(Clone, PartialEq, Message)]
pub struct Link {
    /// Number of the drone at the other end.
    #[prost(uint32, required, tag = "1")]
    pub peer: u32,
    /// The last packet.
    #[prost(float, required, tag = "2")]
    pub raw_dbm: f32,
    /// The strength by the on-board filter.
    #[prost(float, required, tag = "3")]
    pub filtered_dbm: f32,
    /// The true strength, without noise, fading or rounding.
    #[prost(float, required, tag = "4")]
    pub true_dbm: f32,
}

/// One drone at one moment.
#[derive(Clone, PartialEq, Message)]
pub struct DroneState {
    /// The state of the agent, as `trace.csv` spells it.
    #[prost(string, required, tag = "1")]
    pub state: String,
    /// The true place on the floor plan and above it, m.
    #[prost(float, required, tag = "2")]
    pub x_m: f32,
    /// See [`x_m`](Self::x_m).
    #[prost(float, required, tag = "3")]
    pub y_m: f32,
    /// See [`x_m`](Self::x_m).
    #[prost(float, required, tag = "4")]
    pub z_m: f32,
    /// The heading of the nose, rad counter-clockwise from east.
    #[prost(float, required, tag = "5")]
    pub yaw_rad: f32,
    /// How far along the tunnel it is, m.
    #[prost(float, required, tag = "6")]
    pub way_m: f32,
    /// The commanded speed along the nose, m/s.
    #[prost(float, required, tag = "7")]
    pub forward_m_s: f32,
    /// The commanded speed to the left, m/s.
    #[prost(float, required, tag = "8")]
    pub left_m_s: f32,
    /// The commanded yaw rate, rad/s.
    #[prost(float, required, tag = "9")]
    pub yaw_rate_rad_s: f32,
    /// The beam to the front left, m; like the other three absent where nothing was seen or measured.
    #[prost(float, optional, tag = "10")]
    pub range_nw_m: Option<f32>,
    /// See [`range_nw_m`](Self::range_nw_m).
    #[prost(float, optional, tag = "11")]
    pub range_ne_m: Option<f32>,
    /// See [`range_nw_m`](Self::range_nw_m).
    #[prost(float, optional, tag = "12")]
    pub range_sw_m: Option<f32>,
    /// See [`range_nw_m`](Self::range_nw_m).
    #[prost(float, optional, tag = "13")]
    pub range_se_m: Option<f32>,
}

/// A field of a message: its name, type, and whether it is always there. Numbers count from 1.
type Field = (&'static str, Type, Label);

const LINK: [Field; 4] = [
    ("peer", Type::Uint32, Label::Required),
    ("raw_dbm", Type::Float, Label::Required),
    ("filtered_dbm", Type::Float, Label::Required),
    ("true_dbm", Type::Float, Label::Required),
];

const DRONE_STATE: [Field; 13] = [
    ("state", Type::String, Label::Required),
    ("x_m", Type::Float, Label::Required),
    ("y_m", Type::Float, Label::Required),
    ("z_m", Type::Float, Label::Required),
    ("yaw_rad", Type::Float, Label::Required),
    ("way_m", Type::Float, Label::Required),
    ("forward_m_s", Type::Float, Label::Required),
    ("left_m_s", Type::Float, Label::Required),
    ("yaw_rate_rad_s", Type::Float, Label::Required),
    ("range_nw_m", Type::Float, Label::Optional),
    ("range_ne_m", Type::Float, Label::Optional),
    ("range_sw_m", Type::Float, Label::Optional),
    ("range_se_m", Type::Float, Label::Optional),
];

/// The name of a message's schema and its text: a file descriptor set in protobuf.
pub type Schema = (String, Vec<u8>);

impl Link {
    /// The schema.
    #[must_use]
    pub fn schema() -> Schema {
        schema("Link", &LINK)
    }
}

impl DroneState {
    /// The schema.
    #[must_use]
    pub fn schema() -> Schema {
        schema("DroneState", &DRONE_STATE)
    }
}

/// A message as a schema: a set of one file, `uchain.proto`, that defines just this.
fn schema(name: &str, fields: &[Field]) -> Schema {
    let field = |(index, (name, kind, label)): (usize, &Field)| FieldDescriptorProto {
        name: Some((*name).to_owned()),
        number: i32::try_from(index + 1).ok(),
        label: Some(*label as i32),
        r#type: Some(*kind as i32),
        ..FieldDescriptorProto::default()
    };
    let message = DescriptorProto {
        name: Some(name.to_owned()),
        field: fields.iter().enumerate().map(field).collect(),
        ..DescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some(format!("uchain/{name}.proto")),
        package: Some("uchain".to_owned()),
        message_type: vec![message],
        syntax: Some("proto2".to_owned()),
        ..FileDescriptorProto::default()
    };
    let set = FileDescriptorSet { file: vec![file] };
    (format!("uchain.{name}"), set.encode_to_vec())
}
