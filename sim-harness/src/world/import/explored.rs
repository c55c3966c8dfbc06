//! Makes of a map of any format the cells that explorers explore, and on which relays are put down.

use std::path::Path;

use cave_survey::Warning;
use explorers::World;
use robot_maps::Occupancy;
use units::Point2;

use super::{Ends, Map, MapChoice, grid, open};
use crate::input_error::InputError;

/// The edge of the cells as which a cave or a SubT world is drawn, m: those of the explorers; where
/// relays are put down, cells are put together.
const RESOLUTION_M: f64 = 0.1;
/// Galleries within this distance of a cave's route are drawn too, m: all that may be explored.
const AROUND_M: f32 = 100.0;

/// Reads the map `file`, of any format that [`open()`] reads, as a place for explorers that start about
/// `start`, and the remarks of its reader.
///
/// # Errors
/// [`InputError`] where the map cannot be used.
pub fn explored(file: &Path, start: Option<Point2>) -> Result<(World, Vec<Warning>), InputError> {
    let map = cells(file)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let world = World::of_map(&name, &map, start).map_err(|why| {
        let (wrong, remedy) = why.split_once("; ").unwrap_or((&why, "give another map"));
        InputError::new(wrong, remedy).in_file(file)
    })?;
    Ok((world, map.warnings))
}

/// Reads the map `file`, of any format that [`open()`] reads, as an occupancy map: of a robot's map
/// that without the specks that a tunnel does not have either, of a survey and of a
/// SubT world the floor plan of the longest route and of the galleries about it.
///
/// # Errors
/// [`InputError`] where the map cannot be used.
pub fn cells(file: &Path) -> Result<Occupancy, InputError> {
    match open(file, None)? {
        Map::Grid(map) => Ok(grid::without_specks(map)),
        Map::Survey(_) | Map::Subt(_) => {
            let ends = Ends { from: None, to: None, around_m: Some(AROUND_M) };
            let choice = MapChoice { file: file.to_owned(), within: None, ends };
            let (tunnel, _) = choice.dig()?;
            tunnel.occupancy(RESOLUTION_M).ok_or_else(|| {
                let wrong = "its floor plan has too many cells";
                InputError::new(wrong, "cut a part of it out").in_file(file)
            })
        }
    }
}
