//! The `uchain` command as a user meets it: what it prints, with which exit status, and what it
//! leaves on the disk.
//!
//! The transcripts are `tests/cmd/*.trycmd` at the root of the repository; where the command was
//! meant to change, `TRYCMD=overwrite cargo test -p sim-harness --test suite cli` writes them anew (and
//! what was elided with `[..]` must be elided again).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const UCHAIN: &str = env!("CARGO_BIN_EXE_uchain");

#[test]
fn the_transcripts_are_what_is_printed() {
    trycmd::TestCases::new()
        .register_bin("uchain", Path::new(UCHAIN))
        .env("COLUMNS", "100")
        .case("../tests/cmd/*.trycmd");
}

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios")
}

fn uchain(args: &[&str]) -> Output {
    Command::new(UCHAIN).args(args).output().unwrap()
}

/// A folder of this test's own that is not there yet.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}

/// The names of the files in a folder, sorted.
fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

/// Refused as bad input is: exit status 2, nothing on standard output, and one line on standard
/// error that has all of `parts`. Returns the line.
fn refused(output: &Output, parts: &[&str]) -> String {
    let complaint = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(2), "{parts:?}: {complaint}");
    assert!(output.stdout.is_empty(), "{complaint}");
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    assert!(complaint.starts_with("uchain: ") && complaint.ends_with('\n'), "{complaint}");
    for part in parts {
        assert!(complaint.contains(part), "no {part:?} in {complaint}");
    }
    complaint
}

/// For each file in `tests/scenarios/bad`, of each verb that reads one: file, line and remedy, and
/// nothing is written.
#[test]
fn a_bad_scenario_is_refused_in_one_line_and_nothing_is_written() {
    let folder = folder("refused");
    let out = folder.to_str().unwrap();
    let bad = scenarios().join("bad");
    for name in files(&bad) {
        let file = bad.join(&name);
        let file = file.to_str().unwrap();
        for args in [
            &["run", file, "--out", out][..],
            &["run", file, "--json", "--quiet", "--out", out],
            &["campaign", file, "--runs", "2", "--out", out],
        ] {
            let complaint = refused(&uchain(args), &[&format!("{file}:"), "; "]);
            let line = complaint
                .split(&format!("{file}:"))
                .nth(1)
                .and_then(|rest| rest.split(':').next())
                .and_then(|line| line.parse::<usize>().ok());
            let most = fs::read_to_string(file).unwrap().lines().count().max(1);
            assert!(line.is_some_and(|line| (1..=most).contains(&line)), "{complaint}");
        }
    }
    assert!(!folder.exists(), "something was written");
}

