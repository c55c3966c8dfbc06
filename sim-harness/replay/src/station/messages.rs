//! Reads the messages of a `station.mcap`.

use serde::de::DeserializeOwned;

use recordings::mcap_file;
use station_log::{DroneReport, GivenOrder, Limits, OrderEvent, Plan};

/// A way that is longer is none that a drone has flown, m; a picture of it could not be drawn.
const FARTHEST_M: f32 = 10_000.0;

/// A message with the time at which the station wrote it.
pub(super) struct Heard {
    /// The time since 1970.
    pub(super) micros: u64,
    pub(super) message: Message,
}

/// A message that a record is made of.
pub(super) enum Message {
    Report(DroneReport),
    Limits(Limits),
    Plan(Plan),
    /// The base has taken this order.
    Ordered(GivenOrder),
    /// A page ordered a stop.
    Stop,
}

/// The messages in order of time. Messages of other topics and those that are not of their schema
/// are passed over; where the end of the file is missing or damaged, what stands before it is read.
pub(super) fn read(bytes: &[u8]) -> Vec<Heard> {
    let mut heard = Vec::new();
    mcap_file::read(bytes, &mut |message| {
        let micros = message.time_ns / 1000;
        heard.extend(parse(message.topic, message.data).map(|message| Heard { micros, message }));
    });
    heard.sort_by_key(|heard| heard.micros);
    heard
}

fn parse(topic: &str, data: &[u8]) -> Option<Message> {
    match topic {
        Limits::TOPIC => of_json(data).map(Message::Limits),
        Plan::TOPIC => of_json(data).map(Message::Plan),
        OrderEvent::TOPIC => match of_json(data)? {
            OrderEvent { event, .. } if event == "stop" => Some(Message::Stop),
            OrderEvent { order: Some(order), fate: Some(fate), .. } if fate == "taken" => {
                Some(Message::Ordered(order))
            }
            _ => None,
        },
        _ => {
            let report: DroneReport = of_json(data)?;
            let is_sound = topic == DroneReport::topic(report.node)
                && (-FARTHEST_M..=FARTHEST_M).contains(&report.odometer_m);
            is_sound.then_some(Message::Report(report))
        }
    }
}

fn of_json<T: DeserializeOwned>(data: &[u8]) -> Option<T> {
    serde_json::from_slice(data).ok()
}
