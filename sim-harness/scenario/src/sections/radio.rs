//! The section `[radio]` of a scenario file.

use std::sync::Arc;

use airlink::Schedule;
use input::InputError;
use input::reader::{At, Reader};
use radio_model::{Antenna, Attenuation, Fades, PathLoss, Reception, UChain, Walls};
use recordings::{Format, RecordedChannel, recorded_channel};
use serde::Deserialize;
use units::{Db, Dbm, Duration};
use wire::radio::Datarate;
use world::{AntennaTable, FadingTable, ModelTable, RadioPlace, ShadowingTable};

/// The radio of a scenario.
#[derive(Clone, Debug)]
pub struct RadioSpec {
    /// Path loss, shadowing and fading.
    pub place: RadioPlace,
    /// The standard deviation, over drones, of the gain by which a drone sends, and of that by
    /// which it receives.
    pub gain_error: Db,
    /// What each drone on the ground takes from the strength of its links.
    pub ground_loss: Db,
    /// The pattern of the drones' antennas, if they have a preferred direction.
    pub antenna: Option<Antenna>,
    /// Loss and noise of packets.
    pub reception: Reception,
    /// The channel of a log, whose packets are played back.
    pub trace: Option<Arc<RecordedChannel>>,
    /// The fades of each link, the same in both directions.
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
    datarate: Option<At<DatarateKey>>,
    sensitivity_dbm: Option<At<f32>>,
    gain_error_db: Option<At<f32>>,
    ground_loss_db: Option<At<f32>>,
    place_seed: Option<u32>,
    model: Option<At<ModelTable>>,
    shadowing: Option<ShadowingTable>,
    fading: Option<FadingTable>,
    antenna: Option<AntennaTable>,
    trace: Option<TraceTable>,
}

#[derive(Clone, Copy, Deserialize)]
enum DatarateKey {
    #[serde(rename = "250K")]
    Kbit250,
    #[serde(rename = "1M")]
    Mbit1,
    #[serde(rename = "2M")]
    Mbit2,
}

impl From<DatarateKey> for Datarate {
    fn from(key: DatarateKey) -> Self {
        match key {
            DatarateKey::Kbit250 => Self::Kbit250,
            DatarateKey::Mbit1 => Self::Mbit1,
            DatarateKey::Mbit2 => Self::Mbit2,
        }
    }
}

/// The sensitivity of the drones' receiver.
const fn sensitivity(datarate: Datarate) -> Dbm {
    match datarate {
        Datarate::Kbit250 => Reception::NRF51_AT_250_KBIT,
        Datarate::Mbit1 => Reception::NRF51_AT_1_MBIT,
        Datarate::Mbit2 => Reception::NRF51_AT_2_MBIT,
    }
}

/// The table `[radio.trace]`: a log whose packets are played back.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TraceTable {
    log: String,
    format: Option<Format>,
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
    /// Checks the section, for so many nodes.
    pub(crate) fn read(&self, nodes: usize, reader: &Reader<'_>) -> Result<RadioSpec, InputError> {
        let datarate = self.datarate(nodes, reader)?;
        let paper = Reception::PAPER;
        let number = |value: &Option<At<f32>>, key, range, default| {
            reader.or(value.as_ref(), key, range, default)
        };
        let loss_at_1m = Db(number(&self.loss_at_1m_db, "loss_at_1m_db", 0.0..=100.0, 40.0)?);
        let model = self.model.as_ref();
        let law_noise = model.and_then(|model| model.as_ref().noise_variance());
        let reception = Reception {
            noise_variance: number(
                &self.noise_variance_db2,
                "noise_variance_db2",
                0.0..=400.0,
                law_noise.unwrap_or(if self.trace.is_some() { 0.0 } else { paper.noise_variance }),
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
                sensitivity(datarate).0,
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
            place: RadioPlace {
                path_loss: self.path_loss(loss_at_1m, reader)?,
                shadowing: self.shadowing.as_ref().map(|table| table.read(reader)).transpose()?,
                fading_k: self.fading.as_ref().map(|table| table.read(reader)).transpose()?,
                seed: self.place_seed.map_or(1, u64::from),
            },
            gain_error: Db(number(&self.gain_error_db, "gain_error_db", 0.0..=20.0, 0.0)?),
            ground_loss: Db(number(&self.ground_loss_db, "ground_loss_db", 0.0..=40.0, 0.0)?),
            antenna: self.antenna.as_ref().map(|table| table.read(reader)).transpose()?,
            reception,
            trace: self.trace(reader)?,
            fades,
            datarate,
            polling_hz: number(&self.polling_hz, "polling_hz", 0.0..=1_000.0, 0.0)?,
            latency_us: match &self.latency_s {
                Some(value) => reader.micros(value, "latency_s", 0.0..=10.0)?,
                None => 0,
            },
        })
    }

    /// The rate at which the drones send, which must leave a turn for each of them.
    fn datarate(&self, nodes: usize, reader: &Reader<'_>) -> Result<Datarate, InputError> {
        let Some(key) = &self.datarate else { return Ok(Datarate::Mbit2) };
        let datarate = Datarate::from(*key.as_ref());
        let most = usize::from(Schedule::capacity(datarate));
        if nodes > most {
            let wrong =
                format!("{nodes} nodes, the base included, are too many for this data rate");
            let remedy = format!("give no more than {most} nodes, or datarate = \"2M\"");
            return Err(reader.wrong(key, wrong, remedy));
        }
        Ok(datarate)
    }

    /// The channel of the log that the table names, whose path is relative to the scenario's file.
    fn trace(&self, reader: &Reader<'_>) -> Result<Option<Arc<RecordedChannel>>, InputError> {
        let Some(TraceTable { log, format }) = &self.trace else { return Ok(None) };
        recorded_channel(&reader.beside(log), *format).map(|channel| Some(Arc::new(channel)))
    }

    /// The law of the path loss: that of `[radio.model]`, or the paper's.
    fn path_loss(&self, loss_at_1m: Db, reader: &Reader<'_>) -> Result<PathLoss, InputError> {
        if let Some(model) = &self.model {
            if self.attenuation.is_some() || self.walls.is_some() {
                return Err(reader.wrong(
                    model,
                    "attenuation and walls belong to the paper's law".into(),
                    "remove them, or the table [radio.model]",
                ));
            }
            return ModelTable::read(model, loss_at_1m, reader);
        }
        Ok(PathLoss::UChain(UChain {
            attenuation: match self.attenuation {
                Some(AttenuationKey::WallCount) => Attenuation::WallCount,
                None | Some(AttenuationKey::RockDepth) => Attenuation::RockDepth,
            },
            walls: match self.walls {
                None | Some(WallsKey::Rock) => Walls::Rock,
                Some(WallsKey::Paper) => Walls::Paper,
                Some(WallsKey::Leaky) => Walls::Leaky,
            },
            loss_at_1m,
        }))
    }
}
