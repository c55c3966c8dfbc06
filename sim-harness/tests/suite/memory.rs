//! The memory that a mission takes, and what becomes of one for which there is too little.

#![cfg(target_os = "linux")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of this test's own that holds nothing.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("memory").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A mission that waits for so long, with so many relays.
fn mission(folder: &Path, relays: usize, seconds: usize) -> PathBuf {
    let text = format!(
        "title = \"A long wait\"\nduration_s = {seconds}.0\n[tunnel]\nwidth_m = 1.4\n\
         centre_line_m = [[0, 0], [60, 0]]\n[drones]\nrelays = {relays}\n\
         [[pilot]]\nat_s = 0\norder = \"wait\"\n"
    );
    let file = folder.join("mission.toml");
    fs::write(&file, text).unwrap();
    file
}

/// Runs a command that may allocate so much, kB.
fn within(most: &str, args: &[&str], paths: [&Path; 2]) -> Output {
    let limited = "ulimit -d \"$1\" || exit 99; shift; exec \"$@\"";
    let mut command = Command::new("sh");
    // The stacks of threads count, and each core has one.
    command.env("RAYON_NUM_THREADS", "1");
    command.args(["-c", limited, "sh", most, env!("CARGO_BIN_EXE_uchain")]).args(args);
    command.arg(paths[0]).arg("--out").arg(paths[1]).output().unwrap()
}

/// The names in a folder, hidden ones too.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

/// A record has at most as many frames as a mission of 20 minutes, and the files of every frame are
/// written while it is flown: what suffices for such a mission suffices for one three times as long.
/// Without either, two drones took 40 kB more for each second, some 100 MB here.
#[test]
fn memory_does_not_grow_with_a_missions_length() {
    let folder = folder("long");
    let out = folder.join("out");
    for seconds in [1200, 3600] {
        let file = mission(&folder, 1, seconds);
        // A mission of 20 minutes takes half of it.
        let output = within("40000", &["run", "--quiet"], [&file, &out]);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{seconds} s: {complaint}");
        // Each second has five frames, of three nodes each.
        let rows = fs::read_to_string(out.join("trace.csv")).unwrap().lines().count();
        assert!(rows > 10 * seconds, "{seconds} s: {rows} rows");
    }
}

#[test]
fn a_run_for_which_there_is_too_little_memory_is_refused_in_one_line() {
    let folder = folder("refused");
    let file = mission(&folder, 14, 1200);
    let output = within("40000", &["run"], [&file, &folder.join("out")]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(complaint.starts_with("uchain: there is too little memory: "), "{complaint}");
    assert!(complaint.lines().count() == 1 && complaint.contains("; "), "{complaint}");
    assert_eq!(names(&folder), ["mission.toml"]);
}

/// The refusal is a bound on what is needed: with what it asks for a mission is flown.
#[test]
fn a_run_with_the_memory_that_it_asks_for_is_flown() {
    let folder = folder("enough");
    for relays in [1, 14] {
        let file = mission(&folder, relays, 1200);
        // 6 MiB, 800 bytes for each of 6000 frames and each member, and 24 MB for the program itself,
        // which takes most where it is built without optimization.
        let most = (6 * 1024 + 800 * 6000 * (relays + 2) / 1024 + 24_000).to_string();
        let output = within(&most, &["run", "--quiet"], [&file, &folder.join("out")]);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{relays} relays, {most} kB: {complaint}");
    }
}

/// A campaign whose memory ends while it flies leaves the results before it, and the next command
/// removes the rest.
#[test]
fn memory_that_ends_leaves_the_results_before_and_the_next_command_cleans_up() {
    let folder = folder("ended");
    let (file, out) = (mission(&folder, 1, 20), folder.join("out"));
    let mut fly = Command::new(env!("CARGO_BIN_EXE_uchain"));
    fly.args(["run", "--quiet"]).arg(&file).arg("--out").arg(&out);
    assert_eq!(fly.status().unwrap().code(), Some(0));
    let before = (names(&out), fs::read(out.join("summary.json")).unwrap());
    let ended = within("3000", &["campaign", "--runs", "4", "--quiet"], [&file, &out]);
    let complaint = String::from_utf8_lossy(&ended.stderr);
    // A command that gets no memory is ended by a signal, or by a library that panics.
    assert!(!ended.status.success(), "{complaint}");
    assert!(names(&folder).iter().any(|name| name.contains(".unfinished-")), "it had begun");
    assert_eq!((names(&out), fs::read(out.join("summary.json")).unwrap()), before);
    assert_eq!(fly.status().unwrap().code(), Some(0));
    let left = names(&folder)
        .into_iter()
        .filter(|name| !["mission.toml", "out", "out.rows"].contains(&&**name));
    assert_eq!(left.collect::<Vec<_>>(), [""; 0]);
}
