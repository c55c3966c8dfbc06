//! The section `[radio]` of a scenario file.

use radio_model::{Attenuation, Fades, PathLoss, Reception};
use serde::Deserialize;
use units::{Db, Dbm, Duration};
use wire::radio::Datarate;

use crate::input_error::InputError;
use crate::scenario::reader::{At, Reader};
use crate::world::Walls;

/// The radio of a scenario.
#[derive(Clone, Debug)]
pub struct RadioSpec {
    /// Large-scale loss.
    pub path_loss: PathLoss,
    /// How walls attenuate the signal.
    pub walls: Walls,
    /// Loss and noise of packets.
    pub reception: Reception,
    /// The fades of each directed link.
    pub fades: Fades,
    /// The rate at which the drones send.
    pub datarate: Datarate,
    /// How often a second the operator's dongle asks the base for news; zero for no dongle.
    pub polling_hz: f32,
    /// How long a packet lies with its receiver, beside the time that it is on its way.
    pub latency_us: u64,
}

/// The table `[radio]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RadioTable {
    attenuation: Option<AttenuationKey>,
    walls: Option<WallsKey>,
    loss_at_1m_db: Option<At<f32>>,
    noise_variance_db2: Option<At<f32>>,
    resolution_db: Option<At<f32>>,
    packet_loss: Option<At<f32>>,
    fade_share: Option<At<f32>>,
    fade_s: Option<At<f32>>,
    latency_s: Option<At<f32>>,
    polling_hz: Option<At<f32>>,
    sensitivity_dbm: Option<At<f32>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum AttenuationKey {
    WallCount,
    RockDepth,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WallsKey {
    Rock,
    Paper,
    Leaky,
}

impl RadioTable {
    /// Checks the section.
    pub(crate) fn read(&self, reader: &Reader<'_>) -> Result<RadioSpec, InputError> {
        let paper = Reception::PAPER;
        let number = |value: &Option<At<f32>>, key, range, default| {
            reader.or(value.as_ref(), key, range, default)
        };
        let path_loss = PathLoss {
            attenuation: match self.attenuation {
                Some(AttenuationKey::WallCount) => Attenuation::WallCount,
                None | Some(AttenuationKey::RockDepth) => Attenuation::RockDepth,
            },
            loss_at_1m: Db(number(&self.loss_at_1m_db, "loss_at_1m_db", 0.0..=100.0, 40.0)?),
        };
        let reception = Reception {
            noise_variance: number(
                &self.noise_variance_db2,
                "noise_variance_db2",
                0.0..=400.0,
                paper.noise_variance,
            )?,
            resolution: Db(number(
                &self.resolution_db,
                "resolution_db",
                0.0..=10.0,
                paper.resolution.0,
            )?),
            loss_rate: number(&self.packet_loss, "packet_loss", 0.0..=1.0, paper.loss_rate)?,
            sensitivity: Dbm(number(
                &self.sensitivity_dbm,
                "sensitivity_dbm",
                -300.0..=0.0,
                Reception::NRF51_AT_2_MBIT.0,
            )?),
        };
        let fades = Fades {
            share: number(&self.fade_share, "fade_share", 0.0..=0.9, Fades::NONE.share)?,
            mean: match &self.fade_s {
                Some(value) => {
                    Duration::from_micros(reader.micros(value, "fade_s", 0.01..=60.0)?)
                }
                None => Fades::NONE.mean,
            },
        };
        Ok(RadioSpec {
            path_loss,
            walls: match self.walls {
                None | Some(WallsKey::Rock) => Walls::Rock,
                Some(WallsKey::Paper) => Walls::Paper,
                Some(WallsKey::Leaky) => Walls::Leaky,
            },
            reception,
            fades,
            datarate: Datarate::Mbit2,
            polling_hz: number(&self.polling_hz, "polling_hz", 0.0..=1_000.0, 0.0)?,
            latency_us: match &self.latency_s {
                Some(value) => reader.micros(value, "latency_s", 0.0..=10.0)?,
                None => 0,
            },
        })
    }
}
