//! Holds the scenarios that are part of the program: the files of `sim-harness/scenarios/`.

use std::path::Path;

use input::InputError;
use maps::sites::FILES;
pub use maps::sites::{names, text};

use super::{Scenario, file};

/// The scenario that `run` flies when it is given none.
pub const DEMONSTRATION: &str = "demo";

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
    Some(file::parse(Path::new(&format!("{name}.toml")), text(name)?))
}
