//! The PMW3901: the motion of the ground under the drone, in counts.
//!
//! The model is the one that the vendor's estimator inverts (`mm_flow.c` of crazyflie-firmware):
//! 35 pixels over 0.71674 rad, counts of a tenth of a pixel. What goes wrong with it: a gain of
//! the sensor's own, noise that grows with the exposure, whole counts, and nonsense where it is
//! dark, where there is no texture, and where the ground is too near to be in focus.

use random::Stream;
use sensors::pmw3901::Motion;

use scenario::Ground;

use super::body::Vector;

/// Counts per radian of view: 35 pixels over 0.71674 rad, ten counts to a pixel.
const COUNTS_PER_RADIAN: f32 = 35.0 / 0.716_74 * 10.0;
/// Nearer than this the ground is out of focus, m (PMW3901 data sheet: working range from 80 mm).
const NEAREST: f32 = 0.08;
/// Exposure in a lit room and at its end stop, cycles. From 0x1F00 on, with a surface quality below
/// 0x19, a picture is no use (PMW3901 data sheet).
const SHUTTER: f32 = 500.0;
const SHUTTER_END: f32 = 8191.0;
const DARK: f32 = 7936.0;
/// Surface quality of a good ground. 60 to 100 are seen over carpets.
const QUALITY: f32 = 90.0;
/// Below this the counts mean nothing: at the end of the exposure (PMW3901 data sheet), and in any
/// light (a number of ours).
const LEAST_QUALITY: [f32; 2] = [25.0, 12.0];
/// Standard deviation in counts by exposure: the vendor's adaptive model (`flowdeck_v1v2.c`).
const NOISE: [f32; 2] = [0.433_5, 0.000_798_4];
/// Standard deviation of counts that mean nothing. A number of ours.
const NONSENSE: f32 = 8.0;

/// One sensor.
#[derive(Clone, Debug)]
pub struct Flow {
    /// Counts since the last reading, forward and left.
    pending: [f32; 2],
    gain: f32,
}

impl Flow {
    /// Milliseconds between two readings (`flowdeck_v1v2.c`).
    pub const PERIOD_MS: u64 = 10;

    /// A sensor that reads `gain` times the truth.
    #[must_use]
    pub const fn new(gain: f32) -> Self {
        Self { pending: [0.0; 2], gain }
    }

    /// Adds a millisecond of motion over the ground: velocity and rates in body axes, and the
    /// height of the sensor.
    pub fn watch(&mut self, velocity: Vector, rates: Vector, upright: f32, height: f32, time: f32) {
        let counts = self.gain * COUNTS_PER_RADIAN * time;
        // A sensor that lies on the ground sees no motion.
        let near = upright / height.max(0.02);
        self.pending[0] += counts * (velocity[0] * near - rates[1]);
        self.pending[1] += counts * (velocity[1] * near + rates[0]);
    }

    /// The reading of the time since the last one.
    pub fn read(&mut self, ground: Ground, height: f32, random: &mut Stream) -> Motion {
        let light = ground.light.clamp(0.0, 1.0);
        let shutter = (SHUTTER / light.max(1e-3)).min(SHUTTER_END);
        // The quality falls once the exposure can grow no more.
        let exposed = (light * shutter * (1.0 / SHUTTER)).min(1.0);
        let focus = if height < NEAREST { 0.1 } else { 1.0 };
        let quality = QUALITY * ground.texture.clamp(0.0, 1.0) * exposed * focus;
        let [in_the_dark, at_all] = LEAST_QUALITY;
        let least = if shutter >= DARK { in_the_dark } else { at_all };
        let noise = [random.gauss(), random.gauss()];
        let mut counts = [0_i16; 2];
        for axis in 0..2 {
            let seen = std::mem::take(&mut self.pending[axis]);
            let value = if quality < least {
                NONSENSE * noise[axis]
            } else {
                seen + (NOISE[0] + NOISE[1] * shutter) * noise[axis]
            };
            // Fractions of a count are lost; the noise restores them on average.
            counts[axis] = libm::roundf(value) as i16;
        }
        let moved = counts != [0; 2];
        let bright = (255.0 * exposed * 0.5) as u8;
        Motion {
            x: counts[0],
            y: counts[1],
            moved,
            flags: if moved { 0xB0 } else { 0x30 },
            squal: quality as u8,
            shutter: shutter as u16,
            raw_sum: bright,
            raw_max: bright.saturating_add(bright / 2),
            raw_min: bright / 2,
        }
    }
}
