//! The sections of a scenario file that say who flies, how they think, and what the operator does.

mod drones;
mod mind;
mod pilot;

pub use drones::{Drones, Start};
pub(crate) use drones::{DronesTable, MOST_DRONES};
pub(crate) use mind::{LaunchTable, MindTables, PolicyTable, RetreatTable};
pub use pilot::PilotStep;
pub(crate) use pilot::PilotTable;
