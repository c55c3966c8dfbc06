//! Holds the scenarios that are part of the program: the files of `sim-harness/scenarios/`.

use std::path::Path;

use input::InputError;

use super::{Scenario, file};

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        /// Name and text of each.
        const FILES: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../scenarios/", $name, ".toml")))),*
        ];
    };
}

files![
    "demo",
    "straight",
    "paper-z10",
    "paper-u10",
    "paper-wave10",
    "s-turns-5",
    "zigzag-5",
    "winding-5",
    "s-turns-5-step",
    "zigzag-5-step",
    "winding-5-step",
    "t-junction",
    "t-opening",
    "room",
    "swarm-b",
    "swarm-c",
    "explore-room",
    "explore-flow",
    "turns",
    "paper-circuit",
    "relay-pair",
    "short-hop",
    "perch",
    "perch-40m",
    "hover-40m",
    "fork",
    "three-forks",
    "wide-forks",
    "fork-astray",
    "right-angles",
    "spiral",
    "straight-n4",
    "straight-n8",
    "straight-n15",
    "random-n15",
    "tracking-n15",
    "loss-70-n15",
    "meander-105",
    "leaky-u",
    "repair-6",
    "repair-corners",
    "repair-15",
    "cut",
];

/// The scenario that `run` flies when it is given none.
pub const DEMONSTRATION: &str = "demo";

/// Returns the names of all built-in scenarios.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// Returns the name and the title of each built-in scenario.
pub fn titles() -> impl Iterator<Item = (&'static str, String)> {
    #[derive(serde::Deserialize)]
    struct Titled {
        title: String,
    }
    let title =
        |text| toml::from_str(text).map_or_else(|_| String::new(), |Titled { title }| title);
    FILES.iter().map(move |(name, text)| (*name, title(text)))
}

/// The built-in scenario of that name.
#[must_use]
pub fn find(name: &str) -> Option<Result<Scenario, InputError>> {
    let (name, text) = FILES.iter().find(|(known, _)| *known == name)?;
    Some(file::parse(Path::new(&format!("{name}.toml")), text))
}

/// Returns the text of the built-in scenario of that name, as a start for a new one.
#[must_use]
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}
