//! Reads the scenario file: defines its sections, and assembles a [`Scenario`] from them.
//!
//! The code of each section is in the module that it configures. The reader guesses nothing: an
//! unknown key, a number out of its range or an impossible tunnel is refused with file, line and
//! remedy.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use units::MissionKind;

use super::reader::{At, Reader};
use super::{Changes, Fidelity, LinkModel, Scenario};
use crate::bodies::craft::GroundTable;
use crate::bodies::point::VehicleTable;
use crate::input_error::InputError;
use crate::measure::metrics::CriteriaTable;
use crate::mission::medium::RadioTable;
use crate::mission::{
    AgentTables, DronesTable, ExploreTable, LaunchTable, LossTable, PilotTable, PolicyTable,
    RetreatTable, SwarmTable,
};
use crate::world::TunnelTable;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: At<String>,
    duration_s: At<f32>,
    #[serde(default)]
    swarm: SwarmTable,
    #[serde(default)]
    explore: ExploreTable,
    fidelity: Option<At<String>>,
    link: Option<At<String>>,
    mission: Option<At<String>>,
    tunnel: At<TunnelTable>,
    #[serde(default)]
    radio: RadioTable,
    #[serde(default)]
    vehicle: VehicleTable,
    drones: At<DronesTable>,
    #[serde(default)]
    policy: PolicyTable,
    #[serde(default)]
    launch: LaunchTable,
    #[serde(default)]
    retreat: RetreatTable,
    #[serde(default)]
    pilot: Vec<At<PilotTable>>,
    #[serde(default)]
    loss: Vec<At<LossTable>>,
    #[serde(default)]
    ground: GroundTable,
    #[serde(default)]
    criteria: CriteriaTable,
}

/// Reads and checks the text of the scenario file at `path`.
pub(super) fn parse(path: &Path, text: &str) -> Result<Scenario, InputError> {
    parse_with(path, text, &Changes::default())
}

/// Reads and checks the text of the scenario file at `path`, with these changes.
pub(super) fn parse_with(
    path: &Path,
    text: &str,
    changes: &Changes,
) -> Result<Scenario, InputError> {
    let reader = Reader::new(path, text);
    let mut file: File = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
    if let Some(relays) = changes.relays {
        file.drones.as_mut().change_relays(relays);
    }
    let (tunnel, route) = match &changes.map {
        Some(map) => map.dig().map(|(tunnel, route)| (tunnel, Some(route)))?,
        None => TunnelTable::dig(&file.tunnel, &reader)?,
    };
    let drones = DronesTable::read(&file.drones, &tunnel, &reader)?;
    let mut vehicle = file.vehicle.read(&reader)?;
    if let Some(reach) = route.as_ref().and_then(|route| route.long_reach_m)
        && changes.suits_width
    {
        vehicle.reach = reach;
    }
    let radio = file.radio.read(drones.members(), &reader)?;
    let tables = AgentTables { policy: &file.policy, launch: &file.launch, retreat: &file.retreat };
    let mut constants = tables.read(radio.place.path_loss.loss_at_1m(), &vehicle, &reader)?;
    constants.agent.flight.keeps_way_home = !drones.fetched;
    constants.agent.swarm = file.swarm.read(drones.flying(), &reader)?;
    constants.agent.explore = file.explore.read(&reader)?;
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let duration_us = reader.micros(&file.duration_s, "duration_s", 0.2..=86_400.0)?;
    let fidelity = fidelity(file.fidelity.as_ref(), &reader)?;
    let link = link(file.link.as_ref(), fidelity, &reader)?;
    Ok(Scenario {
        name,
        title: file.title.as_ref().clone(),
        duration_us,
        fidelity,
        link,
        mission: mission(file.mission.as_ref(), link, &reader)?,
        tunnel: Arc::new(tunnel),
        route: route.map(Arc::new),
        radio,
        vehicle,
        ground: file.ground.read(&reader)?,
        depth_m: None,
        losses: LossTable::read(&file.loss, &drones, duration_us, &reader)?,
        drones,
        agent: constants.agent,
        assumed_loss_at_1m: constants.assumed_loss_at_1m,
        policy: constants.policy,
        pilot: PilotTable::read(&file.pilot, duration_us, &reader)?,
        criteria: file.criteria.read(&reader)?,
    })
}

fn link(
    key: Option<&At<String>>,
    fidelity: Fidelity,
    reader: &Reader<'_>,
) -> Result<LinkModel, InputError> {
    let Some(key) = key else { return Ok(LinkModel::Exact) };
    let name = key.as_ref().as_str();
    match LinkModel::named(name) {
        Some(link) if link.suits(fidelity) => Ok(link),
        Some(link) => {
            let (link, fidelity) = (link.name(), fidelity.name());
            let wrong = format!("the link \"{link}\" is not for the fidelity \"{fidelity}\"");
            Err(reader.wrong(key, wrong, "write link = \"exact\", or fidelity = \"point\""))
        }
        None => {
            let wrong = format!("there is no link \"{name}\"");
            Err(reader.wrong(key, wrong, "give \"exact\" or \"ideal\""))
        }
    }
}

fn mission(
    key: Option<&At<String>>,
    link: LinkModel,
    reader: &Reader<'_>,
) -> Result<MissionKind, InputError> {
    let Some(key) = key else { return Ok(MissionKind::Chain) };
    let name = key.as_ref().as_str();
    match MissionKind::named(name) {
        Some(MissionKind::Chain) => Ok(MissionKind::Chain),
        Some(mission) if link == LinkModel::Exact => Ok(mission),
        Some(_) => {
            let wrong = "the ideal link carries nothing but the reports and orders of a chain";
            Err(reader.wrong(key, wrong.into(), "write link = \"exact\""))
        }
        None => {
            let names = MissionKind::ALL.map(|mission| format!("{:?}", mission.name()));
            let wrong = format!("there is no mission {name:?}");
            Err(reader.wrong(key, wrong, format!("give {}", names.join(" or "))))
        }
    }
}

fn fidelity(key: Option<&At<String>>, reader: &Reader<'_>) -> Result<Fidelity, InputError> {
    let Some(key) = key else { return Ok(Fidelity::Point) };
    let name = key.as_ref().as_str();
    Fidelity::named(name).ok_or_else(|| match name {
        "policy" => {
            let wrong = "the fidelity \"policy\" is now called \"point\"";
            reader.wrong(key, wrong.into(), "write fidelity = \"point\"")
        }
        _ => {
            let wrong = format!("there is no fidelity \"{name}\"");
            reader.wrong(key, wrong, "give \"point\", \"flight\" or \"virtual\"")
        }
    })
}
