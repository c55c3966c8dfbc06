//! The section `[ground]` of a scenario file.

use input::InputError;
use input::reader::{At, Reader};
use serde::Deserialize;

use super::flow::Ground;

/// The table `[ground]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GroundTable {
    light: Option<At<f32>>,
    texture: Option<At<f32>>,
}

impl GroundTable {
    /// Checks the section.
    pub(crate) fn read(&self, reader: &Reader<'_>) -> Result<Ground, InputError> {
        let part = |value: &Option<At<f32>>, key| reader.or(value.as_ref(), key, 0.0..=1.0, 1.0);
        Ok(Ground { light: part(&self.light, "light")?, texture: part(&self.texture, "texture")? })
    }
}
