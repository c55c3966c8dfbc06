//! `onboard` is the only place where agent, link and CRTP server meet: a file of the firmware or of
//! the simulator that joined two of them, or ran an agent by itself, would begin a second drone
//! beside it.

use std::fs;
use std::path::{Path, PathBuf};

const PARTS: [&str; 3] = ["agent", "airlink", "crtp"];

/// Files that may know two of them, and why.
const EXCEPTIONS: [(&str, &str); 2] = [
    (
        "sim-harness/bodies/src/emulated/provision.rs",
        "makes keys and limits for a drone, and no drone",
    ),
    ("sim-harness/serve/src/tests.rs", "builds drones for a world of its own"),
];

/// The files that may run an agent by itself: they give the agent the inputs that the chip's agent had,
/// and compare the decisions.
const COMPARE_AGENTS: [&str; 2] =
    ["sim-harness/bodies/src/emulated/shadow.rs", "tests/suite/virtual_drones.rs"];

/// The Rust files of the firmware, of the simulator and of the tests, each with its name from the
/// root and its code without the comments.
fn code() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    // The emulator knows the firmware as a file; a test of its own says so.
    let rooms = fs::read_dir(root.join("sim-harness")).unwrap().map(|room| room.unwrap().path());
    let rooms = rooms.filter(|room| room.file_name().unwrap() != "virtual-crazyflie");
    let rooms = rooms.map(|room| if room.ends_with("src") { room } else { room.join("src") });
    sources(&root.join("src"), &mut files);
    rooms.filter(|room| room.is_dir()).for_each(|room| sources(&room, &mut files));
    sources(&root.join("tests"), &mut files);
    assert!(files.len() > 100, "{} files", files.len());
    let name = |file: &Path| file.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
    files.iter().map(|file| (name(file), without_comments(file))).collect()
}

fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, all);
        } else if path.extension().is_some_and(|is| is == "rs") {
            all.push(path);
        }
    }
}

fn without_comments(file: &Path) -> String {
    let code = fs::read_to_string(file).unwrap();
    let lines: Vec<_> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    lines.join("\n")
}

/// Whether the code names a path of this crate.
fn names(code: &str, part: &str) -> bool {
    let path = format!("{part}::");
    code.match_indices(&path).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        before.is_none_or(|c| !(is_of_a_name(c) || c == ':'))
    })
}

/// Whether the code names this type.
fn names_type(code: &str, name: &str) -> bool {
    code.split(|c| !is_of_a_name(c)).any(|word| word == name)
}

fn is_of_a_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

#[test]
fn agent_link_and_crtp_server_meet_in_onboard_alone() {
    let mut used = Vec::new();
    let mut wrong = Vec::new();
    for (name, code) in code() {
        let found: Vec<_> = PARTS.into_iter().filter(|part| names(&code, part)).collect();
        if found.len() < 2 {
            continue;
        }
        match EXCEPTIONS.iter().find(|(file, _)| *file == name) {
            Some((file, _)) => used.push(*file),
            None => wrong.push(format!("{name} uses {}", found.join(" and "))),
        }
    }
    assert!(wrong.is_empty(), "use onboard::Drone instead, or say why not:\n{}", wrong.join("\n"));
    for (file, why) in EXCEPTIONS {
        assert!(used.contains(&file), "{file} is no exception any more: it {why}");
    }
}

#[test]
fn no_agent_runs_outside_onboard() {
    let this = "tests/suite/one_drone.rs";
    let runs: Vec<_> = code()
        .into_iter()
        .filter(|(name, code)| name != this && names_type(code, "Agent"))
        .map(|(name, _)| name)
        .collect();
    assert_eq!(runs, COMPARE_AGENTS, "use onboard::Drone instead of agent::Agent");
}
