//! Defines the messages of a `station.mcap`, which the ground station writes and `uchain replay`
//! reads: JSON, each with a JSON Schema that the file carries.
//!
//! | topic | message |
//! |---|---|
//! | `/drone/N/report` | [`DroneReport`] |
//! | `/base` | [`BaseReport`] |
//! | `/limits` | [`Limits`] |
//! | `/order` | [`OrderEvent`] |
//! | `/map` | [`Plan`] |
//! | `/console`, `/notice` | [`Line`] |

mod chain_line;

use serde::{Deserialize, Serialize};
use units::Point2;

pub use chain_line::ChainLine;
use world::{CentreLine, FloorPlan};

/// The name of a schema and its text, a JSON Schema.
pub type Schema = (&'static str, &'static str);

/// What a drone said last, by its telemetry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DroneReport {
    /// The drone's number.
    pub node: u8,
    /// What the drone is doing, in words.
    pub state: String,
    /// The same as the code of `nodeN.state`.
    pub state_code: u8,
    /// What is wrong with the drone, in words; empty for nothing.
    pub fault: String,
    /// The battery's voltage in V.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub battery_v: Option<f32>,
    /// The time for which the battery still carries the drone, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub endurance_s: Option<f32>,
    /// The way along the tunnel since take-off, in m.
    pub odometer_m: f32,
    /// The neighbour towards the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub back: Option<u8>,
    /// The strength of the link to it by the on-board filter, in dBm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rssi_dbm: Option<f32>,
}

impl DroneReport {
    /// The schema.
    pub const SCHEMA: Schema = (
        "uchain.DroneReport",
        r#"{"type":"object","properties":{"node":{"type":"integer"},"state":{"type":"string"},"state_code":{"type":"integer"},"fault":{"type":"string"},"battery_v":{"type":"number"},"endurance_s":{"type":"number"},"odometer_m":{"type":"number"},"back":{"type":"integer"},"rssi_dbm":{"type":"number"}}}"#,
    );

    /// The topic of a drone's reports.
    #[must_use]
    pub fn topic(node: u8) -> String {
        format!("/drone/{node}/report")
    }
}

/// What the base says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaseReport {
    /// The state of its radio link, in words.
    pub link: String,
    /// Whether a drone of the chain must come home.
    pub recalled: bool,
    /// The number of packets of the chain that it refused.
    pub refused: u32,
}

impl BaseReport {
    /// The schema.
    pub const SCHEMA: Schema = (
        "uchain.BaseReport",
        r#"{"type":"object","properties":{"link":{"type":"string"},"recalled":{"type":"boolean"},"refused":{"type":"integer"}}}"#,
    );
    /// The topic.
    pub const TOPIC: &'static str = "/base";
}

/// The base's number and limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// The base's number.
    pub base: u8,
    /// A link that is weaker calls for the next relay, in dBm.
    pub launch_limit_dbm: f32,
    /// A link that is weaker sends its relay back, in dBm.
    pub retreat_limit_dbm: f32,
}

impl Limits {
    /// The schema.
    pub const SCHEMA: Schema = (
        "uchain.Limits",
        r#"{"type":"object","properties":{"base":{"type":"integer"},"launch_limit_dbm":{"type":"number"},"retreat_limit_dbm":{"type":"number"}}}"#,
    );
    /// The topic.
    pub const TOPIC: &'static str = "/limits";
}

/// An order at one step of its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrderEvent {
    /// `ordered` and `answered` for an order; `stop`, or `gave-up` waiting for answers to it.
    pub event: String,
    /// The order; missing for a stop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<GivenOrder>,
    /// What became of it, once it is answered: `taken`, `refused`, …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fate: Option<String>,
}

impl OrderEvent {
    /// The schema.
    pub const SCHEMA: Schema = (
        "uchain.Order",
        r#"{"type":"object","properties":{"event":{"type":"string"},"order":{"type":"object","properties":{"order":{"type":"string"},"speed":{"type":"number"},"way":{"type":"string"}}},"fate":{"type":"string"}}}"#,
    );
    /// The topic.
    pub const TOPIC: &'static str = "/order";
}

/// An order as the page gave it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GivenOrder {
    /// `wait`, `hold`, `explore`, `branch`, `recall`, `land` or `perch`.
    pub order: String,
    /// The speed to explore at, in m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f32>,
    /// The choice of a branch: `left`, `right`, `straight` or `none`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub way: Option<String>,
}

/// A line of text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// The text.
    pub text: String,
}

impl Line {
    /// The schema.
    pub const SCHEMA: Schema =
        ("uchain.Line", r#"{"type":"object","properties":{"text":{"type":"string"}}}"#);
    /// The topic of what the base's console printed.
    pub const CONSOLE: &'static str = "/console";
    /// The topic of the station's own notices.
    pub const NOTICE: &'static str = "/notice";
}

/// A floor plan seen from above, in metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The closed outlines of the free space.
    pub outlines: Vec<Vec<[f32; 2]>>,
    /// The centre-lines, of which the first is the way that the chain flies in.
    pub lines: Vec<PlanLine>,
    /// How far along the first centre-line the base stands.
    pub base_m: f32,
}

/// One centre-line of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanLine {
    /// The name of the gallery.
    pub name: String,
    /// The points, from its beginning to its end.
    pub points: Vec<[f32; 2]>,
}

impl Plan {
    /// The schema.
    pub const SCHEMA: Schema = (
        "uchain.Plan",
        r#"{"type":"object","properties":{"outlines":{"type":"array","items":{"type":"array","items":{"type":"array","items":{"type":"number"}}}},"lines":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"points":{"type":"array","items":{"type":"array","items":{"type":"number"}}}}}},"base_m":{"type":"number"}}}"#,
    );
    /// The topic.
    pub const TOPIC: &'static str = "/map";

    /// The plan of a tunnel's floor plan, with the base so far along its first centre-line.
    #[must_use]
    pub fn of(plan: &FloorPlan, base_m: f32) -> Self {
        let points = |line: &[Point2]| line.iter().map(|point| [point.x, point.y]).collect();
        let line =
            |line: &CentreLine| PlanLine { name: line.name.clone(), points: points(&line.points) };
        Self {
            outlines: plan.outlines.iter().map(|outline| points(outline)).collect(),
            lines: plan.centre_lines.iter().map(line).collect(),
            base_m,
        }
    }

    /// The floor plan of a recorded or drawn mission.
    #[must_use]
    pub fn floor_plan(&self) -> FloorPlan {
        let points = |line: &[[f32; 2]]| line.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        let line =
            |line: &PlanLine| CentreLine { name: line.name.clone(), points: points(&line.points) };
        FloorPlan {
            outlines: self.outlines.iter().map(|outline| points(outline)).collect(),
            centre_lines: self.lines.iter().map(line).collect(),
        }
    }
}

/// Every schema.
pub const SCHEMAS: [Schema; 6] = [
    DroneReport::SCHEMA,
    BaseReport::SCHEMA,
    Limits::SCHEMA,
    OrderEvent::SCHEMA,
    Line::SCHEMA,
    Plan::SCHEMA,
];
