//! Campaigns of the command: grids, parts, and those that were stopped; and missions that are flown
//! again from their results.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const UCHAIN: &str = env!("CARGO_BIN_EXE_uchain");

fn uchain(args: &[&str]) -> Output {
    Command::new(UCHAIN).args(args).output().unwrap()
}

/// A folder of this test's own, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("campaigns").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn short() -> String {
    format!("{}/../tests/scenarios/short.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The files of a folder by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |entry: fs::DirEntry| {
        (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap())
    };
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|it| read(it.unwrap())).collect();
    files.sort();
    files
}

fn same(one: &Path, other: &Path) {
    let (one, other) = (files(one), files(other));
    let names = |files: &[(String, Vec<u8>)]| {
        files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(&one), names(&other));
    for (one, other) in one.iter().zip(&other) {
        assert!(one.1 == other.1, "{} differs", one.0);
    }
}

/// Asserts that the command is refused, with status 2 and one line that has all of these parts.
fn refused(args: &[&str], parts: &[&str]) {
    let output = uchain(args);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {complaint}");
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    for part in parts {
        assert!(complaint.contains(part), "no {part:?} in {complaint}");
    }
}

/// Runs a command that flies missions, which may fail.
fn flown(args: &[&str]) {
    let output = uchain(args);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {complaint}");
}

/// A campaign of a grid: the options that all parts have.
fn grid(file: &str) -> Vec<&str> {
    let mut args = vec!["campaign", file, "--runs", "3", "--quiet", "--seed", "5"];
    args.extend(["--vary", "radio.packet_loss=0:0.4:2", "--vary", "policy.name=t5,chain"]);
    args
}

