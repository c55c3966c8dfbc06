//! Reads the section `[criteria]` of a scenario file.

use input::InputError;
use input::reader::{At, Reader};
use serde::Deserialize;

use super::MOST_DRONES;

/// The bounds that a scenario sets; a bound that is `None` is not checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criteria {
    /// The largest difference between the mean losses of the links at the end of the hold, dB.
    pub hold_spread_db: Option<f32>,
    /// The largest swing of 95 % of the links at the end of the hold, dB.
    pub swing_p95_db: Option<f32>,
    /// The largest tilt in the air, degrees.
    pub tilt_deg: Option<f32>,
    /// The number of relays that must at least have been in the chain at the same time.
    pub launched: Option<u32>,
    /// The least part that explorers must know of what they can come to; [`Self::EXPLORED`] where it is not
    /// set.
    pub explored: Option<f32>,
    /// The largest part of the walls of explorers' maps that may be none; [`Self::FALSE`] where it is not
    /// set.
    pub false_walls: Option<f32>,
    /// The largest part of what explorers' maps have as free that may be rock; [`Self::FALSE`] where it is
    /// not set.
    pub false_free: Option<f32>,
    /// The least part of its area that a swarm must have flown over; [`Self::COVERED`] where it is not set.
    pub covered: Option<f32>,
}

impl Criteria {
    /// The least part that must be explored: what counts as known in the thesis' figures of time.
    pub const EXPLORED: f32 = 0.99;
    /// The largest part of a map that may be wrong by more than a cell. Our own number.
    pub const FALSE: f32 = 0.05;
    /// The least part of the area that must be covered. Our own number.
    pub const COVERED: f32 = 0.99;
}

/// The table `[criteria]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CriteriaTable {
    hold_spread_db: Option<At<f32>>,
    swing_p95_db: Option<At<f32>>,
    tilt_deg: Option<At<f32>>,
    launched: Option<At<f32>>,
    explored: Option<At<f32>>,
    false_walls: Option<At<f32>>,
    false_free: Option<At<f32>>,
    covered: Option<At<f32>>,
}

impl CriteriaTable {
    /// Checks the section.
    pub(crate) fn read(&self, reader: &Reader<'_>) -> Result<Criteria, InputError> {
        let bound = |value: &Option<At<f32>>, key, range| {
            value.as_ref().map(|value| reader.number(value, key, range)).transpose()
        };
        let most = (MOST_DRONES - 1) as f32;
        Ok(Criteria {
            hold_spread_db: bound(&self.hold_spread_db, "hold_spread_db", 0.0..=100.0)?,
            swing_p95_db: bound(&self.swing_p95_db, "swing_p95_db", 0.0..=100.0)?,
            tilt_deg: bound(&self.tilt_deg, "tilt_deg", 0.0..=180.0)?,
            launched: bound(&self.launched, "launched", 0.0..=most)?.map(|n| n as u32),
            explored: bound(&self.explored, "explored", 0.0..=1.0)?,
            false_walls: bound(&self.false_walls, "false_walls", 0.0..=1.0)?,
            false_free: bound(&self.false_free, "false_free", 0.0..=1.0)?,
            covered: bound(&self.covered, "covered", 0.0..=1.0)?,
        })
    }
}
