//! The signal-to-noise ratio over the distance from a relay.

use units::{Db, Metres};

/// A curve that falls with the square of the distance up to `knee`, and beyond it as a straight
/// line, the tangent at the knee, down to 0 dB.
///
/// The paper names one point of its curve, 37 dB at 20 m (1 Mbit/s); the shape is an assumption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// The ratio above which a cell counts as covered, and the ratio at the knee.
    pub covered: Db,
    /// The distance at which the ratio is `covered`.
    pub knee: Metres,
}

impl Curve {
    /// The paper's point: 37 dB at 20 m.
    pub const DEFAULT: Self = Self { covered: Db(37.0), knee: Metres(20.0) };
    /// The nearest distance that the curve tells apart, m: a relay is not inside its own antenna.
    const NEAREST: f32 = 0.1;

    /// The ratio at a distance.
    #[must_use]
    pub fn at(&self, distance: Metres) -> Db {
        let (d, knee) = (distance.0.max(Self::NEAREST), self.knee.0);
        if d <= knee {
            return Db(self.covered.0 + 20.0 * libm::log10f(knee / d));
        }
        let slope = 20.0 / (core::f32::consts::LN_10 * knee);
        Db((self.covered.0 - slope * (d - knee)).max(0.0))
    }

    /// The farthest distance at which the ratio is still this one, the inverse of [`Self::at`]; for
    /// 0 dB and less the distance at which the curve reaches 0 dB.
    #[must_use]
    pub fn reach(&self, ratio: Db) -> Metres {
        let over = ratio.0.max(0.0) - self.covered.0;
        if over >= 0.0 {
            return Metres(self.knee.0 * libm::powf(10.0, -over / 20.0));
        }
        let slope = 20.0 / (core::f32::consts::LN_10 * self.knee.0);
        Metres(self.knee.0 - over / slope)
    }
}
