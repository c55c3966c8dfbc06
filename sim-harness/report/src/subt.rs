//! Writes a SubT world as tables: `tiles.csv` and `joints.csv`.

use std::io;

use input::InputError;
use robot_maps::subt::World;

use super::Folder;

/// Writes the tables into the folder.
///
/// # Errors
/// [`InputError`] where a file cannot be written.
pub fn write(folder: &mut Folder, world: &World) -> Result<(), InputError> {
    folder.put("tiles.csv", |out| tiles(world, out))?;
    folder.put("joints.csv", |out| joints(world, out))
}

fn places(at: [f64; 3]) -> [String; 3] {
    at.map(|metres| format!("{metres:.3}"))
}

fn tiles(world: &World, out: impl io::Write) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    csv.write_record(["tile", "model", "x_m", "y_m", "z_m", "yaw_rad", "width_m", "is_assumed"])?;
    for tile in &world.tiles {
        let [x, y, z] = places(tile.at);
        let passage = tile.passage();
        let yaw = format!("{:.6}", tile.turned[2]);
        let width = format!("{:.3}", passage.width_m);
        let assumed = if passage.is_assumed { "1" } else { "0" };
        csv.write_record([&tile.name, &tile.model, &x, &y, &z, &yaw, &width, assumed])?;
    }
    csv.flush()
}

fn joints(world: &World, out: impl io::Write) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    csv.write_record(["from", "to", "cost", "x_m", "y_m", "z_m"])?;
    for joint in &world.joints {
        let [from, to] = joint.tiles.map(|tile| world.tiles[tile].name.clone());
        let [x, y, z] = places(joint.at);
        let cost = joint.cost.map_or_else(String::new, |cost| cost.to_string());
        csv.write_record([from, to, cost, x, y, z])?;
    }
    csv.flush()
}
