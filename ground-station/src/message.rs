//! Defines what is recorded and streamed: events, and each of them as a JSON message with its topic
//! and its schema.

use std::time::Duration;

use serde::Serialize;
use station_log::{BaseReport, DroneReport, GivenOrder, Limits, Line, OrderEvent, Plan, Schema};
use units::NodeId;

use crate::blocks;
use crate::order::{Fate, Order, Way};
use crate::range_survey::Sample;
use crate::session::Facts;

/// Something that is recorded, at a time since 1970.
#[derive(Clone, Debug)]
pub struct Record {
    /// The time since 1970.
    pub at: Duration,
    /// What happened.
    pub event: Event,
}

/// What is recorded.
#[derive(Clone, Debug)]
pub enum Event {
    /// A drone said something new.
    Drone(NodeId, blocks::DroneReport),
    /// The base said something about itself.
    Base(blocks::BaseReport),
    /// The base's number and limits are known.
    Limits(Facts),
    /// The floor plan that the page shows.
    Map(Plan),
    /// The base printed a line.
    Console(String),
    /// A page gave an order.
    Ordered(Order),
    /// The fate of an order is known.
    Fate(Order, Fate),
    /// A page ordered a stop.
    Stop,
    /// The operator gave up waiting for answers to the stop.
    GaveUp,
    /// The station printed a notice.
    Notice(String),
    /// A relay that is carried is so far from the base, in metres.
    Mark(NodeId, f32),
    /// A range survey has ended, with these samples.
    Survey(NodeId, Vec<Sample>),
}

/// An event as it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// The topic, which has one schema.
    pub topic: String,
    /// The schema.
    pub schema: Schema,
    /// The message.
    pub json: Vec<u8>,
}

impl Message {
    /// The message of an event.
    ///
    /// # Errors
    /// If a value cannot be written as JSON.
    pub fn of(event: &Event) -> serde_json::Result<Self> {
        match event {
            Event::Drone(node, report) => {
                let report = report_of(*node, report);
                Self::new(DroneReport::topic(node.0), DroneReport::SCHEMA, &report)
            }
            Event::Base(base) => {
                let report = BaseReport {
                    link: crate::words::link(base.link).to_owned(),
                    recalled: base.recalled,
                    refused: base.refused,
                };
                Self::new(BaseReport::TOPIC, BaseReport::SCHEMA, &report)
            }
            Event::Limits(facts) => {
                let limits = Limits {
                    base: facts.node.0,
                    launch_limit_dbm: facts.launch_limit.0,
                    retreat_limit_dbm: facts.retreat_limit.0,
                };
                Self::new(Limits::TOPIC, Limits::SCHEMA, &limits)
            }
            Event::Map(plan) => Self::new(Plan::TOPIC, Plan::SCHEMA, plan),
            Event::Console(text) => Self::line(Line::CONSOLE, text),
            Event::Notice(text) => Self::line(Line::NOTICE, text),
            Event::Ordered(order) => Self::order("ordered", Some(*order), None),
            Event::Fate(order, fate) => Self::order("answered", Some(*order), Some(*fate)),
            Event::Stop => Self::order("stop", None, None),
            Event::GaveUp => Self::order("gave-up", None, None),
            Event::Mark(node, metres) => Self::line(
                Line::NOTICE,
                &format!("Range survey: node {node} is {metres} m from the base."),
            ),
            Event::Survey(node, samples) => {
                let text = format!("Range survey with node {node}: {} samples.", samples.len());
                Self::line(Line::NOTICE, &text)
            }
        }
    }

    fn new(
        topic: impl Into<String>,
        schema: Schema,
        message: &impl Serialize,
    ) -> serde_json::Result<Self> {
        Ok(Self { topic: topic.into(), schema, json: serde_json::to_vec(message)? })
    }

    fn line(topic: &str, text: &str) -> serde_json::Result<Self> {
        Self::new(topic, Line::SCHEMA, &Line { text: text.to_owned() })
    }

    fn order(event: &str, order: Option<Order>, fate: Option<Fate>) -> serde_json::Result<Self> {
        let event = OrderEvent {
            event: event.to_owned(),
            order: order.map(given),
            fate: fate.map(|fate| fate.name().to_owned()),
        };
        Self::new(OrderEvent::TOPIC, OrderEvent::SCHEMA, &event)
    }
}

/// An order as it is written.
fn given(order: Order) -> GivenOrder {
    let (speed, way) = match order {
        Order::Explore { speed } => (Some(speed), None),
        Order::Branch { way } => (None, Some(way)),
        Order::Wait | Order::Hold | Order::Recall | Order::Land | Order::Perch => (None, None),
    };
    let way = way.map(|way: Way| way.name().to_owned());
    GivenOrder { order: order.name().to_owned(), speed, way }
}

/// A drone's report in the units of the messages.
pub(crate) fn report_of(node: NodeId, report: &blocks::DroneReport) -> DroneReport {
    DroneReport {
        node: node.0,
        state: crate::words::state(report.state).to_owned(),
        state_code: report.state,
        fault: crate::words::fault(report.fault).unwrap_or_default().to_owned(),
        battery_v: report.battery.map(|volts| volts.0),
        endurance_s: report.endurance.map(units::Duration::as_secs_f32),
        odometer_m: report.odometer.0,
        back: report.back.map(|(peer, _)| peer.0),
        rssi_dbm: report.back.map(|(_, rssi)| rssi.0),
    }
}
