//! Reads the tables `[radio.model]`, `[radio.shadowing]`, `[radio.fading]` and `[radio.antenna]` of a scenario file.

mod tabulated;

use input::InputError;
use input::reader::{At, Reader};
use radio_model::{Antenna, Corner, LogDistance, Material, PathLoss, Subt, Waveguide};
use serde::Deserialize;
use units::{Db, Metres, Radians};

/// The table `[radio.model]`: a law of the path loss other than the paper's.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    law: LawKey,
    exponent: Option<At<f32>>,
    exponent_per_wall: Option<At<f32>>,
    material: Option<MaterialKey>,
    through_db_per_m: Option<At<f32>>,
    corner_db: Option<At<f32>>,
    width_m: Option<At<f32>>,
    height_m: Option<At<f32>>,
    permittivity: Option<At<f32>>,
    second_mode: Option<At<f32>>,
    distance_m: Option<At<Vec<f32>>>,
    loss_db: Option<At<Vec<Vec<f32>>>>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum LawKey {
    LogDistance,
    Subt,
    Waveguide,
    Table,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum MaterialKey {
    Concrete,
    Brick,
    Wood,
    VeryDryGround,
    MediumDryGround,
}

impl From<MaterialKey> for Material {
    fn from(key: MaterialKey) -> Self {
        match key {
            MaterialKey::Concrete => Self::Concrete,
            MaterialKey::Brick => Self::Brick,
            MaterialKey::Wood => Self::Wood,
            MaterialKey::VeryDryGround => Self::VeryDryGround,
            MaterialKey::MediumDryGround => Self::MediumDryGround,
        }
    }
}

/// The material of the rock, where the file names none.
const ROCK: Material = Material::Concrete;

impl ModelTable {
    /// The law of the table, for a loss over the first metre that the section `[radio]` gives.
    pub fn read(
        table: &At<Self>,
        loss_at_1m: Db,
        reader: &Reader<'_>,
    ) -> Result<PathLoss, InputError> {
        let model = table.as_ref();
        model.refuse_foreign_keys(table, reader)?;
        match model.law {
            LawKey::LogDistance => model.log_distance(loss_at_1m, reader),
            LawKey::Subt => model.subt(loss_at_1m, reader),
            LawKey::Waveguide => model.waveguide(loss_at_1m, reader),
            LawKey::Table => {
                let keys = (model.distance_m.as_ref(), model.loss_db.as_ref());
                tabulated::read(table, keys, reader).map(PathLoss::Tabulated)
            }
        }
    }

    /// The variance of a packet's RSSI that belongs to the law, where it has one, dB².
    pub fn noise_variance(&self) -> Option<f32> {
        (self.law == LawKey::Subt).then_some(Subt::NOISE_VARIANCE)
    }

    /// Refuses keys that the law does not have, which would be read and do nothing.
    fn refuse_foreign_keys(&self, at: &At<Self>, reader: &Reader<'_>) -> Result<(), InputError> {
        use LawKey::{LogDistance, Subt, Table, Waveguide};
        let keys: [(&str, bool, &[LawKey]); 11] = [
            ("exponent", self.exponent.is_some(), &[LogDistance, Subt]),
            ("exponent_per_wall", self.exponent_per_wall.is_some(), &[Subt]),
            ("material", self.material.is_some(), &[LogDistance, Waveguide]),
            ("through_db_per_m", self.through_db_per_m.is_some(), &[LogDistance, Waveguide]),
            ("corner_db", self.corner_db.is_some(), &[LogDistance, Waveguide]),
            ("width_m", self.width_m.is_some(), &[Waveguide]),
            ("height_m", self.height_m.is_some(), &[Waveguide]),
            ("permittivity", self.permittivity.is_some(), &[Waveguide]),
            ("second_mode", self.second_mode.is_some(), &[Waveguide]),
            ("distance_m", self.distance_m.is_some(), &[Table]),
            ("loss_db", self.loss_db.is_some(), &[Table]),
        ];
        match keys.iter().find(|(_, given, laws)| *given && !laws.contains(&self.law)) {
            None => Ok(()),
            Some((key, ..)) => {
                let wrong = format!("this law has no {key}");
                Err(reader.wrong(at, wrong, "remove the key, or choose another law"))
            }
        }
    }

    fn log_distance(&self, loss_at_1m: Db, reader: &Reader<'_>) -> Result<PathLoss, InputError> {
        let default = LogDistance::DEFAULT;
        let exponent =
            reader.or(self.exponent.as_ref(), "exponent", 1.0..=8.0, default.exponent)?;
        let corner = self.corner(reader)?;
        Ok(PathLoss::LogDistance(LogDistance { loss_at_1m, exponent, corner }))
    }

    fn subt(&self, loss_at_1m: Db, reader: &Reader<'_>) -> Result<PathLoss, InputError> {
        let Subt { exponent, per_cost, .. } = Subt::DEFAULT;
        let per_wall = self.exponent_per_wall.as_ref();
        Ok(PathLoss::Subt(Subt {
            loss_at_1m,
            exponent: reader.or(self.exponent.as_ref(), "exponent", 1.0..=8.0, exponent)?,
            per_cost: reader.or(per_wall, "exponent_per_wall", 0.0..=4.0, per_cost)?,
        }))
    }

    fn waveguide(&self, loss_at_1m: Db, reader: &Reader<'_>) -> Result<PathLoss, InputError> {
        let size = |key: Option<&At<f32>>, name| reader.or(key, name, 0.5..=50.0, 2.0).map(Metres);
        let width = size(self.width_m.as_ref(), "width_m")?;
        let height = size(self.height_m.as_ref(), "height_m")?;
        let rock = self.material.map_or(ROCK, Material::from).permittivity();
        let permittivity =
            reader.or(self.permittivity.as_ref(), "permittivity", 1.1..=100.0, rock)?;
        let second = Waveguide::DEFAULT.second_mode;
        let second = reader.or(self.second_mode.as_ref(), "second_mode", 0.0..=0.99, second)?;
        let corner = self.corner(reader)?;
        let guide = Waveguide::of(width, height, permittivity, second);
        Ok(PathLoss::Waveguide(Waveguide { loss_at_1m, corner, ..guide }))
    }

    fn corner(&self, reader: &Reader<'_>) -> Result<Corner, InputError> {
        let rock = self.material.map_or(ROCK, Material::from).loss_per_m();
        let through = self.through_db_per_m.as_ref();
        let round = LogDistance::DEFAULT.corner.round.0;
        Ok(Corner {
            through_db_per_m: reader.or(through, "through_db_per_m", 0.0..=1000.0, rock)?,
            round: Db(reader.or(self.corner_db.as_ref(), "corner_db", 0.0..=100.0, round)?),
        })
    }
}

/// The table `[radio.shadowing]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShadowingTable {
    deviation_db: At<f32>,
    decorrelation_m: At<f32>,
}

