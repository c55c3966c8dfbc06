//! The map that the drones of a mission have drawn.

use explorers::merged;
use mission::Mission;
use robot_maps::Occupancy;

/// The map that the drones have drawn together; `None` where none has drawn one.
pub(super) fn map(mission: &Mission<'_>) -> Option<Occupancy> {
    // The memory of a drone that never began is the map of one cell.
    let maps: Vec<_> = mission.explorations().filter(|map| map.frame().cell_count() > 1).collect();
    let frame = maps.first()?.frame();
    Some(merged(frame, |cell| maps.iter().map(move |map| map.state(cell))))
}
