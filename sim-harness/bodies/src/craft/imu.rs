//! The BMI088: angular velocity and specific force with the errors of the sensor.
//!
//! Each axis is gain × truth + bias + noise, through the sensor's own low-pass, rounded to 16 bits
//! and stopped at the end of the range. The noise is the data sheet's, white, and with the motors
//! on vibration on top, which has no part at zero frequency: a body that shakes goes nowhere.

use random::Stream;

use super::body::Vector;

/// Samples of one sensor in a second.
const RATE: f32 = 1000.0;
/// Square root of half the sampling rate: the factor from a density in /√Hz to the deviation of one
/// sample.
const ROOT_HALF_RATE: f32 = 22.360_68;

/// One sensor's constants, in its own unit (rad/s or m/s²).
#[derive(Clone, Copy, Debug)]
struct Sensor {
    /// White noise, per √Hz, along x, y and z.
    density: Vector,
    /// Standard deviation of the bias at switch-on.
    bias: f32,
    /// The random walk of the bias, per √s.
    walk: f32,
    /// Standard deviation of the gain's error.
    gain: f32,
    /// Standard deviation of the vibration with the motors at hover, before the low-pass.
    vibration: Vector,
    /// The part of a sample that passes the low-pass at once.
    pass: f32,
    /// Full range over 32,768, and one over that.
    digit: f32,
    per_digit: f32,
}

const DEGREE: f32 = core::f32::consts::PI / 180.0;
const MILLI_G: f32 = 9.806_65e-3;

/// BMI088 data sheet 1.4, table 3: 0.014 °/s/√Hz, zero-rate offset ±1 °/s and sensitivity ±1 %
/// (both read as two standard deviations), 0.015 °/s/K over a warming of 10 K in three minutes.
/// Bandwidth 116 Hz. Vibration: the vendor's filter counts on 0.1 rad/s
/// (`kalman_core_params_defaults.h`).
const GYRO: Sensor = Sensor {
    density: [0.014 * DEGREE; 3],
    bias: 0.5 * DEGREE,
    walk: 0.15 * DEGREE / 13.4,
    gain: 0.005,
    vibration: [0.1; 3],
    // 1 - exp(-2π · 116 Hz / 1000 Hz)
    pass: 0.5176,
    digit: 2000.0 * DEGREE / 32_768.0,
    per_digit: 32_768.0 / (2000.0 * DEGREE),
};

/// BMI088 data sheet 1.4, table 2: 160 and 190 µg/√Hz, zero-g offset ±20 mg and sensitivity ±0.5 %
/// (two standard deviations), 0.2 mg/K. Bandwidth 145 Hz (1600 Hz, OSR4). Vibration: the vendor's
/// filter counts on 0.5 m/s² and along z 1 m/s².
const ACCEL: Sensor = Sensor {
    density: [0.160 * MILLI_G, 0.160 * MILLI_G, 0.190 * MILLI_G],
    bias: 10.0 * MILLI_G,
    walk: 2.0 * MILLI_G / 13.4,
    gain: 0.0025,
    vibration: [0.5, 0.5, 1.0],
    // 1 - exp(-2π · 145 Hz / 1000 Hz)
    pass: 0.5979,
    digit: 24_000.0 * MILLI_G / 32_768.0,
    per_digit: 32_768.0 / (24_000.0 * MILLI_G),
};

/// One sensor's state.
#[derive(Clone, Copy, Debug)]
struct Axes {
    bias: Vector,
    gain: Vector,
    /// The last draws, of which the vibration is the difference.
    shake: Vector,
    output: Vector,
}

impl Axes {
    fn new(sensor: &Sensor, random: &mut Stream) -> Self {
        Self {
            bias: std::array::from_fn(|_| sensor.bias * random.gauss()),
            gain: std::array::from_fn(|_| 1.0 + sensor.gain * random.gauss()),
            shake: [0.0; 3],
            output: [0.0; 3],
        }
    }

    fn sample(&mut self, sensor: &Sensor, truth: Vector, shaking: f32, random: &mut Stream) {
        for (axis, truth) in truth.into_iter().enumerate() {
            let draw = random.gauss();
            let white = sensor.density[axis] * ROOT_HALF_RATE * draw;
            let shake = sensor.vibration[axis]
                * core::f32::consts::FRAC_1_SQRT_2
                * shaking
                * (draw - self.shake[axis]);
            self.shake[axis] = draw;
            let input = self.gain[axis] * truth + self.bias[axis] + white + shake;
            self.output[axis] += sensor.pass * (input - self.output[axis]);
        }
    }

    fn walk(&mut self, sensor: &Sensor, root_of_time: f32, random: &mut Stream) {
        for bias in &mut self.bias {
            *bias += sensor.walk * root_of_time * random.gauss();
        }
    }

    fn read(&self, sensor: &Sensor, shake: Vector) -> Vector {
        let mut says = self.output;
        for (value, shake) in says.iter_mut().zip(shake) {
            *value += shake;
            // Rounds to the nearest without a call: 1.5 · 2²³ leaves no bits for a fraction.
            let digits = (*value * sensor.per_digit).clamp(-32_768.0, 32_767.0);
            *value = ((digits + 12_582_912.0) - 12_582_912.0) * sensor.digit;
        }
        says
    }
}

/// One BMI088.
#[derive(Clone, Debug)]
pub struct Imu {
    gyro: Axes,
    accel: Axes,
    /// Samples until the biases walk on.
    until_walk: u16,
}

impl Imu {
    /// Samples between two steps of the biases.
    const WALK_EVERY: u16 = 100;

    /// A sensor that was just switched on.
    #[must_use]
    pub fn new(random: &mut Stream) -> Self {
        Self {
            gyro: Axes::new(&GYRO, random),
            accel: Axes::new(&ACCEL, random),
            until_walk: Self::WALK_EVERY,
        }
    }

    /// The readings of angular velocity in rad/s and specific force in m/s², from the true values.
    /// `shaking` is 1 with the motors at hover, 0 with them off. `shake` is what the propellers'
    /// imbalance adds to both readings, behind the sensor's low-pass.
    pub fn sample(
        &mut self,
        rates: Vector,
        specific_force: Vector,
        shaking: f32,
        shake: (Vector, Vector),
        random: &mut Stream,
    ) -> (Vector, Vector) {
        self.gyro.sample(&GYRO, rates, shaking, random);
        self.accel.sample(&ACCEL, specific_force, shaking, random);
        self.until_walk -= 1;
        if self.until_walk == 0 {
            self.until_walk = Self::WALK_EVERY;
            let root = libm::sqrtf(f32::from(Self::WALK_EVERY) / RATE);
            self.gyro.walk(&GYRO, root, random);
            self.accel.walk(&ACCEL, root, random);
        }
        let (turn, push) = shake;
        (self.gyro.read(&GYRO, turn), self.accel.read(&ACCEL, push))
    }
}
