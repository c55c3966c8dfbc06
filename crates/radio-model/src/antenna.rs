//! The pattern of an antenna in the plane.

use units::{Db, Radians};

/// An antenna that a board or a battery shields on one side: a cardioid, whose gain is 0 dB
/// opposite the null and [`depth`](Self::depth) less towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antenna {
    /// The difference between the best and the worst direction.
    pub depth: Db,
    /// The worst direction, counter-clockwise from the nose.
    pub null: Radians,
}

impl Antenna {
    /// The gain towards this direction, counter-clockwise from the nose; at most 0 dB.
    #[must_use]
    pub fn gain(&self, towards: Radians) -> Db {
        Db(-0.5 * self.depth.0 * (1.0 + libm::cosf(towards.0 - self.null.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn the_gain_falls_towards_the_null() {
        let antenna = Antenna { depth: Db(6.0), null: Radians(PI) };
        for (towards, gain) in [(0.0, 0.0), (FRAC_PI_2, -3.0), (PI, -6.0), (-FRAC_PI_2, -3.0)] {
            assert!((antenna.gain(Radians(towards)).0 - gain).abs() < 1e-5, "{towards}");
        }
    }
}
