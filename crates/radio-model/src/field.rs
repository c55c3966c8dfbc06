//! Fields of fading and shadowing: what the place of both antennas, and nothing else, adds to the
//! loss of a link.
//!
//! A field is a sum of [`WAVES`] plane waves over the four coordinates of both ends, so that it
//! costs no memory and is the same whenever a drone comes back. The waves' directions and phases
//! come from numbers that the caller draws. Equations are those of W. C. Jakes, *Microwave Mobile
//! Communications* (1974), M. Gudmundson, *Correlation model for shadow fading in mobile radio
//! systems* (Electronics Letters 27, 1991), and Z. Wang, E. K. Tameh and A. R. Nix, *Joint shadowing
//! process in urban peer-to-peer radio channels* (IEEE Trans. Veh. Technol. 57, 2008).

use core::f32::consts::TAU;

use units::{Db, Metres, Point2};

/// The number of plane waves in a field: ours, enough for a sum that is nearly normal, and as many
/// cosines for each link whose ends have moved.
pub const WAVES: usize = 32;

/// Uniform numbers in [0, 1) for one plane wave, which the caller draws.
pub type WaveDraws = [f32; 5];

/// One plane wave over both ends of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wave {
    /// The wave vectors at the end that comes first and at the other, rad/m.
    at_first: [f32; 2],
    at_other: [f32; 2],
    phase: f32,
}

impl Wave {
    fn phase_at(&self, first: Point2, other: Point2) -> f32 {
        let [ax, ay] = self.at_first;
        let [bx, by] = self.at_other;
        ax * first.x + ay * first.y + bx * other.x + by * other.y + self.phase
    }
}

/// A wave vector of this length in the direction that is this part of a full turn.
fn vector(length: f32, turn: f32) -> [f32; 2] {
    [length * libm::cosf(TAU * turn), length * libm::sinf(TAU * turn)]
}

/// Spatially correlated shadowing: normal in decibels, with the correlation exp(−Δ/d) over a
/// displacement Δ of either end, d being the decorrelation distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadowing {
    deviation: f32,
    waves: [Wave; WAVES],
}

impl Shadowing {
    /// A field with this standard deviation and decorrelation distance.
    ///
    /// The spectrum of exp(−Δ/d) in the plane falls like (1 + k²d²)^(−3/2); a part u of it has wave
    /// numbers below √(1/(1 − u)² − 1)/d.
    #[must_use]
    pub fn new(deviation: Db, decorrelation: Metres, mut draw: impl FnMut() -> WaveDraws) -> Self {
        let number = |part: f32| {
            let left = 1.0 - part.min(0.999);
            libm::sqrtf(1.0 / (left * left) - 1.0) / decorrelation.0
        };
        let waves = core::array::from_fn(|_| {
            let [first, first_turn, other, other_turn, phase] = draw();
            Wave {
                at_first: vector(number(first), first_turn),
                at_other: vector(number(other), other_turn),
                phase: TAU * phase,
            }
        });
        Self { deviation: deviation.0, waves }
    }

    /// The loss that shadowing adds to a link; negative where it makes the link better.
    #[must_use]
    pub fn loss(&self, first: Point2, other: Point2) -> Db {
        let sum: f32 = self.waves.iter().map(|wave| libm::cosf(wave.phase_at(first, other))).sum();
        Db(self.deviation * libm::sqrtf(2.0 / WAVES as f32) * sum)
    }
}

/// Small-scale fading: a direct wave and scattered ones, which add up anew every few centimetres.
///
/// The power of the direct wave is K times that of all others: K = 0 is Rayleigh fading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fading {
    k: f32,
    wave_number: f32,
    waves: [Wave; WAVES],
}

impl Fading {
    /// A field with this factor K, at least 0, for waves of this length.
    #[must_use]
    pub fn new(k: f32, wavelength: Metres, mut draw: impl FnMut() -> WaveDraws) -> Self {
        let wave_number = TAU / wavelength.0;
        let waves = core::array::from_fn(|_| {
            let [_, first_turn, _, other_turn, phase] = draw();
            Wave {
                at_first: vector(wave_number, first_turn),
                at_other: vector(wave_number, other_turn),
                phase: TAU * phase,
            }
        });
        Self { k, wave_number, waves }
    }

