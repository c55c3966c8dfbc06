//! What the fuzzers have found so far, without a fuzzer: each file of `fuzz/corpus` through the
//! check of its target. See `fuzz/README.md`.

#[path = "../../../../fuzz/src/wire/mod.rs"]
#[allow(unreachable_pub, reason = "public in the fuzz package, which it belongs to")]
mod wire_checks;

#[path = "../../../../fuzz/src/airlink.rs"]
#[allow(unreachable_pub, reason = "public in the fuzz package, which it belongs to")]
mod airlink_check;

#[path = "../../../../fuzz/src/crtp.rs"]
#[allow(unreachable_pub, reason = "public in the fuzz package, which it belongs to")]
mod crtp_check;

use std::fs;
use std::path::Path;

/// Runs the check with every file of the target's corpus.
fn feed(target: &str, check: fn(&[u8])) {
    let corpus = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus")).join(target);
    let files = fs::read_dir(&corpus).unwrap_or_else(|error| panic!("{corpus:?}: {error}"));
    let mut files: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{corpus:?} is empty");
    for file in files {
        // So that a failure names the file.
        println!("{}", file.display());
        check(&fs::read(&file).unwrap());
    }
}

#[test]
fn nothing_found_on_the_line_to_the_radio_chip_does_harm() {
    feed("syslink", wire_checks::syslink::check);
}

#[test]
fn nothing_found_on_the_air_does_harm() {
    feed("p2p", wire_checks::p2p::check);
}

#[test]
fn nothing_found_in_a_capsule_does_harm() {
    feed("capsule", wire_checks::capsule::check);
}

#[test]
fn nothing_found_in_the_eeprom_does_harm() {
    feed("settings", wire_checks::settings::check);
}

#[test]
fn nothing_found_on_the_link_gives_what_nobody_sealed() {
    feed("airlink", airlink_check::check);
}

#[test]
fn nothing_found_from_a_client_does_harm() {
    feed("crtp", crtp_check::check);
}
