//! The attenuation of waves of 2.4 GHz in the materials that tunnels are cut into and lined with.

/// A material of Recommendation ITU-R P.2040-3, table 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// Concrete.
    Concrete,
    /// Brick.
    Brick,
    /// Wood, of shoring and partitions.
    Wood,
    /// Very dry ground: the nearest of the table's to dry rock.
    VeryDryGround,
    /// Medium dry ground: the nearest of the table's to wet rock and clay.
    MediumDryGround,
}

impl Material {
    /// All materials.
    pub const ALL: [Self; 5] =
        [Self::Concrete, Self::Brick, Self::Wood, Self::VeryDryGround, Self::MediumDryGround];

    /// The name of the material in scenario files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Concrete => "concrete",
            Self::Brick => "brick",
            Self::Wood => "wood",
            Self::VeryDryGround => "very-dry-ground",
            Self::MediumDryGround => "medium-dry-ground",
        }
    }

    /// The real part of the relative permittivity at 2.4 GHz: a·f^b of the table, f = 2.4.
    #[must_use]
    pub const fn permittivity(self) -> f32 {
        match self {
            Self::Concrete => 5.24,
            Self::Brick => 3.91,
            Self::Wood => 1.99,
            Self::VeryDryGround => 3.0,
            Self::MediumDryGround => 13.74,
        }
    }

    /// The conductivity at 2.4 GHz, S/m: c·f^d of the table, f = 2.4.
    const fn conductivity(self) -> f32 {
        match self {
            Self::Concrete => 0.091_63,
            Self::Brick => 0.027_38,
            Self::Wood => 0.012_01,
            Self::VeryDryGround => 0.001_362,
            Self::MediumDryGround => 0.145_8,
        }
    }

    /// The loss of a plane wave on each metre, dB: 1636·σ/√ε (the Recommendation's equation for
    /// dielectrics of small loss).
    #[must_use]
    pub const fn loss_per_m(self) -> f32 {
        1636.0 * self.conductivity() / self.refraction()
    }

    /// The square root of the permittivity, which no constant function can take.
    const fn refraction(self) -> f32 {
        match self {
            Self::Concrete => 2.2891,
            Self::Brick => 1.9774,
            Self::Wood => 1.4107,
            Self::VeryDryGround => 1.7321,
            Self::MediumDryGround => 3.7068,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table's a, b, c and d.
    fn table(material: Material) -> [f32; 4] {
        match material {
            Material::Concrete => [5.24, 0.0, 0.0462, 0.7822],
            Material::Brick => [3.91, 0.0, 0.0238, 0.16],
            Material::Wood => [1.99, 0.0, 0.0047, 1.0718],
            Material::VeryDryGround => [3.0, 0.0, 0.000_15, 2.52],
            Material::MediumDryGround => [15.0, -0.1, 0.035, 1.63],
        }
    }

    #[test]
    fn the_constants_are_the_tables_at_2_4_ghz() {
        for material in Material::ALL {
            let [a, b, c, d] = table(material);
            let permittivity = a * libm::powf(2.4, b);
            let conductivity = c * libm::powf(2.4, d);
            let near = |got: f32, wanted: f32| (got / wanted - 1.0).abs() < 1e-3;
            assert!(near(material.permittivity(), permittivity), "{material:?} {permittivity}");
            assert!(near(material.conductivity(), conductivity), "{material:?} {conductivity}");
            let wanted = 1636.0 * conductivity / libm::sqrtf(permittivity);
            assert!(near(material.loss_per_m(), wanted), "{material:?} {wanted}");
        }
    }
}
