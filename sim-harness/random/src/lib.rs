//! Makes random numbers from a seed: one stream per drone and per link, the same on every machine.
//!
//! The generator is ChaCha8; the stream's number is part of its key, so streams never depend on the
//! order in which others are read. Normal deviates are made by Box and Muller's method with `libm`,
//! not with the platform's mathematics; where millions are needed, they are made by Marsaglia and
//! Tsang's ziggurat, which seldom calls any function.

use std::sync::LazyLock;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The purpose of a stream. Its number makes it independent of all others of the same seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The places and moments of the start.
    Start,
    /// The sensors and the vehicle of one drone.
    Drone(u8),
    /// The sensors and the vehicle of one drone at flight level.
    Craft(u8),
    /// The faults of one drone, and their times.
    Fault(u8),
    /// The packets of an attacker.
    Intruder,
    /// The packets from one drone to another.
    Link(u8, u8),
    /// One drone's clock, and how often it has been switched on.
    Radio(u8),
    /// The moments at which one drone's radio chip reports.
    Chip(u8),
    /// The keys of the fleet.
    Keys,
    /// The delays of one drone's reports and orders on the ideal link.
    Delay(u8),
    /// The samples drawn again for the standard errors of a fit.
    Fit,
    /// The fields of shadowing and fading.
    Place,
    /// The errors of one drone's antenna and radio.
    Gain(u8),
    /// The level of a recorded channel between two drones.
    Level(u8, u8),
    /// The deviations of a recorded channel's packets from one drone to another.
    Deviation(u8, u8),
    /// The fades between two drones.
    Fade(u8, u8),
    /// A place that a benchmark draws, with its radio and its pilot.
    Drawn,
}

