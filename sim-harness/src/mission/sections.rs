//! The sections of a scenario file that say which drones fly, the constants of their agents, what the
//! operator does, and which drones are lost.

mod agent;
mod drones;
mod explore;
mod loss;
mod pilot;
mod swarm;

pub(crate) use self::agent::{AgentTables, LaunchTable, PolicyTable, RetreatTable};
pub use drones::{Drones, Start};
pub(crate) use drones::{DronesTable, MOST_DRONES};
pub(crate) use explore::ExploreTable;
pub(crate) use loss::LossTable;
pub use loss::{Loss, LossKind};
pub use pilot::PilotStep;
pub(crate) use pilot::PilotTable;
pub(crate) use swarm::SwarmTable;
