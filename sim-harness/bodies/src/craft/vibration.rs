//! The vibration of unbalanced propellers, as gyroscope and accelerometer read it.
//!
//! Each propeller's centre of mass lies beside its axis, so a force turns with the propeller in the
//! plane of the board. It grows with the square of the speed. It shakes the whole body, and since
//! it acts at the end of an arm and above the centre of mass, it turns the body as well. A
//! propeller that is bent lifts unevenly and shakes along z too, half as much.
//!
//! How strong it is was measured elsewhere. The vendor's propeller test spins one motor at a time
//! and sums the squared deviations of 100 samples along x and y (crazyflie-firmware, `health.c`,
//! with the accelerometer's bandwidth at 280 Hz). A Crazyflie 2.1 passes with 2.5 g² at most, which
//! is 0.16 g for one motor and 0.32 g for four; drones that fly have been seen with 6.8 g² a motor
//! (crazyflie-clients-python, issue 744), which is 0.26 g and 0.52 g.

use flight::{Airframe, GRAVITY};
use random::Stream;

use super::body::{PROPELLER_ABOVE, STEP, Vector};
use super::motors::THRUST_PER_SPEED2;

/// The vibration along z as a part of that in the plane. No source: the propeller test prints it
/// and does not judge it.
const UPWARDS: f32 = 0.5;
/// Half of the vibrating drones have a single bad propeller, the others four.
const SINGLE: f32 = 0.5;
const TURN: f32 = 2.0 * core::f32::consts::PI;

/// Sign of each motor's place along x and y, and of its sense of rotation.
const PLACES: [[f32; 3]; 4] =
    [[1.0, -1.0, 1.0], [-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]];

/// The propellers' imbalances and where they point.
#[derive(Clone, Debug)]
pub struct Vibration {
    /// The acceleration of the body by each propeller at hover, m/s².
    imbalance: [f32; 4],
    /// The direction of each imbalance, rad.
    phase: [f32; 4],
    /// One over the thrust of one motor at hover, 1/N.
    per_hover: f32,
    mass: f32,
    inverse_inertia: Vector,
    arm: f32,
    /// Standard deviation of the slow noise along x and along y at hover, m/s².
    slow: f32,
    /// The slow noise of this millisecond as a part of that, along x and y.
    gusts: [f32; 2],
}

/// Time constant of the slow noise, s: a corner at 40 Hz. In the recorded flight `log15` of
/// arplaboratory/data-driven-system-identification the density of the lateral specific force is the
/// same to a fifth from 8 to 32 Hz, and half of that at 50 to 100 Hz, behind the vendor's filter of
/// 30 Hz. What it has below 8 Hz is drag.
const SLOW: f32 = 0.004;

impl Vibration {
    /// A drone whose accelerometer reads `strength` in the plane at hover: the root mean square of
    /// the horizontal vector, in multiples of gravity.
    #[must_use]
    pub fn new(airframe: &Airframe, strength: f32, random: &mut Stream) -> Self {
        let single = (random.uniform() < SINGLE).then(|| (random.uniform() * 4.0) as usize);
        let mut imbalance: [f32; 4] = std::array::from_fn(|motor| match single {
            Some(bad) => f32::from(u8::from(bad == motor)),
            None => random.gauss().abs().max(0.05),
        });
        let sum: f32 = imbalance.iter().map(|part| part * part).sum();
        let scale = strength * GRAVITY / libm::sqrtf(sum.max(1e-6));
        imbalance.iter_mut().for_each(|part| *part *= scale);
        Self {
            imbalance,
            phase: std::array::from_fn(|_| TURN * random.uniform()),
            per_hover: 1.0 / airframe.hover_thrust(),
            mass: airframe.mass,
            inverse_inertia: airframe.inertia.map(|moment| 1.0 / moment),
            arm: airframe.arm,
            slow: 0.0,
            gusts: [0.0; 2],
        }
    }

    /// The same drone, whose accelerometer reads a slow noise of this standard deviation along x and
    /// along y at hover as well, m/s².
    #[must_use]
    pub fn blown_by(self, slow: f32) -> Self {
        Self { slow, ..self }
    }

    /// Adds another millisecond of the slow noise to a force. Without it no number is drawn.
    fn blow(&mut self, thrust: [f32; 4], force: &mut Vector, random: &mut Stream) {
        if self.slow <= 0.0 {
            return;
        }
        let lift = 0.25 * self.per_hover * thrust.iter().sum::<f32>();
        if lift <= 0.0 {
            return;
        }
        let kept = 1.0 - STEP / SLOW;
        let fresh = (1.0 - kept * kept).sqrt();
        for (gust, force) in self.gusts.iter_mut().zip(force) {
            *gust = kept * *gust + fresh * random.gauss();
            *force += self.slow * lift * *gust;
        }
    }

    /// The body rates and the specific force that the vibration adds after another millisecond with
    /// these thrusts.
    pub fn shake(&mut self, thrust: [f32; 4], random: &mut Stream) -> (Vector, Vector) {
        let (mut rates, mut force) = ([0.0; 3], [0.0; 3]);
        let motors = self.imbalance.iter().zip(&mut self.phase).zip(thrust).zip(PLACES);
        for (((imbalance, phase), thrust), [x, y, sense]) in motors {
            if *imbalance == 0.0 || thrust <= 0.0 {
                continue;
            }
            let speed = (thrust * (1.0 / THRUST_PER_SPEED2)).sqrt();
            *phase = (*phase + STEP * speed) % TURN;
            let size = imbalance * thrust * self.per_hover;
            let (sin, cos) = (libm::sinf(*phase), libm::cosf(*phase));
            let push = [size * cos, sense * size * sin, UPWARDS * size * cos];
            // The integral of a force that turns: a quarter of a turn later, over the speed.
            let late = [size * sin, -sense * size * cos, UPWARDS * size * sin];
            let at = [x * self.arm, y * self.arm, PROPELLER_ABOVE];
            let lever = [
                at[1] * late[2] - at[2] * late[1],
                at[2] * late[0] - at[0] * late[2],
                at[0] * late[1] - at[1] * late[0],
            ];
            for axis in 0..3 {
                force[axis] += push[axis];
                rates[axis] += lever[axis] * self.mass * self.inverse_inertia[axis] / speed;
            }
        }
        self.blow(thrust, &mut force, random);
        (rates, force)
    }
}
