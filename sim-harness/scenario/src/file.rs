//! Reads the scenario file: defines its sections, and assembles a [`Scenario`] from them.
//!
//! The code of each section is in [`sections`](crate::sections). The reader guesses nothing: an
//! unknown key, a number out of its range or an impossible tunnel is refused with file, line and
//! remedy.

use std::path::Path;
use std::sync::Arc;

use agent::ExploreConfig;

use input::InputError;
use input::reader::{At, Reader};
use maps::LONGEST_ROUTE;
use maps::tunnel::TunnelTable;
use serde::Deserialize;
use toml::{Table, Value};

use units::MissionKind;

use super::{Changes, Fidelity, LinkModel, Scenario, Setting};
use crate::sections::{
    AgentTables, CriteriaTable, DronesTable, ExploreTable, GroundTable, LaunchTable, LossTable,
    PilotTable, PolicyTable, RadioTable, RetreatTable, SwarmTable, VehicleTable,
};

/// How far from the base a pilot may be told to fly the head at most, m.
pub const DEPTHS: std::ops::RangeInclusive<f32> = 1.0..=LONGEST_ROUTE;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: At<String>,
    duration_s: At<f32>,
    depth_m: Option<At<f32>>,
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
    if changes.settings.is_empty() {
        return assemble(path, text, changes);
    }
    let set = |settings: &[Setting]| {
        let reader = Reader::new(path, text);
        let mut table: Table = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
        super::settings::make_room(settings, &mut table);
        settings.iter().try_for_each(|setting| setting.put(&mut table))?;
        assemble(path, &table.to_string(), changes)
    };
    set(&changes.settings).map_err(|error| {
        // A mistake of the file is told with its line in the file.
        if let Err(own) = assemble(path, text, changes) {
            return own;
        }
        let alone = |setting: &Setting| {
            let error = set(std::slice::from_ref(setting)).err()?;
            Some(error.at_key(&setting.to_string()))
        };
        changes.settings.iter().find_map(alone).unwrap_or_else(|| {
            let all: Vec<_> = changes.settings.iter().map(Setting::to_string).collect();
            error.at_key(&all.join(" "))
        })
    })
}

/// Assembles the scenario of a text.
fn assemble(path: &Path, text: &str, changes: &Changes) -> Result<Scenario, InputError> {
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
    let fidelity = fidelity(file.fidelity.as_ref(), &reader)?;
    let link = link(file.link.as_ref(), fidelity, &reader)?;
    let mission = mission(file.mission.as_ref(), link, &reader)?;
    let mut vehicle = file.vehicle.read(mission, &reader)?;
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
    constants.agent.explore.cone = vehicle.sees_cones.then_some(ExploreConfig::CONE);
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let duration_us = reader.micros(&file.duration_s, "duration_s", 0.2..=86_400.0)?;
    let depth_m = file.depth_m.as_ref().map(|key| reader.number(key, "depth_m", DEPTHS));
    Ok(Scenario {
        name,
        title: file.title.as_ref().clone(),
        duration_us,
        fidelity,
        link,
        mission,
        tunnel: Arc::new(tunnel),
        route: route.map(Arc::new),
        radio,
        vehicle,
        ground: file.ground.read(&reader)?,
        depth_m: depth_m.transpose()?,
        losses: LossTable::read(&file.loss, &drones, duration_us, &reader)?,
        drones,
        agent: constants.agent,
        assumed_loss_at_1m: constants.assumed_loss_at_1m,
        policy: constants.policy,
        pilot: PilotTable::read(&file.pilot, duration_us, &reader)?,
        criteria: file.criteria.read(&reader)?,
        source: Arc::new(source(text, changes, &reader)?),
    })
}

/// The tables and keys of the text, with the map of the changes, and with whole paths.
fn source(text: &str, changes: &Changes, reader: &Reader<'_>) -> Result<Table, InputError> {
    let mut source: Table = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
    let whole = |path: &Path| {
        let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Value::String(whole.to_string_lossy().into_owned())
    };
    if let Some(map) = &changes.map {
        let mut tunnel = Table::new();
        tunnel.insert("map".into(), whole(&map.file));
        tunnel.extend(map.within.as_deref().map(|within| ("within".into(), whole(within))));
        for (key, end) in [("from", &map.ends.from), ("to", &map.ends.to)] {
            tunnel.extend(end.as_deref().map(|end| (key.to_owned(), end.into())));
        }
        let around = map.ends.around_m.map(|around| Value::Float(f64::from(around)));
        tunnel.extend(around.map(|around| ("around_m".into(), around)));
        source.insert("tunnel".into(), Value::Table(tunnel));
        return Ok(source);
    }
    if let Some(Value::Table(tunnel)) = source.get_mut("tunnel") {
        for key in ["map", "within"] {
            make_whole(tunnel.get_mut(key), whole, reader);
        }
    }
    if let Some(Value::Table(radio)) = source.get_mut("radio")
        && let Some(Value::Table(trace)) = radio.get_mut("trace")
    {
        make_whole(trace.get_mut("log"), whole, reader);
    }
    Ok(source)
}

/// Makes a path that begins at the scenario's folder a whole one.
fn make_whole(path: Option<&mut Value>, whole: impl Fn(&Path) -> Value, reader: &Reader<'_>) {
    if let Some(path @ Value::String(_)) = path {
        *path = whole(&reader.beside(path.as_str().unwrap_or_default()));
    }
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
