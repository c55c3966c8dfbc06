//! What the estimator holds to be true of its sensors.
//!
//! Every noise here is that of a physical source, and the simulator's sensors are made of the same
//! sources: so the innovations come out as large as the estimator says, which is tested.
//!
//! Two kinds of error are not white, and this filter does not estimate them: what is left of the
//! gyroscope's bias after calibration, and the accelerometer's. A constant error b acts for as
//! long as the filter remembers, T, and takes the state b·T away in that time; white noise of the
//! density b²·T spreads it as far. That is what is added.

/// The estimator's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorConfig {
    /// Gyroscope and accelerometer.
    pub inertial: InertialConfig,
    /// Optic flow.
    pub flow: FlowConfig,
    /// The ranger that looks down.
    pub down: DownConfig,
    /// Standing on the ground.
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

/// Gyroscope and accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialConfig {
    /// White noise of the gyroscope, rad/s/√Hz.
    pub gyro_density: f32,
    /// What its calibration leaves of its bias, one standard deviation, rad/s.
    pub gyro_residual: f32,
    /// For how long the filter remembers a tilt, s.
    pub tilt_memory: f32,
    /// White noise of the accelerometer in flight, m/s²/√Hz.
    pub accel_density: f32,
    /// What is left of its error along the vertical when its scale has been set at rest, one
    /// standard deviation, m/s².
    pub accel_residual: f32,
    /// For how long the filter remembers a vertical velocity, s.
    pub climb_memory: f32,
    /// The part of its velocity along x and y that a drone loses to drag in a second, 1/s. Nothing
    /// where the accelerometer is to measure it.
    pub drag: f32,
    /// The part of the drag that may be otherwise, one standard deviation.
    pub drag_doubt: f32,
    /// Over this time gravity is weighed in the air, s.
    pub gravity_time: f32,
    /// For how long the filter remembers a horizontal velocity, s.
    pub velocity_memory: f32,
}

impl InertialConfig {
    /// The BMI088 of the Crazyflie 2.1, and the Crazyflie.
    ///
    /// * Gyroscope's density 0.014 °/s/√Hz (BMI088 data sheet, BST-BMI088-DS001).
    /// * Residual 0.075 °/s: 0.015 °/s/K (same, TCO) over the 5 K that the board warms by after it
    ///   was calibrated.
    /// * Accelerometer's density 0.32 m/s² per sample of 1 ms, all of it the propellers': with it
    ///   the simulator's innovations are as large as claimed (`uchain bench estimator`). The
    ///   vendor's filter takes 0.5 (`procNoiseAcc_xy`, `kalman_core_params_defaults.h`); the
    ///   sensor's own is a fifth, 160 µg/√Hz in x and y, 190 in z (data sheet).
    /// * Residual 0.05 m/s²: 0.2 mg/K (data sheet, TCO) over 10 K is 0.02, and 20 mg across the
    ///   board (data sheet, zero-g offset) at a tilt of 12° are 0.04.
    /// * Gravity is weighed over 5 s: a climb of 0.3 m moves it by 1 cm/s², and what is left of the
    ///   accelerometer's error makes 1 cm/s in a landing of a second.
    /// * Drag: 9.18·10⁻⁷ N s²/m per rad/s of the four propellers together (Förster, "System
    ///   identification of the Crazyflie 2.0", 2015), 8,000 rad/s, 33 g. Half of it may be otherwise:
    ///   that was a bare Crazyflie, and one of them.
    /// * Memories: hovering at 0.3 m over ground, the filter forgets a tilt in 1.5 s, a velocity in
    ///   0.25 s and a climb in 0.2 s (measured: `the_memories_are_the_filters_own`).
    pub const BMI088: Self = Self {
        gyro_density: 2.44e-4,
        gyro_residual: 1.3e-3,
        tilt_memory: 1.5,
        accel_density: 0.01,
        accel_residual: 0.05,
        climb_memory: 0.2,
        drag: 0.22,
        drag_doubt: 0.5,
        gravity_time: 5.0,
        velocity_memory: 0.25,
    };
}

/// Optic flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowConfig {
    /// Counts by which the picture moves per radian.
    pub counts_per_radian: f32,
    /// Noise of a reading in counts, one standard deviation, with no exposure at all,
    pub noise: f32,
    /// and how it grows with the exposure, counts per cycle of the chip's clock.
    pub noise_per_shutter: f32,
    /// By how much of itself the picture's motion is wrong from one reading to the next: the floor
    /// under it is not flat.
    pub scale_noise: f32,
    /// An exposure of this length, in cycles, is as long as it gets: darkness.
    pub dark: u16,
    /// The least surface quality that can be followed.
    pub least_quality: u8,
    /// As many counts in one reading are none.
    pub most_counts: u16,
    /// The least cosine of the tilt at which the floor is seen.
    pub least_tilt_cosine: f32,
    /// The sensor sees sharply from this distance on, m.
    pub nearest: f32,
    /// A reading that covers more time than this is not used, s.
    pub longest: f32,
    /// Readings that are further off than so many standard deviations, in either axis, are not
    /// believed
    pub gate: f32,
    /// unless they agree with each other for so long, s.
    pub patience: f32,
}

