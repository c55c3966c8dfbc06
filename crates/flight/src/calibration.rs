//! Measures the gyroscope's bias and the direction of gravity while the drone lies still.
//!
//! A window of [`CalibrationConfig::samples`] counts as still when every axis of the gyroscope
//! stays within its noise; the mean of the window is then the bias. Calibration goes on for as long
//! as the drone is on the ground, so that a drone that has warmed up has a new bias before it
//! flies.

use crate::airframe::GRAVITY;

/// The limits within which a drone counts as lying still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationConfig {
    /// Samples per window; at 1 kHz, as many milliseconds.
    pub samples: u16,
    /// The largest variance on one axis of the gyroscope, (rad/s)².
    pub most_variance: f32,
    /// The largest plausible bias of the gyroscope, rad/s.
    pub most_bias: f32,
    /// The largest plausible error of the measured gravity, as a fraction of gravity.
    pub most_scale: f32,
}

impl CalibrationConfig {
    /// The constants for the BMI088: 512 samples with a variance below 100 steps² (of 0.061°/s
    /// each), as in crazyflie-firmware, `sensors_bmi088_bmp3xx.c`. The largest bias, 10°/s, is ten
    /// times the BMI088's zero-rate offset of ±1°/s, which grows with temperature. The BMI088's
    /// sensitivity and zero-g errors add up to some 5 %.
    pub const DEFAULT: Self = Self {
        samples: 512,
        most_variance: 100.0 * 1.065e-3 * 1.065e-3,
        most_bias: 0.175,
        most_scale: 0.1,
    };
}

/// The means of a window in which the drone lay still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RestMean {
    /// The gyroscope's bias, rad/s.
    pub(crate) gyro: [f32; 3],
    /// The specific force at rest, m/s².
    pub(crate) accel: [f32; 3],
}

/// A calibration window that is being filled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Calibration {
    count: u16,
    /// The first sample: sums are taken relative to it, so that single precision suffices.
    first: [f32; 3],
    sum: [f32; 3],
    squares: [f32; 3],
    accel: [f32; 3],
}

impl Calibration {
    pub(crate) const fn new() -> Self {
        Self { count: 0, first: [0.0; 3], sum: [0.0; 3], squares: [0.0; 3], accel: [0.0; 3] }
    }

    /// Adds one sample at rest; returns the means at the end of a window that was still.
    pub(crate) fn step(
        &mut self,
        config: &CalibrationConfig,
        gyro: [f32; 3],
        accel: [f32; 3],
    ) -> Option<RestMean> {
        if self.count == 0 {
            *self = Self { first: gyro, ..Self::new() };
        }
        self.count += 1;
        let sums = self.sum.iter_mut().zip(&mut self.squares);
        for ((sum, square), (value, first)) in sums.zip(gyro.iter().zip(self.first)) {
            let off = value - first;
            *sum += off;
            *square += off * off;
        }
        for (sum, value) in self.accel.iter_mut().zip(accel) {
            *sum += value;
        }
        if self.count < config.samples {
            return None;
        }
        let mean = self.finish(config);
        self.count = 0;
        mean
    }

    fn finish(&self, config: &CalibrationConfig) -> Option<RestMean> {
        let n = f32::from(self.count.max(1));
        let mut biases = self.first;
        for ((bias, sum), square) in biases.iter_mut().zip(self.sum).zip(self.squares) {
            let mean = sum / n;
            let variance = square / n - mean * mean;
            *bias += mean;
            let still = variance <= config.most_variance && bias.abs() <= config.most_bias;
            // Written so that a NaN reading is not still.
            if !still {
                return None;
            }
        }
        let accel = self.accel.map(|sum| sum / n);
        let [x, y, z] = accel;
        let length = libm::sqrtf(x * x + y * y + z * z);
        let plausible = (length / GRAVITY - 1.0).abs() <= config.most_scale;
        plausible.then_some(RestMean { gyro: biases, accel })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise without a generator: a sum of incommensurable sines.
    fn noise(n: usize, size: f32) -> f32 {
        let n = n as f32;
        size * (libm::sinf(1.7 * n) + libm::sinf(2.9 * n + 1.0))
    }

    fn window(noise_of: f32, bias: f32, gravity: f32) -> Option<RestMean> {
        let mut calibration = Calibration::new();
        (0..512)
            .filter_map(|n| {
                let gyro = [bias + noise(n, noise_of); 3];
                calibration.step(&CalibrationConfig::DEFAULT, gyro, [0.0, 0.0, gravity])
            })
            .next()
    }

    #[test]
    fn a_still_window_gives_its_mean() {
        let mean = window(2e-3, 0.05, 9.9).unwrap();
        for bias in mean.gyro {
            assert!((bias - 0.05).abs() < 2e-4, "{bias}");
        }
        assert!((mean.accel[2] - 9.9).abs() < 1e-4);
    }

    #[test]
    fn a_moved_drone_or_a_broken_sensor_gives_none() {
        assert_eq!(window(0.05, 0.0, 9.8), None);
        assert_eq!(window(1e-3, 0.5, 9.8), None);
        assert_eq!(window(1e-3, 0.0, 4.0), None);
        assert_eq!(window(f32::NAN, 0.0, 9.8), None);
        assert_eq!(window(1e-3, 0.0, f32::NAN), None);
    }
}
