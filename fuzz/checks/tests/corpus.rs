//! Everything that the fuzzers have found so far, without a fuzzer: each file of `fuzz/corpus` goes
//! through the check of its target. See `fuzz/README.md`.

use std::fs;
use std::path::{Path, PathBuf};

/// The name of a fuzz target, and its check.
type Target = (&'static str, fn(&[u8]));

const TARGETS: [Target; 17] = [
    ("airlink", fuzz_checks::airlink::check),
    ("capsule", fuzz_checks::capsule::check),
    ("compass", fuzz_checks::surveys::compass),
    ("crtp", fuzz_checks::crtp::check),
    ("frontier", fuzz_checks::frontier::check),
    ("map_server", fuzz_checks::maps::map_server),
    ("p2p", fuzz_checks::p2p::check),
    ("pocket_topo", fuzz_checks::surveys::pocket_topo),
    ("replay", fuzz_checks::replay::check),
    ("storage", fuzz_checks::storage::check),
    ("subt", fuzz_checks::maps::subt),
    ("survex", fuzz_checks::surveys::survex),
    ("syslink", fuzz_checks::syslink::check),
    ("therion", fuzz_checks::surveys::therion),
    ("three_d", fuzz_checks::surveys::three_d),
    ("visual_topo", fuzz_checks::surveys::visual_topo),
    ("walls", fuzz_checks::surveys::walls),
];

fn in_fuzz(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder)
}

fn sorted_files(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut files: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{folder:?} is empty");
    files
}

/// Runs the check with every file of the target's corpus.
fn feed(target: &str) {
    let (_, check) = TARGETS.iter().find(|(name, _)| *name == target).unwrap();
    for file in sorted_files(&in_fuzz("corpus").join(target)) {
        // So that a failure names the file.
        println!("{}", file.display());
        check(&fs::read(&file).unwrap());
    }
}

#[test]
fn every_target_has_a_check_and_a_corpus() {
    let names = |folder: &str| -> Vec<String> {
        let name = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
        sorted_files(&in_fuzz(folder)).into_iter().map(name).collect()
    };
    let checks = TARGETS.map(|(name, _)| name);
    assert_eq!(names("fuzz_targets"), checks);
    assert_eq!(names("corpus"), checks);
}

#[test]
fn no_bytes_from_the_radio_chip_do_harm() {
    feed("syslink");
}

#[test]
fn no_packet_from_the_air_does_harm() {
    feed("p2p");
}

#[test]
fn no_packet_of_an_explorer_does_harm() {
    feed("frontier");
}

#[test]
fn no_opened_capsule_does_harm() {
    feed("capsule");
}

#[test]
fn no_contents_of_the_eeprom_do_harm() {
    feed("storage");
}

#[test]
fn no_packets_on_the_link_give_an_event_that_was_not_sealed() {
    feed("airlink");
}

#[test]
fn no_cave_survey_does_harm() {
    for target in ["compass", "pocket_topo", "survex", "therion", "three_d", "visual_topo", "walls"]
    {
        feed(target);
    }
}

#[test]
fn no_map_of_a_robot_does_harm() {
    for target in ["map_server", "subt"] {
        feed(target);
    }
}

#[test]
fn no_packets_of_a_client_do_harm() {
    feed("crtp");
}

#[test]
fn no_bytes_from_a_debug_probe_do_harm() {
    feed("replay");
}
