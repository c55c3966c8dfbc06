//! The sections of a scenario file, each with the data that it is read into.

mod agent;
mod criteria;
mod drones;
mod explore;
mod ground;
mod loss;
mod pilot;
mod radio;
mod swarm;
mod vehicle;

pub(crate) use self::agent::{AgentTables, LaunchTable, PolicyTable, RetreatTable};
pub use criteria::Criteria;
pub(crate) use criteria::CriteriaTable;
pub(crate) use drones::DronesTable;
pub use drones::{Drones, MOST_DRONES, Start};
pub(crate) use explore::ExploreTable;
pub use ground::Ground;
pub(crate) use ground::GroundTable;
pub(crate) use loss::LossTable;
pub use loss::{Loss, LossKind};
pub use pilot::PilotStep;
pub(crate) use pilot::PilotTable;
pub use radio::RadioSpec;
pub(crate) use radio::RadioTable;
pub(crate) use swarm::SwarmTable;
pub use vehicle::VehicleSpec;
pub(crate) use vehicle::VehicleTable;
