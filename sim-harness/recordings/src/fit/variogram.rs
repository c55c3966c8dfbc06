//! Divides the scatter of packets into shadowing, which belongs to a place, and noise.

use std::collections::BTreeMap;

use random::Stream;

use super::Point;

/// The upper ends of the bins of displacement, m.
const BINS: [f64; 14] = [0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
/// Packets of a link that are farther apart than this in the log are not compared.
const WINDOW: usize = 400;

/// Sums over the pairs of packets of one link, by displacement.
type Sums = [Bin; BINS.len()];

#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    pairs: f64,
    displacement: f64,
    /// Half the squared differences.
    halves: f64,
}

/// The variogram of the scatter, link by link.
pub(super) struct Variogram(Vec<Sums>);

/// A fitted variogram.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scatter {
    /// The variance of the noise, dB².
    pub(super) noise: f64,
    /// The variance of shadowing, dB².
    pub(super) shadow: f64,
    /// Its decorrelation distance, m.
    pub(super) decorrelation: f64,
}

impl Variogram {
    pub(super) fn of(points: &[Point], residuals: &[f64]) -> Self {
        let mut links: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (n, point) in points.iter().enumerate() {
            links.entry(point.link).or_default().push(n);
        }
        let sums = |link: &Vec<usize>| {
            let mut sums = Sums::default();
            for (place, &a) in link.iter().enumerate() {
                for &b in link[place + 1..].iter().take(WINDOW) {
                    let apart = apart(&points[a].at, &points[b].at);
                    let Some(bin) = BINS.iter().position(|&most| apart <= most) else { continue };
                    let difference = residuals[a] - residuals[b];
                    sums[bin].pairs += 1.0;
                    sums[bin].displacement += apart;
                    sums[bin].halves += 0.5 * difference * difference;
                }
            }
            sums
        };
        Self(links.values().map(sums).collect())
    }

    /// The scatter that fits best, and those of links drawn again with replacement.
    pub(super) fn fitted(&self, count: usize, random: &mut Stream) -> (Scatter, Vec<Scatter>) {
        let all = scatter(&pooled(self.0.iter()));
        let links = self.0.len() as u32;
        let draw = |_| {
            let chosen: Vec<usize> = (0..links).map(|_| random.below(links) as usize).collect();
            scatter(&pooled(chosen.iter().map(|&link| &self.0[link])))
        };
        (all, (0..count).map(draw).collect())
    }
}

fn apart(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn pooled<'a>(links: impl Iterator<Item = &'a Sums>) -> Sums {
    links.fold(Sums::default(), |mut total, link| {
        for (into, bin) in total.iter_mut().zip(link) {
            into.pairs += bin.pairs;
            into.displacement += bin.displacement;
            into.halves += bin.halves;
        }
        total
    })
}

/// The best of 60 decorrelation distances from 0.05 to 20 m, each with the least-squares variances.
fn scatter(sums: &Sums) -> Scatter {
    let tried = (0..60_i32).map(|n| 0.05 * 400_f64.powf(f64::from(n) / 59.0));
    let fits = tried.map(|decorrelation| with_decorrelation(sums, decorrelation));
    let best = fits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(fit, _)| fit);
    best.unwrap_or(Scatter { noise: 0.0, shadow: 0.0, decorrelation: 1.0 })
}

/// The variances, none below zero, and the weighted sum of squared errors.
fn with_decorrelation(sums: &Sums, decorrelation: f64) -> (Scatter, f64) {
    let points: Vec<[f64; 3]> = sums
        .iter()
        .filter(|bin| bin.pairs > 0.0)
        .map(|bin| {
            let rise = 1.0 - (-bin.displacement / bin.pairs / decorrelation).exp();
            // A bin's own error grows with its value and falls with the root of its pairs; pairs
            // of the same packets are not independent, so a bin weighs by the root of its number.
            [rise, bin.halves / bin.pairs, bin.pairs.sqrt()]
        })
        .collect();
    let sum = |f: fn(&[f64; 3]) -> f64| points.iter().map(f).sum::<f64>();
    let (w, x, y) = (sum(|p| p[2]), sum(|p| p[2] * p[0]), sum(|p| p[2] * p[1]));
    let (xx, xy) = (sum(|p| p[2] * p[0] * p[0]), sum(|p| p[2] * p[0] * p[1]));
    let determinant = w * xx - x * x;
    let shadow = if determinant > 1e-9 { (w * xy - x * y) / determinant } else { 0.0 };
    let noise = if w > 0.0 { (y - shadow * x) / w } else { 0.0 };
    let (noise, shadow) = if shadow < 0.0 {
        (if w > 0.0 { y / w } else { 0.0 }, 0.0)
    } else if noise < 0.0 {
        (0.0, if xx > 0.0 { xy / xx } else { 0.0 })
    } else {
        (noise, shadow)
    };
    let errors =
        points.iter().map(|[rise, seen, weight]| weight * (noise + shadow * rise - seen).powi(2));
    (Scatter { noise, shadow, decorrelation }, errors.sum())
}
