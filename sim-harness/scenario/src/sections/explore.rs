//! The section `[explore]` of a scenario file: the area that drones explore together.

use agent::ExploreConfig;
use frontier::{RULES, Rule, RuleEntry};
use input::reader::{At, Pair, Reader};
use input::{InputError, suggest};
use serde::Deserialize;
use units::{Metres, MetresPerSecond, Point2, Pose2, Radians, RadiansPerSecond};

/// The table `[explore]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExploreTable {
    corner_m: Option<Pair>,
    area_m: Option<At<Pair>>,
    start_m: Option<Pair>,
    direction_deg: Option<At<f32>>,
    speed_mps: Option<At<f32>>,
    turn_dps: Option<At<f32>>,
    rule: Option<At<String>>,
}

impl ExploreTable {
    /// Checks the section.
    pub(crate) fn read(&self, reader: &Reader<'_>) -> Result<ExploreConfig, InputError> {
        let usual = ExploreConfig::DEFAULT;
        let point = |pair: Option<Pair>, usual| pair.map_or(usual, Point2::from);
        let area = match &self.area_m {
            None => usual.area,
            Some(key) => {
                let Point2 { x, y } = Point2::from(*key.as_ref());
                let most = ExploreConfig::MOST_EXTENT.0;
                if !((1.0..=most).contains(&x) && (1.0..=most).contains(&y)) {
                    let wrong = format!("an area of {x} m by {y} m");
                    return Err(reader.wrong(key, wrong, format!("give 1 to {most} m each way")));
                }
                (Metres(x), Metres(y))
            }
        };
        let number =
            |key: &Option<At<f32>>, name, range, usual| reader.or(key.as_ref(), name, range, usual);
        let yaw = usual.start.yaw.0.to_degrees();
        let direction = number(&self.direction_deg, "direction_deg", -360.0..=360.0, yaw)?;
        let turn = number(&self.turn_dps, "turn_dps", 1.0..=90.0, usual.turn.0.to_degrees())?;
        let start = Pose2 {
            at: point(self.start_m, usual.start.at),
            yaw: if self.direction_deg.is_some() {
                Radians(direction.to_radians())
            } else {
                usual.start.yaw
            },
        };
        Ok(ExploreConfig {
            corner: point(self.corner_m, usual.corner),
            area,
            start,
            speed: MetresPerSecond(number(
                &self.speed_mps,
                "speed_mps",
                0.05..=1.0,
                usual.speed.0,
            )?),
            turn: if self.turn_dps.is_some() {
                RadiansPerSecond(turn.to_radians())
            } else {
                usual.turn
            },
            rule: self.rule(usual.rule, reader)?,
            ..usual
        })
    }

    /// The rule, as drones follow it.
    fn rule(&self, usual: Rule, reader: &Reader<'_>) -> Result<Rule, InputError> {
        let Some(name) = &self.rule else { return Ok(usual) };
        let found = RuleEntry::named(name.as_ref()).map(|entry| entry.rule);
        found.map(ExploreConfig::on_board).ok_or_else(|| {
            let names = RULES.map(|entry| entry.name);
            let wrong = format!("there is no rule \"{}\"", name.as_ref());
            reader.wrong(name, wrong, suggest::one_of(name.as_ref(), &names))
        })
    }
}
