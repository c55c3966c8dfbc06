//! A tunnel as a waveguide: a near zone in which waves spread as in free space, and a far zone in
//! which few modes are left, each of which decays by so many decibels a metre.
//!
//! The attenuation of a mode is that of A. Emslie, R. Lagace and P. Strong, *Theory of the
//! propagation of UHF radio waves in coal mine tunnels* (IEEE Trans. Antennas Propag. 23, 1975), for
//! a rectangular tunnel of width w and height h in rock of relative permittivity ε, with the
//! antennas upright:
//!
//! > a = 4.343·λ²·(m² / (w³·√(ε − 1)) + n²·ε / (h³·√(ε − 1)))  dB/m
//!
//! Measurements in a concrete tunnel at 2.45 GHz agree with it (C. Zhou and others, *Attenuation
//! constants of radio waves in lossy-walled rectangular waveguides*, PIER 142, 2013). Two modes of
//! different phase velocity beat: the signal fades periodically, as C. Rizzo and others measured in
//! the Somport tunnel (*Signal-based deployment planning for robot teams in tunnel-like fading
//! environments*, IJRR 32, 2013). By their cut-off in the rectangle, modes (1, 1) and (2, 1) beat with
//! the period
//!
//! > P = 8·w² / (3·λ)

use units::{Db, Metres};

use crate::log_distance::Corner;
use crate::path_loss::{Geometry, beyond};

/// The wavelength at 2.4 GHz, m.
pub const WAVELENGTH: f32 = 0.125;

/// A tunnel as a waveguide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waveguide {
    /// The loss over the first metre.
    pub loss_at_1m: Db,
    /// The end of the near zone.
    pub near: Metres,
    /// The loss of the first mode in the far zone, on each metre, dB.
    pub far_db_per_m: f32,
    /// The depth of the periodic fades: the amplitude of the second mode as a part of the first,
    /// 0 to 0.99.
    pub second_mode: f32,
    /// The distance from fade to fade.
    pub period: Metres,
    /// The losses behind rock.
    pub corner: Corner,
}

impl Waveguide {
    /// The waveguide that a rectangular tunnel makes in rock of this relative permittivity, more
    /// than 1.
    ///
    /// The near zone ends at w²/λ, where the first Fresnel zone meets the walls (Y. P. Zhang and
    /// others, IEEE Trans. Antennas Propag. 46, 1998).
    #[must_use]
    pub fn of(width: Metres, height: Metres, permittivity: f32, second_mode: f32) -> Self {
        let cubed = |metres: f32| metres * metres * metres;
        let excess = libm::sqrtf(permittivity - 1.0);
        let mode = 1.0 / (cubed(width.0) * excess) + permittivity / (cubed(height.0) * excess);
        Self {
            near: Metres(width.0 * width.0 / WAVELENGTH),
            far_db_per_m: 4.343 * WAVELENGTH * WAVELENGTH * mode,
            second_mode,
            period: Metres(8.0 * width.0 * width.0 / (3.0 * WAVELENGTH)),
            ..Self::DEFAULT
        }
    }

    /// A gallery of 2 m by 2 m in concrete, whose second mode is half as strong as the first.
    pub const DEFAULT: Self = Self {
        loss_at_1m: Db(40.0),
        near: Metres(32.0),
        far_db_per_m: 0.026,
        second_mode: 0.5,
        period: Metres(85.3),
        corner: crate::LogDistance::DEFAULT.corner,
    };

    pub(crate) fn loss(&self, link: Geometry, term: f32) -> Db {
        let within = link.along.0.min(self.near.0);
        let farther = link.along.0 - within;
        let spread = beyond(Metres(within), 2.0);
        self.loss_at_1m + spread + Db(self.far_db_per_m * farther + self.fade(farther) + term)
    }

    /// The loss by the beat of two modes, so far into the far zone, dB: none where it begins.
    fn fade(&self, farther: f32) -> f32 {
        let phase = core::f32::consts::TAU * farther / self.period.0;
        let second = self.second_mode;
        let power = 1.0 + second * second + 2.0 * second * libm::cosf(phase);
        let most = (1.0 + second) * (1.0 + second);
        -10.0 * libm::log10f(power / most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_tunnel_loses_less_and_fades_more_slowly() {
        let narrow = Waveguide::of(Metres(1.5), Metres(1.5), 5.24, 0.5);
        let wide = Waveguide::of(Metres(4.65), Metres(4.65), 5.24, 0.5);
        assert!(narrow.far_db_per_m > 10.0 * wide.far_db_per_m);
        // 2π / (β₁ − β₂), with β = √(k² − (mπ/w)²) of each mode.
        let wave_number = core::f64::consts::TAU / f64::from(WAVELENGTH);
        let beta = |m: f64| {
            libm::sqrt(wave_number * wave_number - libm::pow(m * core::f64::consts::PI / 4.65, 2.0))
        };
        let exact = core::f64::consts::TAU / (beta(1.0) - beta(2.0));
        let off = f64::from(wide.period.0) / exact - 1.0;
        assert!(off.abs() < 1e-3, "{:?} for {exact} m", wide.period);
        assert_eq!(narrow.near, Metres(18.0));
    }

    #[test]
    fn the_default_is_a_gallery_of_two_metres_in_concrete() {
        let made = Waveguide::of(Metres(2.0), Metres(2.0), 5.24, 0.5);
        let default = Waveguide::DEFAULT;
        assert_eq!(made.near, default.near);
        assert!((made.far_db_per_m - default.far_db_per_m).abs() < 1e-3, "{made:?}");
        assert!((made.period.0 - default.period.0).abs() < 0.1);
    }

    #[test]
    fn fades_are_as_deep_as_the_second_mode_is_strong() {
        let tunnel = Waveguide { far_db_per_m: 0.0, ..Waveguide::DEFAULT };
        let at = |m| tunnel.loss(Geometry::in_sight(Metres(m)), 0.0).0;
        let (start, trough) = (tunnel.near.0, tunnel.near.0 + tunnel.period.0 / 2.0);
        // 20·log₁₀((1 + 0.5) / (1 − 0.5))
        assert!((at(trough) - at(start) - 9.54).abs() < 0.01);
        assert!((at(start + tunnel.period.0) - at(start)).abs() < 0.01);
    }
}
