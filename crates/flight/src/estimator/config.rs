//! The estimator's constants, most of them the errors of its sensors.
//!
//! Every noise here is that of a physical source, and the simulator's sensors have the same
//! sources. A test checks that the innovations come out as large as the estimator predicts.
//!
//! Two errors are not white, and this filter does not estimate them: the gyroscope's bias that
//! remains after calibration, and the accelerometer's bias. A constant error b acts on the state
//! for the filter's time constant T and displaces it by b·T; white noise of density b²·T spreads
//! the state by as much. That density is added to the process noise.

/// The constants of the estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorConfig {
    /// Errors of the gyroscope and the accelerometer.
    pub inertial: InertialConfig,
    /// Errors and checks of the optic flow sensor.
    pub flow: FlowConfig,
    /// Errors and checks of the ranger that looks down.
    pub down: DownConfig,
    /// The uncertainty of a drone that stands on the ground.
    pub rest: RestConfig,
}

impl EstimatorConfig {
    /// A Crazyflie 2.1 with a Flow deck v2.
    pub const DEFAULT: Self = Self {
        inertial: InertialConfig::BMI088,
        flow: FlowConfig::PMW3901,
        down: DownConfig::VL53L1X,
        rest: RestConfig::DEFAULT,
    };
}

impl Default for EstimatorConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Errors of the gyroscope and the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialConfig {
    /// The noise density of the gyroscope, rad/s/√Hz.
    pub gyro_density: f32,
    /// Bias of the gyroscope that remains after calibration, one standard deviation, rad/s.
    pub gyro_residual: f32,
    /// The time constant with which the filter forgets an error of the tilt, s.
    pub tilt_time_constant: f32,
    /// The noise density of the accelerometer in flight, m/s²/√Hz.
    pub accel_density: f32,
    /// The vertical error of the accelerometer that remains after gravity was measured at rest, one
    /// standard deviation, m/s².
    pub accel_residual: f32,
    /// The time constant with which the filter forgets an error of the climb rate, s.
    pub climb_time_constant: f32,
    /// The fraction of its velocity along x and y that a drone loses to drag per second, 1/s. It
    /// must be zero where the accelerometer's x and y are passed to the filter.
    pub drag: f32,
    /// The relative uncertainty of the drag, one standard deviation.
    pub drag_uncertainty: f32,
    /// The time constant with which gravity is learnt in the air, s.
    pub gravity_time_constant: f32,
    /// The time constant with which the filter forgets an error of the horizontal velocity, s.
    pub velocity_time_constant: f32,
}

impl InertialConfig {
    /// The BMI088 of the Crazyflie 2.1, and the Crazyflie's drag.
    ///
    /// * Gyroscope's density: 0.014 °/s/√Hz (BMI088 data sheet, BST-BMI088-DS001).
    /// * Gyroscope's residual: 0.075 °/s, from 0.015 °/s/K (data sheet, TCO) over the 5 K by which
    ///   the board warms after calibration.
    /// * Accelerometer's density: 0.32 m/s² per sample of 1 ms, almost all of it vibration of the
    ///   propellers; with it the simulator's innovations are as large as predicted (`uchain bench
    ///   estimator`). The vendor's filter uses 0.5 (`procNoiseAcc_xy`,
    ///   `kalman_core_params_defaults.h`). The sensor's own noise is a fifth of it: 160 µg/√Hz in x
    ///   and y, 190 in z (data sheet).
    /// * Accelerometer's residual: 0.05 m/s². 0.2 mg/K (data sheet, TCO) over 10 K give 0.02, and
    ///   an offset of 20 mg across the board (data sheet, zero-g offset) at a tilt of 12° gives
    ///   0.04.
    /// * Gravity's time constant: 5 s. A climb of 0.3 m changes the learnt gravity by 1 cm/s², and
    ///   the remaining error of the accelerometer adds 1 cm/s in a landing of a second.
    /// * Drag: 9.18·10⁻⁷ N s²/m per rad/s of the four propellers together (Förster, "System
    ///   identification of the Crazyflie 2.0", 2015), at 8,000 rad/s and 33 g. Its uncertainty is a
    ///   half, since that was measured on one bare Crazyflie.
    /// * Time constants of the filter: hovering at 0.3 m over ground, it forgets an error of the
    ///   tilt in 1.5 s, of the velocity in 0.25 s and of the climb rate in 0.2 s (measured:
    ///   `the_configured_time_constants_are_those_of_the_filter`).
    pub const BMI088: Self = Self {
        gyro_density: 2.44e-4,
        gyro_residual: 1.3e-3,
        tilt_time_constant: 1.5,
        accel_density: 0.01,
        accel_residual: 0.05,
        climb_time_constant: 0.2,
        drag: 0.22,
        drag_uncertainty: 0.5,
        gravity_time_constant: 5.0,
        velocity_time_constant: 0.25,
    };
}

