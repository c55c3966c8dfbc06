//! The sections of a scenario file that say who flies, how they think, what the operator does, and
//! which drones are lost.

mod drones;
mod loss;
mod mind;
mod pilot;

pub use drones::{Drones, Start};
pub(crate) use drones::{DronesTable, MOST_DRONES};
pub(crate) use loss::LossTable;
pub use loss::{Loss, LossKind};
pub(crate) use mind::{LaunchTable, MindTables, PolicyTable, RetreatTable};
pub use pilot::PilotStep;
pub(crate) use pilot::PilotTable;
