//! What viewers are given to show a mission: layouts for Foxglove and a recording for Rerun with a blueprint.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;

use ::mcap::{Channel, MessageStream};
use prost::Message;
use prost_types::FileDescriptorSet;
use serde_json::Value;
use sim_harness::mission::Mission;
use sim_harness::mission::trace::Trace;
use sim_harness::report::mcap;
use sim_harness::scenario::Scenario;

/// The first minute and a half of a mission.
fn flown(scenario: &str) -> Trace {
    let scenario = Scenario::open(scenario).unwrap();
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 1);
    let mut trace = mission.begin_trace(1);
    for _ in 0..90 * 5 {
        mission.round();
        trace.frames.push(mission.frame());
    }
    trace
}

fn recorded(trace: &Trace) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    mcap::write(trace, &mut file).unwrap();
    file.into_inner()
}

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/viewers")
}

/// The layout for missions of this kind.
fn layout(name: &str) -> Value {
    let file = assets().join("foxglove").join(name).with_extension("json");
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

/// The topics that have messages, each with the name of its schema and the fields of its messages.
struct Written(BTreeMap<String, (String, BTreeSet<String>)>);

impl Written {
    fn by(trace: &Trace) -> Self {
        let file = recorded(trace);
        let messages = MessageStream::new(&file).unwrap().map(Result::unwrap);
        let channels: BTreeMap<_, _> =
            messages.map(|message| (message.channel.topic.clone(), message.channel)).collect();
        Self(channels.into_iter().map(|(topic, channel)| (topic, schema(&channel))).collect())
    }

    /// Asserts that a layout finds a topic, with one of these schemas.
    fn assert_topic(&self, topic: &str, schemas: &[&str]) {
        let found = self.0.get(topic).map(|(schema, _)| schema.as_str());
        assert!(found.is_some_and(|schema| schemas.contains(&schema)), "{topic}: {found:?}");
    }

    /// Asserts that a layout finds the field of `TOPIC.FIELD`.
    fn assert_path(&self, path: &str) {
        let (topic, field) = path.split_once('.').unwrap();
        let found = self.0.get(topic).is_some_and(|(_, fields)| fields.contains(field));
        assert!(found, "{path} is not in the file");
    }
}

/// The name of a channel's schema, and the fields of its message.
fn schema(channel: &Channel) -> (String, BTreeSet<String>) {
    let schema = channel.schema.as_ref().unwrap();
    let files = FileDescriptorSet::decode(&*schema.data).unwrap().file;
    let messages = files.iter().flat_map(|file| {
        let package = file.package();
        file.message_type
            .iter()
            .map(move |message| (format!("{package}.{}", message.name()), message))
    });
    let own = messages.filter(|(name, _)| *name == schema.name);
    let fields = own.flat_map(|(_, message)| &message.field).map(|field| field.name().to_owned());
    (schema.name.clone(), fields.collect())
}

/// The panels that a layout places.
fn placed(tree: &Value, panels: &mut BTreeSet<String>) {
    match tree {
        Value::String(panel) => assert!(panels.insert(panel.clone()), "{panel} is there twice"),
        tree => ["first", "second"].iter().for_each(|part| placed(&tree[part], panels)),
    }
}

fn assert_panel(id: &str, panel: &Value, written: &Written) {
    let paths = || panel["paths"].as_array().unwrap().iter();
    match id.split_once('!').unwrap().0 {
        "3D" => {
            for topic in panel["topics"].as_object().unwrap().keys() {
                written.assert_topic(topic, &["foxglove.SceneUpdate", "foxglove.PointCloud"]);
            }
        }
        "Plot" | "StateTransitions" => {
            assert!(paths().count() > 1, "{id}");
            paths().for_each(|path| written.assert_path(path["value"].as_str().unwrap()));
        }
        "RosOut" => {
            written.assert_topic(panel["topicToRender"].as_str().unwrap(), &["foxglove.Log"]);
        }
        other => panic!("{other}: no such panel is tested"),
    }
}

#[test]
fn each_layout_for_foxglove_shows_what_a_mission_of_its_kind_writes() {
    for (name, scenario) in
        [("chain", "demo"), ("swarm", "swarm-both"), ("exploration", "explore-room")]
    {
        let trace = flown(scenario);
        let written = Written::by(&trace);
        let layout = layout(name);
        let panels = layout["configById"].as_object().unwrap();
        panels.iter().for_each(|(id, panel)| assert_panel(id, panel, &written));
        let mut shown = BTreeSet::new();
        placed(&layout["layout"], &mut shown);
        assert_eq!(shown, panels.keys().cloned().collect(), "{name}");
        let labels = panels["StateTransitions!states"]["paths"].as_array().unwrap();
        let drones = trace.nodes.iter().take(trace.nodes.len() - 1).map(ToString::to_string);
        assert!(drones.eq(labels.iter().map(|path| path["label"].as_str().unwrap())), "{name}");
    }
}

/// Runs a command of Rerun, or the script that makes a recording for it, and returns what it prints.
fn python(args: &[&str]) -> String {
    let python = std::env::var_os("UCHAIN_RERUN_PYTHON").expect(
        "UCHAIN_RERUN_PYTHON does not name a Python with rerun-sdk and mcap-protobuf-support",
    );
    let output = Command::new(python).arg("-B").args(args).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// The entities of a recording and of its blueprint.
fn entities(stats: &str) -> BTreeSet<&str> {
    let lines = stats.lines().filter(|line| line.starts_with('/'));
    lines.map(|line| line.rsplit_once(": ").unwrap().0).collect()
}

#[test]
#[ignore = "needs the Python packages rerun-sdk and mcap-protobuf-support; UCHAIN_RERUN_PYTHON names the Python"]
fn rerun_draws_walls_drones_and_links_where_its_blueprint_looks_for_them() {
    let script = assets().join("to_rerun.py");
    for (scenario, number) in [("demo", "/drone/1/link/back"), ("swarm-b", "/drone/1/state")] {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("viewers").join(scenario);
        fs::create_dir_all(&folder).unwrap();
        let [recording, made] = ["trace.mcap", "trace.rrd"].map(|name| folder.join(name));
        fs::write(&recording, recorded(&flown(scenario))).unwrap();
        python(&[script.to_str().unwrap(), recording.to_str().unwrap()]);
        let made = made.to_str().unwrap();

        let printed = python(&["-m", "rerun_cli", "rrd", "print", made]);
        let drawn = |topic: &&str| {
            let chunk = format!(" - {topic} - data columns: [");
            printed.lines().any(|line| line.contains(&chunk) && line.contains("Points3D:positions"))
        };
        let clouds = ["/map/walls", "/drones/points", "/drones/links"];
        assert!(clouds.iter().all(drawn), "{printed}");
        let words = printed.split_whitespace().collect::<Vec<_>>().join(" ");
        for kind in ["Recording", "Blueprint"] {
            assert!(words.contains(&format!("StoreId( {kind}, \"uchain\"")), "{printed}");
        }

        let stats = python(&["-m", "rerun_cli", "rrd", "stats", made]);
        let entities = entities(&stats);
        let parts =
            entities.iter().filter_map(|entity| entity.split_once("/ViewContents/overrides"));
        let looked_for: BTreeSet<_> =
            parts.filter_map(|(_, rest)| Some(rest.split_once("/visualizers")?.0)).collect();
        assert!(looked_for.is_subset(&entities), "{looked_for:?} in {entities:?}");
        for entity in clouds.iter().chain([&number, &"/drone/1/state"]) {
            assert!(looked_for.contains(entity), "{entity} in {looked_for:?}");
        }
    }
}
