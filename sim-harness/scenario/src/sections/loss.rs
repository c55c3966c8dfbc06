//! The section `[[loss]]` of a scenario file: the drones that the chain loses, and how.

use input::InputError;
use input::reader::{At, Reader};
use serde::Deserialize;

use super::Drones;

/// The loss of one drone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loss {
    /// When the drone is lost.
    pub at_us: u64,
    /// The number of the drone.
    pub drone: usize,
    /// How it is lost.
    pub how: LossKind,
}

/// How a drone is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossKind {
    /// Its flight code brings it down where it is; its radio goes on.
    Lands,
    /// Its radio neither sends nor hears any more; it goes on flying.
    Silent,
    /// Its motors and its radio stop: it lies on the ground.
    Gone,
}

impl LossKind {
    /// Whether the radio is dead.
    #[must_use]
    pub const fn is_silent(self) -> bool {
        matches!(self, Self::Silent | Self::Gone)
    }
}

/// One entry of `[[loss]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LossTable {
    at_s: At<f32>,
    drone: At<usize>,
    how: LossKind,
}

impl LossTable {
    /// Checks all entries, and sorts them by time.
    pub(crate) fn read(
        tables: &[At<Self>],
        drones: &Drones,
        duration_us: u64,
        reader: &Reader<'_>,
    ) -> Result<Vec<Loss>, InputError> {
        let mut losses: Vec<Loss> = Vec::with_capacity(tables.len());
        for table in tables {
            let Self { at_s, drone, how } = table.as_ref();
            let at_us = reader.micros(at_s, "at_s", 0.0..=86_400.0)?;
            if at_us >= duration_us {
                let wrong = format!("at_s = {} is not before the end", at_s.as_ref());
                return Err(reader.wrong(at_s, wrong, "lose it earlier or raise duration_s"));
            }
            let number = *drone.as_ref();
            if number >= drones.flying() {
                let remedy = format!("give a number from 0 to {}", drones.flying() - 1);
                return Err(reader.wrong(drone, format!("drone {number} does not fly"), remedy));
            }
            if losses.iter().any(|loss| loss.drone == number) {
                let wrong = format!("drone {number} is lost twice");
                return Err(reader.wrong(drone, wrong, "lose each drone once"));
            }
            losses.push(Loss { at_us, drone: number, how: *how });
        }
        losses.sort_by_key(|loss| loss.at_us);
        Ok(losses)
    }
}
