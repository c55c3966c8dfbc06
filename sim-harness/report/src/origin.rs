//! What results were made of: the whole scenario as `scenario.toml`, and `origin.json` with the seed,
//! the program and the map.

use std::path::Path;

use crc32fast::Hasher;
use input::InputError;
use serde::{Deserialize, Serialize};

use super::Folder;
use scenario::Scenario;

/// The names of both files.
const SCENARIO: &str = "scenario.toml";
const ORIGIN: &str = "origin.json";

/// The revision of this program's source, where a release build knows it.
pub const REVISION: Option<&str> = option_env!("UCHAIN_BUILD_REVISION");

/// What results were made of, beside the scenario.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct Origin {
    /// The verb of the command: `run`, `campaign` or `serve`.
    pub verb: String,
    /// The scenario's name.
    pub scenario: String,
    /// The seed, or the first one.
    pub seed: u64,
    /// The version of the program.
    pub version: String,
    /// The revision of its source, where a release build knows it.
    pub revision: Option<String>,
    /// The CRC-32 of the floor plan that was made of a map, in hexadecimal; `None` without a map.
    pub map_crc32: Option<String>,
    /// The campaign, where it is one.
    pub campaign: Option<CampaignOrigin>,
}

/// What a campaign flew of its scenario.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct CampaignOrigin {
    /// The missions for each place of the grid.
    pub runs: usize,
    /// The keys that were varied, with their values.
    pub vary: Vec<String>,
    /// The CRC-32 of everything that its missions depend on, in hexadecimal: parts of one campaign have
    /// the same.
    pub crc32: String,
    /// The part `I/N` of the campaign; `1/1` for the whole.
    pub shard: String,
}

impl Origin {
    /// The origin of a mission or a campaign of this scenario.
    #[must_use]
    pub fn of(verb: &str, scenario: &Scenario, seed: u64) -> Self {
        Self {
            verb: verb.to_owned(),
            scenario: scenario.name.clone(),
            seed,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            revision: REVISION.map(str::to_owned),
            map_crc32: scenario.route.is_some().then(|| map_crc32(scenario)),
            campaign: None,
        }
    }

    /// Writes the scenario and its origin.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &mut Folder, scenario: &Scenario) -> Result<(), InputError> {
        folder.put_text(SCENARIO, &scenario.resolved())?;
        folder.put_json(ORIGIN, self)
    }

    /// Reads what the results in a folder were made of.
    ///
    /// # Errors
    /// [`InputError`] where there is none, it is damaged, or its map is no longer the same.
    pub fn read(folder: &Path) -> Result<(Self, Scenario), InputError> {
        let path = folder.join(ORIGIN);
        let wrong = |what: String| {
            InputError::new(what, "give a folder that uchain has written with --out").in_file(&path)
        };
        let text = input::file::read_text(&path, input::file::LARGEST_TEXT)
            .map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let origin: Self = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let mut scenario = Scenario::read(&folder.join(SCENARIO))?;
        scenario.name.clone_from(&origin.scenario);
        if origin.map_crc32.as_ref().is_some_and(|crc| *crc != map_crc32(&scenario)) {
            let error = InputError::new(
                "the map has changed since these results were made",
                "bring back the map that was flown in",
            );
            return Err(error.in_file(&path));
        }
        Ok((origin, scenario))
    }
}

/// The CRC-32 of the walls and the centre-lines, by the bits of their coordinates.
fn map_crc32(scenario: &Scenario) -> String {
    let plan = scenario.tunnel.floor_plan();
    let mut hasher = Hasher::new();
    let lines = plan.outlines.iter().chain(plan.centre_lines.iter().map(|line| &line.points));
    for line in lines {
        hasher.update(&(line.len() as u64).to_le_bytes());
        for point in line {
            hasher.update(&point.x.to_bits().to_le_bytes());
            hasher.update(&point.y.to_bits().to_le_bytes());
        }
    }
    format!("{:08x}", hasher.finalize())
}