/// Errors and checks of the optic flow sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowConfig {
    /// Counts per radian of image motion.
    pub counts_per_radian: f32,
    /// The noise of a reading at zero exposure, one standard deviation, counts.
    pub noise: f32,
    /// The growth of the noise with exposure, counts per cycle of the chip's clock.
    pub noise_per_shutter: f32,
    /// The relative error of the image motion that differs from reading to reading, one standard
    /// deviation: it stands for a floor that is not flat.
    pub scale_noise: f32,
    /// The exposure, in cycles, from which on it counts as dark for the sensor: its longest
    /// exposure.
    pub dark: u16,
    /// The lowest surface quality (SQUAL) at which a reading in the dark is used.
    pub least_quality_in_the_dark: u8,
    /// The lowest surface quality at which any reading is used.
    pub least_quality: u8,
    /// A reading with this many counts or more on one axis is out of range.
    pub most_counts: u16,
    /// The cosine of the largest tilt at which a reading is used.
    pub least_tilt_cosine: f32,
    /// The distance from the floor below which the image is out of focus, m.
    pub nearest: f32,
    /// The longest time that one reading may cover, s.
    pub longest_interval: f32,
    /// A reading is rejected if its innovation on either axis is larger than this many standard
    /// deviations.
    pub gate: f32,
    /// Rejected readings that agree with each other for this long reset the velocity, s.
    pub reset_after: f32,
    /// The largest change of velocity by such a reset, m/s. A sensor that asks for more is wrong,
    /// however well its readings agree, and is not believed again before the drone has stood on
    /// the ground.
    pub most_reset: f32,
}

impl FlowConfig {
    /// The PMW3901 of the Flow deck v2, read 100 times a second.
    ///
    /// * Counts per radian: 35 pixels over 0.71674 rad, ten counts per pixel (`mm_flow.c` of
    ///   crazyflie-firmware).
    /// * Noise: 0.4335 counts and 0.0007984 counts per cycle of exposure, fitted to flights over
    ///   floors of more and less texture (`flowdeck_v1v2.c`, where σ is in counts and `mm_flow.c`
    ///   turns it into pixels). Rounding to whole counts is added.
    /// * Scale noise: 2 %, which is 6 mm of relief seen from 0.3 m.
    /// * Darkness from 0x1F00 cycles on, of 0x1FFF, where a quality from 0x19 on is still good
    ///   (PMW3901 data sheet, "false motion": discard where the upper shutter byte is 0x1F and SQUAL
    ///   below 0x19). A long exposure alone costs noise, which `noise_per_shutter` counts.
    /// * A quality below 10 is refused in any light. No source: the data sheet accepts it.
    /// * At most 100 counts (`flowdeck_v1v2.c`).
    /// * Tilt up to 45°: the supervisor stops a flight before that.
    /// * In focus from 80 mm on (data sheet).
    /// * Longest interval: 50 ms, which is five missed readings; the velocity is no longer constant
    ///   over a longer one.
    /// * Gate of 5σ: it rejects one good reading in a million.
    /// * Reset after 0.5 s: as long as a drone may fly without a velocity.
    /// * A reset changes the velocity by 1.5 m/s at most. Our own number: in 0.5 s that is a push of
    ///   0.3 g, or a tilt that is wrong by 17°, of which the gyroscope would know. A flow and a height
    ///   that are both wrong ask for more: counts that would be 0.6 m/s at 0.3 m are 2.6 m/s at 1.3 m.
    pub const PMW3901: Self = Self {
        counts_per_radian: 10.0 * 35.0 / 0.716_74,
        noise: 0.4335,
        noise_per_shutter: 0.000_798_4,
        scale_noise: 0.02,
        dark: 0x1F00,
        least_quality_in_the_dark: 0x19,
        least_quality: 10,
        most_counts: 100,
        least_tilt_cosine: core::f32::consts::FRAC_1_SQRT_2,
        nearest: 0.08,
        longest_interval: 0.05,
        gate: 5.0,
        reset_after: 0.5,
        most_reset: 1.5,
    };
}

