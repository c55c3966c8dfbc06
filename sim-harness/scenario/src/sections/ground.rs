//! The section `[ground]` of a scenario file.

use input::InputError;
use input::reader::{At, Reader};
use serde::Deserialize;

/// Light and texture of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Light on it: 1 is a lit room, 0 is none at all.
    pub light: f32,
    /// The texture: 1 is a carpet, 0 a sheet of paper.
    pub texture: f32,
}

impl Ground {
    /// A lit floor with texture.
    pub const GOOD: Self = Self { light: 1.0, texture: 1.0 };
    /// A cave without a lamp.
    pub const DARK: Self = Self { light: 0.0, texture: 1.0 };
}

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
