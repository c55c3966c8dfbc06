//! A second-order Butterworth low-pass over three axes.

/// The coefficients of the filter, for one sampling rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    b: [f32; 3],
    a: [f32; 2],
}

impl LowPass {
    /// A filter of 80 Hz at a sampling rate of 1 kHz, which is the Crazyflie's filter between
    /// gyroscope and rate loop (crazyflie-firmware, `sensors_bmi088_bmp3xx.c`,
    /// `GYRO_LPF_CUTOFF_FREQ`).
    pub const HZ_80: Self =
        Self { b: [0.046_131_8, 0.092_263_6, 0.046_131_8], a: [-1.307_285, 0.491_812_2] };

    /// 30 Hz at a sampling rate of 1 kHz: the Crazyflie's filter behind the accelerometer (the same
    /// file, `ACCEL_LPF_CUTOFF_FREQ`). Of the vibration of a propeller, 230 to 400 Hz, it passes 1.5
    /// % and less. A blow that changes the velocity by 1 m/s becomes a pulse of 86 m/s², 6 ms later.
    pub const HZ_30: Self =
        Self { b: [0.007_820_2, 0.015_640_4, 0.007_820_2], a: [-1.734_725_8, 0.766_006_6] };
}

/// The state of the filter (transposed direct form II).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LowPassState {
    state: [[f32; 2]; 3],
}

impl LowPassState {
    pub(crate) const fn new() -> Self {
        Self { state: [[0.0; 2]; 3] }
    }

    pub(crate) fn step(&mut self, filter: &LowPass, input: [f32; 3]) -> [f32; 3] {
        let LowPass { b: [b0, b1, b2], a: [a1, a2] } = *filter;
        let mut output = input;
        for (value, [s1, s2]) in output.iter_mut().zip(&mut self.state) {
            let x = *value;
            let y = b0 * x + *s1;
            *s1 = b1 * x - a1 * y + *s2;
            *s2 = b2 * x - a2 * y;
            *value = y;
        }
        output
    }
}