/// Errors and checks of the ranger that looks down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DownConfig {
    /// The noise of a reading at short range, one standard deviation, m.
    pub noise: f32,
    /// The distance at which the noise is twice `noise`, m.
    pub doubled_at: f32,
    /// The distance over which the distance-dependent part of the noise grows by the factor e, m.
    pub noise_grows_over: f32,
    /// Unevenness of the floor from one reading to the next, one standard deviation, m. It is zero
    /// for a built floor.
    pub relief: f32,
    /// The distance below which the data sheet promises no accuracy, m.
    pub nearest: f32,
    /// The noise of a reading below `nearest`, one standard deviation, m.
    pub near_noise: f32,
    /// The noise of a reading whose own σ is above the sensor's limit, one standard deviation, m.
    pub doubted_noise: f32,
    /// The distance from which on a reading is out of range, m.
    pub farthest: f32,
    /// The cosine of the largest tilt at which a reading is used.
    pub least_tilt_cosine: f32,
    /// A reading is rejected if its innovation is larger than this many standard deviations.
    pub gate: f32,
    /// Rejected readings that agree with each other for this long reset the height, s.
    pub reset_after: f32,
    /// Two rejected readings in a row agree if their innovations differ by no more than this, m.
    pub agreement: f32,
}

impl DownConfig {
    /// The VL53L1x of the Flow deck v2, read 40 times a second.
    ///
    /// * Noise: 2.5 mm at short range and 0.2 m at 4 m, exponential between: 0.0025·(1 + e^(k·(d −
    ///   2.5))) with k = ln(0.2/0.0025)/1.5 (`zranger2.c` of crazyflie-firmware).
    /// * Nearest: 40 mm, the data sheet's shortest distance; a shorter reading may stand for
    ///   any distance below it.
    /// * Doubted: twice the sensor's limit of 90 mm (`sensors::vl53l1x`, register 0x64). Twice is ours.
    /// * Farthest: 5 m (`zranger2.c`).
    /// * Tilt up to 45°: the supervisor stops a flight before that.
    /// * Reset after 0.3 s, which is 12 readings. At 0.5 m/s a drone has passed over a boulder by
    ///   then, or is over a new floor.
    /// * Agreement: 0.1 m, the unevenness of a boulder's top.
    pub const VL53L1X: Self = Self {
        noise: 0.0025,
        doubled_at: 2.5,
        noise_grows_over: 1.5 / 4.382_027,
        relief: 0.0,
        nearest: 0.04,
        near_noise: 0.02,
        doubted_noise: 0.18,
        farthest: 5.0,
        least_tilt_cosine: core::f32::consts::FRAC_1_SQRT_2,
        gate: 5.0,
        reset_after: 0.3,
        agreement: 0.1,
    };
}

/// The uncertainty of a drone that stands on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestConfig {
    /// The uncertainty of the velocity, one standard deviation, m/s.
    pub velocity: f32,
    /// The uncertainty of the height, one standard deviation, m.
    pub height: f32,
    /// The uncertainty of the tilt, one standard deviation, rad.
    pub tilt: f32,
    /// The fraction of the angle between measured and estimated vertical that is corrected per step
    /// of 1 ms.
    pub gain: f32,
}

impl RestConfig {
    /// The constants of a Crazyflie on the ground.
    ///
    /// * Velocity 0.01 m/s: `stdDevInitialVelocity` of crazyflie-firmware's
    ///   `kalman_core_params_defaults.h`.
    /// * Height 0.02 m: the ranger is at most that high above the floor.
    /// * Tilt 0.02 rad: an offset of 20 mg across the board looks like that tilt (BMI088 data
    ///   sheet, zero-g offset).
    /// * Gain 0.001: a time constant of 1 s, which leaves a thirtieth of the noise.
    pub const DEFAULT: Self = Self { velocity: 0.01, height: 0.02, tilt: 0.02, gain: 0.001 };
}
