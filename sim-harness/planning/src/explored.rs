//! Makes of a map of any format a place for explorers.

use std::path::Path;

use cave_survey::Warning;
use explorers::World;
use input::InputError;
use maps::cells;
use units::Point2;

/// Reads the map `file`, of any format that [`maps::open()`] reads, as a place for explorers that start about
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
