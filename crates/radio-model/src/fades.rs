//! Fades: stretches of time in which a link loses every packet, as where a drone flies through a
//! minimum of the standing waves, or a body stands between two antennas.

use units::Duration;

/// The fades of a link: E. Gilbert's channel of two states (*Capacity of a burst-noise channel*, Bell
/// System Technical Journal 39, 1960) in continuous time, as packets do not come at equal
/// distances. In the good state nothing is lost by it, in a fade everything. Both states last for
/// exponentially distributed times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fades {
    /// The part of the time that a link is in a fade, from 0 to below 1.
    pub share: f32,
    /// The mean length of a fade.
    pub mean: Duration,
}

impl Fades {
    /// A link without fades.
    pub const NONE: Self = Self { share: 0.0, mean: Duration::from_secs(1) };

    /// Whether a link is ever in a fade.
    #[must_use]
    pub fn any(&self) -> bool {
        self.share > 0.0
    }

    /// Whether a link is in a fade, where it was in one or not (`was`) so long ago. `None` stands for
    /// a link that was not looked at before. `luck` is uniform in [0, 1).
    ///
    /// With the rates μ = 1/mean out of a fade and λ = μ·share/(1 − share) into one, the chance of a
    /// fade comes back to `share` by exp(−(λ + μ)·elapsed).
    #[must_use]
    pub fn faded(&self, was: Option<bool>, elapsed: Duration, luck: f32) -> bool {
        let Some(was) = was else { return luck < self.share };
        let mean_s = self.mean.as_secs_f32() * (1.0 - self.share);
        let memory = libm::expf(-elapsed.as_secs_f32() / mean_s);
        let before = if was { 1.0 } else { 0.0 };
        luck < self.share + (before - self.share) * memory
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use proptest::prelude::*;

    /// A uniform number from a counter: splitmix64's finaliser.
    fn luck(seed: u64, n: u64) -> f32 {
        let mut z = seed.wrapping_add(n.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / 16_777_216.0
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// However often a link is looked at, it is in a fade for its share of the time.
        #[test]
        fn the_share_is_kept(
            share in 0.02f32..0.8, mean_ms in 20_u64..2_000, step_ms in 1_u64..1_000, seed: u64,
        ) {
            let fades = Fades { share, mean: Duration::from_millis(mean_ms) };
            let step = Duration::from_millis(step_ms);
            let (mut was, mut faded) = (None, 0_u32);
            // As many independent looks as are needed for three standard deviations of 2 %.
            let memory_ms = mean_ms as f32 * (1.0 - share);
            let looks = (8_000.0 * (1.0 + 2.0 * memory_ms / step_ms as f32)) as u64;
            for n in 0..looks {
                let now = fades.faded(was, step, luck(seed, n));
                faded += u32::from(now);
                was = Some(now);
            }
            let part = faded as f32 / looks as f32;
            prop_assert!((part - share).abs() < 0.03, "{part} of {looks}, not {share}");
        }

        /// A link that is looked at often enough shows fades of the mean length.
        #[test]
        fn fades_last(share in 0.05f32..0.6, mean_ms in 100_u64..1_000, seed: u64) {
            let fades = Fades { share, mean: Duration::from_millis(mean_ms) };
            let step = Duration::from_millis(mean_ms / 50);
            let (mut was, mut faded, mut began) = (None, 0_u32, 0_u32);
            for n in 0..400_000 {
                let now = fades.faded(was, step, luck(seed, n));
                faded += u32::from(now);
                began += u32::from(now && was == Some(false));
                was = Some(now);
            }
            let steps = faded as f32 / began as f32;
            let mean = steps * step.as_secs_f32() / fades.mean.as_secs_f32();
            // Fades and gaps that are shorter than a step are not seen.
            prop_assert!((0.85..1.2).contains(&mean), "{mean} of the mean");
        }
    }

    #[test]
    fn a_link_without_fades_has_none() {
        assert!(!Fades::NONE.any());
        assert!(!Fades::NONE.faded(None, Duration::ZERO, 0.0));
        assert!(!Fades::NONE.faded(Some(false), Duration::from_secs(9), 0.0));
    }
}
