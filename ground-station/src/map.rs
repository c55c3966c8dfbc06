//! Reads the floor plan that the page shows: a route of a survey or map, or a scenario's tunnel.

use std::path::{Path, PathBuf};

use input::InputError;
use maps::sites::{Site, usual_base};
use maps::{Ends, MapChoice};
use station_log::Plan;

/// The map that was asked for, as for `uchain run --map`.
#[derive(Clone, Debug, clap::Args)]
pub struct MapArgs {
    /// The place, for the page to show: a survey of a cave (Survex, Therion and others), a world of the
    /// SubT Challenge (.dot, .sdf), a map of a robot (map_server's .yaml), or a scenario, by its file
    /// (.toml) or its name. Where left out, the page shows the way flown
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Station of the survey, tile of the world or point x,y of the map at which the base stands
    #[arg(long, value_name = "PLACE", requires = "map", allow_hyphen_values = true)]
    from: Option<String>,
    /// Station, tile or point at which the way in ends
    #[arg(long, value_name = "PLACE", requires = "map", allow_hyphen_values = true)]
    to: Option<String>,
}

impl MapArgs {
    /// The plan of the map, if one was asked for.
    ///
    /// # Errors
    /// A map that cannot be used, or has no such route.
    pub fn open(&self) -> Result<Option<Plan>, InputError> {
        let Some(file) = &self.map else { return Ok(None) };
        let Site { tunnel, base } = if is_scenario(file) {
            Site::open(&file.to_string_lossy())?
        } else {
            let ends = Ends { from: self.from.clone(), to: self.to.clone(), around_m: None };
            let choice = MapChoice { file: file.clone(), within: None, ends, memory: None };
            let (tunnel, _) = choice.dig()?;
            Site { base: usual_base(&tunnel), tunnel }
        };
        let base_m = if base.on.edge == 0 { base.on.along } else { 0.0 };
        Ok(Some(Plan::of(&tunnel.floor_plan(), base_m)))
    }
}

/// Whether this is the name or the file of a scenario.
fn is_scenario(file: &Path) -> bool {
    file.extension().is_none_or(|ending| ending == "toml")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(file: &str) -> Result<Option<Plan>, InputError> {
        MapArgs { map: Some(file.into()), from: None, to: None }.open()
    }

    #[test]
    fn scenarios_and_maps_have_plans() {
        let survey = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/caves/crooked.svx");
        for file in ["demo", survey] {
            let plan = open(file).unwrap().unwrap();
            assert!(!plan.outlines.is_empty() && !plan.lines.is_empty(), "{file}");
        }
        assert_eq!(MapArgs { map: None, from: None, to: None }.open(), Ok(None));
    }

    #[test]
    fn what_is_no_map_is_said_to_be_none() {
        assert!(open("no-such-scenario").unwrap_err().to_string().contains("no scenario"));
        assert!(open("no-such-map.svx").is_err());
    }
}
