//! The floor plan as the cells of a map.

use robot_maps::{Cell, Occupancy};
use world::Tunnel;

use super::content::{MAP, header};
use crate::mcap::Moment;
use ros2_topics::messages::{MapMetaData, OccupancyGrid, Point, Pose, Quaternion, Time};

/// The edge of a cell, m; it is doubled until the map has no more than [`MOST`] cells.
const CELL_M: f64 = 0.05;
const MOST: usize = 4_000_000;

/// The occupancy map of a tunnel; `None` for one that is too large for any cells.
pub(super) fn of(tunnel: &Tunnel) -> Option<Occupancy> {
    let sizes = (0..8).map(|doubled| CELL_M * f64::from(1 << doubled));
    let mut maps = sizes.filter_map(|size| tunnel.occupancy(size));
    maps.find(|map| map.cells().len() <= MOST)
}

/// The message of a map.
pub(super) fn message(map: &Occupancy, now: Moment) -> OccupancyGrid {
    let value = |cell: &Cell| match cell {
        Cell::Free => 0,
        Cell::Occupied => 100,
        Cell::Unknown => -1,
    };
    let [x, y] = map.place(0.0, 0.0);
    let orientation = Quaternion { w: 1.0, ..Quaternion::default() };
    OccupancyGrid {
        header: header(MAP, now),
        info: MapMetaData {
            map_load_time: Time::default(),
            resolution: map.resolution_m as f32,
            width: map.columns() as u32,
            height: map.rows() as u32,
            origin: Pose { position: Point { x, y, z: 0.0 }, orientation },
        },
        data: map.cells().iter().map(value).collect(),
    }
}
