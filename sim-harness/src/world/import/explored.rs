//! Makes of a map the place that explorers explore.

use std::path::Path;

use explorers::World;
use units::Point2;

use super::{Ends, Map, MapChoice, open};
use crate::input_error::InputError;

/// The edge of the cells as which a cave or a SubT world is drawn, m: those of the explorers.
const RESOLUTION_M: f64 = 0.1;
/// Galleries within this distance of a cave's route are drawn too, m: all that may be explored.
const AROUND_M: f32 = 100.0;

/// Reads the map `file`, of any format that [`open()`] reads, as a place for explorers that start about
/// `start`.
///
/// # Errors
/// [`InputError`] where the map cannot be used.
pub fn explored(file: &Path, start: Option<Point2>) -> Result<World, InputError> {
    let map = match open(file, None)? {
        Map::Grid(map) => map,
        Map::Survey(_) | Map::Subt(_) => {
            let ends = Ends { from: None, to: None, around_m: Some(AROUND_M) };
            let choice = MapChoice { file: file.to_owned(), within: None, ends };
            let (tunnel, _) = choice.dig()?;
            tunnel.occupancy(RESOLUTION_M).ok_or_else(|| {
                let wrong = "its floor plan has too many cells";
                InputError::new(wrong, "cut a part of it out").in_file(file)
            })?
        }
    };
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    World::of_map(&name, &map, start).map_err(|why| {
        let (wrong, remedy) = why.split_once("; ").unwrap_or((&why, "give another map"));
        InputError::new(wrong, remedy).in_file(file)
    })
}