impl FlowConfig {
    /// The PMW3901 of the Flow deck v2, read 100 times a second.
    ///
    /// * 35 pixels over 0.71674 rad, ten counts to a pixel (`mm_flow.c` of crazyflie-firmware).
    /// * Noise 0.4335 counts and 0.0007984 per cycle of exposure: fitted to flights over floors of
    ///   more and less texture (`flowdeck_v1v2.c`, where σ is in counts and `mm_flow.c` makes
    ///   pixels of it). Rounding to whole counts comes on top.
    /// * Scale noise 2 %: 6 mm of relief seen from 0.3 m.
    /// * Dark from 0x1F00 cycles on, of 0x1FFF; quality from 0x19 on (PMW3901 data sheet, "false
    ///   motion": discard where the upper shutter byte is 0x1F and SQUAL below 0x19). Either of
    ///   them is enough here.
    /// * At most 100 counts (`flowdeck_v1v2.c`).
    /// * Tilt to 45°: the supervisor stops a flight before that.
    /// * Sharp from 80 mm on (data sheet).
    /// * 50 ms are five readings missed; by then the velocity is no longer one number.
    /// * 5σ: one good reading in a million is lost.
    /// * Patience 0.5 s: what a drone may fly blind.
    pub const PMW3901: Self = Self {
        counts_per_radian: 10.0 * 35.0 / 0.716_74,
        noise: 0.4335,
        noise_per_shutter: 0.000_798_4,
        scale_noise: 0.02,
        dark: 0x1F00,
        least_quality: 0x19,
        most_counts: 100,
        least_tilt_cosine: core::f32::consts::FRAC_1_SQRT_2,
        nearest: 0.08,
        longest: 0.05,
        gate: 5.0,
        patience: 0.5,
    };
}

/// The ranger that looks down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DownConfig {
    /// Noise of a reading of nothing, one standard deviation, m.
    pub noise: f32,
    /// At this distance, m, the noise is twice as large,
    pub doubled_at: f32,
    /// and from there on it grows by the factor e every so many metres.
    pub noise_grows_over: f32,
    /// How far the floor is from flat, one standard deviation, m, as seen from one reading to the
    /// next. Nothing for a built floor.
    pub relief: f32,
    /// Below this distance, m, the sensor promises nothing,
    pub nearest: f32,
    /// and its error is, one standard deviation, m.
    pub near_noise: f32,
    /// Readings from here on, m, are of nothing.
    pub farthest: f32,
    /// The least cosine of the tilt at which the beam meets the floor underneath.
    pub least_tilt_cosine: f32,
    /// Readings that are further off than so many standard deviations are not believed
    pub gate: f32,
    /// unless for so long, s,
    pub patience: f32,
    /// each differs from what was expected by as much as the one before it, m.
    pub agreement: f32,
}

impl DownConfig {
    /// The VL53L1x of the Flow deck v2, read 40 times a second.
    ///
    /// * Noise 2.5 mm at hand, 0.2 m at 4 m, exponentially: 0.0025·(1 + e^(k·(d − 2.5))) with
    ///   k = ln(0.2/0.0025)/1.5 (`zranger2.c` of crazyflie-firmware).
    /// * Nearest 40 mm (data sheet, least distance); a reading of less may be any of them.
    /// * Farthest 5 m (`zranger2.c`).
    /// * Tilt to 45°: the supervisor stops a flight before that.
    /// * Patience 0.3 s: 12 readings. At 0.5 m/s a boulder passes under the drone in less, or is
    ///   a floor to fly over.
    /// * Agreement 0.1 m: what a boulder's top is uneven.
    pub const VL53L1X: Self = Self {
        noise: 0.0025,
        doubled_at: 2.5,
        noise_grows_over: 1.5 / 4.382_027,
        relief: 0.0,
        nearest: 0.04,
        near_noise: 0.02,
        farthest: 5.0,
        least_tilt_cosine: core::f32::consts::FRAC_1_SQRT_2,
        gate: 5.0,
        patience: 0.3,
        agreement: 0.1,
    };
}

/// Standing on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestConfig {
    /// What is not known of the velocity, one standard deviation, m/s.
    pub velocity: f32,
    /// What is not known of the height, one standard deviation, m.
    pub height: f32,
    /// What is not known of the tilt, one standard deviation, rad.
    pub tilt: f32,
    /// The part of a difference between the accelerometer's vertical and the estimated one that is
    /// made good in one step of 1 ms.
    pub gain: f32,
}

impl RestConfig {
    /// * Velocity 0.01 m/s: `stdDevInitialVelocity` of crazyflie-firmware's
    ///   `kalman_core_params_defaults.h`.
    /// * Height 0.02 m: the ranger sits that high over what the drone stands on, or less.
    /// * Tilt 0.02 rad: 20 mg across the board, which pass for a tilt (BMI088 data sheet, zero-g
    ///   offset).
    /// * Gain: 1 s, which leaves a thirtieth of the noise.
    pub const DEFAULT: Self = Self { velocity: 0.01, height: 0.02, tilt: 0.02, gain: 0.001 };
}
