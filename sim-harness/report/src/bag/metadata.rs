//! `metadata.yaml`, by which programs of ROS 2 find the files and the topics of a bag.

use std::fmt::Write;

use super::BAG;
use crate::mcap::Moment;
use mission::trace::Trace;

/// A topic of the bag.
pub(super) struct Known {
    pub(super) name: String,
    /// The message's package and name.
    pub(super) kind: &'static str,
    pub(super) is_latched: bool,
    /// The messages so far.
    pub(super) count: u32,
}

/// How the messages of a topic are to be sent, as YAML of rosbag2's version 9, behind so many spaces.
pub(super) fn qos(is_latched: bool, indent: usize) -> String {
    let (depth, durability) = if is_latched { (1, "transient_local") } else { (10, "volatile") };
    let lines = [
        "- history: keep_last".to_owned(),
        format!("  depth: {depth}"),
        "  reliability: reliable".to_owned(),
        format!("  durability: {durability}"),
        "  deadline: {sec: 0, nsec: 0}".to_owned(),
        "  lifespan: {sec: 0, nsec: 0}".to_owned(),
        "  liveliness: automatic".to_owned(),
        "  liveliness_lease_duration: {sec: 0, nsec: 0}".to_owned(),
        "  avoid_ros_namespace_conventions: false".to_owned(),
    ];
    lines.iter().map(|line| format!("{:indent$}{line}\n", "")).collect()
}

/// The file.
pub(super) fn text(trace: &Trace, topics: &[Known], span: Option<(Moment, Moment)>) -> String {
    let (first, last) = span.map_or((0, 0), |(first, last)| (first.nanos(), last.nanos()));
    let duration = last - first;
    let count: u64 = topics.iter().map(|topic| u64::from(topic.count)).sum();
    // A string of JSON is one of YAML.
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {duration}\n  starting_time:\n    nanoseconds_since_epoch: {first}\n  \
         message_count: {count}\n  topics_with_message_count:\n"
    );
    for Known { name, kind, is_latched, count } in topics {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "    - topic_metadata:\n        name: {name}\n        type: {kind}\n        \
             serialization_format: cdr\n        offered_qos_profiles:\n{}        \
             type_description_hash: \"\"\n      message_count: {count}\n",
            qos(*is_latched, 10)
        );
    }
    let seed = trace.seed.map_or_else(String::new, |seed| seed.to_string());
    let _ = write!(
        text,
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {BAG}\n  \
         files:\n    - path: {BAG}\n      starting_time:\n        nanoseconds_since_epoch: {first}\n      \
         duration:\n        nanoseconds: {duration}\n      message_count: {count}\n  custom_data:\n    \
         scenario: {}\n    seed: {}\n  ros_distro: jazzy\n",
        quoted(&trace.scenario),
        quoted(&seed)
    );
    text
}
