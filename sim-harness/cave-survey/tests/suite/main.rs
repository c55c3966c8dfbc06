//! The readers from outside: what they make of files, what they refuse, and that they agree with
//! Survex's own `cavern`.

mod adjustment;
mod bad_input;
mod compass;
mod formats;
mod grammar;
mod oracle;
mod therion;
mod walls;

use cave_survey::{Memory, Refusal, Survey, read};

/// Reads a survey of one `.svx` file.
fn svx(text: &str) -> Result<Survey, Refusal> {
    read(&Memory::default().with("cave.svx", text), "cave.svx")
}

/// The position of a station, m.
fn at(survey: &Survey, name: &str) -> [f64; 3] {
    let station = survey.station_named(name).unwrap_or_else(|| panic!("no {name}"));
    survey.stations[station].position
}

/// Within half a centimetre, which is how exactly `dump3d` prints.
fn assert_at(survey: &Survey, name: &str, expected: [f64; 3]) {
    let found = at(survey, name);
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 0.0051, "{name} is at {found:?}, not at {expected:?}");
}
