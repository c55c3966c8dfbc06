//! A fleet as crazyswarm2's `crazyflies.yaml`: what the command prints and writes, and what the reader
//! of YAML that crazyswarm2 has makes of it.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::station_process::command;

#[test]
fn the_transcripts_are_what_is_printed() {
    trycmd::TestCases::new()
        .register_bin("uchain-ground", Path::new(env!("CARGO_BIN_EXE_uchain-ground")))
        .env("COLUMNS", "100")
        .case("tests/cmd/*.trycmd");
}

/// Reads a file as crazyswarm2's launch file and servers do, and prints what they would connect to.
const READ: &str = "
import json, sys, yaml
file = yaml.safe_load(open(sys.argv[1]))
assert file.get('fileversion', 1) >= 2
found = {}
for name, robot in file['robots'].items():
    kind = file['robot_types'][robot['type']]
    assert isinstance(name, str) and kind['motion_capture']['tracking'] != 'librigidbodytracker'
    assert all(isinstance(metres, float) for metres in robot['initial_position'])
    if robot['enabled'] and kind.get('connection', 'crazyflie') == 'crazyflie':
        found[name] = [robot['uri'], robot['initial_position']]
assert file['all']['firmware_logging']['enabled'] is False
def parameters(value):
    if isinstance(value, dict):
        return all(isinstance(key, str) and parameters(each) for key, each in value.items())
    return value is not None and value != []
assert parameters(file), 'ROS 2 takes no null and no empty list'
print(json.dumps([found, file['uchain']]))
";

#[test]
#[ignore = "needs python3 with PyYAML"]
fn pyyaml_reads_an_exported_fleet_as_crazyswarm2_does() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("crazyflies.yaml");
    let fleet = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd/fleet.in/drones.toml");
    let status = command().args(["--fleet", fleet, "--export"]).arg(&file).status().unwrap();
    assert!(status.success());
    let output = Command::new("python3").args(["-c", READ]).arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: Value = serde_json::from_slice(&output.stdout).unwrap();
    let uri = |end: &str| format!("radio://0/80/2M/E7E7E7E7{end}");
    let robots = serde_json::json!({
        "Ada": [uri("00"), [1.05, 0.0, 0.0]],
        "cf1": [uri("01"), [0.7, 0.0, 0.0]],
        "cf2": [uri("E7"), [0.35, 0.0, 0.0]],
        "Base": [uri("0F"), [0.0, 0.0, 0.0]],
    });
    assert_eq!(read[0], robots);
    assert_eq!(read[1]["firmware"]["revision"], "0123456789ab");
    assert_eq!(read[1]["limits"]["launch_limit_dbm"], -67.0);
}
