//! The error of a position that a drone reckons by optic flow.

use rand_chacha::ChaCha8Rng;

use crate::air::uniform;

/// The error of the scale of flow over a measured height, and the part of the error that comes and
/// goes, in metres: one standard deviation each, as a drone of the chain takes its odometer to have
/// (`agent::odometer_deviation`).
const SCALE: f32 = 0.03;
const WANDER: f32 = 0.12;
/// The time in which the latter is forgotten, in seconds. Our own number.
const MEMORY_S: f32 = 30.0;

/// The error of one robot's position.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    scale: f32,
    of_way: [f32; 2],
    wander: [f32; 2],
    draws: ChaCha8Rng,
}

impl Drift {
    pub(crate) fn new(mut draws: ChaCha8Rng) -> Self {
        Self { scale: SCALE * normal(&mut draws), of_way: [0.0; 2], wander: [0.0; 2], draws }
    }

    /// The error grows with a way that is flown in `dt` seconds.
    pub(crate) fn fly(&mut self, way: [f32; 2], dt: f32) {
        let part = dt / MEMORY_S;
        for (axis, way) in way.into_iter().enumerate() {
            self.of_way[axis] += self.scale * way;
            let fresh = WANDER * (2.0 * part).sqrt() * normal(&mut self.draws);
            self.wander[axis] += fresh - part * self.wander[axis];
        }
    }

    /// The reckoned position less the true one.
    pub(crate) fn error(&self) -> [f32; 2] {
        [self.of_way[0] + self.wander[0], self.of_way[1] + self.wander[1]]
    }
}

/// A number of the standard normal distribution, within six of its deviations.
fn normal(draws: &mut ChaCha8Rng) -> f32 {
    (0..12).map(|_| uniform(draws)).sum::<f32>() - 6.0
}