/// What is no text, or cannot be read at all.
#[test]
fn what_is_no_scenario_at_all_is_refused_in_one_line() {
    let folder = folder("no-scenario");
    fs::create_dir_all(folder.join("directory.toml")).unwrap();
    let noise: Vec<u8> =
        (0..4_096_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    fs::write(folder.join("noise.toml"), noise).unwrap();
    fs::write(folder.join("zeros.toml"), [0; 512]).unwrap();
    let out = folder.join("out");
    for name in ["noise.toml", "zeros.toml", "directory.toml", "missing.toml"] {
        let file = folder.join(name);
        let args = ["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
        refused(&uchain(&args), &[name, "; "]);
        assert!(!out.exists(), "{name}: something was written");
    }
}

#[test]
fn out_writes_exactly_the_files_that_it_lists() {
    let folder = folder("run");
    let file = scenarios().join("short.toml");
    let output = uchain(&["run", file.to_str().unwrap(), "--out", folder.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let found = files(&folder);
    assert_eq!(
        found,
        [
            "files.txt",
            "links.png",
            "links.svg",
            "map-moving.svg",
            "map.png",
            "map.svg",
            "origin.json",
            "positions.png",
            "positions.svg",
            "report.html",
            "scenario.toml",
            "summary.json",
            "trace.csv",
            "trace.mcap",
        ]
    );
    let said = String::from_utf8(output.stdout).unwrap();
    let mut listed: Vec<_> = said
        .lines()
        .filter_map(|line| line.strip_prefix("wrote "))
        .map(|path| Path::new(path).file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    listed.sort();
    assert_eq!(listed, found);

    // One row for each of four members and each of a hundred rounds.
    let table = fs::read_to_string(folder.join("trace.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 4 * 100);
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap();
    assert_eq!((&summary["scenario"], &summary["seed"]), (&"short".into(), &1.into()));
    assert_eq!(summary["version"], env!("CARGO_PKG_VERSION"));
}

/// A swarm and an exploration have no head and no relays.
#[test]
fn drones_have_the_names_of_their_mission_at_its_end() {
    for (scenario, name) in [("swarm-b", "drone"), ("explore-room", "explorer")] {
        let said = String::from_utf8(uchain(&["run", scenario]).stdout).unwrap();
        let states = said.lines().find_map(|line| line.strip_prefix("  at the end")).unwrap();
        assert!(states.trim().starts_with(&format!("{name} 0 ")), "{states}");
        assert!(states.contains(&format!(", {name} 1 ")) && !states.contains("relay"), "{states}");
    }
}

/// The same command twice leaves the same bytes in every file, and `--json` prints what
/// `summary.json` holds.
#[test]
fn the_same_command_leaves_the_same_bytes() {
    let file = scenarios().join("out-of-reach.toml");
    let file = file.to_str().unwrap();
    let folders = [folder("once"), folder("again")];
    let printed = folders.each_ref().map(|folder| {
        let out = folder.to_str().unwrap();
        let output = uchain(&["run", file, "--seed", "9", "--json", "--out", out]);
        assert_eq!(output.status.code(), Some(1), "a mission that fails writes all the same");
        output.stdout
    });
    assert_eq!(printed[0], printed[1]);
    for name in files(&folders[0]) {
        let [once, again] = folders.each_ref().map(|folder| fs::read(folder.join(&name)).unwrap());
        assert!(once == again, "{name} differs");
    }
    let value = |bytes: &[u8]| serde_json::from_slice::<serde_json::Value>(bytes).unwrap();
    let summary = fs::read(folders[0].join("summary.json")).unwrap();
    assert_eq!(value(&printed[0]), value(&summary));
}

/// The files of a campaign.
const CAMPAIGN: [&str; 6] =
    ["files.txt", "origin.json", "runs.csv", "runs.parquet", "scenario.toml", "summary.json"];

/// The number of rows of a campaign.
fn rows(folder: &Path) -> usize {
    fs::read_to_string(folder.join("runs.csv")).unwrap().lines().count() - 1
}

#[test]
fn a_campaign_leaves_its_summary_and_every_run() {
    let folder = folder("campaign");
    let file = scenarios().join("short.toml");
    let out = folder.to_str().unwrap();
    let output =
        uchain(&["campaign", file.to_str().unwrap(), "--runs", "3", "--json", "--out", out]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["runs"], 3);
    assert!(printed["metrics"]["farthest_m"]["value"].is_number());
    assert_eq!(files(&folder), CAMPAIGN);
    assert_eq!(rows(&folder), 3);
}

/// `--quiet` says nothing, and `--out` somewhere impossible is the user's to mend.
#[test]
fn quiet_is_quiet_and_an_impossible_place_is_refused() {
    let file = scenarios().join("short.toml");
    let file = file.to_str().unwrap();
    let output = uchain(&["run", file, "--quiet"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let output = uchain(&["run", file, "--quiet", "--out", &format!("{file}/out")]);
    refused(&output, &["--out"]);
}

/// What `--show` prints is a scenario of its own.
#[test]
fn a_shown_scenario_can_be_flown() {
    let folder = folder("shown");
    fs::create_dir_all(&folder).unwrap();
    for name in ["straight", "paper-wave10", "t-junction"] {
        let shown = uchain(&["run", name, "--show"]);
        assert_eq!(shown.status.code(), Some(0));
        let text = String::from_utf8(shown.stdout).unwrap();
        // A shorter one, before the pilot's first order: this is about the file, not the flight.
        let short: String = text
            .lines()
            .take_while(|line| !line.starts_with("[[pilot]]"))
            .map(|line| if line.starts_with("duration_s") { "duration_s = 1.0" } else { line })
            .flat_map(|line| [line, "\n"])
            .collect();
        let file = folder.join(format!("{name}.toml"));
        fs::write(&file, short).unwrap();
        let flown = uchain(&["run", file.to_str().unwrap(), "--quiet"]);
        assert_eq!(flown.status.code(), Some(0), "{name}");
    }
}

#[test]
#[cfg(unix)]
fn an_input_that_never_ends_is_refused() {
    for args in [&["run", "/dev/zero"][..], &["replay", "/dev/zero"], &["map", "info", "/dev/zero"]]
    {
        refused(&uchain(args), &["zero", "; "]);
    }
}

/// A mission that takes minutes, in a file of this test's own.
fn long_mission(folder: &Path) -> PathBuf {
    fs::create_dir_all(folder).unwrap();
    let short = fs::read_to_string(scenarios().join("short.toml")).unwrap();
    let file = folder.join("long.toml");
    fs::write(&file, short.replace("duration_s = 20.0", "duration_s = 86400.0")).unwrap();
    file
}

/// Starts a command, and interrupts it when its temporary directory is there.
#[cfg(unix)]
fn interrupted(folder: &Path, args: &[&str]) -> Output {
    use std::process::Stdio;
    let mut command = Command::new(UCHAIN);
    command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let unfinished = |name: &String| name.contains(".unfinished-");
    while !files(folder).iter().any(unfinished) {
        assert!(child.try_wait().unwrap().is_none(), "ended before it was interrupted");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    child.wait_with_output().unwrap()
}

#[test]
#[cfg(unix)]
fn a_run_that_is_interrupted_leaves_nothing() {
    let folder = folder("interrupted");
    let file = long_mission(&folder);
    let out = folder.join("out");
    let args = ["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = interrupted(&folder, &args);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{complaint}");
    assert_eq!(complaint, "uchain: interrupted; nothing was written\n");
    assert_eq!(files(&folder), ["long.toml"]);
}

/// Whenever it is interrupted: it says how many missions it flew, and writes so many.
#[test]
#[cfg(unix)]
fn a_campaign_that_is_interrupted_keeps_what_was_flown() {
    let folder = folder("interrupted-campaign");
    fs::create_dir_all(&folder).unwrap();
    let (file, out) = (scenarios().join("short.toml"), folder.join("out"));
    let file = file.to_str().unwrap();
    let args = ["campaign", file, "--runs", "1000000", "--out", out.to_str().unwrap(), "--json"];
    let output = interrupted(&folder, &args);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{complaint}");
    if !out.exists() {
        assert!(complaint.contains("before a mission was flown"), "{complaint}");
        return;
    }
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let flown = summary["runs"].as_u64().unwrap();
    assert_eq!(summary["runs_asked"], 1_000_000);
    assert!(complaint.contains(&format!("{flown} of 1000000 missions")), "{complaint}");
    assert_eq!(rows(&out), flown as usize);
    assert_eq!(files(&folder), ["out", "out.rows"], "the rows are kept for --resume");
}

/// A run that cannot be written is refused before it is flown: this one would take minutes.
#[test]
fn an_out_that_cannot_be_written_is_refused_before_the_flight() {
    let folder = folder("unwritable");
    let file = long_mission(&folder);
    let file = file.to_str().unwrap();
    let notes = folder.join("notes");
    fs::create_dir(&notes).unwrap();
    fs::write(notes.join("todo.txt"), "mine").unwrap();
    for wrong in [file, &format!("{file}/out"), notes.to_str().unwrap()] {
        refused(&uchain(&["run", file, "--out", wrong]), &["--out", "; "]);
    }
    assert_eq!(files(&notes), ["todo.txt"]);
}

/// Killed while it flies, so that it can clean up nothing: the next command does.
#[test]
#[cfg(unix)]
fn what_a_killed_run_has_left_is_removed_by_the_next() {
    let folder = folder("killed");
    let (long, short) = (long_mission(&folder), scenarios().join("short.toml"));
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let mut child =
        Command::new(UCHAIN).args(["run", long.to_str().unwrap(), "--out", out]).spawn().unwrap();
    let is_begun = |name: &String| name.contains(".unfinished-");
    while !files(&folder).iter().any(is_begun) {
        assert!(child.try_wait().unwrap().is_none(), "ended before it was killed");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let busy = uchain(&["run", short.to_str().unwrap(), "--out", out]);
    refused(&busy, &["another uchain is writing into this directory", "; "]);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(files(&folder).iter().any(is_begun));
    let output = uchain(&["run", short.to_str().unwrap(), "--quiet", "--out", out]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(files(&folder), ["long.toml", "out"]);
}

/// A working directory, which cannot be exchanged for another.
#[test]
fn results_can_be_written_into_the_working_directory() {
    let folder = folder("here");
    fs::create_dir_all(&folder).unwrap();
    let short = scenarios().join("short.toml");
    for args in [&["run"][..], &["campaign", "--runs", "1"]] {
        let mut command = Command::new(UCHAIN);
        command.args(args).arg(&short).args(["--quiet", "--out", "."]).current_dir(&folder);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(files(&folder), CAMPAIGN);
}

/// The second of two runs into one directory replaces all files of the first.
#[test]
fn a_run_replaces_the_one_before_it() {
    let folder = folder("replaced");
    let out = folder.to_str().unwrap();
    let short = scenarios().join("short.toml");
    let short = short.to_str().unwrap();
    assert_eq!(uchain(&["run", short, "--out", out]).status.code(), Some(0));
    fs::write(folder.join("notes"), "mine").unwrap();
    let output = uchain(&["campaign", short, "--runs", "1", "--out", out]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let mut names = [&CAMPAIGN[..], &["notes"]].concat();
    names.sort_unstable();
    assert_eq!(files(&folder), names);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_at_standard_output_is_no_success() {
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for args in [&["run", "--show", "demo"][..], &["--help"], &["run", "nowhere"]] {
        let mut command = Command::new(UCHAIN);
        let output = command.args(args).stdout(full()).output().unwrap();
        refused(&output, &["; "]);
        let status = command.stdout(full()).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(2), "where standard error is full, too");
    }
}

#[test]
#[cfg(unix)]
fn a_reader_that_goes_away_is_no_success_and_no_panic() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = Command::new(UCHAIN).args(["run", "--show", "demo"]).stdout(writer).output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(141));
    assert!(output.stderr.is_empty());
}

/// A run's own trace is a recording like any other.
#[test]
fn the_trace_of_a_run_can_be_replayed() {
    let folder = folder("replayed");
    let short = scenarios().join("short.toml");
    let flown = uchain(&["run", short.to_str().unwrap(), "--out", folder.to_str().unwrap()]);
    assert_eq!(flown.status.code(), Some(0));
    let trace = folder.join("trace.csv");
    let output = uchain(&["replay", trace.to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let file = &summary["files"][0];
    assert_eq!((&file["format"], &file["rows"]), (&"trace".into(), &400.into()));
    assert!(file["packets"].as_u64().is_some_and(|packets| packets > 300), "{file}");
    assert!(file["prediction"]["kalman"].is_object(), "the motion is known");
}

#[test]
fn strengths_without_a_sign_are_taken_and_a_line_says_so() {
    let folder = folder("unsigned");
    fs::create_dir_all(&folder).unwrap();
    let replayed = |name: &str, strengths: [&str; 3]| {
        let file = folder.join(name);
        let rows = strengths.iter().enumerate().map(|(n, rssi)| format!("{n},a,{rssi}\n"));
        fs::write(&file, format!("time_s,link,rssi_dbm\n{}", rows.collect::<String>())).unwrap();
        let output = uchain(&["replay", file.to_str().unwrap(), "--json"]);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let mean = summary["files"][0]["links"][0]["mean_dbm"].as_f64();
        (mean, String::from_utf8(output.stderr).unwrap())
    };
    // 127 is what some logs write for "none".
    let (mean, note) = replayed("unsigned.csv", ["52", "54", "127"]);
    assert_eq!(mean, Some(-53.0));
    assert!(note.contains("unsigned.csv: no RSSI in it is negative"), "{note}");
    let (mean, note) = replayed("signed.csv", ["-52", "-54", "127"]);
    assert_eq!((mean, &*note), (Some(-53.0), ""));
}
