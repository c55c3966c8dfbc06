//! Whatever a scenario file holds, reading it gives a scenario or one line that says where and how
//! to mend it; never a panic, never half a scenario. (What the command makes of it is tested with
//! the command; tunnels of astronomic size have a file of their own there.)

use std::fs;
use std::path::{Path, PathBuf};

use input::InputError;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sim_harness::scenario::{Scenario, builtin};

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..Default::default()
    }
}

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenario-refusals");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

/// Reads these bytes as a scenario file of that name.
fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scenario, InputError> {
    let file = file(name);
    fs::write(&file, bytes).unwrap();
    Scenario::read(&file)
}

/// An error is one line that names the file and has a remedy.
fn well_told(name: &str, error: &InputError) -> Result<(), TestCaseError> {
    let told = error.to_string();
    prop_assert_eq!(told.lines().count(), 1, "{}", told);
    prop_assert!(told.contains(name) && told.contains("; "), "{told}");
    Ok(())
}

/// A scenario that has every key there is, one value a line.
const FULL: &str = "\
title = \"Every key there is\"
duration_s = 20.0
fidelity = \"point\"
link = \"ideal\"
[tunnel]
width_m = 1.5
centre_line_m = [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0]]
[[tunnel.branch]]
width_m = 1.0
centre_line_m = [[4.0, 0.0], [4.0, 3.0]]
[[tunnel.room]]
centre_m = [6.0, 0.0]
size_m = [3.0, 3.0]
[radio]
attenuation = \"rock-depth\"
loss_at_1m_db = 40.0
noise_variance_db2 = 3.0
resolution_db = 1.0
packet_loss = 0.2
fade_share = 0.1
fade_s = 0.5
latency_s = 0.02
polling_hz = 100.0
sensitivity_dbm = -95.0
[vehicle]
lag_s = 0.3
flow_noise_mps = 0.02
flow_scale_error = 0.03
radius_m = 0.08
reach_m = 2.0
range_noise_m = 0.01
[drones]
relays = 2
start = \"placed\"
at_m = [9.0, 6.0, 3.0]
[policy]
name = \"chain\"
loss_at_1m_db = 40.0
[launch]
limit_dbm = -60.0
settled_db = 4.0
at_once = false
hold_s = 2.0
patience_s = 10.0
arm_delay_s = 3.0
[retreat]
limit_dbm = -70.0
speed_mps = 0.2
max_time_s = 30.0
max_distance_m = 6.0
[[pilot]]
at_s = 1.0
order = \"explore\"
speed_mps = 0.2
[[pilot]]
at_s = 10.0
order = \"return\"
[[loss]]
at_s = 5.0
drone = 2
how = \"lands\"
";

#[test]
fn the_full_scenario_and_every_built_in_one_are_read() {
    let full = read("full.toml", FULL).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((full.name.as_str(), full.drones.relays, full.pilot.len()), ("full", 2, 2));
    for name in builtin::names() {
        let text = builtin::text(name).unwrap();
        let again = read(&format!("{name}.toml"), text).unwrap_or_else(|error| panic!("{error}"));
        let known = Scenario::open(name).unwrap();
        assert_eq!(format!("{again:?}"), format!("{known:?}"), "a copy of {name} is another");
    }
}

/// Every key of the full scenario, one after the other: misspelt, it is refused at its line.
#[test]
fn a_misspelt_key_is_refused_at_its_line() {
    for (n, line) in FULL.lines().enumerate().filter(|(_, line)| line.contains(" = ")) {
        let misspelt = line.replacen(" = ", "_ = ", 1);
        let text: Vec<_> = FULL
            .lines()
            .enumerate()
            .map(|(m, line)| if m == n { &misspelt } else { line })
            .collect();
        let error = read("misspelt.toml", text.join("\n")).unwrap_err().to_string();
        let place = format!("misspelt.toml:{}: ", n + 1);
        assert!(error.contains(&place) && error.contains("unknown key"), "{line}: {error}");
    }
}

/// Every number of the full scenario out of all bounds is refused at its line.
#[test]
fn a_number_out_of_bounds_is_refused_at_its_line() {
    for (n, line) in FULL.lines().enumerate() {
        let Some((key, value)) = line.split_once(" = ") else { continue };
        if value.parse::<f32>().is_err() {
            continue;
        }
        for bad in ["nan", "inf", "-inf", "-1e9", "1e9"] {
            let spoilt = format!("{key} = {bad}");
            let text: Vec<_> = FULL
                .lines()
                .enumerate()
                .map(|(m, line)| if m == n { spoilt.as_str() } else { line })
                .collect();
            let error = match read("spoilt.toml", text.join("\n")) {
                Ok(_) => panic!("{spoilt} in line {} is accepted", n + 1),
                Err(error) => error.to_string(),
            };
            // A side gallery is refused where it begins.
            let places = [n, n + 1].map(|line| format!("spoilt.toml:{line}: "));
            assert!(places.iter().any(|place| error.contains(place)), "{spoilt}: {error}");
        }
    }
}

proptest! {
    #![proptest_config(cases(256))]

    /// Any bytes at all.
    #[test]
    fn any_bytes_are_a_scenario_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Err(error) = read("bytes.toml", bytes) {
            well_told("bytes.toml", &error)?;
        }
    }

    /// A good file with bytes replaced, cut out or put in.
    #[test]
    fn a_damaged_file_is_a_scenario_or_an_error(
        damage in prop::collection::vec((0..FULL.len(), 0usize..4, "[ -~\n]{0,3}"), 1..4),
    ) {
        let mut text = FULL.as_bytes().to_vec();
        for (at, length, instead) in damage {
            let from = at.min(text.len());
            let to = (from + length).min(text.len());
            // No astronomic tunnels here: digits only where there are few already.
            let instead = instead.replace(|c: char| c.is_ascii_digit() || c == 'e', "x");
            text.splice(from..to, instead.bytes());
        }
        prop_assume!(!has_long_number(&text));
        if let Err(error) = read("damaged.toml", text) {
            well_told("damaged.toml", &error)?;
        }
    }

}

proptest! {
    #![proptest_config(cases(64))]

    /// Any tunnel of up to six points on a floor plan of 40 m: dug, or refused.
    #[test]
    fn any_tunnel_is_dug_or_refused(
        points in prop::collection::vec((-20i8..20, -20i8..20), 0..6), width in 0.1f32..6.0,
    ) {
        let points: Vec<_> = points.iter().map(|(x, y)| format!("[{x}.0, {y}.0]")).collect();
        let text = format!(
            "title = \"Any\"\nduration_s = 1.0\n[tunnel]\nwidth_m = {width}\n\
             centre_line_m = [{}]\n[drones]\nrelays = 0\n",
            points.join(", ")
        );
        if let Err(error) = read("tunnel.toml", text) {
            well_told("tunnel.toml", &error)?;
        }
    }
}

/// Four digits before the point, or so.
fn has_long_number(text: &[u8]) -> bool {
    text.split(|byte| !byte.is_ascii_digit()).any(|digits| digits.len() > 3)
}
