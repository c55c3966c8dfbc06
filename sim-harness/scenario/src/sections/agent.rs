//! The sections `[policy]`, `[launch]` and `[retreat]` of a scenario file: the constants of the
//! on-board code.

use agent::{AgentConfig, ConfigError};
use chain::launch::LaunchConfig;
use chain::policy::{NAMES, Policy};
use chain::retreat::RetreatConfig;
use input::reader::{At, Reader};
use input::{InputError, suggest};
use serde::Deserialize;
use units::{Db, Dbm, Metres, MetresPerSecond};

use super::VehicleSpec;

/// The tables that configure the on-board code.
pub(crate) struct AgentTables<'a> {
    pub(crate) policy: &'a PolicyTable,
    pub(crate) launch: &'a LaunchTable,
    pub(crate) retreat: &'a RetreatTable,
}

/// The on-board code's constants, with the name of the policy that they come from.
pub(crate) struct AgentConstants {
    /// The name of the movement policy.
    pub(crate) policy: String,
    /// The loss over the first metre that the drones assume.
    pub(crate) assumed_loss_at_1m: Db,
    pub(crate) agent: AgentConfig,
}

/// The table `[policy]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PolicyTable {
    name: Option<At<String>>,
    loss_at_1m_db: Option<At<f32>>,
}

/// The table `[launch]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LaunchTable {
    limit_dbm: Option<At<f32>>,
    settled_db: Option<At<f32>>,
    at_once: Option<bool>,
    hold_s: Option<At<f32>>,
    patience_s: Option<At<f32>>,
    arm_delay_s: Option<At<f32>>,
}

/// The table `[retreat]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RetreatTable {
    limit_dbm: Option<At<f32>>,
    speed_mps: Option<At<f32>>,
    max_time_s: Option<At<f32>>,
    max_distance_m: Option<At<f32>>,
    longest_m: Option<At<f32>>,
}

impl AgentTables<'_> {
    /// Checks the sections.
    pub(crate) fn read(
        &self,
        loss_at_1m: Db,
        vehicle: &VehicleSpec,
        reader: &Reader<'_>,
    ) -> Result<AgentConstants, InputError> {
        let mut agent = AgentConfig::DEFAULT;
        let table = self.policy;
        let name = table.name.as_ref().map_or("chain", |name| name.as_ref().as_str());
        let Some(policy) = Policy::named(name) else {
            let wrong = format!("there is no policy \"{name}\"");
            let remedy = suggest::one_of(name, &NAMES);
            return Err(match &table.name {
                Some(at) => reader.wrong(at, wrong, remedy),
                None => reader.at_byte(0, InputError::new(wrong, remedy)),
            });
        };
        let assumed =
            reader.or(table.loss_at_1m_db.as_ref(), "loss_at_1m_db", 0.0..=100.0, loss_at_1m.0)?;
        agent.policy = policy.config.for_loss_at_1m(Db(assumed));
        agent.nav.reach = Metres(vehicle.reach);
        self.launch(&mut agent.launch, reader)?;
        self.retreat(&mut agent.retreat, reader)?;
        agent.check().map_err(|ConfigError::LaunchBehindRetreat| self.contradiction(reader))?;
        Ok(AgentConstants { policy: name.to_owned(), assumed_loss_at_1m: Db(assumed), agent })
    }

    fn contradiction(&self, reader: &Reader<'_>) -> InputError {
        let wrong = ConfigError::LaunchBehindRetreat.to_string();
        let remedy = "raise launch.limit_dbm or lower retreat.limit_dbm";
        match self.launch.limit_dbm.as_ref().or(self.retreat.limit_dbm.as_ref()) {
            Some(at) => reader.wrong(at, wrong, remedy),
            None => reader.at_byte(0, InputError::new(wrong, remedy)),
        }
    }

    fn launch(&self, launch: &mut LaunchConfig, reader: &Reader<'_>) -> Result<(), InputError> {
        let table = self.launch;
        if table.at_once == Some(true) {
            *launch = LaunchConfig::AT_ONCE;
        }
        let limit =
            reader.or(table.limit_dbm.as_ref(), "limit_dbm", -300.0..=0.0, launch.limit.0)?;
        launch.limit = Dbm(limit);
        if let Some(settled) = &table.settled_db {
            launch.settled = Some(Db(reader.number(settled, "settled_db", 0.1..=100.0)?));
        }
        let minute = 0.0..=60.0;
        launch.hold =
            reader.span_of(table.hold_s.as_ref(), "hold_s", minute.clone(), launch.hold)?;
        launch.patience = reader.span_of(
            table.patience_s.as_ref(),
            "patience_s",
            minute.clone(),
            launch.patience,
        )?;
        launch.arm_delay =
            reader.span_of(table.arm_delay_s.as_ref(), "arm_delay_s", minute, launch.arm_delay)?;
        Ok(())
    }

    fn retreat(&self, retreat: &mut RetreatConfig, reader: &Reader<'_>) -> Result<(), InputError> {
        let table = self.retreat;
        retreat.limit =
            Dbm(reader.or(table.limit_dbm.as_ref(), "limit_dbm", -300.0..=0.0, retreat.limit.0)?);
        retreat.speed = MetresPerSecond(reader.or(
            table.speed_mps.as_ref(),
            "speed_mps",
            0.01..=1.0,
            retreat.speed.0,
        )?);
        retreat.max_time = reader.span_of(
            table.max_time_s.as_ref(),
            "max_time_s",
            0.0..=600.0,
            retreat.max_time,
        )?;
        retreat.max_distance = Metres(reader.or(
            table.max_distance_m.as_ref(),
            "max_distance_m",
            0.0..=100.0,
            retreat.max_distance.0,
        )?);
        retreat.longest = Metres(reader.or(
            table.longest_m.as_ref(),
            "longest_m",
            1.0..=1_000.0,
            retreat.longest.0,
        )?);
        Ok(())
    }
}