#[test]
fn parts_merged_are_the_campaign_in_one_piece() {
    let (folder, file) = (folder("parts"), short());
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let fly = |name: &str, more: &[&str]| {
        let out = at(name);
        flown(&[&grid(&file)[..], &["--out", &out], more].concat());
        out
    };
    let whole = fly("whole", &[]);
    let parts = ["1/3", "2/3", "3/3"].map(|part| fly(&part[..1], &["--shard", part]));
    let [one, two, three] = parts.each_ref().map(String::as_str);
    let merged = at("merged");
    flown(&["campaign", "--quiet", "--merge", three, one, two, "--out", &merged]);
    same(Path::new(&whole), Path::new(&merged));
    let rows = fs::read_to_string(folder.join("whole/runs.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 12);
    assert!(rows.starts_with("radio.packet_loss,policy.name,seed,success,"), "{rows}");
    let line = rows.lines().nth(4).unwrap();
    assert!(line.starts_with("0.0,chain,5,"), "{line}");

    let merge = |folders: &[&str], parts: &[&str]| {
        refused(&[&["campaign", "--quiet", "--merge"], folders].concat(), parts);
    };
    merge(&[one, three], &["part 2/3 is missing"]);
    merge(&[one, two, three, two], &["part 2/3 is there twice"]);
    let other = at("other");
    let args = ["campaign", &file, "--runs", "2", "--quiet", "--out", &other, "--shard", "2/3"];
    flown(&args);
    merge(&[one, &other, three], &["other", "another campaign"]);
    merge(&[one, &at("nowhere")], &["no results"]);
    merge(&[one, two, three, "--out", two], &["one of the parts", "another folder"]);
    let rows = folder.join("2/runs.csv");
    let text = fs::read_to_string(&rows).unwrap();
    fs::write(&rows, text.replacen(",6,", ",5,", 1)).unwrap();
    merge(&[one, two, three], &["runs.csv", "was changed since uchain wrote it"]);
}

#[test]
fn a_campaign_that_was_stopped_goes_on_to_the_same_bytes() {
    let (folder, file) = (folder("resumed"), short());
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    let args = |out: &Path, more: &[&'static str]| {
        let mut args: Vec<String> = grid(&file).iter().map(ToString::to_string).collect();
        args.extend(["--out".to_owned(), out.to_str().unwrap().to_owned()]);
        args.extend(more.iter().map(ToString::to_string));
        args
    };
    let fly = |args: &[String]| flown(&args.iter().map(String::as_str).collect::<Vec<_>>());
    fly(&args(&whole, &[]));
    // Killed, at some moment.
    let journal = folder.join("out.rows");
    kill_at(Command::new(UCHAIN).args(args(&out, &[])), &journal, 3);
    if !out.exists() {
        let refuse = |more: &[&'static str], parts: &[&str]| {
            let args = args(&out, more);
            refused(&args.iter().map(String::as_str).collect::<Vec<_>>(), parts);
        };
        refuse(&[], &["out.rows", "--resume"]);
        refuse(&["--resume", "--set", "radio.fade_share=0.1"], &["another campaign"]);
        // A line that was cut short is flown again; a line that was changed is not taken.
        let text = fs::read_to_string(&journal).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let damaged = text.replacen(lines[1], &lines[1].replacen(',', ";", 1), 1);
        fs::write(&journal, damaged).unwrap();
        refuse(&["--resume"], &["out.rows:2", "damaged"]);
        fs::write(&journal, format!("{}\n{}\n{}", lines[0], lines[1], &lines[2][..40])).unwrap();
    }
    fly(&args(&out, &["--resume"]));
    same(&whole, &out);
    assert!(!journal.exists());
}

/// Begins a campaign and kills it once its journal has so many lines, or it has ended.
fn kill_at(command: &mut Command, journal: &Path, count: usize) {
    let mut child = command.spawn().unwrap();
    let lines = || fs::read_to_string(journal).map_or(0, |text| text.lines().count());
    while lines() < count && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Missions are flown, and their rows read back, in chunks of 4,096. A row that stands among those of
/// another chunk, as after a change by hand, is flown again.
#[test]
fn a_campaign_of_several_chunks_goes_on_to_the_same_bytes() {
    let (folder, file) = (folder("chunks"), short());
    let (whole, out) = (folder.join("whole"), folder.join("out"));
    let [whole_text, out_text] = [&whole, &out].map(|path| path.to_str().unwrap());
    let mut args = vec!["campaign", &file, "--quiet", "--set", "duration_s=0.2"];
    args.extend(["--set", "pilot=[]"]);
    let campaign = |more: &[&'static str]| [&args[..], more].concat();
    let few = campaign(&["--runs", "4200", "--out"]);
    flown(&[&few[..], &[whole_text]].concat());
    // A campaign of so many more missions that it is under way when it is killed.
    let many = campaign(&["--runs", "1000000", "--out"]);
    let journal = folder.join("out.rows");
    kill_at(Command::new(UCHAIN).args(&many).arg(out_text), &journal, 4120);
    assert!(!out.exists(), "it ended before it was killed");
    // Its rows are those of the smaller campaign, which is named by the first line.
    let origin = fs::read_to_string(whole.join("origin.json")).unwrap();
    let crc = &origin.split("\"crc32\": \"").nth(1).unwrap()[..8];
    let title = format!("# uchain campaign {crc} 1/1");
    let text = fs::read_to_string(&journal).unwrap();
    let lines: Vec<&str> = text.lines().take(4110).collect();
    let moved = [&[&*title][..], &lines[4100..4105], &lines[1..4090], &lines[4105..]].concat();
    fs::write(&journal, moved.join("\n") + "\n").unwrap();
    flown(&[&few[..], &[out_text, "--resume"]].concat());
    same(&whole, &out);
    assert!(!journal.exists());
}

#[test]
fn a_mission_is_flown_again_from_its_results() {
    let folder = folder("again");
    let map = format!("{}/../tests/caves/crooked.svx", env!("CARGO_MANIFEST_DIR"));
    let (one, two) = (folder.join("one"), folder.join("two"));
    let [one_text, two_text] = [&one, &two].map(|path| path.to_str().unwrap());
    let mut args = vec!["run", "--map", &map, "--relays", "1", "--seed", "9", "--policy", "t5"];
    args.extend(["--set", "radio.packet_loss=0.3", "--set", "pilot=[]", "--set", "duration_s=2"]);
    flown(&[&args[..], &["--quiet", "--out", one_text]].concat());
    flown(&["run", "--quiet", "--again", one_text, "--out", two_text]);
    same(&one, &two);
    refused(&["campaign", "--quiet", "--merge", one_text], &["no part of a campaign"]);
    // The map is another one now.
    let origin = one.join("origin.json");
    let text = fs::read_to_string(&origin).unwrap();
    let crc = text.split("\"map_crc32\": \"").nth(1).unwrap()[..8].to_owned();
    fs::write(&origin, text.replace(&crc, "00000000")).unwrap();
    refused(&["run", "--again", one_text], &["origin.json", "the map has changed"]);
    refused(&["run", "--again", folder.to_str().unwrap()], &["origin.json"]);
    refused(&["run", "--again", one_text, "--seed", "3"], &["--again"]);
}

#[test]
fn a_wrong_key_is_named() {
    let file = short();
    for verb in ["run", "campaign"] {
        refused(&[verb, &file, "--set", "radio.packet_los=1"], &["did you mean packet_loss?"]);
        refused(&[verb, &file, "--set", "radio"], &["KEY=VALUE"]);
    }
    let vary = |text: &str, parts: &[&str]| refused(&["campaign", &file, "--vary", text], parts);
    vary("radio.packet_los=0:1:3", &["radio.packet_los=0", "did you mean packet_loss?"]);
    vary("radio.packet_loss=0:2:3", &["radio.packet_loss=2", "from 0 to 1"]);
    vary("radio.packet_loss=0:1:0", &["KEY=A:B:N"]);
    refused(&["campaign", &file, "--shard", "3/2", "--out", "nowhere"], &["I/N"]);
}
