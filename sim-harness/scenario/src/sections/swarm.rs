//! The section `[swarm]` of a scenario file: the plan of a swarm's mission.

use agent::SwarmConfig;
use input::InputError;
use input::reader::{At, Pair, Reader};
use serde::Deserialize;
use units::{Metres, MetresPerSecond, Point2, Radians};
use virtual_forces::Passage;

/// The table `[swarm]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SwarmTable {
    corner_m: Option<Pair>,
    area_m: Option<At<Pair>>,
    entrance_m: Option<Pair>,
    width_m: Option<At<f32>>,
    direction_deg: Option<At<f32>>,
    length_m: Option<At<f32>>,
    both_areas: Option<bool>,
    speed_mps: Option<At<f32>>,
}

impl SwarmTable {
    /// Checks the section, for so many drones.
    pub(crate) fn read(
        &self,
        drones: usize,
        reader: &Reader<'_>,
    ) -> Result<SwarmConfig, InputError> {
        let usual = SwarmConfig::DEFAULT;
        let point = |pair: Option<Pair>, usual| pair.map_or(usual, Point2::from);
        let area = match &self.area_m {
            None => usual.area,
            Some(key) => {
                let Point2 { x, y } = Point2::from(*key.as_ref());
                if !((1.0..=100.0).contains(&x) && (1.0..=100.0).contains(&y)) {
                    let wrong = format!("an area of {x} m by {y} m");
                    return Err(reader.wrong(key, wrong, "give 1 to 100 m each way"));
                }
                (Metres(x), Metres(y))
            }
        };
        let number =
            |key: &Option<At<f32>>, name, range, usual| reader.or(key.as_ref(), name, range, usual);
        let direction = number(&self.direction_deg, "direction_deg", -360.0..=360.0, 0.0)?;
        let (sin, cos) = Radians(direction.to_radians()).sin_cos();
        let Passage { width, length, .. } = usual.passage;
        Ok(SwarmConfig {
            drones: drones as u16,
            corner: point(self.corner_m, usual.corner),
            area,
            both: self.both_areas.unwrap_or(usual.both),
            passage: Passage {
                entrance: point(self.entrance_m, usual.passage.entrance),
                width: Metres(number(&self.width_m, "width_m", 0.5..=20.0, width.0)?),
                way: Point2::new(cos, sin),
                length: Metres(number(&self.length_m, "length_m", 0.0..=100.0, length.0)?),
            },
            speed: MetresPerSecond(number(
                &self.speed_mps,
                "speed_mps",
                0.05..=1.0,
                usual.speed.0,
            )?),
            ..usual
        })
    }
}
