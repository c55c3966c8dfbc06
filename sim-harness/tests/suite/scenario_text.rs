//! Reads scenarios from texts that stand in tests.

use std::fs;
use std::path::Path;

use sim_harness::scenario::Scenario;

/// Reads this text as the scenario of this name, `test/scenario`, that no other test has.
pub(crate) fn read(name: &str, text: &str) -> Scenario {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.toml"));
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    fs::write(&file, text).unwrap();
    Scenario::read(&file).unwrap_or_else(|error| panic!("{error}"))
}
