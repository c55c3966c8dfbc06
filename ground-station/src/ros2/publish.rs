//! Publishes what the station knows of the chain: only what the drones have said, and no places, which the
//! station does not know.
//!
//! | topic | message |
//! |---|---|
//! | `/drone_N/link/back/filtered_dbm` | `std_msgs/msg/Float32`: the strength of the link towards the base |
//! | `/drone_N/battery_v`, `/drone_N/odometer_m` | `std_msgs/msg/Float32` |
//! | `/diagnostics` | `diagnostic_msgs/msg/DiagnosticArray`: the base and each drone in words |
//! | `/notice` | `std_msgs/msg/String`: what became of orders, and what else happened |

use std::collections::BTreeMap;
use std::io;
use std::time::{SystemTime, UNIX_EPOCH};

use ros2_topics::messages::{DiagnosticArray, DiagnosticStatus, Float32, Header, KeyValue, Text};
use ros2_topics::{Sink, Topic};

use super::state::{Base, Drone, State};

/// The time between two messages of diagnostics, ms.
const DIAGNOSTICS_EVERY: u64 = 1_000;

/// Of `DiagnosticStatus`.
const OK: u8 = 0;
const WARN: u8 = 1;
const ERROR: u8 = 2;
const STALE: u8 = 3;

/// The topics, and what was published on them.
pub(super) struct Published {
    diagnostics: Topic<DiagnosticArray>,
    notice: Topic<Text>,
    drones: BTreeMap<u8, Own>,
    /// The stamp of the last state that was published, and of the last one in the diagnostics.
    stamp: Option<u64>,
    diagnosed: Option<u64>,
}

/// The topics of one drone.
#[derive(Clone, Copy)]
struct Own {
    link: Topic<Float32>,
    battery: Topic<Float32>,
    odometer: Topic<Float32>,
    /// The age of the last report that was published.
    age_s: f32,
}

impl Published {
    /// Adds the topics of the station to a sink; those of drones are added as drones are heard.
    pub(super) fn new<S: Sink + ?Sized>(sink: &mut S) -> io::Result<Self> {
        Ok(Self {
            diagnostics: Topic::add(sink, "/diagnostics", false)?,
            notice: Topic::add(sink, "/notice", false)?,
            drones: BTreeMap::new(),
            stamp: None,
            diagnosed: None,
        })
    }

    /// Publishes what is new in a state, and the notices.
    pub(super) fn put<S: Sink + ?Sized>(
        &mut self,
        sink: &mut S,
        state: &State,
        notices: &[String],
    ) -> io::Result<()> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let now = u64::try_from(now.as_micros()).unwrap_or(u64::MAX);
        for text in notices {
            self.notice.put(sink, now, &Text { data: text.clone() })?;
        }
        if self.stamp.replace(state.stamp) == Some(state.stamp) {
            return Ok(());
        }
        for drone in &state.drones {
            self.put_report(sink, drone, now)?;
        }
        let is_due = |then| state.stamp.saturating_sub(then) >= DIAGNOSTICS_EVERY;
        if self.diagnosed.is_none_or(is_due) {
            self.diagnosed = Some(state.stamp);
            self.diagnostics.put(sink, now, &diagnostics(state, now))?;
        }
        Ok(())
    }

    /// Publishes a drone's report, if it is a new one: the report of the state before has grown older
    /// since.
    fn put_report<S: Sink + ?Sized>(
        &mut self,
        sink: &mut S,
        drone: &Drone,
        now: u64,
    ) -> io::Result<()> {
        let known = self.drones.get(&drone.node).copied();
        let own = match known {
            Some(own) if drone.age_s >= own.age_s => Own { age_s: drone.age_s, ..own },
            Some(own) => Own { age_s: drone.age_s, ..own }.put(sink, drone, now)?,
            None => Own::new(sink, drone)?.put(sink, drone, now)?,
        };
        self.drones.insert(drone.node, own);
        Ok(())
    }
}

impl Own {
    fn new<S: Sink + ?Sized>(sink: &mut S, drone: &Drone) -> io::Result<Self> {
        let mut topic = |what| Topic::add(sink, &format!("{}/{what}", prefix(drone)), false);
        let link = topic("link/back/filtered_dbm")?;
        let (battery, odometer) = (topic("battery_v")?, topic("odometer_m")?);
        Ok(Self { link, battery, odometer, age_s: drone.age_s })
    }

    fn put<S: Sink + ?Sized>(self, sink: &mut S, drone: &Drone, now: u64) -> io::Result<Self> {
        let values = [
            (self.link, drone.link.as_ref().map(|link| link.dbm)),
            (self.battery, drone.battery_v),
            (self.odometer, Some(drone.odometer_m)),
        ];
        for (topic, value) in values {
            if let Some(data) = value {
                topic.put(sink, now, &Float32 { data })?;
            }
        }
        Ok(self)
    }
}

/// The drone's part of the names of its topics.
fn prefix(drone: &Drone) -> String {
    format!("/drone_{}", drone.node)
}

/// The base and each drone in words.
fn diagnostics(state: &State, now: u64) -> DiagnosticArray {
    let drones = state.drones.iter().map(status);
    let status = std::iter::once(base(state)).chain(drones).collect();
    DiagnosticArray { header: Header::at_micros(now, ""), status }
}

fn pair(key: &str, value: impl ToString) -> KeyValue {
    KeyValue { key: key.to_owned(), value: value.to_string() }
}