    /// The loss that fading adds to a link, whose mean power is that without fading; at most 60 dB.
    #[must_use]
    pub fn loss(&self, first: Point2, other: Point2) -> Db {
        let direct = libm::sqrtf(self.k / (self.k + 1.0));
        let each = libm::sqrtf(1.0 / ((self.k + 1.0) * WAVES as f32));
        let path = self.wave_number * first.distance(other).0;
        let begin = [direct * libm::cosf(path), direct * libm::sinf(path)];
        let [re, im] = self.waves.iter().fold(begin, |[re, im], wave| {
            let phase = wave.phase_at(first, other);
            [re + each * libm::cosf(phase), im + each * libm::sinf(phase)]
        });
        Db(-10.0 * libm::log10f((re * re + im * im).max(1e-6)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator for these tests: xorshift.
    fn draws(seed: u32) -> impl FnMut() -> WaveDraws {
        let mut state = seed.wrapping_mul(2_654_435_761) | 1;
        move || {
            core::array::from_fn(|_| {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                (state >> 8) as f32 / (1_u32 << 24) as f32
            })
        }
    }

    /// Mean, variance, and correlation over a displacement of one end, over 4,000 fields.
    fn statistics(moved: f32) -> [f32; 3] {
        let here = Point2::new(3.0, -2.0);
        let there = Point2::new(11.0, 4.0);
        let count = 4000_u16;
        let mut sums = [0.0_f32; 3];
        for seed in 1..=count {
            let field = Shadowing::new(Db(4.0), Metres(5.0), draws(u32::from(seed)));
            let a = field.loss(here, there).0;
            let b = field.loss(here, Point2::new(11.0 + moved, 4.0)).0;
            sums = [sums[0] + a, sums[1] + a * a, sums[2] + a * b];
        }
        sums.map(|sum| sum / f32::from(count))
    }

    #[test]
    fn shadowing_has_the_deviation_and_the_correlation_that_it_is_made_for() {
        for moved in [0.5, 2.0, 5.0, 10.0] {
            let [mean, square, product] = statistics(moved);
            let wanted = 16.0 * libm::expf(-moved / 5.0);
            // Four deviations of a mean of 4,000 products.
            assert!(mean.abs() < 0.26, "{mean}");
            assert!((square - 16.0).abs() < 1.5, "{square}");
            assert!((product - wanted).abs() < 1.5, "{moved} m: {product} for {wanted}");
        }
    }

    /// The mean power is one, and the part of fades below 10 dB is that of Rayleigh's and of Rice's
    /// distribution: 9.52 % and, with K = 4, 1.64 % (1 − Q₁(√(2K), √(2(K + 1)·0.1)), by two
    /// million draws of the sum of a direct and a normal wave).
    #[test]
    fn fading_is_rayleighs_and_rices() {
        for (k, deep) in [(0.0, 0.0952_f32), (4.0, 0.0164)] {
            let (mut power, mut below, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
            for seed in 1..=200 {
                let field = Fading::new(k, Metres(0.125), draws(seed));
                for step in 0..50_u8 {
                    let other = Point2::new(5.0 + f32::from(step) * 0.5, 1.0);
                    let loss = field.loss(Point2::new(0.0, 0.0), other).0;
                    power += libm::powf(10.0, -loss / 10.0);
                    below += if loss > 10.0 { 1.0 } else { 0.0 };
                    count += 1.0;
                }
            }
            assert!((power / count - 1.0).abs() < 0.05, "K {k}: mean power {}", power / count);
            let share = below / count;
            assert!((share - deep).abs() < 0.2 * deep + 0.004, "K {k}: {share} below −10 dB");
        }
    }

    /// Waves of 12.5 cm: over 1 mm nothing changes, over a quarter of a wavelength much does.
    #[test]
    fn fading_belongs_to_the_place() {
        let field = Fading::new(0.0, Metres(0.125), draws(7));
        let at = |x: f32| field.loss(Point2::new(0.0, 0.0), Point2::new(x, 0.3)).0;
        let apart = |by: f32| -> f32 {
            (0..400_u16)
                .map(|n| 4.0 + f32::from(n) * 0.03)
                .map(|x| (at(x) - at(x + by)).abs())
                .sum::<f32>()
                / 400.0
        };
        assert_eq!(at(6.0), at(6.0));
        assert!(apart(0.001) < 0.6, "{}", apart(0.001));
        assert!(apart(0.031) > 3.0, "{}", apart(0.031));
    }
}
