//! Makes of a map of any format the cells that explorers explore, and on which relays are put down.

use std::path::Path;

use input::InputError;
use robot_maps::Occupancy;

use super::{Ends, Map, MapChoice, grid, open};

/// The edge of the cells as which a cave or a SubT world is drawn, m: those of the explorers; where
/// relays are put down, cells are put together.
const RESOLUTION_M: f64 = 0.1;
/// Galleries within this distance of a cave's route are drawn too, m: all that may be explored.
const AROUND_M: f32 = 100.0;

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
            let choice = MapChoice { file: file.to_owned(), within: None, ends, memory: None };
            let (tunnel, _) = choice.dig()?;
            tunnel.occupancy(RESOLUTION_M).ok_or_else(|| {
                let wrong = "its floor plan has too many cells";
                InputError::new(wrong, "cut a part of it out").in_file(file)
            })
        }
    }
}
