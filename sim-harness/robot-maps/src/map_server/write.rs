//! Writes maps as `map_saver` of ROS does.

use std::io::{self, Write};

use crate::occupancy::{Cell, Occupancy};

/// The name of the image that a written YAML file names.
pub const IMAGE: &str = "map.pgm";

/// Writes the YAML file and the image of a map. Free cells are 254, occupied ones 0 and unknown ones
/// 205, and the thresholds are those that tell them apart: all as `map_saver` of ROS 1.
///
/// # Errors
/// The error of the writers.
pub fn write(map: &Occupancy, mut yaml: impl Write, mut image: impl Write) -> io::Result<()> {
    let [x, y, yaw] = map.origin;
    writeln!(yaml, "image: {IMAGE}")?;
    writeln!(yaml, "resolution: {:?}", map.resolution_m)?;
    writeln!(yaml, "origin: [{x:?}, {y:?}, {yaw:?}]")?;
    writeln!(yaml, "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196")?;
    write!(image, "P5\n{} {}\n255\n", map.columns(), map.rows())?;
    for row in map.cells().chunks_exact(map.columns()).rev() {
        let pixel = |cell: &Cell| match cell {
            Cell::Free => 254,
            Cell::Occupied => 0,
            Cell::Unknown => 205,
        };
        image.write_all(&row.iter().map(pixel).collect::<Vec<u8>>())?;
    }
    Ok(())
}