impl ShadowingTable {
    /// The standard deviation and the decorrelation distance.
    pub fn read(&self, reader: &Reader<'_>) -> Result<(Db, Metres), InputError> {
        let deviation = reader.number(&self.deviation_db, "deviation_db", 0.0..=30.0)?;
        let distance = reader.number(&self.decorrelation_m, "decorrelation_m", 0.1..=1000.0)?;
        Ok((Db(deviation), Metres(distance)))
    }
}

/// The table `[radio.fading]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FadingTable {
    rician_k: At<f32>,
}

impl FadingTable {
    /// The factor K.
    pub fn read(&self, reader: &Reader<'_>) -> Result<f32, InputError> {
        reader.number(&self.rician_k, "rician_k", 0.0..=1000.0)
    }
}

/// The table `[radio.antenna]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AntennaTable {
    depth_db: At<f32>,
    null_deg: At<f32>,
}

impl AntennaTable {
    /// The pattern.
    pub fn read(&self, reader: &Reader<'_>) -> Result<Antenna, InputError> {
        let depth = reader.number(&self.depth_db, "depth_db", 0.0..=40.0)?;
        let null = reader.number(&self.null_deg, "null_deg", -180.0..=180.0)?;
        Ok(Antenna { depth: Db(depth), null: Radians(null.to_radians()) })
    }
}
