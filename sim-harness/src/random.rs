//! Randomness with a seed: one stream per drone and per link, the same on every machine.
//!
//! The generator is ChaCha8; the stream's number is part of its key, so streams never depend on
//! the order in which others are read. Normal deviates come by Box and Muller through `libm`, not
//! through the platform's mathematics.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What a stream is for. Its number keeps it apart from all others of the same seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Where and when everything starts.
    Start,
    /// The sensors and the vehicle of one drone.
    Drone(u8),
    /// The packets from one drone to another.
    Link(u8, u8),
}

impl Purpose {
    fn stream(self) -> u64 {
        match self {
            Self::Start => 0,
            Self::Drone(id) => 0x1_0000 | u64::from(id),
            Self::Link(from, to) => 0x2_0000 | u64::from(from) << 8 | u64::from(to),
        }
    }
}

/// One stream of random numbers.
#[derive(Clone, Debug)]
pub struct Stream {
    generator: ChaCha8Rng,
    /// Box and Muller make two at a time.
    spare: Option<f32>,
}

impl Stream {
    /// The stream for this purpose in the run with this seed.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = *b"........ U-Chain simulator, v1  ";
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(purpose.stream());
        Self { generator, spare: None }
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    pub fn uniform(&mut self) -> f32 {
        (self.generator.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f32 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = libm::sqrtf(-2.0 * libm::logf(1.0 - self.uniform()));
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * self.uniform());
        self.spare = Some(radius * sin);
        radius * cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_their_own() {
        let first = |purpose| Stream::new(7, purpose).uniform();
        assert_eq!(first(Purpose::Link(1, 2)), first(Purpose::Link(1, 2)));
        assert_ne!(first(Purpose::Link(1, 2)), first(Purpose::Link(2, 1)));
        assert_ne!(first(Purpose::Drone(1)), first(Purpose::Start));
    }

    #[test]
    fn normal_has_mean_zero_and_variance_one() {
        let mut stream = Stream::new(1, Purpose::Start);
        let draws: Vec<f64> = (0..100_000).map(|_| f64::from(stream.normal())).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }
}
