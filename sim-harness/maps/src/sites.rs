//! Reads where a scenario is flown: its tunnel and the place of its base, for a program that needs no more
//! of a scenario than that. It holds the texts of the scenarios that are part of the program, the files of
//! `sim-harness/scenarios/`.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use input::reader::{At, Reader};
use input::{InputError, suggest};
use serde::Deserialize;
use world::{SkeletonPlace, Spot, Tunnel};

use crate::tunnel::{PlaceKey, TunnelTable};

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        /// Name and text of each built-in scenario.
        pub const FILES: &[(&str, &str)] = &[
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
    "swarm-both",
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

/// Returns the names of all built-in scenarios.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// Returns the text of the built-in scenario of that name, as a start for a new one.
#[must_use]
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The text of a scenario's file.
///
/// # Errors
/// [`InputError`] where it cannot be read or is no text.
pub fn read_text(path: &Path) -> Result<String, InputError> {
    input::file::read_text(path, input::file::LARGEST_TEXT).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => {
            InputError::new("this is not text in UTF-8", "give a TOML file, saved as UTF-8")
                .in_file(path)
        }
        _ => InputError::new(format!("cannot be read: {error}"), "give a TOML file").in_file(path),
    })
}

/// The text of the built-in scenario of that name, or of the file at that path, with the path that errors
/// in it name.
///
/// # Errors
/// [`InputError`] where it is neither, or the file cannot be read.
pub fn open_text(name_or_path: &str) -> Result<(PathBuf, Cow<'static, str>), InputError> {
    let path = Path::new(name_or_path);
    if let Some(text) = text(name_or_path) {
        return Ok((path.with_extension("toml"), text.into()));
    }
    if path.exists() {
        return Ok((path.to_owned(), read_text(path)?.into()));
    }
    let known: Vec<_> = names().collect();
    let stem = path.file_stem().map_or_else(Default::default, |stem| stem.to_string_lossy());
    let meant = suggest::question(&stem, names());
    Err(InputError::new(
        format!("there is no scenario and no file called \"{name_or_path}\""),
        format!("{meant}give a TOML file or one of {}", known.join(", ")),
    ))
}

/// The place at which a base stands where its scenario does not say: the beginning of the main gallery.
#[must_use]
pub fn usual_base(tunnel: &Tunnel) -> Spot {
    Spot::on(tunnel.skeleton(), SkeletonPlace::main(0.0))
}

/// Where a scenario is flown.
#[derive(Debug)]
pub struct Site {
    /// The walls and the skeleton.
    pub tunnel: Tunnel,
    /// The place of the base.
    pub base: Spot,
}

/// The keys of a scenario that say where it is flown; all others are left unread.
#[derive(Deserialize)]
struct SiteFile {
    tunnel: At<TunnelTable>,
    drones: Option<DronesSite>,
}

#[derive(Deserialize)]
struct DronesSite {
    base: Option<At<PlaceKey>>,
}

impl Site {
    /// The place of the built-in scenario of that name, or of the file at that path.
    ///
    /// # Errors
    /// [`InputError`] where it is neither, or has no usable tunnel or base.
    pub fn open(name_or_path: &str) -> Result<Self, InputError> {
        let (path, text) = open_text(name_or_path)?;
        let reader = Reader::new(&path, &text);
        let file: SiteFile = toml::from_str(&text).map_err(|error| reader.syntax(&error))?;
        let (tunnel, _) = TunnelTable::dig(&file.tunnel, &reader)?;
        let base = match file.drones.and_then(|drones| drones.base) {
            None => usual_base(&tunnel),
            Some(key) => key.as_ref().spot(&key, "base", 0.0, &tunnel, &reader)?,
        };
        Ok(Self { tunnel, base })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scenario_has_a_site() {
        for name in names() {
            let site = Site::open(name).unwrap();
            assert!(site.tunnel.is_free(site.base.at), "{name}");
        }
    }

    #[test]
    fn a_name_that_is_none_is_told_with_what_was_meant() {
        let error = Site::open("strait").unwrap_err().to_string();
        assert!(error.contains("no scenario") && error.contains("straight"), "{error}");
    }
}