/// The base, by name and hardware as the simulator has them, with what to do next.
fn base(state: &State) -> DiagnosticStatus {
    let mut values = vec![pair("advice", &state.advice.text)];
    values.extend(state.task.as_ref().map(|task| pair("task", task)));
    let (level, message) = match &state.base {
        _ if !state.hears_base => (ERROR, "the station does not hear it".to_owned()),
        None => (WARN, "the station does not know it yet".to_owned()),
        Some(Base { recalled: true, radio, .. }) => {
            (WARN, format!("{radio}; a drone must come home"))
        }
        Some(Base { radio, .. }) => (OK, radio.clone()),
    };
    let hardware = state.base.as_ref().map(|base| format!("drone_{}", base.node));
    DiagnosticStatus {
        level,
        name: "base".to_owned(),
        message,
        hardware_id: hardware.unwrap_or_default(),
        values,
    }
}

fn status(drone: &Drone) -> DiagnosticStatus {
    let mut values = vec![pair("odometer_m", drone.odometer_m), pair("age_s", drone.age_s)];
    values.extend(drone.battery_v.map(|volts| pair("battery_v", volts)));
    values.extend(drone.endurance_s.map(|seconds| pair("endurance_s", seconds)));
    if let Some(link) = &drone.link {
        values.push(pair("back_peer", link.to));
        values.push(pair("back_filtered_dbm", link.dbm));
        values.push(pair("back_grade", &link.grade));
    }
    let grade = drone.link.as_ref().map(|link| link.grade.as_str());
    let (level, wrong) = match (&drone.fault, drone.silent, grade) {
        (Some(fault), _, _) => (ERROR, Some(fault.as_str())),
        (None, true, _) => (STALE, Some("silent")),
        (None, false, Some("weak")) => (WARN, Some("a link is below the launch limit")),
        (None, false, Some("too weak")) => (WARN, Some("a link is below the retreat limit")),
        (None, false, _) => (OK, None),
    };
    let wrong = wrong.map_or_else(String::new, |wrong| format!(", {wrong}"));
    DiagnosticStatus {
        level,
        name: drone.name.clone(),
        message: format!("{}{wrong}", drone.state),
        hardware_id: format!("drone_{}", drone.node),
        values,
    }
}

#[cfg(test)]
mod tests {
    use ros2_topics::About;
    use serde_json::{Value, json};

    use super::*;

    /// The topics, and the number of messages of each.
    #[derive(Default)]
    struct Counts(Vec<(String, usize)>);

    impl Sink for Counts {
        fn topic(&mut self, about: &About<'_>) -> io::Result<usize> {
            self.0.push((about.name.to_owned(), 0));
            Ok(self.0.len() - 1)
        }

        fn put(&mut self, topic: usize, _: u64, _: &[u8]) -> io::Result<()> {
            self.0[topic].1 += 1;
            Ok(())
        }
    }

    impl Counts {
        fn of(&self, name: &str) -> usize {
            self.0.iter().find(|(topic, _)| topic == name).map_or(0, |(_, count)| *count)
        }
    }

    fn state(stamp: u64, drone: &Value) -> State {
        let json = json!({
            "stamp": stamp, "hears_base": true, "drones": [drone], "advice": { "text": "Wait." },
            "base": { "node": 4, "radio": "it is a member of the chain", "recalled": false },
        });
        State::read(&json.to_string()).unwrap()
    }

    fn drone(age_s: f32) -> Value {
        json!({
            "node": 1, "name": "relay 1", "state": "relaying", "airborne": true, "age_s": age_s,
            "silent": false, "odometer_m": 2.5,
            "link": { "to": 4, "dbm": -61.5, "grade": "good" },
        })
    }

    #[test]
    fn a_report_is_published_once_and_the_diagnostics_each_second() {
        let mut sink = Counts::default();
        let mut published = Published::new(&mut sink).unwrap();
        for n in 0..=20 {
            // The drone speaks every second; the station looks at each state twice.
            let state = state(100 * n, &drone((n % 10) as f32 * 0.1));
            let notices: &[_] = if n == 3 { &["The base is there.".to_owned()] } else { &[] };
            published.put(&mut sink, &state, notices).unwrap();
            published.put(&mut sink, &state, &[]).unwrap();
        }
        assert_eq!(sink.of("/drone_1/link/back/filtered_dbm"), 3);
        assert_eq!(sink.of("/drone_1/odometer_m"), 3);
        assert_eq!(sink.of("/drone_1/battery_v"), 0, "the drone says nothing of it");
        assert_eq!(sink.of("/diagnostics"), 3);
        assert_eq!(sink.of("/notice"), 1);
    }

    #[test]
    fn diagnostics_say_what_is_wrong() {
        let level = |key: &str, value: Value| {
            let mut drone = drone(0.1);
            drone[key] = value;
            let DiagnosticStatus { level, message, .. } =
                diagnostics(&state(0, &drone), 0).status[1].clone();
            (level, message)
        };
        let of = |level, message: &str| (level, message.to_owned());
        assert_eq!(level("age_s", json!(0.2)), of(OK, "relaying"));
        let link = json!({ "to": 4, "dbm": -71.0, "grade": "weak" });
        assert_eq!(level("link", link), of(WARN, "relaying, a link is below the launch limit"));
        assert_eq!(level("silent", json!(true)), of(STALE, "relaying, silent"));
        assert_eq!(level("fault", json!("a motor")), of(ERROR, "relaying, a motor"));
        let mut lost = state(0, &drone(0.1));
        lost.hears_base = false;
        assert_eq!(base(&lost).level, ERROR);
    }
}