impl Purpose {
    fn stream(self) -> u64 {
        match self {
            Self::Start => 0,
            Self::Drone(id) => 0x1_0000 | u64::from(id),
            Self::Link(from, to) => 0x2_0000 | u64::from(from) << 8 | u64::from(to),
            Self::Craft(id) => 0x3_0000 | u64::from(id),
            Self::Fault(id) => 0x4_0000 | u64::from(id),
            Self::Intruder => 0x7_0000,
            Self::Delay(id) => 0x8_0000 | u64::from(id),
            Self::Chip(id) => 0x9_0000 | u64::from(id),
            Self::Radio(id) => 0x5_0000 | u64::from(id),
            Self::Keys => 0x6_0000,
            Self::Place => 0x10_0000,
            Self::Fit => 0xB_0000,
            Self::Gain(id) => 0xA_0000 | u64::from(id),
            Self::Level(low, high) => 0xC_0000 | u64::from(low) << 8 | u64::from(high),
            Self::Deviation(from, to) => 0xD_0000 | u64::from(from) << 8 | u64::from(to),
            Self::Fade(low, high) => 0xE_0000 | u64::from(low) << 8 | u64::from(high),
            Self::Drawn => 0xF_0000,
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

    /// Returns a number uniform in [0, 1), a multiple of 2⁻²⁴.
    pub fn uniform(&mut self) -> f32 {
        (self.generator.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Returns random bytes.
    pub fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.generator.next_u32() as u8)
    }

    /// Returns a whole number below `limit`, which must not be zero.
    pub fn below(&mut self, limit: u32) -> u32 {
        ((u64::from(self.generator.next_u32()) * u64::from(limit)) >> 32) as u32
    }

    /// Returns a standard normal number.
    pub fn normal(&mut self) -> f32 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = libm::sqrtf(-2.0 * libm::logf(1.0 - self.uniform()));
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * self.uniform());
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Returns a standard normal number ten times as fast as [`normal`](Self::normal): nearly
    /// always by one draw and one product.
    #[inline]
    pub fn gauss(&mut self) -> f32 {
        let ziggurat = &*ZIGGURAT;
        loop {
            let bits = self.generator.next_u32();
            let layer = (bits & 0xFF) as usize;
            // 24 bits with their sign, over 2²³.
            let place = (bits as i32 >> 8) as f32 * (1.0 / 8_388_608.0);
            let Layer { width, inner, .. } = ziggurat[layer];
            let value = place * width;
            if place.abs() < inner {
                return value;
            }
            if let Some(value) = self.gauss_at_the_edge(layer, value) {
                return value;
            }
        }
    }

    /// Beyond the part of a layer that is all under the curve.
    #[cold]
    fn gauss_at_the_edge(&mut self, layer: usize, value: f32) -> Option<f32> {
        if layer == 0 {
            // The tail: Marsaglia's exponential method.
            loop {
                let x = -libm::logf(1.0 - self.uniform()) / EDGE as f32;
                let y = -libm::logf(1.0 - self.uniform());
                if 2.0 * y >= x * x {
                    return Some((EDGE as f32 + x).copysign(value));
                }
            }
        }
        let Layer { low, high, .. } = ZIGGURAT[layer];
        let height = low + self.uniform() * (high - low);
        (height < libm::expf(-0.5 * value * value)).then_some(value)
    }
}

/// Where the ziggurat's tail begins and how large each of its 256 layers is: Marsaglia and Tsang,
/// "The Ziggurat Method for Generating Random Variables", 2000.
const EDGE: f64 = 3.654_152_885_361_009;
const AREA: f64 = 0.004_928_673_233_974_655;

/// One layer of the ziggurat.
#[derive(Clone, Copy, Default)]
struct Layer {
    /// Half its width.
    width: f32,
    /// The part of it that is under the curve at any height.
    inner: f32,
    /// The curve at its two ends.
    low: f32,
    high: f32,
}

static ZIGGURAT: LazyLock<[Layer; 256]> = LazyLock::new(|| {
    let curve = |x: f64| libm::exp(-0.5 * x * x);
    let mut layers = [Layer::default(); 256];
    // The lowest layer has the tail in it, as if it were a box that wide.
    let mut width = AREA / curve(EDGE);
    let mut inside = EDGE;
    for (n, layer) in layers.iter_mut().enumerate() {
        *layer = Layer {
            width: width as f32,
            inner: (inside / width) as f32,
            low: curve(width) as f32,
            high: curve(inside) as f32,
        };
        width = inside;
        let top = curve(inside) + AREA / inside;
        inside = if n >= 254 || top >= 1.0 { 0.0 } else { libm::sqrt(-2.0 * libm::log(top)) };
    }
    layers
});

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
    fn no_two_purposes_share_a_stream() {
        let single = |id| {
            [
                Purpose::Drone(id),
                Purpose::Craft(id),
                Purpose::Fault(id),
                Purpose::Radio(id),
                Purpose::Chip(id),
                Purpose::Delay(id),
                Purpose::Gain(id),
            ]
        };
        let double = |a, b| {
            [
                Purpose::Link(a, b),
                Purpose::Level(a, b),
                Purpose::Deviation(a, b),
                Purpose::Fade(a, b),
            ]
        };
        let plain = [
            Purpose::Start,
            Purpose::Intruder,
            Purpose::Keys,
            Purpose::Fit,
            Purpose::Place,
            Purpose::Drawn,
        ];
        let ids = 0..=u8::MAX;
        let all = plain
            .into_iter()
            .chain(ids.clone().flat_map(single))
            .chain(ids.clone().flat_map(|a| ids.clone().flat_map(move |b| double(a, b))));
        let mut taken = std::collections::HashMap::new();
        for purpose in all {
            let other = taken.insert(purpose.stream(), purpose);
            assert_eq!(other, None, "{purpose:?} has the stream of another purpose");
        }
    }

    #[test]
    fn normal_has_mean_zero_and_variance_one() {
        let mut stream = Stream::new(1, Purpose::Start);
        let draws: Vec<f64> = (0..100_000).map(|_| f64::from(stream.normal())).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }

    /// The part of a million draws below each of these is the normal distribution's, to within
    /// four standard deviations: tail, layers and edges are all in it.
    #[test]
    fn the_ziggurat_is_normal() {
        let mut stream = Stream::new(1, Purpose::Start);
        let draws: Vec<f32> = (0..1_000_000).map(|_| stream.gauss()).collect();
        for (below, part) in [
            (-4.2, 1.335e-5_f64),
            (-3.9, 4.81e-5),
            (-3.0, 1.3499e-3),
            (-2.0, 0.022_750),
            (-1.0, 0.158_655),
            (-0.2, 0.420_740),
            (0.0, 0.5),
            (0.1, 0.539_828),
            (0.7, 0.758_036),
            (1.5, 0.933_193),
            (3.7, 0.999_892),
        ] {
            let count = draws.iter().filter(|draw| **draw < below).count() as f64;
            let wanted = part * 1e6;
            let deviation = (wanted * (1.0 - part)).sqrt();
            assert!((count - wanted).abs() < 4.0 * deviation, "{below}: {count} for {wanted}");
        }
        let moment = |power| draws.iter().map(|d| f64::from(*d).powi(power)).sum::<f64>() / 1e6;
        assert!((moment(2) - 1.0).abs() < 0.006 && (moment(4) - 3.0).abs() < 0.04);
    }
}
