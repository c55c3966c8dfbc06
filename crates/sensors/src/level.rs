//! The vendor's trim of the accelerometer, for an inertial sensor that is not mounted quite level.

use units::{Acceleration, Radians};

/// The rotation of accelerations from the sensor's axes to the airframe's, as in the vendor's
/// firmware: about x by the roll, then about y by the pitch (crazyflie-firmware,
/// `sensors_bmi088_bmp3xx.c`, `sensorsAccAlignToGravity`). As there, the gyroscope's rates are not
/// rotated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Level {
    roll: SinCos,
    pitch: SinCos,
}

impl Level {
    /// The rotation for a sensor that is tilted by `roll` and `pitch`, each up to 0.35 rad, while
    /// the airframe is level: `roll` lowers its right side, and `pitch`, with the vendor's sign,
    /// **raises** its nose.
    #[must_use]
    pub fn new(roll: Radians, pitch: Radians) -> Self {
        Self { roll: SinCos::of(roll.0), pitch: SinCos::of(pitch.0) }
    }

    /// Rotates an acceleration from the sensor's axes to the airframe's.
    #[must_use]
    pub fn apply(&self, Acceleration([x, y, z]): Acceleration) -> Acceleration {
        let SinCos { sin, cos } = self.roll;
        let (y, z) = (y * cos - z * sin, y * sin + z * cos);
        let SinCos { sin, cos } = self.pitch;
        let (x, z) = (x * cos - z * sin, x * sin + z * cos);
        Acceleration([x, y, z])
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct SinCos {
    sin: f32,
    cos: f32,
}

impl SinCos {
    /// Sine and cosine by their series, good to 2·10⁻⁷ within 0.35 rad. Those of `libm` calculate
    /// in double precision, which the drone's processor does not have.
    fn of(angle: f32) -> Self {
        let square = angle * angle;
        Self {
            sin: angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))),
            cos: 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f32 = 9.806_65;

    fn near(Acceleration(one): Acceleration, other: [f32; 3]) -> bool {
        one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-5)
    }

    #[test]
    fn gravity_on_a_tilted_sensor_in_a_level_airframe_is_along_z() {
        for roll in -35..=35 {
            for pitch in -35..=35 {
                let (roll, pitch) = (0.01 * roll as f32, 0.01 * pitch as f32);
                // The vertical in the axes of a sensor with its right side down and its nose up.
                let measured =
                    [G * pitch.sin(), G * roll.sin() * pitch.cos(), G * roll.cos() * pitch.cos()];
                let level = Level::new(Radians(roll), Radians(pitch));
                assert!(near(level.apply(Acceleration(measured)), [0.0, 0.0, G]), "{roll} {pitch}");
            }
        }
    }

    #[test]
    fn a_positive_roll_turns_gravity_to_the_right_and_a_positive_pitch_backwards() {
        let measured = Acceleration([0.0, 0.0, G]);
        let [x, y, _] = Level::new(Radians(0.1), Radians::ZERO).apply(measured).0;
        assert!(x == 0.0 && y < -0.9);
        let [x, y, _] = Level::new(Radians::ZERO, Radians(0.1)).apply(measured).0;
        assert!(x < -0.9 && y == 0.0);
    }

    #[test]
    fn the_series_keep_their_error_bound() {
        for step in -3_500..=3_500 {
            let angle = 1e-4 * step as f32;
            let SinCos { sin, cos } = SinCos::of(angle);
            let (true_sin, true_cos) = f64::from(angle).sin_cos();
            assert!((f64::from(sin) - true_sin).abs() < 2e-7, "sin {angle}");
            assert!((f64::from(cos) - true_cos).abs() < 2e-7, "cos {angle}");
        }
    }
}
