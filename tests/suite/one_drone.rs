//! `onboard` is the only place where agent, link and CRTP server meet: a file of the firmware or of
//! the simulator that joined two of them would begin a second drone beside it.

use std::fs;
use std::path::{Path, PathBuf};

const PARTS: [&str; 3] = ["agent", "airlink", "crtp"];

/// Files that may know two of them, and why.
const EXCEPTIONS: [(&str, &str); 2] = [
    ("sim-harness/src/emulated/provision.rs", "makes keys and limits for a drone, and no drone"),
    ("sim-harness/src/serve/tests.rs", "builds drones for a world of its own"),
];

fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // The emulator knows the firmware as a file; a test of its own says so.
        if path.is_dir() && path.file_name().unwrap() != "virtual-crazyflie" {
            sources(&path, all);
        } else if path.extension().is_some_and(|is| is == "rs") {
            all.push(path);
        }
    }
}

/// Whether the code of a file, its comments left out, names a path of this crate.
fn names(code: &str, part: &str) -> bool {
    let path = format!("{part}::");
    code.lines().filter(|line| !line.trim_start().starts_with("//")).any(|line| {
        line.match_indices(&path).any(|(at, _)| {
            let before = line[..at].chars().next_back();
            before.is_none_or(|c| !(c.is_alphanumeric() || c == '_' || c == ':'))
        })
    })
}

#[test]
fn agent_link_and_crtp_server_meet_in_onboard_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    ["src", "sim-harness/src", "tests"].iter().for_each(|at| sources(&root.join(at), &mut files));
    assert!(files.len() > 100, "{} files", files.len());
    let mut used = Vec::new();
    let mut wrong = Vec::new();
    for file in files {
        let code = fs::read_to_string(&file).unwrap();
        let found: Vec<_> = PARTS.into_iter().filter(|part| names(&code, part)).collect();
        let name = file.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
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
