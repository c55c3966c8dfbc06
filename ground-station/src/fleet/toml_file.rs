//! Reads the project's own fleet file:
//!
//! ```toml
//! [limits]
//! launch_limit_dbm = -70.0
//! retreat_limit_dbm = -76.0
//!
//! [[drone]]
//! number = 0
//! name = "Ada"
//! address = "radio://0/80/2M/E7E7E7E700"
//! ```

use std::path::Path;

use input::InputError;
use serde::Deserialize;
use toml::Spanned;

use super::entry::{self, Entry, FirmwareTable, LimitsTable, RoleKey};
use super::{Deck, Fleet};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    limits: LimitsTable,
    #[serde(default)]
    firmware: FirmwareTable,
    drone: Vec<DroneTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DroneTable {
    number: u8,
    #[serde(default)]
    name: String,
    address: Spanned<String>,
    role: Option<RoleKey>,
    decks: Option<Vec<Deck>>,
}

/// Reads the text of a fleet file, whose path stands in errors.
pub(super) fn parse(text: &str, path: &Path) -> Result<Fleet, InputError> {
    let line_at = |byte: usize| 1 + text.bytes().take(byte).filter(|&b| b == b'\n').count();
    let file: File = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(span.start));
        let wrong = error.message().replace('\n', " ");
        InputError::new(wrong, "the book's chapter on the station describes the file")
            .at_line(path, line)
    })?;
    let entry = |table| {
        let DroneTable { number, name, address, role, decks } = table;
        let line = line_at(address.span().start);
        let address =
            address.as_ref().parse().map_err(|error: InputError| error.at_line(path, line))?;
        Ok(Entry { number, name, address, role, decks, line })
    };
    let entries = file.drone.into_iter().map(entry).collect::<Result<Vec<_>, _>>()?;
    let limits = entry::limits(file.limits, file.firmware).map_err(|error| error.in_file(path))?;
    Fleet::of(limits, entries, path, "add a [[drone]] with number = 15, or with role = \"base\"")
}
