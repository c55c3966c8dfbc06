//! Motors with their propellers: from a voltage to a thrust, with a lag.

use flight::{Airframe, Duties};
use random::Stream;

use super::body::STEP;

/// Time constant of the thrust behind its set-point, s: the pole at 0.9695404 for steps of 2 ms
/// that Förster identified ("System Identification of the Crazyflie 2.0", ETH Zürich 2015).
/// Eschmann and others found 0.069 s for a propeller that speeds up ("Data-Driven System
/// Identification of Quadrotors Subject to Motor Delays", 2024).
pub const LAG: f32 = 0.064_66;
/// Standard deviation of one motor's thrust from the mean of all motors, as a part of it. A number
/// of ours: propellers balanced by hand.
const SPREAD: f32 = 0.03;
/// Thrust per square of the rotor's speed, N / (rad/s)²: 24.4 g of four at 15,924 turns a minute
/// (wiki.bitcraze.io, "Investigations: thrust").
pub(super) const THRUST_PER_SPEED2: f32 = 2.15e-8;

/// Four motors.
#[derive(Clone, Debug)]
pub struct Motors {
    thrust: [f32; 4],
    /// The strength of each motor, in parts of the mean motor's.
    strength: [f32; 4],
    response: f32,
}

impl Motors {
    /// Motors at rest, each as strong as the mean.
    #[must_use]
    pub fn new() -> Self {
        Self { thrust: [0.0; 4], strength: [1.0; 4], response: -libm::expm1f(-STEP / LAG) }
    }

    /// Motors at rest, each with a random strength.
    #[must_use]
    pub fn drawn(random: &mut Stream) -> Self {
        let strength = std::array::from_fn(|_| 1.0 + SPREAD * random.gauss());
        Self { strength, ..Self::new() }
    }

    /// Multiplies the strength of all motors by `common`, and makes each by the part `each` stronger
    /// or weaker, at random.
    pub fn err(&mut self, common: f32, each: f32, random: &mut Stream) {
        for strength in &mut self.strength {
            let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
            *strength *= common * (1.0 + sign * each);
        }
    }

    /// Scales the strength of one motor.
    pub fn weaken(&mut self, motor: usize, part: f32) {
        if let Some(strength) = self.strength.get_mut(motor) {
            *strength *= part;
        }
    }

    /// One millisecond at these duties of a battery of `volts`.
    pub fn advance(&mut self, airframe: &Airframe, duties: Duties, volts: f32) {
        for ((thrust, strength), duty) in self.thrust.iter_mut().zip(self.strength).zip(duties.0) {
            // A NaN as duty leaves the bridge off.
            let duty = if duty.is_nan() { 0.0 } else { duty.clamp(0.0, 1.0) };
            let wanted = strength * airframe.thrust_at(duty * volts);
            *thrust += self.response * (wanted - *thrust);
        }
    }

    /// The thrust of each motor, N.
    #[must_use]
    pub const fn thrust(&self) -> [f32; 4] {
        self.thrust
    }

    /// The thrust of all motors together, N.
    #[must_use]
    pub const fn lift(&self) -> f32 {
        let [a, b, c, d] = self.thrust;
        a + b + c + d
    }

    /// The speeds of all rotors together, rad/s.
    #[must_use]
    pub fn spin(&self) -> f32 {
        let speed = |thrust: f32| (thrust * (1.0 / THRUST_PER_SPEED2)).sqrt();
        let [a, b, c, d] = self.thrust;
        speed(a) + speed(b) + speed(c) + speed(d)
    }
}

impl Default for Motors {
    fn default() -> Self {
        Self::new()
    }
}
