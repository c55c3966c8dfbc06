//! Physical quantities as tuple structs over `f32`, with only those products and differences that
//! have a physical meaning.

use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::Duration;

/// Declares a quantity whose values can be added to each other and scaled.
macro_rules! linear_quantity {
    ($(#[$doc:meta])* $name:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name(pub f32);

        impl $name {
            /// The amount zero.
            pub const ZERO: Self = Self(0.0);

            /// The same amount without its sign.
            #[must_use]
            pub const fn abs(self) -> Self {
                Self(self.0.abs())
            }

            /// The amount limited to ±`limit`; a negative `limit` counts as zero, and NaN becomes
            /// zero.
            #[must_use]
            pub const fn limited_to(self, limit: Self) -> Self {
                let limit = limit.0.max(0.0);
                if self.0.is_nan() { Self(0.0) } else { Self(self.0.max(-limit).min(limit)) }
            }
        }

        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                self.0 += other.0;
            }
        }

        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl SubAssign for $name {
            fn sub_assign(&mut self, other: Self) {
                self.0 -= other.0;
            }
        }

        impl Neg for $name {
            type Output = Self;
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Mul<f32> for $name {
            type Output = Self;
            fn mul(self, factor: f32) -> Self {
                Self(self.0 * factor)
            }
        }

        impl Div<f32> for $name {
            type Output = Self;
            fn div(self, divisor: f32) -> Self {
                Self(self.0 / divisor)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)?;
                f.write_str($unit)
            }
        }
    };
}

linear_quantity! {
    /// A ratio of powers in decibels. As a path loss it is positive and larger is worse.
    Db, " dB"
}
linear_quantity! {
    /// The growth of a path loss with distance, in decibels per metre.
    DbPerMetre, " dB/m"
}
linear_quantity! {
    /// The compliance of a link or a chain of links: the length in metres by which it grows when
    /// its loss grows by one decibel. It is the inverse of a [`DbPerMetre`].
    MetresPerDb, " m/dB"
}
linear_quantity! {
    /// A length or a position, in metres.
    Metres, " m"
}
linear_quantity! {
    /// A speed, in metres per second.
    MetresPerSecond, " m/s"
}
linear_quantity! {
    /// An angle, in radians, counter-clockwise.
    Radians, " rad"
}
linear_quantity! {
    /// A turn rate, in radians per second, counter-clockwise.
    RadiansPerSecond, " rad/s"
}

impl Radians {
    /// The same direction as an angle of half a turn at most, for one of a turn and a half at most.
    #[must_use]
    pub fn wrapped(self) -> Self {
        use core::f32::consts::{PI, TAU};
        match self.0 {
            angle if angle > PI => Self(angle - TAU),
            angle if angle < -PI => Self(angle + TAU),
            angle => Self(angle),
        }
    }

    /// Returns sine and cosine, accurate to 1e-6 within some turns of zero. Unlike the C library's
    /// functions this one needs neither double precision nor tables, which take 3 kB of flash.
    #[must_use]
    pub fn sin_cos(self) -> (f32, f32) {
        use core::f32::consts::FRAC_2_PI;
        // π/2 in two parts, so that quarter turns are taken away exactly.
        const HALF_PI: [f32; 2] = [1.570_312_5, 4.838_268e-4];
        let half = if self.0 < 0.0 { -0.5 } else { 0.5 };
        let quarters = (self.0 * FRAC_2_PI + half) as i32;
        let n = quarters as f32;
        let x = self.0 - n * HALF_PI[0] - n * HALF_PI[1];
        let square = x * x;
        let sin = x * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
        let cos = 1.0
            - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
        match quarters & 3 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
}

linear_quantity! {
    /// A voltage, in volts.
    Volts, " V"
}

/// The received power in dBm: a negative number, larger is better. Two of them differ by [`Db`].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Dbm(pub f32);

impl Dbm {
    /// The path loss of a packet that was sent at 0 dBm and received at this power: −RSSI, the
    /// number that the U-Chain paper and its authors' firmware calculate with.
    #[must_use]
    pub const fn loss(self) -> Db {
        Db(-self.0)
    }

    /// The received power of a packet that was sent at 0 dBm and lost `loss` on its path.
    #[must_use]
    pub const fn after_loss(loss: Db) -> Self {
        Self(-loss.0)
    }
}

impl Sub for Dbm {
    type Output = Db;
    fn sub(self, other: Self) -> Db {
        Db(self.0 - other.0)
    }
}

impl Sub<Db> for Dbm {
    type Output = Self;
    fn sub(self, loss: Db) -> Self {
        Self(self.0 - loss.0)
    }
}

impl Add<Db> for Dbm {
    type Output = Self;
    fn add(self, gain: Db) -> Self {
        Self(self.0 + gain.0)
    }
}

impl fmt::Display for Dbm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)?;
        f.write_str(" dBm")
    }
}

impl Mul<Metres> for DbPerMetre {
    type Output = Db;
    fn mul(self, distance: Metres) -> Db {
        Db(self.0 * distance.0)
    }
}

impl Mul<Duration> for MetresPerSecond {
    type Output = Metres;
    fn mul(self, time: Duration) -> Metres {
        Metres(self.0 * time.as_secs_f32())
    }
}

impl Mul<Duration> for RadiansPerSecond {
    type Output = Radians;
    fn mul(self, time: Duration) -> Radians {
        Radians(self.0 * time.as_secs_f32())
    }
}

/// A drone's place in the launch order: 0 is the head, the base has the largest number of its
/// chain, and of two flying nodes the one with the smaller number is nearer to the head.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NodeId(pub u8);

impl NodeId {
    /// The number of the head, the explorer that the operator pilots.
    pub const HEAD: Self = Self(0);
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_c_library() {
        for n in -2_000..=2_000 {
            let angle = n as f32 * 0.01;
            let (sin, cos) = Radians(angle).sin_cos();
            assert!((sin - series(angle)).abs() < 4e-6, "sin {angle} is not {sin}");
            assert!((cos - series(angle + core::f32::consts::FRAC_PI_2)).abs() < 4e-6);
        }
    }

    /// The series of the sine, in double precision.
    fn series(angle: f32) -> f32 {
        let turn = 2.0 * core::f64::consts::PI;
        let mut x = f64::from(angle) % turn;
        if x.abs() > 0.5 * turn {
            x -= turn.copysign(x);
        }
        let mut term = x;
        let mut sum = x;
        for n in 1..20 {
            let n = f64::from(2 * n);
            term *= -x * x / (n * (n + 1.0));
            sum += term;
        }
        sum as f32
    }

    #[test]
    fn a_limit_holds_for_any_bits() {
        let limit = MetresPerSecond(0.4);
        assert_eq!(MetresPerSecond(f32::NAN).limited_to(limit), MetresPerSecond(0.0));
        assert_eq!(MetresPerSecond(f32::NEG_INFINITY).limited_to(limit), MetresPerSecond(-0.4));
        assert_eq!(MetresPerSecond(0.1).limited_to(MetresPerSecond(-1.0)), MetresPerSecond(0.0));
    }

    #[test]
    fn loss_and_received_power_mirror_each_other() {
        assert_eq!(Dbm::after_loss(Dbm(-63.0).loss()), Dbm(-63.0));
        assert_eq!(Dbm(-60.0) - Db(3.0), Dbm(-63.0));
    }
}
