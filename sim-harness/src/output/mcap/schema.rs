//! The two messages of our own: what a drone did, and how a link was.
//!
//! In protobuf's terms they are proto2 with required fields, because proto3 leaves zeros out: a
//! viewer would show nothing where a drone stands at 0. Field numbers never change; a new field
//! takes the next one.

use foxglove::{Encode, Schema};
use prost::bytes::BufMut;
use prost::{EncodeError, Message};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

use crate::measure::trace::{DroneFrame, LinkFrame};

/// One link as the drone at one end of it knew it, beside the truth.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Link {
    /// Number of the drone at the other end.
    #[prost(uint32, required, tag = "1")]
    pub(crate) peer: u32,
    /// The last packet.
    #[prost(float, required, tag = "2")]
    pub(crate) raw_dbm: f32,
    /// The strength by the on-board filter.
    #[prost(float, required, tag = "3")]
    pub(crate) filtered_dbm: f32,
    /// The true strength, without noise, fading or rounding.
    #[prost(float, required, tag = "4")]
    pub(crate) true_dbm: f32,
}

impl From<&LinkFrame> for Link {
    fn from(link: &LinkFrame) -> Self {
        Self {
            peer: u32::from(link.peer.0),
            raw_dbm: link.raw.0,
            filtered_dbm: link.filtered.0,
            true_dbm: link.truth.0,
        }
    }
}

/// One drone at one moment.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct DroneState {
    /// The state of the agent, as `trace.csv` spells it.
    #[prost(string, required, tag = "1")]
    pub(crate) state: String,
    #[prost(float, required, tag = "2")]
    pub(crate) x_m: f32,
    #[prost(float, required, tag = "3")]
    pub(crate) y_m: f32,
    #[prost(float, required, tag = "4")]
    pub(crate) z_m: f32,
    #[prost(float, required, tag = "5")]
    pub(crate) yaw_rad: f32,
    #[prost(float, required, tag = "6")]
    pub(crate) way_m: f32,
    #[prost(float, required, tag = "7")]
    pub(crate) forward_m_s: f32,
    #[prost(float, required, tag = "8")]
    pub(crate) left_m_s: f32,
    #[prost(float, required, tag = "9")]
    pub(crate) yaw_rate_rad_s: f32,
    /// The beams; absent where nothing was seen or measured.
    #[prost(float, optional, tag = "10")]
    pub(crate) range_nw_m: Option<f32>,
    #[prost(float, optional, tag = "11")]
    pub(crate) range_ne_m: Option<f32>,
    #[prost(float, optional, tag = "12")]
    pub(crate) range_sw_m: Option<f32>,
    #[prost(float, optional, tag = "13")]
    pub(crate) range_se_m: Option<f32>,
}

impl From<&DroneFrame> for DroneState {
    fn from(drone: &DroneFrame) -> Self {
        let [x_m, y_m, z_m] = super::scene::spatial(drone);
        let [forward_m_s, left_m_s] = drone.commanded;
        let [nw, ne, sw, se] = drone.ranges.map(|range| Some(range).filter(|r| r.is_finite()));
        Self {
            state: drone.state.name().to_owned(),
            x_m,
            y_m,
            z_m,
            yaw_rad: drone.pose.yaw.0,
            way_m: drone.way,
            forward_m_s,
            left_m_s,
            yaw_rate_rad_s: drone.yaw_rate,
            range_nw_m: nw,
            range_ne_m: ne,
            range_sw_m: sw,
            range_se_m: se,
        }
    }
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
    Schema::new(format!("uchain.{name}"), "protobuf", set.encode_to_vec())
}

/// Lets one of our messages stand beside Foxglove's.
macro_rules! encode {
    ($message:ident, $name:literal, $fields:ident) => {
        impl Encode for $message {
            type Error = EncodeError;

            fn get_schema() -> Option<Schema> {
                Some(schema($name, &$fields))
            }

            fn get_message_encoding() -> String {
                "protobuf".to_owned()
            }

            fn encode(&self, buf: &mut impl BufMut) -> Result<(), EncodeError> {
                Message::encode(self, buf)
            }
        }
    };
}

encode!(Link, "Link", LINK);
encode!(DroneState, "DroneState", DRONE_STATE);
